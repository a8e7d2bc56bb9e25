#!/usr/bin/env python3
"""Level of the workpiece against step, basis and mesh; writes docs/convergence.md.

    cargo build --release && python3 tests/peers/convergence.py [--starts 16]

Bonded contact run by run; the block that bounces as the mean of starts that differ by gaps of 1 um.
"""

import argparse
import json
import math
import os
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.join(ROOT, "target", "release", "nailnoise")

# What is refined, and by how much the level may move.
VARIANTS = [
    ("as designed", "", None),
    ("half the step", 'analysis.time_step = "2 us"', 0.1),
    ("basis to 1.5 instead of 1.2 times the top", "analysis.mode_margin = 1.5", 0.2),
    (
        "next finer mesh",
        'analysis.workpiece_element = "12 mm"\nanalysis.worktable_element = "20 mm"\nanalysis.worktable_leg_element = "40 mm"',
        0.3,
    ),
]


def run(text):
    with tempfile.TemporaryDirectory() as folder:
        design = os.path.join(folder, "variant.toml")
        base = os.path.join(ROOT, "designs", "n80cb.toml")
        with open(design, "w") as file:
            file.write(f'base = "{base}"\n{text}\n')
        command = [PROGRAM, "run", design, "--json", "--out", os.path.join(folder, "out")]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if not done.stdout:
            raise SystemExit(done.stderr)
        return json.loads(done.stdout)


def workpiece(result):
    return next(source["lwa_db"] for source in result["ranking"] if source["source"] == "workpiece")


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--starts", type=int, default=16)
    starts = arguments.parse_args().starts
    rows, fine = [], True
    reference = {}
    for name, text, limit in VARIANTS:
        glued = workpiece(run(text + "\nsupport.contact.bonded = true"))
        scatter = run(text + f"\nanalysis.starts = {starts}")["starts"]
        mean, deviation = scatter["mean_lwa_db"], scatter["deviation_db"]
        reference.setdefault("glued", glued)
        reference.setdefault("mean", mean)
        moved = glued - reference["glued"], mean - reference["mean"]
        error = deviation / math.sqrt(starts)
        verdict = "" if limit is None else f"{limit} dB"
        if limit is not None:
            fine &= abs(moved[0]) < limit and abs(moved[1]) < limit
        rows.append(
            f"| {name} | {glued:.2f} | {moved[0]:+.2f} | {mean:.2f} | {deviation:.2f} | {error:.2f} | {moved[1]:+.2f} | {verdict} |"
        )
        print(rows[-1], flush=True)
    text = f"""# Convergence of the workpiece's level

L_WA,1s of the workpiece on worktable A in dB: glued to the table run by run, and free to bounce as the mean of {starts}
starts whose gaps under the block differ by up to 1 um (`analysis.starts`), with the standard deviation of one start and of
the mean. Written by `tests/peers/convergence.py`.

| | glued | change | bouncing, mean | deviation | of the mean | change | limit |
|---|---|---|---|---|---|---|---|
""" + "\n".join(rows) + "\n"
    with open(os.path.join(ROOT, "docs", "convergence.md"), "w") as file:
        file.write(text)
    raise SystemExit(0 if fine else 1)


if __name__ == "__main__":
    main()
