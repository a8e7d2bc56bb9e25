"""Results: numpy arrays, tables, and how they look in a notebook."""

from __future__ import annotations

import io
import json
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._tables import as_figures, as_html, as_text, decibels, table

Floats = NDArray[np.float64]


def _floats(data: bytes) -> Floats:
    return np.frombuffer(data, dtype=np.float64)


def _xarray() -> Any:
    """xarray, for arrays with their coordinates."""
    try:
        import xarray
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError("arrays with coordinates need xarray: pip install xarray") from error
    return xarray


class _Shown:
    """A result that is shown as a table, in a notebook with its charts. ``charts`` maps their names to SVG."""

    charts: dict[str, str] = {}

    def _shown(self) -> tuple[str, list[str], list[list[str]]]:
        raise NotImplementedError

    def __repr__(self) -> str:
        title, headings, rows = self._shown()
        return f"{title}\n{as_text(headings, rows)}"

    def _repr_html_(self) -> str:
        return as_html(*self._shown()) + as_figures(self.charts)


def _headline(found: dict[str, Any] | None) -> list[str]:
    """The sentence of a headline, marked as an alarm, and its inputs."""
    if found is None:
        return []
    inputs = [f"{own['key']} {own['from']} -> {own['to']} ({own['outcome'].replace('_', ' ')})" for own in found["inputs"]]
    advice = [f"inputs that would change it most: {'; '.join(inputs)}"] if inputs else []
    return [f"ATTENTION: {found['text']}", *advice]


