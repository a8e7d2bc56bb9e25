"""Many shots of a design: studies, shots alone and sweeps, in this process or as tasks of a cluster."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from . import _native
from ._cluster import Cluster
from ._design import Design, Value
from ._results import Shots, Study, Sweep
from ._work import Cache, Progress, _cache, _reporter, _shown

if TYPE_CHECKING:
    from distributed import Client


@contextlib.contextmanager
def _collecting(cache: Cache) -> Iterator[str]:
    """The folder into which results of a cluster come: the cache, or one that goes when the work is done."""
    folder, keep = _cache(cache)
    if keep:
        yield folder or os.fspath(_native.cache_folder())
    else:
        with tempfile.TemporaryDirectory(prefix="nailnoise-") as place:
            yield place


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
    progress: Progress | bool | None = None,
) -> Study:
    """Draws ``n`` designs from the ranges, and states how sure levels and ranking are.

    ``structures`` draws block, table and tool body, too, a new structure every so many draws; without it they are held.

    With a ``client`` of dask.distributed the draws are tasks on its workers: one for each structure, or ``tasks`` (four for each
    thread of the cluster unless given) where structures are held. ``store`` is a folder that this process and all workers share;
    without it, results travel with the tasks. A task whose worker dies is done again. Numbers depend on none of these.
    """
    folder = None if store is None else os.path.abspath(store)
    progress = _shown(progress)
    if client is None:
        return Study(*_native.study(design._native, n, seed, structures, *_cache(cache), folder, _reporter(progress)))
    if n < 1:
        raise ValueError("a study needs at least one draw")
    with _collecting(cache) as place:
        Cluster(client, folder, folder or place, progress).study(design, n, seed, structures, tasks)
        made = _native.study(design._native, n, seed, structures, *_cache(cache), folder or place, _reporter(None))
    return Study(*made)


def shots(
    design: Design,
    n: int = 1000,
    *,
    seed: int = 1,
    cache: Cache = False,
    store: str | os.PathLike[str] | None = None,
    client: Client | None = None,
    progress: Progress | bool | None = None,
) -> Shots:
    """Draws ``n`` designs from the ranges of what takes part in the cycle, and computes what becomes of the shot of each.

    ``client`` and ``store`` are those of :func:`study`.
    """
    progress = _shown(progress)
    if n < 1:
        raise ValueError("shots are drawn from one on")
    folder = None if store is None else os.path.abspath(store)
    if client is None:
        place, keep = (folder, True) if folder else _cache(cache)
        return Shots(_native.shots(design._native, n, seed, place, keep, _reporter(progress)))
    with _collecting(cache) as own:
        Cluster(client, folder, folder or own, progress).shots(design, n, seed)
        return Shots(_native.shots(design._native, n, seed, folder or own, True, _reporter(None)))


def sweep(
    design: Design,
    vary: Mapping[str, Sequence[Value] | str],
    *,
    draws: int | None = None,
    seed: int = 1,
    cache: Cache = None,
    store: str | os.PathLike[str] | None = None,
    client: Client | None = None,
    progress: Progress | bool | None = None,
) -> Sweep:
    """Computes the levels over a grid: ``sweep(design, {"supply.pressure": "80psig..110psig:7", "exhaust.holes": [3, 5, 12]})``.

    With a ``client`` of dask.distributed each point is a task, and points that share structures wait for the first of them;
    ``store`` is that of :func:`study`. Draws over the grid (``draws``) are computed by this process.
    """
    if not vary:
        raise ValueError("a sweep needs a key to vary, as {'exhaust.holes': [3, 5, 12]}")
    progress = _shown(progress)
    axes = [f"{key}={_listed(given)}" for key, given in vary.items()]
    folder = None if store is None else os.path.abspath(store)

    def stated(place: str | None, keep: bool, progress: Progress | None) -> Sweep:
        return Sweep(list(vary), *_native.sweep(design._native, axes, draws, seed, place, keep, _reporter(progress)))

    if client is None:
        return stated(*((folder, True) if folder else _cache(cache)), progress)
    with _collecting(cache) as own:
        Cluster(client, folder, folder or own, progress).levels(_points(design, axes))
        return stated(folder or own, True, None)


def _listed(given: Sequence[Value] | str) -> str:
    return given if isinstance(given, str) else ",".join(str(value) for value in given)


def _points(design: Design, axes: list[str]) -> list[Design]:
    """The designs of a grid, without values that are none: the sweep itself says why."""
    values = _native.axis_values(axes)
    points: list[dict[str, Value]] = [{}]
    for key, own in values:
        points = [{**point, key: value} for point in points for value in own]
    designs = []
    for point in points:
        with contextlib.suppress(_native.NailnoiseError):
            designs.append(design.with_(point))
    return designs


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
    return _native.study_task(design._native, n, seed, structures, task, False, os.fspath(folder), report)[0]
