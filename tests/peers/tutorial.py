"""Runs the comparisons of the tutorial and checks its numbers against them.

    tutorial.py NAILNOISE TUTORIAL.md OUT
"""

import json
import re
import subprocess
import sys
from pathlib import Path

program, page, out = sys.argv[1], Path(sys.argv[2]).read_text(), sys.argv[3]


def compare(*designs: str, more: tuple[str, ...] = (), status: int = 0) -> dict:
    command = [program, "compare", *designs, "--json", "--quiet", "--out", out, *more]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == status, done.stderr
    return json.loads(done.stdout)


commands = [line.split()[2:] for line in page.splitlines() if line.startswith("nailnoise compare")]
assert len(commands) == 3, commands

ideas = compare(*commands[0])
levels = {row["source"]: row["level_db"] for row in ideas["sources"]} | {"total": ideas["total"]["level_db"]}
rows = re.findall(r"^\| (\w+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|$", page, re.MULTILINE)
assert {row[0] for row in rows} == set(levels), rows
for name, *written in rows:
    for said, found in zip(written, levels[name]):
        assert abs(float(said) - found) < 0.1, f"{name}: the page says {said}, the run {found:.2f}"
event = next(row["values"] for row in ideas["events"] if row["name"] == "t16")
assert [round(1e3 * event[i], 1) for i in (2, 0)] == [76.8, 75.0], event
stop = next(row["values"] for row in ideas["cycle"] if row["name"] == "peak_stopper_force")
assert [round(1e-3 * stop[i], 2) for i in (2, 0)] == [1.41, 1.52], stop

table = compare(*commands[1])
exhaust = next(row for row in table["sources"] if row["source"] == "exhaust")["change_db"][1]
assert abs(exhaust + 7.2) < 0.1 and abs(table["total"]["change_db"][1] + 1.0) < 0.1, table["total"]

gate = commands[2].index("--fail-above")
compare(*commands[2][:gate], more=tuple(commands[2][gate:]))
compare(*commands[2][:gate], more=("--fail-above", "total=85"), status=1)
print(f"the tutorial's {3 * len(rows)} levels hold")