class Run(_Shown):
    """The ranked sources of a design. ``data`` is result.json as a dictionary, ``json`` its text."""

    #: Samples per second of ``sound``.
    sample_rate = 48_000

    def __init__(self, text: str, signals: dict[str, list[bytes]], charts: list[tuple[str, str]]) -> None:
        self.json, self.charts = text, dict(charts)
        self.data: dict[str, Any] = json.loads(text)
        self.sound: dict[str, Floats] = {
            source: np.stack([_floats(signal) for signal in microphones]) for source, microphones in signals.items()
        }
        """Sound pressure of each source at each microphone from the trigger on: microphones x samples [Pa]."""

    @property
    def name(self) -> str:
        """Name of the design."""
        return str(self.data["design"]["name"])

    @property
    def total_db(self) -> float | None:
        """Level of all sources together [dB re 1 pW s]."""
        level: float | None = self.data["total"]["lwa_db"]
        return level

    @property
    def levels(self) -> dict[str, float | None]:
        """Level of each source, loudest first [dB re 1 pW s]; None for silence."""
        return {source["source"]: source["lwa_db"] for source in self.data["ranking"]}

    @property
    def ranking(self) -> Any:
        """Sources, loudest first, as a table."""
        columns = ("source", "lwa_db", "lw_db", "share")
        return table([{name: source[name] for name in columns} for source in self.data["ranking"]], "source")

    @property
    def study(self) -> dict[str, Any] | None:
        """What a study that serves the design says about the levels: draws, intervals, orders; None without one."""
        study: dict[str, Any] = self.data["study"]
        return study if study["state"] == "known" else None

    @property
    def no_study(self) -> str | None:
        """Why no intervals are stated; None where they are."""
        return None if self.study else str(self.data["study"]["reason"])

    @property
    def intervals(self) -> Any:
        """Interval of each source and of the total [dB re 1 pW s] and P(first), as a table; empty without a study.

        The ends are P5 and P95 from 32 draws, else the lowest and the highest level (``study["ends"]``)."""
        spreads = [*self.study["sources"], self.study["total"]] if self.study else []
        return table(spreads, "source")

    @property
    def orders(self) -> list[tuple[list[str], float]]:
        """Orders of the sources, loudest first, with their shares of the draws; empty without a study."""
        return [(list(own["order"]), float(own["share"])) for own in (self.study or {}).get("orders", [])]

    @property
    def k_db(self) -> int | None:
        """K of the declaration [dB]; None where it is not stated, for the reason ``data["declaration"]["k_not_stated"]``."""
        k: int | None = self.data["declaration"]["k_db"]
        return k

    @property
    def bands(self) -> Any:
        """A-weighted one-third-octave levels [dB re 1 pW s]: a row a band, a column a source."""
        rows: dict[float, dict[str, Any]] = {}
        for source in self.data["ranking"]:
            for band in source["bands"]:
                rows.setdefault(band["hz"], {"hz": band["hz"]})[source["source"]] = band["lwa_db"]
        return table(list(rows.values()), "hz")

    def to_xarray(self) -> Any:
        """Levels of the sources in bands [dB re 1 pW s] and sound pressure at the microphones [Pa], as a data set of xarray."""
        xarray = _xarray()
        hz = [band["hz"] for band in self.data["ranking"][0]["bands"]]
        levels = [[band["lwa_db"] for band in source["bands"]] for source in self.data["ranking"]]
        names = list(self.levels)
        units = {"units": "dB re 1 pW s", "weighting": "A"}
        arrays = {
            "lwa_band": (("source", "hz"), np.array(levels, dtype=float), units),
            "lwa": ("source", np.array(list(self.levels.values()), dtype=float), units),
        }
        coordinates: dict[str, Any] = {"source": names, "hz": ("hz", hz, {"units": "Hz"})}
        if self.sound:
            sound = np.stack(list(self.sound.values()))
            arrays["pressure"] = (("heard", "microphone", "time"), sound, {"units": "Pa", "weighting": "none"})
            coordinates |= {"heard": list(self.sound), "time": np.arange(sound.shape[2]) / self.sample_rate}
        return xarray.Dataset(arrays, coordinates, {"design": self.name})

    @property
    def events(self) -> dict[str, float | None]:
        """Times of the events t0 .. t18 [s]."""
        return dict(self.data["events"])

    @property
    def outcome(self) -> str:
        """What the shot did: ``drives``, ``underdriven`` and so on."""
        return str(self.data["outcome"])

    @property
    def performance(self) -> dict[str, float | None]:
        """What the shot has left and consumes: ``head_depth_m``, ``energy_left_j`` at flush, ``air_m3``, ``shots_per_second``."""
        return dict(self.data["performance"])

    @property
    def headline(self) -> list[str]:
        """How a shot ended that does not drive, and which inputs would change that most; empty for one that drives."""
        return _headline(self.data.get("headline"))

    @property
    def failed_checks(self) -> list[str]:
        """Names of checks that do not hold: with one, do not rely on the result."""
        return [check["name"] for check in self.data["checks"] if not check["ok"]]

    def _shown(self) -> tuple[str, list[str], list[list[str]]]:
        title = "".join(f"{line}\n" for line in self.headline)
        title += f"{self.name}: single-event sound power levels re 1 pW s, one shot"
        if self.failed_checks:
            title += f"; do not rely on them, because checks failed: {', '.join(self.failed_checks)}"
        rows = [
            [source["source"], decibels(source["lwa_db"]), decibels(source["lw_db"]), f"{100 * source['share']:.1f} %"]
            for source in self.data["ranking"]
        ]
        rows.append(["total", decibels(self.total_db), decibels(self.data["total"]["lw_db"]), ""])
        headings = ["source", "L_WA,1s dB", "L_W,1s dB", "share (A)"]
        if self.study:
            spreads = {own["source"]: own for own in [*self.study["sources"], self.study["total"]]}
            headings.append("90 % of draws dB" if self.study["ends"] == "percentiles" else f"{self.study['draws']} draws dB")
            for row in rows:
                own = spreads[row[0]]
                row.append(f"{decibels(own['low_db'])} .. {decibels(own['high_db'])}")
        return title, headings, rows


