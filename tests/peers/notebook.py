"""Executes a notebook as a new user would, from the root of the repository, and checks its output.

    notebook.py NOTEBOOK [SECONDS]

Fails where a cell fails, where the ranking, a chart, the interval, the sweep or the picture is not among the outputs, or where it takes
longer than SECONDS (no limit unless given).
"""

import sys
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient


def main() -> int:
    path = Path(sys.argv[1])
    limit = float(sys.argv[2]) if len(sys.argv) > 2 else float("inf")
    notebook = nbformat.read(path, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), f"{path} is kept without outputs"
    begin = time.monotonic()
    NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(path.resolve().parents[1])}}).execute()
    seconds = time.monotonic() - begin
    outputs = [output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", [])]
    pages = [data["text/html"] for data in outputs if "text/html" in data]
    for what, mark in {
        "the ranking": "<th>share (A)</th>",
        "a chart": "data:image/svg+xml;base64,",
        "the probability of being first": "<th>P(first)</th>",
        "the sweep": "exhaust.holes",
    }.items():
        assert any(mark in page for page in pages), f"{what} is not shown"
    pictures = [data["image/png"] for data in outputs if "image/png" in data]
    assert pictures and len(pictures[-1]) > 5000, "the picture of a mode is not shown"
    assert seconds <= limit, f"{seconds:.0f} s, more than {limit:.0f}"
    print(f"{path}: {sum(cell.cell_type == 'code' for cell in notebook.cells)} cells in {seconds:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
