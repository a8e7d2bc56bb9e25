"""Runs the commands of the page on where to begin, and checks its numbers and its decision.

    exhaust_first.py NAILNOISE PAGE.md OUT
"""

import json
import re
import subprocess
import sys
from pathlib import Path

program, page, out = sys.argv[1], Path(sys.argv[2]).read_text(), sys.argv[3]
run, compare = (line.split()[1:] for line in page.splitlines() if line.startswith("nailnoise "))


def output(*arguments: str) -> str:
    done = subprocess.run([program, *arguments, "--quiet"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


# The intervals and P(first) next to the levels of the run.
text = output(*run, "--out", f"{out}/n80cb")
shown = re.findall(r"^ *(\w+) +([\d.]+) +([\d.]+) \.\. ([\d.]+) +([\d.]+) ", text, re.MULTILINE)
stated = re.findall(r"^\| (\w+) \| ([\d.]+) \| ([\d.]+) \.\. ([\d.]+) \| ([\d.]+) \|$", page, re.MULTILINE)
assert len(stated) == 3, stated
for row in stated:
    found = next(own for own in shown if own[0] == row[0])
    for said, is_so, limit in zip(row[1:], found[1:], [0.1, 0.11, 0.11, 0.011]):
        assert abs(float(said) - float(is_so)) < limit, f"the page says {row}, the run {found}"
first = {row[0]: float(row[4]) for row in stated}
assert first["exhaust"] < 0.5 < first["workpiece"], first

# The change over common draws, next to the spread of the level itself.
paired = json.loads(output(*compare, "--json", "--out", out))["paired"][0]
changes = {own["source"]: own for own in paired["changes"]}
for name, *said in re.findall(
    r"^\| (\w+) \| (-?[\d.]+) \| (-?[\d.]+) \.\. (-?[\d.]+) \| ([\d.]+) \| ([\d.]+) \|$", page, re.MULTILINE
):
    own = changes[name]
    quantiles = [own["change_db"][place]["value"] for place in ("p50", "p05", "p95")]
    for number, found in zip(map(float, said), [*quantiles, own["width_db"], own["level_width_db"]]):
        assert abs(number - found) < 0.15, f"{name}: the page says {number}, the comparison {found:.2f}"
exhaust = changes["exhaust"]
assert exhaust["level_width_db"] >= 3 * exhaust["width_db"], exhaust
print(f"the page's {len(stated)} levels and its change hold: {exhaust['width_db']:.2f} dB wide, the level {exhaust['level_width_db']:.1f} dB")
