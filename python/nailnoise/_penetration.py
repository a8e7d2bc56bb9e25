"""Penetration laws: published ones, tables, and fits to measured drives."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._blocks import _row
from ._results import Floats, _floats, _Shown
from ._tables import table
from ._work import Progress, _reporter


def penetration_names() -> dict[str, list[str]]:
    """Names of the published laws, and of the woods and nails of their tests."""
    return dict(zip(("laws", "woods", "nails"), _native.penetration_names()))


class Penetration(_Shown):
    """Force on a nail over its depth. ``band`` is the force with the root one standard error lower and higher; None without one."""

    def __init__(self, made: dict[str, Any]) -> None:
        self.name = str(made["name"])
        self.charts = dict(made["charts"])
        self.depth, self.force, self.work = (_floats(made[name]) for name in ("depth", "force", "work"))
        """Depth [m], force [N], and work from the surface on [J]."""
        self.band: Floats | None = _floats(made["band"]).reshape(-1, 2) if "band" in made else None
        self.notes: list[str] = list(made["notes"])
        """What limits the use of the law."""

    @property
    def table(self) -> Any:
        """A row for each depth."""
        return table([{"depth": depth, "force": force, "work": work} for depth, force, work in zip(self.depth, self.force, self.work)])

    def _shown(self) -> tuple[str, list[str], list[list[str]]]:
        places = np.linspace(0, len(self.depth) - 1, min(len(self.depth), 11)).astype(int)
        rows = [[f"{1e3 * self.depth[own]:.1f}", f"{self.force[own]:.0f}", f"{self.work[own]:.2f}"] for own in places]
        return f"{self.name}: force on the nail", ["depth mm", "force N", "work J"], rows


def penetration(
    law: str | os.PathLike[str],
    *,
    wood: str = "Douglas-fir plywood",
    nail: str = "16d",
    speed: float = 0.8466e-3,
    depths: ArrayLike | None = None,
) -> Penetration:
    """Force over depth of a published law at a penetration speed [m/s], or of a table in a CSV file of depths [m] and forces [N].

    ``penetration_names()`` lists laws, woods and nails. Without ``depths`` [m] there are 201 over the nail's length.
    """
    given = os.fspath(law)
    of_file = Path(given).suffix.lower() == ".csv"
    points = None if depths is None else _row("depths", depths)
    made = _native.penetration_curve(None if of_file else given, given if of_file else None, wood, nail, speed, points)
    return Penetration(made)


class PenetrationFit(_Shown):
    """A law fitted to measured drives. ``data`` is the law, ``fitting`` its validation, reduction and conditions."""

    def __init__(self, made: dict[str, Any]) -> None:
        self.data: dict[str, Any] = json.loads(made["fit"])
        self.fitting: dict[str, Any] = json.loads(made["fitting"])
        self.toml = str(made["toml"])
        """The text of fit.toml, as `wood.penetration_fit` of a design names it."""
        self.residuals = _floats(made["residuals"])
        """Root of the measured force less that of the law, by point."""
        self.charts = dict(made["charts"])

    @property
    def terms(self) -> Any:
        """Coefficient and standard error of each term."""
        return table(self.data["terms"], "name")

    @property
    def conditions(self) -> Any:
        """Force [N], 95 % bands and work of the law under each condition of the data."""
        return table(self.fitting["conditions"], "group")

    @property
    def notes(self) -> list[str]:
        """What a reader must know."""
        return list(self.fitting["notes"])

    def write(self, path: str | os.PathLike[str] = "fit.toml") -> Path:
        """Writes the law for designs."""
        file = Path(path)
        file.write_text(self.toml)
        return file

    def _shown(self) -> tuple[str, list[str], list[list[str]]]:
        quality = self.data["quality"]
        title = f"fitted penetration law: R2 {100 * quality['r_squared']:.2f} %, standard error {quality['standard_error_n']:.1f} N"
        rows = [[own["name"], f"{own['coefficient']:.4e}", f"{own['standard_error']:.1e}"] for own in self.data["terms"]]
        return title, ["term", "coefficient", "standard error"], rows


def fit_penetration(
    *files: str | os.PathLike[str],
    form: str | None = None,
    method: str | None = None,
    reduce: bool = False,
    leave: str | None = None,
    split: bool = False,
    start: float | None = None,
    rate: str | None = None,
    friction_share: float | None = None,
    extrapolate: bool = False,
    progress: Progress | bool | None = None,
) -> PenetrationFit:
    """Fits a law to the drives of CSV files, as ``nailnoise penetration fit``: terms of ``form``; ``method`` least-squares or within-between;
    ``reduce`` drops terms; cross-validation leaves out a group, nail, wood or drive; ``start`` is the force [N] at the tip.
    ``rate`` reduces drives at known speeds to the quasi-static law: ``speed`` by the published coefficients, ``estimate`` by fitted ones;
    ``friction_share`` [-] is the share of friction in the force at full depth.
    """
    if not files:
        raise ValueError("a fit needs a file of drives")
    paths: Sequence[str] = [os.fspath(file) for file in files]
    return PenetrationFit(
        _native.fit_penetration(
            list(paths), form, method, reduce, leave, split, start, rate, friction_share, extrapolate, _reporter(progress)
        )
    )
