#!/usr/bin/env python3
"""The Radiatterer by bempp-cl, another boundary element program, beside the reference and our own values.

    pip install bempp-cl==0.4.2 numba
    python3 tests/peers/bempp_radiatterer.py docs/benchmark/radiatterer.csv 125 180 240 300

The geometry is read from `acoustics/examples/radiatterer.rs`. bempp-cl solves the same panels of 0.1 m, each cut into
two triangles: Galerkin's method, linear pressure, dense matrices, no Burton-Miller. The solid walls are at most 0.5 m
thick, so the lowest interior resonance lies above 300 Hz. Prints, for each frequency, the power and the levels at the
three points, and their differences from the rows of the CSV file, by the program and by the reference. Status 1 if the
program differs by more than 0.3 dB.
"""

import csv
import math
import pathlib
import re
import sys
import time

import numpy as np
from bempp_benchmark import Surface

EXAMPLE = pathlib.Path(__file__).parents[2] / "acoustics" / "examples" / "radiatterer.rs"
DENSITY, SPEED = 1.3, 340.0
TOLERANCE = 0.3


def constant(text, name):
    """The numbers of a constant array of the example, in order."""
    body = re.search(rf"const {name}: [^=]*= \[(.*?)\];", text, re.DOTALL)[1]
    return [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", body)]


def panels(side, brick, cuts):
    """Corners of a panel on every side of a solid cell that is exposed to the air, counter-clockwise from outside."""
    solid = np.ones(brick, dtype=bool)
    for x, y, z in cuts:
        solid[x[0] : x[1], y[0] : y[1], z[0] : z[1]] = False
    padded = np.pad(solid, 1)
    for cell in np.argwhere(solid):
        for axis in range(3):
            for upper in (0, 1):
                beyond = cell + 1
                beyond[axis] += 2 * upper - 1
                if padded[tuple(beyond)]:
                    continue
                u, v = (axis + 1) % 3, (axis + 2) % 3
                corners = []
                for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    point = cell.copy()
                    point[axis] += upper
                    point[u] += i
                    point[v] += j
                    corners.append(point)
                yield side * np.array(corners if upper else corners[::-1], dtype=float)


def main():
    text = EXAMPLE.read_text()
    cuts = np.array(constant(text, "CUT"), dtype=int).reshape(-1, 3, 2)
    brick = [int(n) for n in constant(text, "BRICK")]
    side = float(re.search(r"const SIDE: f64 = ([\d.]+);", text)[1])
    velocity = float(re.search(r"const VELOCITY: f64 = ([\de.-]+);", text)[1])
    points = np.array(constant(text, "POINTS")).reshape(-1, 3)
    corners = np.array(list(panels(side, brick, cuts)))
    surface = Surface(corners.reshape(-1, 3), np.arange(4 * len(corners)).reshape(-1, 4))
    count, unknowns = surface.grid.number_of_elements, surface.linear.global_dof_count
    print(f"{count} triangles, {unknowns} unknowns, {surface.open_edges()} open edges", flush=True)
    with open(sys.argv[1], newline="") as file:
        ours = {float(row[0]): [float(x or "nan") for x in row] for row in list(csv.reader(file))[1:]}
    print("Hz,power [W],L_1 [dB],L_2 [dB],L_3 [dB],from the program [dB]: power,L_1,L_2,L_3,"
          "from the reference [dB]: power,L_1,L_2,L_3,time [s]")
    worst = 0.0
    moving = np.full(4 * len(corners), velocity)
    for hz in map(float, sys.argv[2:]):
        started = time.perf_counter()
        omega = math.tau * hz
        slope = surface.on_triangles(1j * omega * DENSITY * moving)
        pressure = surface.pressure(omega / SPEED, slope)
        power = 0.5 * surface.flow(pressure, moving.astype(complex)).real
        field = surface.at(points.T, omega / SPEED, pressure, slope)
        levels = 20.0 * np.log10(np.abs(field) / 2e-5)
        own = ours[hz]
        from_us = [10.0 * math.log10(power / own[1]), *(levels - own[2:5])]
        worst = max(worst, *map(abs, from_us))
        from_reference = np.array(from_us) + own[5:9]
        shown = ",".join(f"{x:.3f}" for x in [*levels, *from_us, *from_reference])
        print(f"{hz:g},{power:.5e},{shown},{time.perf_counter() - started:.0f}", flush=True)
    if worst > TOLERANCE:
        sys.exit("the boundary element programs differ")


if __name__ == "__main__":
    main()
