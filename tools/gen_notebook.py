"""Execute docs/notebook.ipynb and keep its outputs, with a digest of the cells that they are of.

python tools/gen_notebook.py           execute it in an empty folder and write it with its outputs
python tools/gen_notebook.py -o FILE   write them into another file
"""

from __future__ import annotations

import argparse
import hashlib
import json
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

NOTEBOOK = Path(__file__).resolve().parents[1] / "docs" / "notebook.ipynb"
DIGEST = "graphnav_cells"
"""The key of the notebook's metadata that holds the digest."""


def digest_of(cells: Sequence[Mapping[str, Any]]) -> str:
    """Return a digest of the sources of the code cells."""
    sources = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    return hashlib.sha256(json.dumps(sources).encode()).hexdigest()


def main() -> None:
    """Execute and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", dest="target", type=Path, default=NOTEBOOK, metavar="FILE", help="the file to write")
    args = parser.parse_args()
    notebook = nbformat.read(NOTEBOOK, as_version=4)  # type: ignore[no-untyped-call]
    nbformat.validate(notebook)
    with tempfile.TemporaryDirectory() as work:
        NotebookClient(notebook, timeout=300, resources={"metadata": {"path": work}}).execute()
        if left := sorted(path.name for path in Path(work).iterdir()):
            raise SystemExit(f"the notebook leaves {', '.join(left)} in its folder")
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
    notebook.metadata[DIGEST] = digest_of(notebook.cells)
    nbformat.write(notebook, args.target)  # type: ignore[no-untyped-call]


if __name__ == "__main__":
    main()
