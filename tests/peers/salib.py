"""Whether the indices of `nailnoise study` are those that SALib finds in the same draws.

    salib.py NAILNOISE DESIGN OUT [DRAWS]

First-order indices of single inputs: `draws.csv` through SALib's estimator by given data (delta, Plischke 2013) against
`study.json`. Groups: `groups.csv` through SALib's total index (Jansen 1999) against the total index of `study.json`. SALib and numpy
must be installed.
"""

import csv
import json
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np
from SALib.analyze import delta
from SALib.analyze.sobol import total_order

program, design, out = sys.argv[1:4]
draws = sys.argv[4] if len(sys.argv) > 4 else "128"
command = [program, "study", design, "-n", draws, "--groups", "--quiet", "--json", "--out", out]
done = subprocess.run(command, capture_output=True, text=True)
assert done.returncode == 0, done.stderr
study = json.loads(done.stdout)
folder = Path(out) / "study"


def rows(name: str) -> list[dict[str, str]]:
    with open(folder / name, newline="") as file:
        return list(csv.DictReader(file))


def level(output: str) -> str:
    return f"L_WA,1s {output} [dB]"


# Single inputs, by given data.
table = rows("draws.csv")
columns = {}
for name in table[0]:
    try:
        columns[name.split(" [")[0]] = np.array([float(row[name]) for row in table])
    except ValueError:
        pass
compared = 0
for own in study["contributions"]:
    if level(own["output"]) not in table[0]:
        continue
    levels = np.array([float(row[level(own["output"])]) for row in table])
    for found in own["inputs"]:
        if found["variable"] not in columns:
            continue
        values = columns[found["variable"]]
        problem = {"num_vars": 1, "names": ["x"], "bounds": [[values.min(), values.max()]]}
        other = delta.analyze(problem, values[:, None], levels, seed=1, num_resamples=100)
        apart = abs(other["S1"][0] - found["first_order"])
        print(f"{own['output']:>10} {found['variable']:<40} {found['first_order']:.3f}, SALib {other['S1'][0]:.3f}")
        assert apart < 0.1 + 2 * other["S1_conf"][0], f"{found['variable']}: {apart:.3f} apart"
        compared += 1

# Groups, by the partners that share all else.
levels = defaultdict(dict)
for row in rows("groups.csv"):
    levels[row["draw"]][row["group"], row["shares"]] = row
names = [group["name"] for group in study["groups"]["groups"]]
whole = [own for own in levels.values() if len(own) == 1 + 2 * len(names)]
assert len(whole) == study["groups"]["rows"]
for own in study["groups"]["outputs"]:
    if " less " in own["output"]:
        continue
    figure = level(own["output"])
    base = np.array([float(row["", "all"][figure]) for row in whole])
    spread = np.var([float(row[figure]) for rows in whole for row in rows.values()])
    assert abs(spread / own["variance_db2"] - 1) < 1e-3, f"variance {spread}, stated {own['variance_db2']}"
    for group in own["groups"]:
        partner = np.array([float(row[group["group"], "rest"][figure]) for row in whole])
        # SALib divides by the variance of the two samples that it is given.
        other = total_order(base, partner, base) * np.var(np.r_[base, base]) / spread
        found = group["total"]["value"]
        print(f"{own['output']:>10} {group['group']:<40} {found:.4f}, SALib {other:.4f}")
        assert abs(other - found) < 2e-3, f"{group['group']}: {other} and {found}"
        compared += 1
assert compared > 8, compared
print(f"{compared} indices agree with SALib")
