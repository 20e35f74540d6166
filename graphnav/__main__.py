"""``python -m graphnav``: the same as the command ``graphnav``."""

import sys

from graphnav.cli import main

if __name__ == "__main__":
    sys.exit(main())
