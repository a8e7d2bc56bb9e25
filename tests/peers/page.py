"""Runs the Python blocks of a page in order, as a reader would paste them.

    page.py PAGE.md FOLDER [FROM=TO ...]

FOLDER is the working folder. FROM=TO replaces a string in the blocks, for example the name of a run.
"""

import os
import re
import sys
from pathlib import Path

page, folder = Path(sys.argv[1]).read_text(), sys.argv[2]
code = "\n".join(re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL))
assert code.count("\n") > 10, "the page has no Python"
for pair in sys.argv[3:]:
    old, new = pair.split("=", 1)
    assert old in code, old
    code = code.replace(old, new)
os.chdir(folder)
exec(compile(code, sys.argv[1], "exec"), {"__name__": "__page__"})
