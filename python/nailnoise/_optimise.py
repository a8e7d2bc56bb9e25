"""Designs that radiate least under constraints, by Optuna (Akiba et al. 2019): tree-structured Parzen estimators for one objective,
and for the front of two."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._cluster import Cluster, Sent, structures, trial
from ._design import Design, Value, _text
from ._results import _Shown
from ._tables import decibels, table
from ._trial import LEVELS, Constraint, Proposal, Tried, Values, figures_of, number, try_design
from ._work import Cache, Progress, _shown

if TYPE_CHECKING:
    from distributed import Client
    from optuna.samplers import BaseSampler
    from optuna.trial import Trial

#: Maximum number of candidates per trial; it ends an optimisation if hardly any shot meets the constraints.
CANDIDATES_A_TRIAL = 20


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
        (from_, unit_of_low), (to, unit) = number(low), number(high)
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

        best = [(score, trial) for score, trial in sorted(scored, key=lambda own: own[0]) if not bettered(score)]
        # The first of equal ones.
        return [trial for place, (score, trial) in enumerate(best) if all(score != other for other, _ in best[:place])]

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
        base = Path(os.path.relpath(self.design.path, place)).as_posix()
        files = []
        for number, proposal in enumerate(self.front, 1):
            file = place / f"{self.design.name}-{number}.toml"
            # Written completely or not at all: a full disk leaves the older file.
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
    sampler: BaseSampler | None = None,
) -> Optimisation:
    """Looks for the design of the lowest level with a sampler of Optuna; the command ``nailnoise optimise`` needs no Python.

    ``vary`` maps keys to ranges (``"80psig..110psig"``, ``"0.01..0.08:log"``) or choices. ``minimise`` is ``total``, a source, or a
    figure of the shot; ``pareto`` a second objective, with a minus to maximise it (``"-drive_energy"``). A shot that breaks a
    constraint costs a cycle and no sound, and is no trial: ``trials`` counts the designs whose levels are computed. An optimisation ends
    earlier after ``CANDIDATES_A_TRIAL`` candidates for each trial that was asked for. The same seed tries the same designs. ``sampler``
    replaces the tree-structured Parzen estimator.

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
    known = {**figures_of(design), **dict.fromkeys(LEVELS, 0.0)}
    for name in [*(own.lstrip("-") for own in objectives), *(own.figure for own in constraints)]:
        if name not in known:
            raise ValueError(f"there is no figure `{name}`; there are {', '.join(sorted(known))}")
    if sampler is None:
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
            # For an infeasible trial, only the constraints count.
            score = found._score(proposal) if proposal.feasible else tuple(math.inf for _ in objectives)
            study.tell(trial, [max(-1e9, min(value, 1e9)) for value in score])
        if show is not None:
            show("designs", done, trials)
    return found


def _here(
    design: Design, variables: Sequence[Variable], constraints: Sequence[Constraint], cache: Cache
) -> Callable[[list[Values]], list[Tried]]:
    """Tries designs in this process."""
    return lambda batch: [try_design(design, variables[0].key, values, constraints, cache) for values in batch]


def _on_cluster(
    client: Client, shared: str | None, design: Design, variables: Sequence[Variable], constraints: Sequence[Constraint]
) -> tuple[Callable[[list[Values]], list[Tried]], int]:
    """Tries designs on a cluster, after the structures of the design itself are made; and the threads of the cluster."""
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
