"""Building blocks for one's own meshes and records: radiation, modes, exhaust noise, levels and bands. All in SI units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._results import Floats, _floats
from ._tables import table


def _points(points: ArrayLike) -> list[tuple[float, float, float]]:
    array = np.asarray(points, dtype=float)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"points are rows of x, y and z, found an array of shape {array.shape}")
    return [(float(x), float(y), float(z)) for x, y, z in array]


def _row(name: str, values: ArrayLike, length: int | None = None) -> list[float]:
    """The numbers of an array of one dimension. One of several would be read row by row, which mixes its columns."""
    array = np.asarray(values, dtype=float)
    if array.ndim != 1:
        raise ValueError(f"{name} is an array of one dimension, found one of shape {array.shape}; give one column at a time")
    if length is not None and len(array) != length:
        raise ValueError(f"{name} has {len(array)} values, expected {length}")
    numbers: list[float] = array.tolist()
    return numbers


def radiated_power(points: ArrayLike, triangles: ArrayLike, velocity: ArrayLike, hz: float) -> float:
    """Power [W] that a closed surface of triangles radiates into free air at 20 degC and 101 325 Pa, by boundary elements.

    The corners of a triangle run counter-clockwise as seen from outside; ``velocity`` is the normal one at each point [m/s, rms].
    """
    rows = np.asarray(triangles)
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise ValueError(f"triangles are rows of three numbers of points, found an array of shape {rows.shape}")
    corners = [(int(a), int(b), int(c)) for a, b, c in rows]
    places = _points(points)
    return _native.radiated_power(places, corners, _row("velocity", velocity, len(places)), float(hz))


@dataclass(frozen=True)
class Elastic:
    """A linear elastic material with axes x, y, z: Young's and shear moduli [Pa], Poisson ratios, density [kg/m3]."""

    constants: tuple[float, float, float, float, float, float, float, float, float]
    density: float

    @classmethod
    def isotropic(cls, young: float, poisson: float, density: float) -> Elastic:
        """The same in all directions."""
        shear = young / (2.0 * (1.0 + poisson))
        return cls((young, young, young, shear, shear, shear, poisson, poisson, poisson), density)

    @classmethod
    def orthotropic(
        cls, e: tuple[float, float, float], g: tuple[float, float, float], nu: tuple[float, float, float], density: float
    ) -> Elastic:
        """Wood along x: E_1, E_2, E_3; G_12, G_13, G_23; nu_12, nu_13, nu_23, where nu_ij is the contraction along j by a pull along i."""
        return cls((*e, *g, *nu), density)


@dataclass(frozen=True)
class MeshModes:
    """All modes of a mesh below a frequency; a Sturm count proves that none is missing."""

    hz: Floats
    rigid: NDArray[np.bool_]
    shapes: Floats
    """Mode x node x direction, of unit modal mass [kg^-1/2]."""
    residuals: Floats


def mesh_modes(
    nodes: ArrayLike, elements: Sequence[ArrayLike], material: Elastic, top_hz: float, *, held: Sequence[int] = ()
) -> MeshModes:
    """Modes of a mesh below ``top_hz``: elements of 4, 10 (tetrahedra), 8, 20, 27 (hexahedra) or 15 (wedges) nodes in the order of VTK.

    ``elements`` is one array of node numbers, or several for several kinds; nodes of ``held`` do not move.
    """
    blocks = [np.atleast_2d(np.asarray(block, dtype=int)) for block in elements] if not isinstance(elements, np.ndarray) else [elements]
    for block in blocks:
        if block.ndim != 2:
            raise ValueError(f"elements are rows of node numbers, found an array of shape {block.shape}")
    rows = [[int(node) for node in row] for block in blocks for row in block]
    points = _points(nodes)
    made = _native.mesh_modes(points, rows, material.constants, material.density, float(top_hz), [int(node) for node in held])
    hz = _floats(made["hz"])
    shapes = _floats(made["shapes"]).reshape(len(hz), len(points), 3)
    return MeshModes(hz, np.array(made["rigid"], dtype=bool), shapes, _floats(made["residuals"]))


@dataclass(frozen=True)
class ExhaustLevels:
    """Noise of an outflow: levels [dB re 1 pW s], and energy over frequency [J/Hz]."""

    lwa: float | None
    lw: float | None
    parts: dict[str, float | None]
    """A-weighted levels of mixing noise, shock noise and unsteady flow."""
    bands: Any
    frequency: Floats
    energy_density: Floats
    mass: float
    """Mass that left [kg]."""
    jet_mass: float
    """Mass of the isentropic jets [kg]: near ``mass`` where areas and pressures agree with the flow."""


def exhaust_levels(
    sample_interval: float,
    mass_flow: ArrayLike,
    pressure: ArrayLike,
    temperature: ArrayLike,
    *,
    holes: int,
    diameter: float,
    discharge_coefficient: float = 0.8,
    pitch: float | None = None,
    air: tuple[float, float] = (293.15, 101_325.0),
    range_hz: tuple[float, float] = (20.0, 20_000.0),
) -> ExhaustLevels:
    """Levels of the air that leaves through round holes, from its flow: mass flow [kg/s], absolute stagnation pressure [Pa] and
    temperature [K] before the holes at equal intervals [s]. ``air`` is temperature [K] and pressure [Pa] outside."""
    flow = _row("mass_flow", mass_flow)
    before, warmth = _row("pressure", pressure, len(flow)), _row("temperature", temperature, len(flow))
    opening = (holes, diameter, discharge_coefficient, pitch)
    made = _native.exhaust_levels(float(sample_interval), flow, before, warmth, opening, air, range_hz)
    return ExhaustLevels(
        made["lwa"], made["lw"], dict(made["parts"]), _bands(made["bands"]), _floats(made["frequency"]),
        _floats(made["energy_density"]), made["mass"], made["jet_mass"],
    )  # fmt: skip


@dataclass(frozen=True)
class SignalLevels:
    """Levels of a record of sound pressure [dB re 20 uPa]."""

    exposure: dict[str, float | None]
    """Sound exposure levels L_E by weighting: A, C, Z."""
    peak: dict[str, float | None]
    """Peak sound levels by weighting: C, Z."""
    bands: Any
    """One-third-octave bands of the sound exposure level, unweighted and A-weighted."""


def signal_levels(pressure: ArrayLike, sample_rate: float) -> SignalLevels:
    """Levels of a single event (IEC 61672-1) from the record of one channel of sound pressure [Pa]."""
    if not sample_rate > 0.0:
        raise ValueError(f"a record has a positive number of samples a second, found {sample_rate}")
    made = _native.signal_levels(_row("pressure", pressure), float(sample_rate))
    return SignalLevels(dict(made["exposure"]), dict(made["peak"]), _bands(made["bands"]))


def _bands(rows: Sequence[tuple[float, float | None, float | None]]) -> Any:
    return table([{"hz": hz, "unweighted_db": z, "a_weighted_db": a} for hz, z, a in rows], "hz")
