"""The command that the wheel puts on the path."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import nailnoise as nn
import pytest
from nailnoise import _command

COMMAND = Path(sys.executable).with_name("nailnoise")


def _run(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([COMMAND, *arguments], capture_output=True, text=True, env={**os.environ, **environment})


def test_the_command_is_the_program_of_the_package() -> None:
    printed = _run("--version")
    assert printed.returncode == 0, printed.stderr
    assert printed.stdout.splitlines()[0] == f"nailnoise {nn.__version__}"


def test_results_go_to_standard_output_and_the_exit_status_is_that_of_the_program() -> None:
    listed = _run("list", "woods", "--json")
    assert listed.returncode == 0, listed.stderr
    assert json.loads(listed.stdout)
    wrong = _run("list", "nothing")
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert "nothing" in wrong.stderr


def test_a_design_that_does_not_exist_is_refused_with_a_remedy() -> None:
    missing = _run("run", "no-such-design.toml")
    assert missing.returncode == 2
    assert "no-such-design.toml" in missing.stderr and "help:" in missing.stderr


def _program(folder: Path, name: str) -> Path:
    folder.mkdir(exist_ok=True)
    program = folder / (f"{name}.bat" if os.name == "nt" else name)
    program.write_text("")
    program.chmod(0o755)
    return program


def test_a_gmsh_next_to_the_interpreter_is_found_and_one_on_the_path_comes_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    beside = _program(tmp_path / "environment", "gmsh")
    monkeypatch.setattr(sys, "executable", str(beside.with_name("python")))
    monkeypatch.setattr(_command, "command", lambda arguments: len(arguments))
    monkeypatch.setattr(sys, "argv", ["nailnoise", "mesh", "housing.step"])
    monkeypatch.setenv("PATH", str(tmp_path / "nowhere"))
    assert _command.main() == 3
    assert shutil.which("gmsh") == str(beside)

    chosen = _program(tmp_path / "chosen", "gmsh")
    monkeypatch.setenv("PATH", str(chosen.parent))
    _command.main()
    assert shutil.which("gmsh") == str(chosen)
    assert str(beside.parent) not in os.environ["PATH"].split(os.pathsep)
