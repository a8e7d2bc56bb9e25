"""A design that an optimiser proposes: its figures, and how far it is beyond each constraint."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from . import _native
from ._design import Design, Value, _text
from ._work import Cache, _cache, _reporter, cycle

#: Sources and their sum, whose levels are in dB.
LEVELS = ("total", *_native.SOURCES)

#: Unit and factor to SI of the figures in a constraint.
UNITS = {
    "": 1.0, "m": 1.0, "mm": 1e-3, "m/s": 1.0, "N": 1.0, "kN": 1e3, "kg": 1.0, "g": 1e-3, "J": 1.0, "s": 1.0, "ms": 1e-3, "dB": 1.0,
}  # fmt: skip

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*$")


def _unit_of(figure: str) -> str:
    """SI unit of a figure; empty for plain numbers."""
    if figure in LEVELS:
        return "dB"
    if figure in ("penetration", "head_depth"):
        return "m"
    ends = {"_force": "N", "_mass": "kg", "_energy": "J", "_speed": "m/s"}
    return next((unit for end, unit in ends.items() if figure.endswith(end)), "m/s" if figure.startswith("speed_") else "")


def number(text: str) -> tuple[float, str]:
    found = _NUMBER.match(text)
    if found is None:
        raise ValueError(f"`{text}` does not begin with a number")
    return float(found[1]), found[2]


@dataclass(frozen=True)
class Constraint:
    """A figure of the shot, or a level, that must not be beyond a limit; or the outcome that the shot must have."""

    text: str
    figure: str
    sign: float
    limit: float
    outcome: str = ""

    @classmethod
    def parse(cls, text: str) -> Constraint:
        """``"penetration >= 80 mm"``, ``"exhaust <= 92 dB"``, ``"outcome == drives"``."""
        found = re.fullmatch(r"\s*(\w+)\s*(>=|<=|==|=)\s*(.+)", text)
        if found is None:
            raise ValueError(f"`{text}` is no constraint; give FIGURE >= VALUE, FIGURE <= VALUE or outcome == drives")
        figure, relation, value = found[1], found[2], found[3].strip()
        if figure == "outcome":
            return cls(text, figure, 0.0, 0.0, value.replace(" ", "_"))
        if relation not in (">=", "<="):
            raise ValueError(f"`{text}`: a figure is held by >= or <=")
        limit, unit = number(value)
        if unit not in UNITS:
            raise ValueError(f"`{unit}` is no unit of a constraint; units are {', '.join(filter(None, UNITS))}")
        expected = _unit_of(figure)
        if {"mm": "m", "kN": "N", "g": "kg", "ms": "s"}.get(unit, unit) != expected:
            raise ValueError(f"`{text}`: the unit of {figure} is {expected or 'none'}")
        return cls(text, figure, 1.0 if relation == "<=" else -1.0, limit * UNITS[unit])

    def excess(self, figures: Mapping[str, Any]) -> float:
        """How far a shot is beyond the limit, in parts of it; at most 0 where the constraint is met."""
        if self.figure == "outcome":
            return 0.0 if figures["outcome"] == self.outcome else 1.0
        if self.figure not in figures:
            known = ", ".join(sorted(key for key, value in figures.items() if isinstance(value, float)))
            raise ValueError(f"there is no figure `{self.figure}`; there are {known}")
        value = figures[self.figure]
        if value is None:
            # Silence is below any limit, and a phase that does not occur has no figure.
            return -1.0 if self.figure in LEVELS and self.sign > 0.0 else 1.0
        return self.sign * (float(value) - self.limit) / (abs(self.limit) or 1.0)


def figures_of(design: Design) -> dict[str, Any]:
    """Figures of a shot; ``drive_energy`` is the work that nail and wood take up [J]."""
    shot = cycle(design)
    return {**shot.data["summary"], "outcome": shot.outcome, "drive_energy": shot.data["energy"]["penetration"]}


def _levels(design: Design, key: str, cache: Cache) -> dict[str, float | None]:
    """Levels of the sources and of all together [dB re 1 pW s]."""
    value = design.entry(key)["value"]
    text, _ = _native.sweep(design._native, [f"{key}={_text(value)}"], None, 1, *_cache(cache), _reporter(None))
    (point,) = json.loads(text)
    if point["levels"] is None:
        raise _native.NailnoiseError(point["refused"])
    return {**{own["source"]: own["lwa_db"] for own in point["levels"]["sources"]}, "total": point["total_db"]}


@dataclass
class Proposal:
    """A design that was tried."""

    values: dict[str, Value]
    #: Figures of the shot and, if these meet the constraints, levels.
    figures: dict[str, Any]
    feasible: bool
    #: Why it is not a design; empty for a design.
    refused: str = ""

    @property
    def has_levels(self) -> bool:
        """Whether its sound was computed: its shot meets the constraints."""
        return "total" in self.figures

    def toml(self, base: str, before: Mapping[str, Value] | None = None) -> str:
        """The design as a file over its base, with values that were set before."""
        values = {**(before or {}), **self.values}
        lines = [f"base = {json.dumps(base)}", *(f"{key} = {_toml(value)}" for key, value in values.items())]
        return "\n".join(lines) + "\n"


def _toml(value: Value) -> str:
    """A value in a design file: a text that is a number, a switch or a table there is none in quotes."""
    if not isinstance(value, str):
        return _text(value)
    try:
        tomllib.loads(f"value = {value}")
    except tomllib.TOMLDecodeError:
        return json.dumps(value)
    return value


Values = dict[str, Value]
Tried = tuple[Proposal, dict[str, float]]


def try_design(design: Design, key: str, values: Values, constraints: Sequence[Constraint], cache: Cache) -> Tried:
    """A design with these values, and how far it is beyond each constraint; ``key`` is one of those varied."""
    excesses: dict[str, float] = {"is a design": 0.0}
    try:
        own = design.with_(values)
        figures = figures_of(own)
        of_shot = [constraint for constraint in constraints if constraint.figure not in LEVELS]
        excesses |= {constraint.text: constraint.excess(figures) for constraint in of_shot}
        if all(excess <= 0.0 for excess in excesses.values()):
            figures |= _levels(own, key, cache)
            of_levels = [constraint for constraint in constraints if constraint.figure in LEVELS]
            excesses |= {constraint.text: constraint.excess(figures) for constraint in of_levels}
    except _native.NailnoiseError as error:
        return Proposal(values, {}, False, str(error)), {"is a design": 1.0}
    return Proposal(values, figures, all(excess <= 0.0 for excess in excesses.values())), excesses
