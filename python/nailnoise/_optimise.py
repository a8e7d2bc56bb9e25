"""Designs that radiate least under constraints, by Optuna (Akiba et al. 2019): tree-structured Parzen estimators for one objective,
and for the front of two."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _native
from ._design import Design, Value, _text
from ._results import _Shown
from ._tables import decibels, table
from ._work import Cache, Progress, _cache, _reporter, _shown, cycle

if TYPE_CHECKING:
    from distributed import Client
    from optuna.trial import Trial

#: Sources and their sum, whose levels are in dB.
LEVELS = ("total", *_native.SOURCES)

#: Unit and factor to SI of the figures in a constraint.
UNITS = {
    "": 1.0, "m": 1.0, "mm": 1e-3, "m/s": 1.0, "N": 1.0, "kN": 1e3, "kg": 1.0, "g": 1e-3, "J": 1.0, "s": 1.0, "ms": 1e-3, "dB": 1.0,
}  # fmt: skip

#: Most candidates for each trial: where hardly any shot meets the constraints, an optimisation ends.
CANDIDATES_A_TRIAL = 20

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*$")


def _unit_of(figure: str) -> str:
    """SI unit of a figure; empty for plain numbers."""
    if figure in LEVELS:
        return "dB"
    if figure in ("penetration", "head_depth"):
        return "m"
    ends = {"_force": "N", "_mass": "kg", "_energy": "J", "_speed": "m/s"}
    return next((unit for end, unit in ends.items() if figure.endswith(end)), "m/s" if figure.startswith("speed_") else "")


def _number(text: str) -> tuple[float, str]:
    found = _NUMBER.match(text)
    if found is None:
        raise ValueError(f"`{text}` does not begin with a number")
    return float(found[1]), found[2]


@dataclass(frozen=True)
class Variable:
    """A key that is varied: a range, or choices."""

    key: str
    low: float = 0.0
    high: float = 0.0
    unit: str = ""
    whole: bool = False
    log: bool = False
    choices: tuple[str, ...] = ()

    @classmethod
    def parse(cls, key: str, text: str, whole: bool) -> Variable:
        """``"80psig..110psig"``, ``"0.01..0.08:log"``, or ``"A,B,C"``; ``whole`` for the range of a count."""
        if ".." not in text:
            choices = tuple(choice.strip() for choice in text.split(","))
            if len(choices) < 2 or not all(choices):
                raise ValueError(f"`{key}` needs a range LOW..HIGH or two choices A,B; found `{text}`")
            return cls(key, choices=choices)
        span, _, scale = text.partition(":")
        low, _, high = span.partition("..")
        (from_, unit_of_low), (to, unit) = _number(low), _number(high)
        if unit_of_low not in ("", unit):
            raise ValueError(f"both ends of `{key}` need the same unit; found `{text}`")
        if scale not in ("", "log"):
            raise ValueError(f"`{scale}` is no scale of `{key}`; `log` is one")
        if not from_ < to or (scale == "log" and from_ <= 0.0):
            raise ValueError(f"the range of `{key}` is empty or not above zero: `{text}`")
        return cls(key, from_, to, unit, whole, scale == "log")

    def suggest(self, trial: Trial) -> Value:
        """The value of a trial, as it would stand in a design."""
        if self.choices:
            return str(trial.suggest_categorical(self.key, self.choices))
        if self.whole:
            return trial.suggest_int(self.key, math.ceil(self.low), math.floor(self.high), log=self.log)
        # Six digits are more than a workshop needs, and can be read.
        value = float(f"{trial.suggest_float(self.key, self.low, self.high, log=self.log):.6g}")
        return f"{value!r} {self.unit}" if self.unit else value


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
        number, unit = _number(value)
        if unit not in UNITS:
            raise ValueError(f"`{unit}` is no unit of a constraint; units are {', '.join(filter(None, UNITS))}")
        expected = _unit_of(figure)
        if {"mm": "m", "kN": "N", "g": "kg", "ms": "s"}.get(unit, unit) != expected:
            raise ValueError(f"`{text}`: the unit of {figure} is {expected or 'none'}")
        return cls(text, figure, 1.0 if relation == "<=" else -1.0, number * UNITS[unit])

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


def _figures(design: Design) -> dict[str, Any]:
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
    #: Figures of the shot and, where these meet the constraints, levels.
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
        lines = [f"base = {json.dumps(base)}"]
        lines += [f"{key} = {_text(value) if not isinstance(value, str) else json.dumps(value)}" for key, value in values.items()]
        return "\n".join(lines) + "\n"


class Optimisation(_Shown):
    """What an optimisation found. ``best`` is the feasible design of the lowest objective; None where none is feasible."""

    def __init__(self, design: Design, objectives: Sequence[str], trials: list[Proposal]) -> None:
        self.design, self.objectives, self.trials = design, list(objectives), trials

    def _score(self, proposal: Proposal) -> tuple[float, ...]:
        values = (proposal.figures.get(own.lstrip("-")) for own in self.objectives)
        signs = (-1.0 if own.startswith("-") else 1.0 for own in self.objectives)
        return tuple(-math.inf if value is None else sign * float(value) for sign, value in zip(signs, values))

    @property
    def feasible(self) -> list[Proposal]:
        """Designs that meet all constraints."""
        return [trial for trial in self.trials if trial.feasible]

    @property
    def best(self) -> Proposal | None:
        """The feasible design of the lowest first objective."""
        return min(self.feasible, key=self._score, default=None)

    @property
    def front(self) -> list[Proposal]:
        """Feasible designs that no other betters in all objectives, by the first objective."""
        scored = [(self._score(trial), trial) for trial in self.feasible]

        def bettered(score: tuple[float, ...]) -> bool:
            return any(other != score and all(a <= b for a, b in zip(other, score)) for other, _ in scored)

        return [trial for score, trial in sorted(scored, key=lambda own: own[0]) if not bettered(score)]

    @property
    def table(self) -> Any:
        """A row for each trial."""
        keys = ("outcome", *LEVELS, "penetration", "drive_energy")
        rows = [
            {**own.values, **{key: own.figures.get(key) for key in keys}, "feasible": own.feasible, "refused": own.refused or None}
            for own in self.trials
        ]
        return table(rows)

    def write(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Writes each design of the front as a TOML file over the base; the files."""
        place = Path(folder)
        place.mkdir(parents=True, exist_ok=True)
        base = os.path.abspath(self.design.path)
        files = []
        for number, proposal in enumerate(self.front, 1):
            file = place / f"{self.design.name}-{number}.toml"
            # Whole or not at all: a full disk leaves the older file.
            part = file.with_name(f".{file.name}.{os.getpid()}.tmp")
            try:
                part.write_text(proposal.toml(base, self.design._values))
                part.replace(file)
            finally:
                part.unlink(missing_ok=True)
            files.append(file)
        return files

    def _shown(self) -> tuple[str, list[str], list[list[str]]]:
        with_levels = sum(own.has_levels for own in self.trials)
        title = f"{self.design.name}: {len(self.trials)} candidates, levels of {with_levels}, {len(self.feasible)} feasible"
        if not self.feasible:
            return f"{title}; loosen a constraint or widen a range", ["design"], []
        varied = list(self.trials[0].values)
        headings = ["design", *varied, "total dB", "drive energy J"]
        rows = [
            [str(number), *(str(own.values[key]) for key in varied), decibels(own.figures["total"]), f"{own.figures['drive_energy']:.1f}"]
            for number, own in enumerate(self.front, 1)
        ]
        return f"{title}; the best", headings, rows


