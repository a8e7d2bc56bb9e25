"""Runs the page on your own housing as a reader would, and compares its output with that on the page.

    housing.py NAILNOISE PAGE.md FOLDER

FOLDER is emptied and becomes the working folder. Blocks `toml NAME` of the page are written to the file NAME, blocks `sh`
are run. The output block that follows a command must have the same words, and numbers that agree: gmsh of another version
makes another mesh.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

program, page, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).read_text(), Path(sys.argv[3])
root = Path.cwd()

# Largest relative difference of two numbers that agree, and the absolute one near zero: 0.3 dB, 0.3 mm.
RELATIVE, ABSOLUTE = 0.15, 0.3
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def words(text: str) -> list[str]:
    """Words without numbers, table rules and line breaks, which depend on lengths of numbers."""
    return [word for word in re.split(r"[\s()|,:;]+", NUMBER.sub("", text)) if word.strip("-.x+~%")]


def numbers(text: str) -> list[float]:
    return [float(number) for number in NUMBER.findall(text)]


def same(shown: str, found: str) -> None:
    """Every line of the page is a line of the output, in this order; `...` stands for any lines between."""
    rest = iter(found.splitlines())
    for line in filter(str.strip, shown.splitlines()):
        if line.strip() == "...":
            continue
        for candidate in rest:
            if words(candidate) == words(line) and len(numbers(candidate)) == len(numbers(line)):
                break
        else:
            raise AssertionError(f"the output has no line like\n{line}\nin\n{found}")
        for said, computed in zip(numbers(line), numbers(candidate)):
            near = abs(said - computed) <= max(ABSOLUTE, RELATIVE * abs(computed))
            assert near, f"the page says {said}, the command {computed}:\n{line}\n{candidate}"


shutil.rmtree(folder, ignore_errors=True)
folder.mkdir(parents=True)
os.chdir(folder)
for link in ("designs", "examples"):
    os.symlink(root / link, link)
environment = os.environ | {"PATH": f"{program.parent}:{os.environ['PATH']}", "NO_COLOR": "1"}
output, commands, compared = "", 0, 0
for kind, name, text in re.findall(r"^```(\w+) ?(\S*)\n(.*?)^```$", page, re.MULTILINE | re.DOTALL):
    if kind == "toml" and name:
        with open(name, "a") as file:
            file.write(text)
    elif kind == "sh":
        done = subprocess.run(["bash", "-c", text], capture_output=True, text=True, env=environment)
        # Commands may be refused; the page then shows the refusal as output.
        assert done.returncode in (0, 2), (text, done.stderr)
        output = done.stdout + done.stderr
        commands += 1
    elif kind == "text":
        same(text, output)
        compared += 1
assert commands >= 4 and compared >= 3, (commands, compared)
print(f"the page's {commands} commands give what it shows")
