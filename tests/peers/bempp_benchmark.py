#!/usr/bin/env python3
"""The sound field of the benchmark's surface velocities by bempp-cl, another boundary element program.

    pip install bempp-cl==0.4.2 numba
    python3 tests/peers/benchmark.py target/release/nailnoise FOLDER
    python3 tests/peers/bempp_benchmark.py FOLDER docs/benchmark/case.json

Reads `surface.csv` and `surface-power.csv` of the folder (docs/benchmark.md), cuts each panel into two triangles and
adds the image of the surface in the floor. bempp-cl solves the Helmholtz equation outside: Galerkin's method, linear
pressure, linear velocity on each triangle, dense matrices, no Burton-Miller. Block and table top as one box have
their lowest interior resonance at 1.8 kHz; that of the exact surface was not computed. Energies must agree to
0.1 dB, pressures to 2 % of their largest value at a frequency.

A sphere with a known pressure comes first: it shows the signs and the error of the method.
"""

import csv
import json
import math
import os
import pathlib
import sys
import time

os.environ.setdefault("NUMBA_NUM_THREADS", "1")
import bempp_cl.api as bempp  # noqa: E402
import numpy as np  # noqa: E402

bempp.DEFAULT_DEVICE_INTERFACE = "numba"
POINTS = np.array([[1.5, 0.0, 0.5], [0.0, 1.5, 0.5], [0.0, 0.0, 1.5]]).T
ENERGY_DB, PRESSURE = 0.1, 0.02


def rows(path):
    with open(path, newline="") as file:
        return list(csv.reader(file))


def air(case):
    """Density in kg/m3 and speed of sound in m/s at the ambient state of the case."""
    inputs = {own["key"]: own["value"] for own in json.loads(pathlib.Path(case).read_text())["inputs"]}
    kelvin, gas = inputs["ambient.temperature"], inputs["ambient.gas_constant"]
    return inputs["ambient.pressure"] / (gas * kelvin), math.sqrt(inputs["ambient.heat_capacity_ratio"] * gas * kelvin)


def triangles(panels):
    """Corners of two triangles for every quadrilateral panel, one for every triangle."""
    for corners in panels:
        yield corners[:3]
        if len(corners) == 4:
            yield [corners[0], corners[2], corners[3]]


class Surface:
    """A closed surface with the image of the given panels in the floor, and its spaces of functions."""

    def __init__(self, places, panels, floor=None):
        own = np.array(list(triangles(panels)))
        points, places_of = self.weld(places)
        corners = places_of[own]
        self.values, self.own = own, len(own)
        if floor is not None:
            image = points.copy()
            image[:, 2] = 2.0 * floor - image[:, 2]
            points, both = self.weld(np.vstack([points, image]))
            mirrored = both[corners + len(image)][:, ::-1]
            corners = np.vstack([both[corners], mirrored])
            self.values = np.vstack([own, own[:, ::-1]])
        self.grid = bempp.Grid(points.T, corners.T.astype("uint32"))
        self.linear = bempp.function_space(self.grid, "P", 1)
        self.broken = bempp.function_space(self.grid, "DP", 1)
        identity = bempp.operators.boundary.sparse.identity
        self.mass = identity(self.linear, self.linear, self.linear).weak_form().to_sparse()

    @staticmethod
    def weld(places):
        """Distinct points, and the index of the point at each place."""
        _, first, index = np.unique(np.round(places, 5), axis=0, return_index=True, return_inverse=True)
        return places[first], index.ravel()

    def on_triangles(self, corner_values):
        """Coefficients of a linear function on each triangle from its values at the corners of the panels."""
        coefficients = np.zeros(self.broken.global_dof_count, dtype=complex)
        coefficients[self.broken.local2global] = corner_values[self.values]
        return coefficients

    def open_edges(self):
        """Number of edges that do not belong to exactly two triangles."""
        corners = self.grid.elements.T
        edges = np.sort(np.vstack([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]), axis=1)
        _, count = np.unique(edges, axis=0, return_counts=True)
        return int(np.sum(count != 2))

    def pressure(self, wavenumber, slope):
        """Linear pressure for its normal derivative (time factor exp(-i omega t)): p/2 - K p = -V dp/dn."""
        boundary = bempp.operators.boundary.helmholtz
        double = boundary.double_layer(self.linear, self.linear, self.linear, wavenumber).weak_form().to_dense()
        single = boundary.single_layer(self.broken, self.linear, self.linear, wavenumber).weak_form().to_dense()
        return np.linalg.solve(0.5 * self.mass.toarray() - double, -single @ slope)

    def at(self, points, wavenumber, pressure, slope):
        """Pressures in the air by the layers of the solution."""
        potential = bempp.operators.potential.helmholtz
        double = potential.double_layer(self.linear, points, wavenumber)
        single = potential.single_layer(self.broken, points, wavenumber)
        field = double * bempp.GridFunction(self.linear, coefficients=pressure)
        return (field - single * bempp.GridFunction(self.broken, coefficients=slope))[0]

    def flow(self, pressure, velocity):
        """The integral of p conj(v) over the triangles of the given panels."""
        area = self.grid.volumes[: self.own]
        p, v = pressure[self.linear.local2global[: self.own]], velocity[self.values[: self.own]].conj()
        # Integral of a product of two linear functions: area/12 (sum of p times sum of v + sum of the products).
        return np.sum(area / 12.0 * (p.sum(axis=1) * v.sum(axis=1) + (p * v).sum(axis=1)))