class Cycle(_Shown):
    """One nailing cycle. Histories are arrays by name: ``cycle["piston_velocity"]`` [m/s] over ``cycle.time`` [s]."""

    def __init__(self, name: str, text: str, histories: dict[str, tuple[str, bytes]], charts: list[tuple[str, str]]) -> None:
        self.name, self.charts = name, dict(charts)
        self.data: dict[str, Any] = json.loads(text)
        self.units = {key: unit for key, (unit, _) in histories.items()}
        self._histories = {key: _floats(data) for key, (_, data) in histories.items()}

    def __getitem__(self, name: str) -> Floats:
        return self._histories[name]

    @property
    def names(self) -> list[str]:
        """Names of the histories."""
        return list(self._histories)

    @property
    def time(self) -> Floats:
        """Times of the samples [s]."""
        return self._histories["time"]

    @property
    def outcome(self) -> str:
        """What the shot did: ``drives``, ``underdriven`` and so on."""
        return str(self.data["outcome"])

    @property
    def events(self) -> dict[str, float | None]:
        """Times of the events t0 .. t18 [s]."""
        return dict(self.data["events"])

    def to_xarray(self) -> Any:
        """All histories over time [s], as a data set of xarray with their units."""
        histories = {name: ("time", self[name], {"units": self.units[name]}) for name in self._histories if name != "time"}
        return _xarray().Dataset(histories, {"time": ("time", self.time, {"units": "s"})}, {"design": self.name})

    @property
    def histories(self) -> Any:
        """All histories as a table over time."""
        names = [name for name in self._histories if name != "time"]
        try:
            import pandas
        except ModuleNotFoundError:
            return dict(self._histories)
        return pandas.DataFrame({name: self._histories[name] for name in names}, index=pandas.Index(self.time, name="time"))

    def _shown(self) -> tuple[str, list[str], list[list[str]]]:
        rows = [[event, "-" if time is None else f"{1e3 * time:.3f}"] for event, time in self.events.items()]
        return f"{self.name}: {self.outcome.replace('_', ' ')}", ["event", "time ms"], rows


class Modes(_Shown):
    """Modes of a body. ``shapes`` is modes x nodes x 3 [kg^-1/2] (of unit modal mass), ``points`` nodes x 3 [m].

    ``faces`` has the outer faces as ``pyvista.PolyData(modes.points, modes.faces)`` takes them: the number of corners of a face, then
    its nodes, face after face.
    """

    def __init__(self, body: str, made: dict[str, Any]) -> None:
        self.body = body
        self.hz = _floats(made["hz"])
        self.rigid = np.array(made["rigid"], dtype=bool)
        self.loss_factor = float(made["loss_factor"])
        self.modes_there_are = int(made["modes_there_are"])
        self.points = _floats(made["points"]).reshape(-1, 3)
        self.shapes = _floats(made["shapes"]).reshape(len(self.hz), -1, 3)
        self.faces: NDArray[np.int64] = np.array(made["faces"], dtype=np.int64)

    def moved(self, mode: int, amplitude: float | None = None) -> Floats:
        """Points displaced by a mode, counted from 0: the largest displacement is ``amplitude`` [m], else 6 % of the body's diagonal."""
        shape = self.shapes[mode]
        largest = float(np.linalg.norm(shape, axis=1).max())
        if amplitude is None:
            amplitude = 0.06 * float(np.linalg.norm(np.ptp(self.points, axis=0)))
        moved: Floats = self.points + (amplitude / largest if largest > 0.0 else 0.0) * shape
        return moved

    def _shown(self) -> tuple[str, list[str], list[list[str]]]:
        rows = [[str(place + 1), f"{hz:.2f}"] for place, hz in enumerate(self.hz) if not self.rigid[place]]
        return f"{self.body}: {len(self.hz)} modes, {int(self.rigid.sum())} of them rigid", ["mode", "Hz"], rows[:20]


class Comparison(_Shown):
    """Runs side by side. ``data`` is what ``nailnoise compare --json`` prints; with draws it has ``paired``, too."""

    def __init__(self, text: str, paired: str | None = None) -> None:
        self.data: dict[str, Any] = json.loads(text)
        if paired is not None:
            self.data["paired"] = json.loads(paired)

    @property
    def changes(self) -> Any:
        """Change of each level from the first design over common draws [dB], as a table: P5, P50, P95 and P(quieter); empty without
        draws."""

        def row(paired: dict[str, Any], change: dict[str, Any]) -> dict[str, Any]:
            of_change = {key: change["change_db"][key]["value"] for key in ("p05", "p50", "p95")}
            return {"design": paired["design"], "source": change["source"], **of_change, "quieter": change["quieter"]["value"]}

        return table([row(paired, change) for paired in self.data.get("paired", []) for change in paired["changes"]])

    @property
    def levels(self) -> Any:
        """Level of each source in each run [dB re 1 pW s], as a table."""
        return table(self._rows(), "source")

    def _rows(self) -> list[dict[str, Any]]:
        sources = [*self.data["sources"], {"source": "total", **self.data["total"]}]
        return [{"source": own["source"], **dict(zip(self.data["designs"], own["level_db"]))} for own in sources]

    def _shown(self) -> tuple[str, list[str], list[list[str]]]:
        rows = self._rows()
        headings = list(rows[0])
        alarms = [f"ATTENTION: {self.data['unlike']}"] if self.data.get("unlike") else []
        for name, found in zip(self.data["designs"], self.data.get("headlines") or []):
            alarms += [f"{name}: {line}" for line in _headline(found)]
        title = "".join(f"{line}\n" for line in alarms) + "levels, dB re 1 pW s"
        return title, headings, [[str(row["source"]), *(decibels(row[name]) for name in headings[1:])] for row in rows]


