#!/usr/bin/env python3
"""Compares levels of workpiece and tool for several steps, bases and meshes; writes docs/convergence.md.

    cargo build --release && python3 tests/peers/convergence.py [--starts 16] [--fresh]

Bonded contact is computed run by run, the bouncing block as the mean of starts that differ by gaps of 1 um. The first call
takes half an hour on two cores; target/convergence.json stores finished runs until --fresh.
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

# Refinements, with the limit on the change of the level.
ON_TABLE = [STEP, BASIS, ("next finer mesh", f"{BLOCK}\n{TABLE}", 0.3)]
IN_SAND = [STEP, BASIS, ("next finer mesh", BLOCK, 0.3)]
# Runs for the workpiece omit the elastic housing, because it does not affect the wood.
RIGID = 'body.model = "rigid"'
# docs/verification.md compares the meshes of the tool.
TOOL = [STEP, BASIS]


class Runs:
    """Runs of the base design with changes, stored under these changes."""

    def __init__(self, program, fresh):
        self.program = program
        self.kept = {}
        if not fresh and os.path.exists(KEPT):
            with open(KEPT) as file:
                self.kept = json.load(file)

    def __call__(self, *changes):
        text = "\n".join(sorted(line for change in changes for line in change.splitlines()))
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
                # Only the motion is studied; radiation efficiency 1 avoids a radiation matrix for every mesh.
                erp = 'acoustics.method = "erp"\nacoustics.body_method = "erp"'
                file.write(f'base = "{base}"\n{erp}\n{text}\n')
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


def refined(variants, levels_of, limited):
    """Rows of a table and whether the limited level moved less than its limit; the first column of levels is the
    limited one."""
    rows, fine, reference = [], True, None
    for name, change, limit in [("as designed", "", None), *variants]:
        found = levels_of(change)
        reference = reference or found
        moved = [a - b for a, b in zip(found, reference)]
        held = limit is None or all(abs(change) < limit for change in moved[:limited])
        fine &= held
        cells = [name]
        for level, change in zip(found, moved):
            cells += [f"{level:.2f}", f"{change:+.2f}" if limit else ""]
        cells.append("" if limit is None else f"{limit} dB" if held else f"**{limit} dB**")
        rows.append("| " + " | ".join(cells) + " |")
        print(rows[-1], flush=True)
    return rows, fine


def bouncing_rows(runs, starts):
    """The same for the block that bounces on the worktable: mean and deviation of its starts."""
    rows, fine, reference = [], True, None
    for name, change, limit in [("as designed", "", None), *ON_TABLE]:
        levels = runs(RIGID, change, f"analysis.starts = {starts}")["starts"]
        mean, deviation = mean_and_deviation(levels)
        reference = reference or levels
        # Both sets have the same gaps, so the error of the change is that of the mean of their differences.
        moved, error = mean_and_deviation([a - b for a, b in zip(levels, reference)])
        error /= math.sqrt(starts)
        held = limit is None or abs(moved) < limit
        fine &= held
        cells = [name, f"{mean:.2f}", f"{deviation:.2f}", f"{moved:+.2f} +- {error:.2f}" if limit else ""]
        cells.append("" if limit is None else f"{limit} dB" if held else f"**{limit} dB**")
        rows.append("| " + " | ".join(cells) + " |")
        print(rows[-1], flush=True)
    return rows, fine


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--starts", type=int, default=16)
    arguments.add_argument("--fresh", action="store_true")
    arguments.add_argument("--program", default=os.path.join(ROOT, "target", "release", "nailnoise"))
    given = arguments.parse_args()
    runs, starts = Runs(given.program, given.fresh), given.starts
    sand = 'support.kind = "sandbox"'
    workpiece = lambda *changes: lambda change: [runs(RIGID, *changes, change)["workpiece"]]
    tool = lambda change: (lambda found: [found["body"], found["parts"]["housing"]])(runs(sand, change))
    tables = [
        (
            "Workpiece glued to worktable A",
            "",
            "| | L_WA | change | limit |\n|---|---|---|---|",
            lambda: refined(ON_TABLE, workpiece("support.contact.bonded = true"), 1),
        ),
        (
            "Workpiece bouncing freely on worktable A",
            f"Mean of {starts} starts whose gaps under the block differ by up to 1 um (`analysis.starts`), standard deviation of "
            "one start,\nand change of the mean with its standard error. A run with such starts adds twice this deviation to the "
            "uncertainty of\nthe level.",
            "| | mean L_WA | deviation | change | limit |\n|---|---|---|---|---|",
            lambda: bouncing_rows(runs, starts),
        ),
        (
            "Workpiece bonded to the sand",
            "",
            "| | L_WA | change | limit |\n|---|---|---|---|",
            lambda: refined(IN_SAND, workpiece(sand, "support.sand.bonded = true"), 1),
        ),
        (
            "Tool",
            "The body as a source, and the vibration of its housing alone, both with `acoustics.body_method = \"erp\"`. "
            "[Verification](verification.md)\ncompares its meshes.",
            "| | body L_WA | change | housing L_WA | change | limit |\n|---|---|---|---|---|---|",
            lambda: refined(TOOL, tool, 1),
        ),
    ]
    text = """# Convergence

This page shows how L_WA,1s of the N80CB, in dB, depends on the time step of the response, on the number of modes and on the
mesh. One of them is refined at a time. A limit in bold is not met. All levels use radiation efficiency 1, because the page
studies the motion. `tests/peers/convergence.py` writes this page.
"""
    all_fine = True
    for title, words, head, rows_of in tables:
        print(title, flush=True)
        rows, fine = rows_of()
        all_fine &= fine
        text += "\n".join(["", f"## {title}", ""] + ([words, ""] if words else []) + [head, *rows]) + "\n"
    with open(os.path.join(ROOT, "docs", "convergence.md"), "w") as file:
        file.write(text)
    raise SystemExit(0 if all_fine else 1)


if __name__ == "__main__":
    main()