def optimise(
    design: Design,
    vary: Mapping[str, str | Sequence[Value]],
    *,
    minimise: str = "total",
    subject_to: Sequence[str] = ("outcome == drives",),
    pareto: str | None = None,
    trials: int = 60,
    seed: int = 1,
    cache: Cache = None,
    client: Client | None = None,
    store: str | os.PathLike[str] | None = None,
    batch: int | None = None,
    progress: Progress | bool | None = None,
) -> Optimisation:
    """Looks for the design of the lowest level.

    ``vary`` maps keys to ranges (``"80psig..110psig"``, ``"0.01..0.08:log"``) or choices. ``minimise`` is ``total``, a source, or a
    figure of the shot; ``pareto`` a second objective, with a minus to maximise it (``"-drive_energy"``). A shot that breaks a
    constraint costs a cycle and no sound, and is no trial: ``trials`` counts the designs whose levels are computed. An optimisation ends
    earlier after ``CANDIDATES_A_TRIAL`` candidates for each trial that was asked for. The same seed tries the same designs.

    With a ``client`` of dask.distributed, ``batch`` designs at a time (one for each thread of the cluster) are tasks on its workers.
    The optimiser then knows less when it proposes one, so that seed and batch decide which designs are tried. ``store`` is that of
    :func:`nailnoise.study`.
    """
    try:
        import optuna
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError("optimise needs optuna 5 or later: pip install 'nailnoise[optimise]'") from error
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    if not vary:
        raise ValueError("an optimisation needs a key to vary")
    variables = [_variable(design, key, given) for key, given in vary.items()]
    constraints = [Constraint.parse(text) for text in subject_to]
    objectives = [minimise, *([pareto] if pareto else [])]
    known = {**_figures(design), **dict.fromkeys(LEVELS, 0.0)}
    for name in [*(own.lstrip("-") for own in objectives), *(own.figure for own in constraints)]:
        if name not in known:
            raise ValueError(f"there is no figure `{name}`; there are {', '.join(sorted(known))}")
    sampler = optuna.samplers.TPESampler(seed=seed, n_startup_trials=max(10, 3 * len(variables)), constant_liar=client is not None)
    study = optuna.create_study(sampler=sampler, directions=["minimize"] * len(objectives))
    found = Optimisation(design, objectives, [])
    show = _shown(progress)
    tried = _here(design, variables, constraints, cache)
    at_once = 1
    if client is not None:
        folder = None if store is None else os.path.abspath(store)
        tried, threads = _on_cluster(client, folder, design, variables, constraints)
        at_once = batch or threads
    done = 0
    while done < trials and len(found.trials) < CANDIDATES_A_TRIAL * trials:
        asked = [study.ask() for _ in range(min(at_once, trials - done))]
        values = [{variable.key: variable.suggest(trial) for variable in variables} for trial in asked]
        for trial, (proposal, excesses) in zip(asked, tried(values)):
            found.trials.append(proposal)
            done += proposal.has_levels
            for name, excess in excesses.items():
                trial.set_constraint(name, excess)
            # Of an infeasible trial only the constraints count.
            score = found._score(proposal) if proposal.feasible else tuple(math.inf for _ in objectives)
            study.tell(trial, [max(-1e9, min(value, 1e9)) for value in score])
        if show is not None:
            show("designs", done, trials)
    return found