class Study(_Shown):
    """How sure levels and ranking are. ``data`` is study.json, ``draws`` a row for each draw."""

    def __init__(self, text: str, draws: str, charts: list[tuple[str, str]]) -> None:
        self.json, self.charts = text, dict(charts)
        self.data: dict[str, Any] = json.loads(text)
        self.csv = draws

    @property
    def draws(self) -> Any:
        """A row for each draw: what was drawn, and the levels."""
        import csv

        try:
            import pandas
        except ModuleNotFoundError:
            return list(csv.DictReader(io.StringIO(self.csv)))
        return pandas.read_csv(io.StringIO(self.csv))

    def to_xarray(self) -> Any:
        """Levels with the errors of methods [dB re 1 pW s]: draw x source, the total among the sources; NaN for silence."""
        import csv

        rows = list(csv.DictReader(io.StringIO(self.csv)))
        columns = [name for name in (rows[0] if rows else {}) if name.startswith("L_WA,1s ")]
        levels = np.array([[float(row[name] or "nan") for name in columns] for row in rows])
        coordinates = {"draw": np.arange(len(rows)), "source": [name.split()[1] for name in columns]}
        return _xarray().DataArray(levels, coordinates, ("draw", "source"), "lwa", {"units": "dB re 1 pW s", "weighting": "A"})

    @property
    def levels(self) -> Any:
        """P5, P50 and P95 of each source and of the total [dB re 1 pW s], and the probability of being the loudest."""
        return table(self._rows(), "source")

    @property
    def first(self) -> dict[str, float | None]:
        """Probability of each source of being the loudest."""
        return {own["source"]: own["first"]["value"] for own in self.data["sources"]}

    def _rows(self) -> list[dict[str, Any]]:
        def row(name: str, level: dict[str, Any], first: dict[str, Any] | None) -> dict[str, Any]:
            of_level = {key: level["level_db"][key]["value"] for key in ("p05", "p50", "p95")}
            return {"source": name, "design": level["nominal_db"], **of_level, "first": first and first["value"]}

        rows = [row(own["source"], own["level"], own["first"]) for own in self.data["sources"]]
        return [*rows, row("total", self.data["total"], None)]

    def _shown(self) -> tuple[str, list[str], list[list[str]]]:
        title = "".join(f"{line}\n" for line in _headline(self.data.get("headline")))
        title += f"{self.data['design']['name']}: {self.data['draws']} draws, levels in dB re 1 pW s"
        # Percentiles need at least 32 draws.
        few = self.data["draws"] < 32
        headings = ["source", "design", "lowest" if few else "P5", "P50", "highest" if few else "P95", "P(first)"]
        ends = {own["source"]: own["level"]["extremes_db"] for own in self.data["sources"]}
        ends["total"] = self.data["total"]["extremes_db"]

        def cells(row: dict[str, Any]) -> list[str]:
            low, high = ends[row["source"]] if few else (row["p05"], row["p95"])
            levels = [decibels(level) for level in (row["design"], low, row["p50"], high)]
            return [row["source"], *levels, "" if row["first"] is None else f"{row['first']:.2f}"]

        return title, headings, [cells(row) for row in self._rows()]


