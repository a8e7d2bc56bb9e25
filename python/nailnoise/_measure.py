"""The measurement side: levels from recordings of a wrapping test, and what such a test gives for a design."""

from __future__ import annotations

import json
import os
from typing import Any

from . import _native
from ._design import Design
from ._results import _Shown
from ._tables import decibels, table
from ._work import Cache, Progress, _cache, _reporter


class Measurement(_Shown):
    """Levels of the sources from recordings. ``data`` is measurement.json, ``json`` its text."""

    def __init__(self, text: str, charts: list[tuple[str, str]]) -> None:
        self.json, self.charts = text, dict(charts)
        self.data: dict[str, Any] = json.loads(text)

    @property
    def levels(self) -> dict[str, float | None]:
        """Level of each source less the residual [dB re 1 pW s]; None where nothing is left."""
        return {own["source"]: own["level"] and own["level"]["db"] for own in self.data["sources"]}

    @property
    def configurations(self) -> Any:
        """The configurations as recorded."""
        return table(self.data["configurations"], "name")

    @property
    def sources(self) -> Any:
        """The sources less the residual."""
        return table(self.data["sources"], "source")

    @property
    def notes(self) -> list[str]:
        """What a reader must know."""
        return list(self.data["notes"])

    def _shown(self) -> tuple[str, list[str], list[list[str]]]:
        def row(name: str, level: dict[str, Any] | None) -> list[str]:
            if level is None:
                return [name, "-", "-", "0"]
            return [name, decibels(level["db"]), f"{level['expanded_db']:.1f}", str(level["repeats"])]

        rows = [row(own["source"], own["level"]) for own in self.data["sources"]]
        rows += [row(own["name"], own["level"]) for own in self.data["configurations"] if not rows]
        title = f"{self.data['manifest']}: A-weighted single-event sound power levels re 1 pW s"
        return title, ["source", "L_WA,1s dB", "+-, k = 2", "shots"], rows


def measure(
    manifest: str | os.PathLike[str],
    *,
    reading: str = "margin",
    paired: bool = False,
    total_less_residual: bool = False,
    progress: Progress | bool | None = None,
) -> Measurement:
    """Levels of the sources from the recordings that a manifest names, as ``nailnoise measure``.

    ``reading`` says which lines the subtraction of the residual sets to zero: margin, corrected or literal.
    """
    return Measurement(*_native.measure(os.fspath(manifest), reading, paired, total_less_residual, _reporter(progress)))


class WrappingTest(_Shown):
    """What a wrapping test of a design gives in energies, as ``nailnoise test --energies``."""

    SOURCES = tuple(_native.ROLES)

    def __init__(self, text: str) -> None:
        self.json = text
        self.data: dict[str, Any] = json.loads(text)

    @property
    def levels(self) -> Any:
        """Each source alone (bare), and as the test states it less the residual [dB re 1 pW s]."""
        return table(self._rows(), "source")

    def _rows(self) -> list[dict[str, Any]]:
        columns = {"bare": "sources_db", "less_residual": "separated_db", "least_squares": "unmixed_db"}
        return [
            {"source": source, **{name: self.data[key][place] for name, key in columns.items()}} for place, source in enumerate(self.SOURCES)
        ]

    def _shown(self) -> tuple[str, list[str], list[list[str]]]:
        rows = [[own["source"], *(decibels(own[name]) for name in ("bare", "less_residual", "least_squares"))] for own in self._rows()]
        return "virtual wrapping test, levels in dB re 1 pW s", ["source", "bare", "less residual", "least squares"], rows


def test_energies(
    design: Design, *, perfect_wraps: bool = False, cache: Cache = None, progress: Progress | bool | None = None
) -> WrappingTest:
    """What the wrapping test of EN 12549 gives for a design, in energies, without recordings and scatter."""
    return WrappingTest(_native.test_energies(design._native, perfect_wraps, *_cache(cache), _reporter(progress)))
