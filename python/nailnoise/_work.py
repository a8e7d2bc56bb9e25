"""What computes: each function releases the interpreter's lock, reports progress, and ends on Ctrl-C."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from . import _native
from ._design import Design, Value
from ._results import Comparison, Cycle, Modes, Run, Study, Sweep

if TYPE_CHECKING:
    from distributed import Client

_LOGGER = logging.getLogger("nailnoise")

Cache = str | os.PathLike[str] | bool | None
Progress = Callable[[str, int, int], None]


def _reporter(progress: Progress | None) -> Callable[[str, str, int, int], None]:
    """Passes remarks to the logger, and stages and counts to ``progress(stage, done, of)``."""
    stage = ""

    def report(kind: str, text: str, done: int, of: int) -> None:
        nonlocal stage
        if kind == "note":
            _LOGGER.info(text)
            return
        if kind == "stage":
            stage = text
        if progress is not None:
            progress(text or stage, done, of)

    return report


def _cache(cache: Cache) -> tuple[str | None, bool]:
    """A folder and whether anything is kept: None is the user's cache, False is none, a path is that folder."""
    if cache is None or cache is True:
        return None, True
    if cache is False:
        return None, False
    return os.fspath(cache), True


def run(design: Design, *, cache: Cache = None, progress: Progress | None = None) -> Run:
    """Ranks the sources of a design by their sound power.

    The first run of a design takes minutes. ``cache`` is a folder for results of stages, None for the user's own, or False;
    ``progress(stage, done, of)`` is called as the work goes on.
    """
    text, signals = _native.run(design._native, *_cache(cache), _reporter(progress))
    return Run(text, signals)


def cycle(design: Design) -> Cycle:
    """Computes the nailing cycle alone: pressures, motions, forces and events."""
    return Cycle(design.name, *_native.cycle(design._native, _reporter(None)))


def modes(design: Design, body: str, *, cache: Cache = None, progress: Progress | None = None) -> Modes:
    """Computes the vibration modes of a body: ``workpiece``, ``worktable`` or ``tool``."""
    return Modes(body, _native.modes(design._native, body, *_cache(cache), _reporter(progress)))


def compare(*runs: Run | Design, cache: Cache = None) -> Comparison:
    """Compares runs, or runs designs and compares them; the first is the reference."""
    if len(runs) < 2:
        raise ValueError("a comparison needs two runs or designs")
    done = [run(one, cache=cache) if isinstance(one, Design) else one for one in runs]
    return Comparison(_native.compare([one.json for one in done]))


def study(
    design: Design,
    n: int = 256,
    *,
    seed: int = 1,
    structures: int | None = None,
    cache: Cache = None,
    store: str | os.PathLike[str] | None = None,
    client: Client | None = None,
    tasks: int | None = None,
    progress: Progress | None = None,
) -> Study:
    """Draws ``n`` designs from the ranges, and states how sure levels and ranking are.

    ``structures`` draws block, table and tool body, too, a new structure every so many draws; without it they are held.

    With a ``client`` of dask.distributed the draws are divided into ``tasks`` on its workers (four for each thread of the cluster
    unless given). ``store`` is then a folder that this process and all workers share; the file of the design must be there for
    all, too. A task that a worker loses is done again, and what it had finished is read from the folder. Numbers do not depend on
    client or tasks.
    """
    folder = None if store is None else os.path.abspath(store)
    report = _reporter(progress)
    if client is not None:
        if folder is None:
            raise ValueError("workers leave their draws in a folder that all share: store=...")
        _on_cluster(client, tasks, progress, (design, n, folder, seed, structures))
    return Study(*_native.study(design._native, n, seed, structures, *_cache(cache), folder, report))


def _on_cluster(client: Client, tasks: int | None, progress: Progress | None, study: _Task) -> None:
    """Computes all draws of a study on the workers of a cluster."""
    from distributed import as_completed

    threads = sum(worker["nthreads"] for worker in client.scheduler_info(n_workers=-1)["workers"].values())
    count = tasks or max(1, min(study[1], 4 * threads))
    futures = client.map(_task, range(1, count + 1), of=count, study=study, pure=False, retries=3)
    for done, future in enumerate(as_completed(futures), 1):  # type: ignore[no-untyped-call]
        future.result()
        if progress is not None:
            progress("tasks of the study", done, count)


_Task = tuple[Design, int, str, int, int | None]


def _task(number: int, *, of: int, study: _Task) -> int:
    """One task of a study, on a worker, with as many threads as the worker has."""
    from distributed import get_worker

    # Read where the pool of threads of the process begins, with its first task.
    os.environ.setdefault("RAYON_NUM_THREADS", str(get_worker().state.nthreads))
    design, n, folder, seed, structures = study
    return study_task(design, n, (number, of), folder, seed=seed, structures=structures)


def sweep(
    design: Design,
    vary: Mapping[str, Sequence[Value] | str],
    *,
    draws: int | None = None,
    seed: int = 1,
    cache: Cache = None,
    progress: Progress | None = None,
) -> Sweep:
    """Computes the levels over a grid: ``sweep(design, {"supply.pressure": "80psig..110psig:7", "exhaust.holes": [3, 5, 12]})``."""

    def values(given: Sequence[Value] | str) -> str:
        return given if isinstance(given, str) else ",".join(str(value) for value in given)

    axes = [f"{key}={values(given)}" for key, given in vary.items()]
    text = _native.sweep(design._native, axes, draws, seed, *_cache(cache), _reporter(progress))
    return Sweep(list(vary), text)


def study_task(
    design: Design,
    n: int,
    task: tuple[int, int],
    folder: str | os.PathLike[str],
    *,
    seed: int = 1,
    structures: int | None = None,
) -> int:
    """Computes task ``(k, of)`` of a study into a shared folder; returns how many draws it made."""
    report: Any = _reporter(None)
    return _native.study_task(design._native, n, seed, structures, task, os.fspath(folder), report)