class Shots(_Shown):
    """What becomes of drawn shots. ``data`` holds keys, counts and draws."""

    def __init__(self, text: str) -> None:
        self.json = text
        self.data: dict[str, Any] = json.loads(text)

    @property
    def counts(self) -> dict[str, int]:
        """Draws of each outcome."""
        return dict(self.data["counts"])

    @property
    def draws(self) -> Any:
        """A row for each draw, in SI units: candidate, outcome, figures of the shot, and the values drawn."""
        return table(self._rows())

    def _rows(self) -> list[dict[str, Any]]:
        names = [own["key"] for own in self.data["parameters"]] + self.data["scores"]

        def row(draw: dict[str, Any]) -> dict[str, Any]:
            end = draw["outcome"]
            figures = dict(end["Shot"]) if isinstance(end, dict) and "Shot" in end else {"outcome": _failed(end)}
            return {"candidate": draw["candidate"], **figures, **dict(zip(names, draw["values"]))}

        return [row(draw) for draw in self.data["draws"]]

    def _shown(self) -> tuple[str, list[str], list[list[str]]]:
        counts = sorted(self.counts.items(), key=lambda own: -own[1])
        return f"{len(self.data['draws'])} shots (seed {self.data['seed']})", ["outcome", "draws"], [[own, str(n)] for own, n in counts]


def _failed(end: Any) -> str:
    """Name of the end of a shot that has no figures."""
    return {"DryFire": "dry_fire"}.get(end, "solver_failure") if isinstance(end, str) else "solver_failure"


def _number(value: str) -> tuple[float, str] | None:
    """The number and the unit of a value; None for a word."""
    found = re.fullmatch(r"([-+]?[0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]+)?) *([^0-9 ][^ ]*)?", value.strip())
    return (float(found[1]), found[2] or "") if found else None


def _common_unit(values: list[str]) -> str | None:
    """The unit of values that are numbers in one unit; None for others."""
    units = {number[1] if (number := _number(value)) else None for value in values}
    return units.pop() if len(units) == 1 else None


class Sweep(_Shown):
    """Levels over a grid of values. ``points`` holds each as a dictionary, ``units`` the unit of each key whose values are numbers."""

    def __init__(self, keys: list[str], text: str, charts: list[tuple[str, str]]) -> None:
        self.keys, self.charts = keys, dict(charts)
        self.points: list[dict[str, Any]] = json.loads(text)
        units = {key: _common_unit([point["values"][place] for point in self.points]) for place, key in enumerate(keys)}
        self.units = {key: unit for key, unit in units.items() if unit is not None}

    @property
    def table(self) -> Any:
        """A row for each point: its values, as numbers in ``units`` where they are numbers, the level of each source and of the total
        [dB re 1 pW s], and the outcome."""
        return table(self._rows())

    def _rows(self) -> list[dict[str, Any]]:
        def row(point: dict[str, Any]) -> dict[str, Any]:
            levels = point["levels"]
            sources = {own["source"]: own["lwa_db"] for own in levels["sources"]} if levels else {}
            outcome = levels["outcome"] if levels else None
            values = dict(zip(self.keys, point["values"]))
            values |= {key: number[0] for key in self.units if (number := _number(values[key]))}
            return {**values, **sources, "total": point["total_db"], "outcome": outcome, "refused": point["refused"] or None}

        return [row(point) for point in self.points]

    def _shown(self) -> tuple[str, list[str], list[list[str]]]:
        rows = self._rows()
        names = max((list(row) for row in rows), key=len)[:-1]
        headings = [f"{name} {self.units[name]}".rstrip() if name in self.units else name for name in names]

        def cell(name: str, value: Any) -> str:
            if name in self.units:
                return f"{value:g}"
            return decibels(value) if isinstance(value, float) else str(value if value is not None else "-")

        missed = next((point for point in self.points if point.get("headline")), None)
        lines = _headline(missed["headline"]) if missed else []
        ends = {point["levels"]["outcome"] for point in self.points if point["levels"]}
        if len(ends) > 1:
            words = ", ".join(sorted(own.replace("_", " ") for own in ends))
            lines.insert(0, f"ATTENTION: the shots do not end alike ({words}): do not compare their levels")
        title = "".join(f"{line}\n" for line in lines) + "levels, dB re 1 pW s"
        return title, headings, [[cell(name, row.get(name)) for name in names] for row in rows]
