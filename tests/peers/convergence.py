#!/usr/bin/env python3
"""Levels of workpiece and tool against step, basis and mesh; writes docs/convergence.md.

    cargo build --release && python3 tests/peers/convergence.py [--starts 16] [--fresh]

Glued contact run by run; the block that bounces as the mean of starts that differ by gaps of 1 um. Half an hour of two
cores the first time; what has been run is kept in target/convergence.json until --fresh.
"""

import argparse
import json
import math
import os
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
KEPT = os.path.join(ROOT, "target", "convergence.json")

STEP = ("half the step, 2 us", 'analysis.time_step = "2 us"', 0.1)
BASIS = ("basis to 1.5 instead of 1.2 times the top", "analysis.mode_margin = 1.5", 0.2)
BLOCK = 'analysis.workpiece_element = "12 mm"'
TABLE = 'analysis.worktable_element = "20 mm"\nanalysis.worktable_leg_element = "40 mm"'

# Supports, what glues the block to them, and what is refined: by how much the level may move.
SUPPORTS = [
    ("worktable A", "", "support.contact.bonded = true", [STEP, BASIS, ("next finer mesh", f"{BLOCK}\n{TABLE}", 0.3)]),
    (
        "sandbox",
        'support.kind = "sandbox"',
        "support.sand.bonded = true",
        [STEP, BASIS, ("next finer mesh", BLOCK, 0.3)],
    ),
]

# The tool's meshes are compared in docs/verification.md.
TOOL = [STEP, BASIS]


class Runs:
    """Runs of the base design with something changed, kept by what was changed."""

    def __init__(self, program, fresh):
        self.program = program
        self.kept = {}
        if not fresh and os.path.exists(KEPT):
            with open(KEPT) as file:
                self.kept = json.load(file)

    def __call__(self, *changes):
        text = "\n".join(change for change in changes if change)
        if text not in self.kept:
            self.kept[text] = self.compute(text)
            with open(KEPT, "w") as file:
                json.dump(self.kept, file, indent=1)
        return self.kept[text]

    def compute(self, text):
        with tempfile.TemporaryDirectory() as folder:
            design = os.path.join(folder, "variant.toml")
            base = os.path.join(ROOT, "designs", "n80cb.toml")
            with open(design, "w") as file:
                file.write(f'base = "{base}"\n{text}\n')
            command = [self.program, "run", design, "--json", "--out", os.path.join(folder, "out")]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if not done.stdout:
                raise SystemExit(done.stderr)
            result = json.loads(done.stdout)
        levels = {source["source"]: source["lwa_db"] for source in result["ranking"]}
        levels["parts"] = {
            part["name"]: part["lwa_db"]
            for source in result["ranking"]
            if source["source"] == "body"
            for part in source["components"]
        }
        levels["starts"] = (result.get("starts") or {}).get("lwa_db")
        levels["failed"] = [check["name"] for check in result["checks"] if not check["ok"]]
        return levels


def mean_and_deviation(values):
    mean = sum(values) / len(values)
    return mean, math.sqrt(sum((value - mean) ** 2 for value in values) / (len(values) - 1))


def support_rows(runs, support, glue, variants, starts):
    """Rows of the table of a support, and whether all moved less than they may."""
    rows, fine, reference = [], True, None
    for name, change, limit in [("as designed", "", None), *variants]:
        # The housing is left out: nothing of it reaches the workpiece.
        common = ('body.model = "rigid"', support, change)
        glued = runs(*common, glue)["workpiece"]
        levels = runs(*common, f"analysis.starts = {starts}")["starts"]
        mean, deviation = mean_and_deviation(levels)
        reference = reference or (glued, mean, levels)
        moved = glued - reference[0], mean - reference[1]
        # The same gaps stand in both sets, so that the error of the change is that of the mean of their differences.
        error = mean_and_deviation([a - b for a, b in zip(levels, reference[2])])[1] / math.sqrt(starts)
        held = limit is None or all(abs(change) < limit for change in moved)
        fine &= held
        cells = [name, f"{glued:.2f}", f"{moved[0]:+.2f}" if limit else "", f"{mean:.2f}", f"{deviation:.2f}"]
        cells += [f"{moved[1]:+.2f} +- {error:.2f}", f"{limit} dB" if held else f"**{limit} dB**"] if limit else ["", ""]
        rows.append("| " + " | ".join(cells) + " |")
        print(rows[-1], flush=True)
    return rows, fine


def tool_rows(runs):
    rows, fine, reference = [], True, None
    for name, change, limit in [("as designed", "", None), *TOOL]:
        levels = runs('support.kind = "sandbox"', change)
        found = levels["body"], levels["parts"]["housing"]
        reference = reference or found
        moved = [a - b for a, b in zip(found, reference)]
        held = limit is None or abs(moved[0]) < limit
        fine &= held
        cells = [name, f"{found[0]:.2f}", f"{moved[0]:+.2f}", f"{found[1]:.2f}", f"{moved[1]:+.2f}"]
        cells += [f"{limit} dB" if held else f"**{limit} dB**"] if limit else [""]
        rows.append("| " + " | ".join(cells) + " |")
        print(rows[-1], flush=True)
    return rows, fine


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--starts", type=int, default=16)
    arguments.add_argument("--fresh", action="store_true")
    arguments.add_argument("--program", default=os.path.join(ROOT, "target", "release", "nailnoise"))
    given = arguments.parse_args()
    runs, all_fine = Runs(given.program, given.fresh), True
    text = f"""# Convergence

L_WA,1s in dB against the step of the response, the modes kept and the mesh, one of them refined at a time. The workpiece
glued to what it stands on is compared run by run; free to bounce, as the mean of {given.starts} starts whose gaps under
the block differ by up to 1 um (`analysis.starts`), with the standard deviation of one start, and the change of the mean
with its standard error. Every such run of `nailnoise` adds two of these deviations to the level's uncertainty. A limit in
bold is not met. Written by `tests/peers/convergence.py`.
"""
    for name, support, glue, variants in SUPPORTS:
        print(name, flush=True)
        rows, fine = support_rows(runs, support, glue, variants, given.starts)
        all_fine &= fine
        text += f"""
## Workpiece, {name}

| | glued | change | bouncing, mean | deviation | change | limit |
|---|---|---|---|---|---|---|
"""
        text += "\n".join(rows) + "\n"
    print("tool", flush=True)
    rows, fine = tool_rows(runs)
    all_fine &= fine
    text += """
## Tool

The mesh of the housing is refined in the [verification](verification.md).

| | body | change | vibration of the housing | change | limit |
|---|---|---|---|---|---|
"""
    text += "\n".join(rows) + "\n"
    with open(os.path.join(ROOT, "docs", "convergence.md"), "w") as file:
        file.write(text)
    raise SystemExit(0 if all_fine else 1)


if __name__ == "__main__":
    main()
