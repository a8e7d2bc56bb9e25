"""Intervals of redesigns: they include the design, are not wider than those of the base, and cover fresh draws.

    redesigns.py PROGRAM DESIGN [--redesigns 50] [--draws 128] [--fresh 200] [--of N] [--seed 1]

Redesigns change one to five numbers of DESIGN, each to a value within twice its range (half of the range's width beyond either end,
within the same sign). Each is one `--set KEY=VALUE`, as a user gives it, so that its range is the one the program assumes.

1. `run` of each redesign, with its screening: the interval of every level includes the level of the run, or no P(first) is printed,
   because the outcome differs or the check of the interval fails; the latter is counted separately.
2. `study -n DRAWS` of the base and of the first `--of` redesigns whose shot drives: the width of the interval of every source and of the
   total against that of the base, and the share of FRESH draws (another seed) within the interval.

The whole chain of the N80CB costs minutes for each study, so CI takes tests/data/small.toml, whose meshes are coarse, and few of each.
"""

import argparse
import csv
import json
import math
import random
import re
import subprocess
import sys
import tempfile
from pathlib import Path

LEVEL = re.compile(r"^  (workpiece|exhaust|body|total) +(-?[\d.]+) +(-?[\d.]+|-) \.\. (-?[\d.]+)")


def keys_of(program, design):
    """Numbers of the cycle with a range, by `nailnoise draw`, which a redesign may change."""
    done = subprocess.run([program, "run", design, "--json", "--quiet", "--out", tempfile.mkdtemp()], capture_output=True, text=True)
    inputs = json.loads(done.stdout)["inputs"]
    groups = ("supply.", "piston.", "head_valve.", "chambers.", "exhaust.", "trigger.", "wood.", "contacts.", "tool.")
    structures = ("wood.elastic", "wood.density", "piston.bore", "tool.mass", "exhaust.muffler", "exhaust.plenum", "exhaust.fitting")
    found = []
    for own in inputs:
        key, value, ends = own["key"], own["value"], own["range"]
        numbers = isinstance(value, (int, float)) and not isinstance(value, bool) and ends and ends[0] < ends[1]
        if numbers and own["provenance"] != "numerical" and key.startswith(groups) and not key.startswith(structures):
            found.append((key, value, ends))
    return found


def redesign(keys, dice):
    assignments = []
    for key, value, (low, high) in dice.sample(keys, dice.randint(1, 5)):
        wide = [low - 0.5 * (high - low), high + 0.5 * (high - low)]
        if low >= 0:
            wide[0] = max(wide[0], 0.5 * low)
        new = dice.uniform(*wide)
        assignments.append(f"{key}={max(1, round(new))}" if isinstance(value, int) else f"{key}={new:.6g}")
    return [word for own in assignments for word in ("--set", own)]


def run(program, design, changes, folder):
    command = [program, "run", design, *changes, "--out", str(folder / "run")]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 1, 3):
        return None
    rows = [match.groups() for match in map(LEVEL.match, done.stdout.splitlines()) if match]
    inside = all(low == "-" or float(low) <= float(level) <= float(high) for _, level, low, high in rows)
    return {
        "inside": bool(rows) and inside,
        "outcome differs": "no interval, no P(first)" in done.stdout,
        "outside": "lies outside its own interval" in done.stdout,
        "status": done.returncode,
    }


def study(program, design, changes, draws, seed, folder):
    out = folder / f"study-{seed}"
    command = [program, "study", design, *changes, "-n", str(draws), "--seed", str(seed), "--json", "--quiet", "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0 or not done.stdout:
        return None
    with (out / "study/draws.csv").open(newline="") as file:
        heads, *rows = csv.reader(file)
    columns = {}
    for name in ("workpiece", "exhaust", "body", "total"):
        place = next(place for place, head in enumerate(heads) if head.startswith(f"L_WA,1s {name}"))
        columns[name] = [float(row[place] or "-inf") for row in rows]
    return json.loads(done.stdout), columns


def intervals(result):
    ends = {own["source"]: own["level"]["level_db"] for own in result["sources"]} | {"total": result["total"]["level_db"]}
    return {name: (own["p05"]["value"], own["p95"]["value"]) for name, own in ends.items()}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("design")
    parser.add_argument("--redesigns", type=int, default=50)
    parser.add_argument("--draws", type=int, default=128)
    parser.add_argument("--fresh", type=int, default=200)
    parser.add_argument("--of", type=int, default=5)
    parser.add_argument("--screening", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    program, dice = str(Path(options.program).resolve()), random.Random(options.seed)
    wrong, counts, tried, driving = [], {"inside": 0, "outcome differs": 0, "outside": 0}, 0, []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        # The same design with a screening: small.toml does not request one.
        design = folder / "base.toml"
        design.write_text(f'base = "{Path(options.design).resolve()}"\n[study]\nscreening = {options.screening}\n')
        keys = keys_of(program, str(design))
        while tried < options.redesigns:
            changes = redesign(keys, dice)
            found = run(program, str(design), changes, folder)
            if found is None:
                continue  # conflicting values are refused
            tried += 1
            for what in counts:
                counts[what] += found[what]
            if not (found["inside"] or found["outcome differs"] or found["outside"]):
                wrong.append((changes, found))
            if found["inside"]:
                driving.append(changes)
        print(f"{tried} redesigns: {counts}, {len(wrong)} wrong")
        for changes, found in wrong:
            print("  ", " ".join(changes), found)
        bad = bool(wrong)
        base = study(program, str(design), [], options.draws, 1, folder)
        widths_of_base = {name: high - low for name, (low, high) in intervals(base[0]).items()}
        ratios, inside, fresh_draws, shares = [], 0, 0, []
        for changes in [[], *driving[: options.of]]:
            made = study(program, str(design), changes, options.draws, 1, folder)
            fresh = study(program, str(design), changes, options.fresh, 2, folder)
            if made is None or fresh is None:
                print("no study:", " ".join(changes))
                continue
            for name, (low, high) in intervals(made[0]).items():
                within = sum(low <= level <= high for level in fresh[1][name])
                shares.append(within / len(fresh[1][name]))
                inside, fresh_draws = inside + within, fresh_draws + len(fresh[1][name])
                ratios.append(((high - low) / widths_of_base[name], name, " ".join(changes)))
        share = inside / fresh_draws
        spread = f"{min(shares):.3f} .. {max(shares):.3f}"
        print(f"{len(shares)} intervals of {options.draws} draws contain {100 * share:.1f} % of fresh draws (single ones {spread})")
        widest = max(ratios)
        print(f"widest against the base: {widest[0]:.2f} ({widest[1]}; {widest[2]})")
        # Sampling error of the mean over few intervals.
        error = 3 * math.sqrt(0.1 * 0.9 * (1 / options.draws + 1 / options.fresh) / max(1, len(shares) / 4))
        bad |= not 0.85 - max(0, error - 0.05) <= share <= 0.95 + max(0, error - 0.05)
    sys.exit(bad)


main()
