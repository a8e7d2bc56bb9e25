"""The command ``nailnoise`` of the package: the program itself, in the native module."""

from __future__ import annotations

import os
import shutil
import sys

from ._native import command


def main() -> int:
    """Runs the command line of this process; returns its exit status."""
    programs = os.path.dirname(sys.executable)
    path = os.environ.get("PATH", "")
    # `pip install gmsh` puts gmsh next to the interpreter, which is not on the path unless the environment is active.
    # Its first line asks for the `python` that is first on the path.
    if shutil.which("gmsh") is None and shutil.which("gmsh", path=programs):
        os.environ["PATH"] = os.pathsep.join(filter(None, [programs, path]))
    os.environ.setdefault("NAILNOISE_PYTHON", sys.executable)
    return command(["nailnoise", *sys.argv[1:]])
