#!/usr/bin/env python3
"""NAFEMS FV41 and FV22 against CalculiX on the same meshes.

    apt-get install calculix-ccx
    python3 tests/peers/calculix.py

Both programs integrate the 20-node hexahedron with 3 x 3 x 3 points, so every frequency must agree to the digits that
CalculiX prints (7). The targets of the benchmarks are printed next to them and not asserted: those of FV41 belong to
the axisymmetric modes among many others, those of FV22 to a thick-plate theory.
"""

import pathlib
import subprocess
import sys
import tempfile

TARGETS = {
    "fv41": [243.53, 377.41, 394.11, 397.72, 405.28],
    "fv22": [133.95, 201.41, 265.81, 282.74, 334.45],
}


def calculix(folder, name):
    subprocess.run(["ccx", "-i", name], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    rows = []
    for line in (folder / f"{name}.dat").read_text().splitlines():
        words = line.split()
        if len(words) == 5 and words[0].isdigit():
            rows.append(float(words[3]))
        elif rows:
            break
    return rows


def main():
    folder = pathlib.Path(tempfile.mkdtemp())
    command = ["cargo", "run", "--release", "-q", "-p", "nailnoise-fem", "--example", "nafems", "--", str(folder)]
    subprocess.run(command, check=True)
    worst = 0.0
    for name, targets in TARGETS.items():
        ours = [float(f) for f in (folder / f"{name}.csv").read_text().split()]
        theirs = calculix(folder, name)
        elastic = [(a, b) for a, b in zip(ours, theirs) if a > 1.0]
        if len(ours) != len(theirs) or not elastic:
            sys.exit(f"{name}: {len(ours)} modes here, {len(theirs)} there")
        difference = max(abs(a / b - 1.0) for a, b in elastic)
        worst = max(worst, difference)
        print(f"{name}: {len(elastic)} elastic modes, largest difference {difference:.1e}")
        for target in targets:
            nearest = min(elastic, key=lambda pair: abs(pair[0] - target))
            print(f"  target {target:8.2f} Hz, nearest mode {nearest[0]:8.3f}, CalculiX {nearest[1]:8.3f}")
    if worst > 1e-5:
        sys.exit(f"frequencies differ by {worst:.1e}")


if __name__ == "__main__":
    main()
