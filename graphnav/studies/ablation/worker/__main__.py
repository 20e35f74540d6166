"""``python -m graphnav.studies.ablation.worker FD``: the process that makes runs."""

import sys

from graphnav.studies.ablation.worker.serve_tasks import serve

serve(int(sys.argv[1]))
