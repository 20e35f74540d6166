"""Visual navigation as a dataflow graph: plugin stages, LCM channels, a simulated robot to close the loop.

The public names are in ``__init__.pyi``. Each is imported on first use, so that ``graphnav --help`` loads no numpy;
and so that what numpy computes with can be pinned before it is loaded.
"""

from graphnav.core.exports import exports
from graphnav.core.machine import pin

__version__ = "0.21.0"

pin()
__getattr__, __dir__ = exports(__name__, __file__, "__version__")
