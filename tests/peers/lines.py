"""No line of Rust, and no line of prose in Markdown, has more than 120 columns.

    lines.py REPOSITORY

Tables, code and output in Markdown are exempt. Prints the lines that are longer; status 1 if there are any.
"""

import subprocess
import sys
from pathlib import Path

COLUMNS = 120


def prose(text: str) -> list[tuple[int, str]]:
    """Lines of Markdown outside code blocks and tables, with their numbers."""
    lines, code = [], False
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("```"):
            code = not code
        elif not code and not line.lstrip().startswith(("|", "`")):
            lines.append((number, line))
    return lines


def main(root: Path) -> int:
    files = subprocess.run(["git", "-C", root, "ls-files", "*.rs", "*.md"], capture_output=True, text=True, check=True)
    found = 0
    for name in files.stdout.splitlines():
        text = (root / name).read_text()
        lines = prose(text) if name.endswith(".md") else list(enumerate(text.splitlines(), 1))
        for number, line in lines:
            if len(line) > COLUMNS:
                print(f"{name}:{number}: {len(line)} columns")
                found += 1
    return int(found > 0)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
