"""Calibration: the ranges of a design conditioned on measurements of the tool."""

from __future__ import annotations

import csv
import io
import json
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from . import _native
from ._cluster import Cluster
from ._design import Design, load
from ._results import _Shown
from ._tables import table
from ._work import Cache, Progress, _cache, _reporter, _shown

if TYPE_CHECKING:
    from distributed import Client

#: Files of a calibrated design: the design, and the joint draws that it names.
_DESIGN, _JOINT = "calibrated.toml", "calibrated.draws"


class Calibration(_Shown):
    """A design conditioned on measurements. ``data`` is calibration.json, ``json`` its text, ``csv`` that of posterior.csv.

    All numbers are in SI units, levels in dB."""

    def __init__(
        self, files: tuple[str, str, str, str, list[tuple[str, str]]], folder: Path, own: tempfile.TemporaryDirectory[str] | None
    ) -> None:
        self.json, self.csv, design, joint, charts = files
        self.data: dict[str, Any] = json.loads(self.json)
        self.charts, self._own = dict(charts), own
        folder.mkdir(parents=True, exist_ok=True)
        (folder / _JOINT).write_text(joint, encoding="utf-8")
        (folder / _DESIGN).write_text(design, encoding="utf-8")
        self.design: Design = load(folder / _DESIGN)
        """The calibrated design: its ranges contain the draws, and studies of it draw them jointly."""

    @property
    def converged(self) -> bool:
        """Whether every diagnostic is within its limit; ``faults`` lists the others."""
        return bool(self.data["converged"])

    @property
    def faults(self) -> list[str]:
        """Diagnostics beyond their limits."""
        return list(self.data["faults"])

    @property
    def inputs(self) -> Any:
        """Inputs, what moved most first: P5 and P95 before and now, ratio of the widths, and the value of the middle draw."""
        return table([_flat(own, ("before", "now")) for own in self.data["inputs"]], "name")

    @property
    def moved(self) -> list[str]:
        """Names of the inputs that moved by more than chance."""
        return [own["name"] for own in self.data["inputs"] if own["ratio"] < self.data["moved_below"]]

    @property
    def measured(self) -> Any:
        """The measurements: reading, P5 and P95 of its prediction before and now, what is left over, and verdict."""
        return table([_flat(own, ("reading", "before", "now")) for own in self.data["measurements"]], "name")

    @property
    def conflicts(self) -> list[dict[str, Any]]:
        """Measurements that contradict each other or the ranges, with what would have to give."""
        return list(self.data["conflicts"])

    @property
    def figures(self) -> Any:
        """Figures of the design's own shot: P5, P50 and P95 before and now."""
        return table([_flat(own, ("before", "now")) for own in self.data["figures"]], "name")

    @property
    def levels(self) -> Any:
        """Level of each source and of the total [dB re 1 pW s] without measured levels and with them; empty without any."""
        return table([_flat(own, ("ranges", "before", "now")) for own in self.data["levels"]], "output")

    @property
    def next(self) -> Any:
        """What to measure next, what an hour of work makes narrowest first; empty unless asked for with ``next=True``."""
        rows = [{**own, "width": own["width"][1], "first": own["first"][1]} for own in self.data["next"]]
        return table(rows, "measurement")

    @property
    def draws(self) -> Any:
        """A row a draw: values of the inputs, predicted measurements, figures and levels, as a table."""
        rows = [{name: float(value or "nan") for name, value in row.items()} for row in csv.DictReader(io.StringIO(self.csv))]
        return table(rows, "draw")

    @property
    def notes(self) -> list[str]:
        """What a reader must know."""
        return list(self.data["notes"])

    def _shown(self) -> tuple[str, list[str], list[list[str]]]:
        def ends(pair: list[float | None]) -> str:
            low, high = ("" if own is None else f"{own:.4g}" for own in pair)
            return low if low == high else f"{low} .. {high}"

        rows = [
            [own["name"], own["unit"], ends(own["reading"]), ends(own["before"]), ends(own["now"]), own["verdict"].replace("_", " ")]
            for own in self.data["measurements"]
        ]
        title = f"{self.data['design']['name']}: {self.data['draws']} draws given {self.data['measured']}"
        title += "".join(f"\nATTENTION: not converged: {fault}" for fault in self.faults)
        return title, ["measurement", "unit", "value", "before, 90 %", "now, 90 %", "verdict"], rows


def _flat(row: dict[str, Any], intervals: Sequence[str]) -> dict[str, Any]:
    """A row with a column for each end of its intervals, and for the middle of those that have one."""
    ends = {2: ("low", "high"), 3: ("p05", "p50", "p95")}
    flat: dict[str, Any] = {}
    for name, value in row.items():
        if name in intervals and value is not None:
            flat |= {f"{name}_{end}": own for end, own in zip(ends[len(value)], value)}
        else:
            flat[name] = value
    return flat


def calibrate(
    design: Design,
    measured: str | os.PathLike[str] | None = None,
    *,
    draws: int = 512,
    moves: int = 24,
    seed: int = 1,
    hold_out: Sequence[str] = (),
    conflict: Literal["leave-out", "widen"] = "leave-out",
    next: bool = False,
    levels: int = 128,
    redraw: Sequence[Literal["board", "nails", "support"]] = (),
    client: Client | None = None,
    out: str | os.PathLike[str] | None = None,
    cache: Cache = None,
    store: str | os.PathLike[str] | None = None,
    progress: Progress | bool | None = None,
) -> Calibration:
    """Conditions the ranges of a design on the measurements in a file, as ``nailnoise calibrate``.

    ``hold_out`` names measurements that are only predicted. ``next`` ranks further measurements, and needs no file. ``redraw`` names
    what the calibrated design draws from the ranges of the design, for shots with others than those measured. ``out`` is a folder for
    the calibrated design and its joint draws; without it they are in a temporary folder that lives as long as the result. ``store`` is a
    folder that keeps candidates and draws in place of the cache; a calibration that was cut off continues from there.
    With ``client`` the workers of a cluster of Dask compute the shots of the sampler; measured levels are computed here.
    """
    own = tempfile.TemporaryDirectory(prefix="nailnoise-calibrated-") if out is None else None
    folder = Path(own.name if own is not None else os.fspath(out or "")).absolute()
    tasks, workers = None, 0
    if client is not None:
        if measured is None:
            raise ValueError("client computes the shots of a calibration: give a file of measurements")
        cluster = Cluster(client, None, "", None)
        tasks, workers = cluster.of_calibration(design, os.path.abspath(measured), draws, seed), cluster.threads()
    files = _native.calibrate(
        design._native,
        None if measured is None else os.fspath(measured),
        draws,
        moves,
        seed,
        list(hold_out),
        conflict,
        next,
        levels,
        list(redraw),
        os.fspath(folder),
        *_cache(cache),
        None if store is None else os.path.abspath(store),
        _reporter(_shown(progress)),
        tasks,
        workers,
    )
    return Calibration(files, folder, own)