Values = dict[str, Value]
Tried = tuple[Proposal, dict[str, float]]


def _here(
    design: Design, variables: Sequence[Variable], constraints: Sequence[Constraint], cache: Cache
) -> Callable[[list[Values]], list[Tried]]:
    """Tries designs in this process."""
    return lambda batch: [_tried(design, variables[0].key, values, constraints, cache) for values in batch]


def _on_cluster(
    client: Client, shared: str | None, design: Design, variables: Sequence[Variable], constraints: Sequence[Constraint]
) -> tuple[Callable[[list[Values]], list[Tried]], int]:
    """Tries designs on a cluster, after the structures of the design itself are made; and the threads of the cluster."""
    from ._cluster import Cluster, Sent, structures, trial

    cluster = Cluster(client, shared, "", None)
    sent = cluster.share(Sent.of(design))
    first = cluster.submit(structures, sent, shared)

    def tried(batch: list[Values]) -> list[Tried]:
        futures = [cluster.submit(trial, sent, variables[0].key, values, tuple(constraints), shared, first) for values in batch]
        return [future.result() for future in futures]

    return tried, cluster.threads()


def _variable(design: Design, key: str, given: str | Sequence[Value]) -> Variable:
    if key not in design:
        raise ValueError(f"the design has no key `{key}`")
    text = given if isinstance(given, str) else ",".join(str(value) for value in given)
    whole = isinstance(design[key], int) and not isinstance(design[key], bool)
    return Variable.parse(key, text, whole)


def _tried(design: Design, key: str, values: Values, constraints: Sequence[Constraint], cache: Cache) -> Tried:
    """A design with these values, and how far it is beyond each constraint; ``key`` is one of those varied."""
    excesses: dict[str, float] = {"is a design": 0.0}
    try:
        own = design.with_(values)
        figures = _figures(own)
        of_shot = [constraint for constraint in constraints if constraint.figure not in LEVELS]
        excesses |= {constraint.text: constraint.excess(figures) for constraint in of_shot}
        if all(excess <= 0.0 for excess in excesses.values()):
            figures |= _levels(own, key, cache)
            of_levels = [constraint for constraint in constraints if constraint.figure in LEVELS]
            excesses |= {constraint.text: constraint.excess(figures) for constraint in of_levels}
    except _native.NailnoiseError as error:
        return Proposal(values, {}, False, str(error)), {"is a design": 1.0}
    return Proposal(values, figures, all(excess <= 0.0 for excess in excesses.values())), excesses