def sphere():
    """The largest part of the pressure by which a pulsating sphere of 320 flat triangles is wrong, ka = 1."""
    golden = 0.5 * (1.0 + math.sqrt(5.0))
    points = np.array([p for s in (1, -1) for t in (golden, -golden) for p in ((0, s, t), (s, t, 0), (t, 0, s))])
    edge = lambda a, b: abs(np.linalg.norm(points[a] - points[b]) - 2.0) < 1e-9  # noqa: E731
    count = range(len(points))
    faces = [[a, b, c] for a in count for b in count[a:] for c in count[b:] if edge(a, b) and edge(b, c) and edge(a, c)]
    corners = points[np.array(faces)].astype(float)
    for _ in range(2):
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        corners = np.stack([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]])
        corners = np.moveaxis(corners, 2, 1).reshape(-1, 3, 3)
    corners /= np.linalg.norm(corners, axis=2, keepdims=True)
    inward = np.linalg.det(corners) < 0.0
    corners[inward] = corners[inward][:, ::-1]
    ball = Surface(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    slope = ball.on_triangles(np.ones(3 * len(corners)))
    exact = 1.0 / (1j - 1.0)
    return np.abs(ball.pressure(1.0, slope) / exact - 1.0).max()


def main():
    folder, case = pathlib.Path(sys.argv[1]), sys.argv[2]
    started = time.perf_counter()
    print(f"pulsating sphere, 320 triangles, ka 1: {100.0 * sphere():.2f} %", flush=True)
    print(f"{time.perf_counter() - started:.0f} s, mainly to compile", flush=True)
    rho, speed = air(case)
    header, *table = rows(folder / "surface.csv")
    places = np.array([row[2:5] for row in table], dtype=float)
    panels = {}
    for index, row in enumerate(table):
        panels.setdefault(row[0], []).append(index)
    surface = Surface(places, panels.values(), places[:, 2].min())
    count, unknowns = surface.grid.number_of_elements, surface.linear.global_dof_count
    print(f"{count} triangles with their image, {unknowns} unknowns, {surface.open_edges()} open edges", flush=True)
    worst = [0.0, 0.0]
    print("Hz,energy [J/Hz],reference [J/Hz],difference [dB],pressures [Pa/Hz],largest difference [%],time [s]")
    for number, reference in enumerate(rows(folder / "surface-power.csv")[1:]):
        started = time.perf_counter()
        reference = [float(x) for x in reference]
        hz, energy = reference[:2]
        theirs = np.array(reference[3:]).reshape(-1, 2) @ [1.0, 1.0j]
        columns = slice(5 + 2 * number, 7 + 2 * number)
        assert header[columns][0] == f"Re v {hz:.4f} Hz [m]"
        # The files have the time factor exp(+j omega t): conjugate velocities give conjugate pressures.
        velocity = (np.array([row[columns] for row in table], dtype=float) @ [1.0, 1.0j]).conj()
        omega = math.tau * hz
        slope = surface.on_triangles(1j * omega * rho * velocity)
        pressure = surface.pressure(omega / speed, slope)
        found = 2.0 * surface.flow(pressure, velocity).real
        field = surface.at(POINTS, omega / speed, pressure, slope).conj()
        level = 10.0 * math.log10(found / energy)
        part = np.abs(field - theirs).max() / np.abs(theirs).max()
        worst = [max(worst[0], abs(level)), max(worst[1], part)]
        shown = " ".join(f"{p:.4e}" for p in np.abs(field))
        took = time.perf_counter() - started
        print(f"{hz:.4f},{found:.4e},{energy:.4e},{level:+.3f},{shown},{100.0 * part:.2f},{took:.0f}", flush=True)
    if worst[0] > ENERGY_DB or worst[1] > PRESSURE:
        sys.exit("the boundary element programs differ")


if __name__ == "__main__":
    main()
