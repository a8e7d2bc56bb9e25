"""Studies, draws of shots, sweeps and optimisations on a cluster of Dask.

Dask alone distributes: it places tasks, moves results between workers, begins tasks anew whose worker has died, and shows them on its
dashboard. A task computes outputs of stages into a folder. Where workers and client share that folder, nothing else has to travel.
Where they do not, each worker has a folder of its own, and a task returns the files that others need, which are keyed and verified
as in the cache. The client then states the result from these files, as it would alone, so that numbers are the same.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _native
from ._design import Design, load
from ._trial import try_design

if TYPE_CHECKING:
    from distributed import Client

#: Content of files by their names.
Files = dict[str, bytes]

#: Beginnings of the names of the small files that the client needs to state a result.
STATED = ("levels-", "outcomes-")

#: How often a task is restarted if its worker died or its machine had no room.
RETRIES = 3

#: Maximum number of candidates for each that is wanted, and before any is accepted, as in the study itself.
MOST, MOST_IN_VAIN = 1000, 4096


@dataclass(frozen=True)
class Sent:
    """A design on its way: its file with values over it, and the content of all files it is made of."""

    path: str
    digest: str
    values: tuple[tuple[str, Any], ...]
    files: tuple[tuple[str, bytes], ...]

    @classmethod
    def of(cls, design: Design, more: Sequence[str | os.PathLike[str]] = ()) -> Sent:
        """``more`` are files that travel with those of the design."""
        paths = [Path(os.path.abspath(file)) for file in [*design._native.files(), *more]]
        files = tuple((str(path), path.read_bytes()) for path in paths if path.is_file())
        return cls(os.path.abspath(design.path), design.digest, tuple(design._values.items()), files)

    def _is_here(self) -> bool:
        return all(Path(path).is_file() and Path(path).read_bytes() == data for path, data in self.files)

    def design(self) -> Design:
        """The design on a worker: its own file if the worker has all files, else a copy."""
        return _received(self)[1]

    def place(self, path: str) -> Path:
        """The place of one of the files on a worker."""
        return _placed(_received(self)[0], path)


def _placed(copies: Path | None, path: str) -> Path:
    return Path(path) if copies is None else copies / Path(path).relative_to(Path(path).anchor)


@lru_cache(maxsize=8)
def _received(sent: Sent) -> tuple[Path | None, Design]:
    """The folder of the copies of the files, in the order of their folders; none if the worker has the files. And the design."""
    copies = None
    if not sent._is_here():
        copies = _own_folder() / "designs" / hashlib.sha256(repr(sent.files).encode()).hexdigest()[:16]
        for name, data in sent.files:
            _write(_placed(copies, name), data)
    design = load(_placed(copies, sent.path), dict(sent.values))
    if design.digest != sent.digest:
        raise RuntimeError(f"{sent.path} is another design on this worker; bases and meshes need paths relative to their design")
    return copies, design


def _write(path: Path, data: bytes) -> None:
    """Writes a file whole: others see all of it or nothing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".", suffix=".tmp", delete=False) as file:
        file.write(data)
    os.replace(file.name, path)


def put(folder: str | os.PathLike[str], files: Files) -> None:
    """Puts files into a folder that lacks them."""
    for name, data in files.items():
        path = Path(folder) / name
        if not path.exists():
            _write(path, data)


def _own_folder() -> Path:
    """The worker's own folder, which goes with it."""
    from distributed import get_worker

    folder = Path(get_worker().local_directory) / "nailnoise"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _begin(shared: str | None, received: Sequence[Files]) -> str:
    """The folder of a task with what it has received, and as many threads for it as the worker has."""
    from distributed import get_worker

    # Read when the process starts its pool of threads, with its first task.
    os.environ.setdefault("RAYON_NUM_THREADS", str(get_worker().state.nthreads))
    folder = shared or str(_own_folder())
    for files in received:
        put(folder, files)
    return folder


def _end(shared: str | None, folder: str, names: Sequence[str], stated: bool) -> Files:
    """The files that a task returns: none where all share the folder, else those it used, or of them what the client needs."""
    if shared is not None:
        return {}
    wanted = [name for name in names if not stated or name.startswith(STATED)]
    return {name: (Path(folder) / name).read_bytes() for name in wanted if (Path(folder) / name).exists()}


@lru_cache(maxsize=4)
def _candidates(sent: Sent, kind: str, seed: int) -> _native.Candidates:
    """Candidates of a study, whose preparation a process does once."""
    native = sent.design()._native
    if kind == "shots":
        return _native.Candidates.of_shots(native, seed)
    return _native.Candidates.of_study(native, seed, kind == "structures")


def itself(value: Any) -> Any:
    """Task: a value that other tasks read."""
    return value


def outcomes(sent: Sent, kind: str, seed: int, block: int, shared: str | None) -> tuple[int, Files]:
    """Task: the shots of a block of candidates; how many are accepted."""
    folder = _begin(shared, [])
    accepted, names = _candidates(sent, kind, seed).outcomes(block, folder)
    return accepted, _end(shared, folder, names, stated=True)


def structures(sent: Sent, shared: str | None) -> Files:
    """Task: modes and radiation matrices of a design with its levels, on which draws of other quantities depend."""
    return _levels(sent, shared, (), stated=False)


def levels(sent: Sent, shared: str | None, *received: Files) -> Files:
    """Task: levels of a design on structures that are made."""
    return _levels(sent, shared, received, stated=True)


def _levels(sent: Sent, shared: str | None, received: Sequence[Files], stated: bool) -> Files:
    folder = _begin(shared, received)
    try:
        names = _native.levels_task(sent.design()._native, folder)
    except _native.NailnoiseError:
        # A design without levels is left to the client, which gives the reason.
        names = []
    return _end(shared, folder, names, stated)


def draws(sent: Sent, study: tuple[int, int, int | None], task: tuple[int, int], shared: str | None, *received: Files) -> Files:
    """Task: draws of a study, those of one structure or every so many of them."""
    folder = _begin(shared, received)
    n, seed, each = study
    _, names = _native.study_task(sent.design()._native, n, seed, each, task, True, folder, None)
    return _end(shared, folder, names, stated=True)


@lru_cache(maxsize=4)
def _calibration(sent: Sent, measured: str, draws: int, seed: int) -> _native.CalibrationWorker:
    design = sent.design()
    return _native.CalibrationWorker(design._native, sent.place(measured), draws, seed)


def calibration_shots(sent: Sent, measured: str, draws: int, seed: int, points: bytes) -> bytes:
    """Task: the shots of points that a calibration proposes."""
    _begin(None, [])
    return _calibration(sent, measured, draws, seed).result(points)


def trial(sent: Sent, key: str, values: dict[str, Any], constraints: Sequence[Any], shared: str | None, *received: Files) -> Any:
    """Task: a design that an optimiser proposes, with its figures and how far it is beyond each constraint."""
    return try_design(sent.design(), key, values, constraints, _begin(shared, received))


Progress = Callable[[str, int, int], None]


class Cluster:
    """A client of a cluster, with the folder that workers share (or none) and the one in which the client collects files."""

    def __init__(self, client: Client, shared: str | None, folder: str, progress: Progress | None) -> None:
        self.client, self.shared, self.folder, self.progress = client, shared, folder, progress

    def threads(self) -> int:
        """Threads of all workers."""
        workers = self.client.scheduler_info(n_workers=-1)["workers"].values()
        return sum(worker["nthreads"] for worker in workers) or 1

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Any:
        """A task; identical ones are tasks of their own, because what counts is what they leave behind."""
        return self.client.submit(task, *arguments, pure=False, retries=RETRIES)

    def share(self, value: Any) -> Any:
        """A value that many tasks read: it goes to a worker once, and from there to others that need it.

        It is the result of a task, because Dask computes a result again if the only worker that held it has died. A scattered value is lost.
        """
        return self.submit(itself, value)

    def collect(self, what: str, futures: Sequence[Any]) -> None:
        """Waits for tasks and puts what they return into the client's folder."""
        from distributed import as_completed

        for done, future in enumerate(as_completed(futures), 1):  # type: ignore[no-untyped-call]
            put(self.folder, future.result())
            if self.progress is not None:
                self.progress(what, done, len(futures))

    def screen(self, sent: Any, kind: str, seed: int, want: int) -> Files:
        """Computes blocks of candidates in their order until enough are accepted; the files."""
        accepted: dict[int, int] = {}
        files: Files = {}
        for block, (count, own) in self._blocks(sent, kind, seed, lambda: _enough(accepted, want)):
            accepted[block] = count
            files.update(own)
            put(self.folder, own)
            if self.progress is not None:
                self.progress("shots of candidates", min(want, sum(accepted.values())), want)
        return files

    def _blocks(self, sent: Any, kind: str, seed: int, enough: Callable[[], bool]) -> Iterator[tuple[int, tuple[int, Files]]]:
        """Blocks as they are done, with two in the queue of each thread."""
        from distributed import as_completed

        ahead = 2 * self.threads()
        running = {self.submit(outcomes, sent, kind, seed, block, self.shared): block for block in range(ahead)}
        completed, following = as_completed(list(running)), ahead  # type: ignore[no-untyped-call]
        for future in completed:
            yield running.pop(future), future.result()
            if enough():
                for other in running:
                    other.cancel()
                return
            other = self.submit(outcomes, sent, kind, seed, following, self.shared)
            running[other] = following
            completed.add(other)  # type: ignore[no-untyped-call]
            following += 1

    def study(self, design: Design, n: int, seed: int, each: int | None, tasks: int | None) -> None:
        """Computes the draws of a study. Structures are made once: the design's own before its draws, drawn ones with theirs."""
        sent = self.share(Sent.of(design))
        units = n if not each else -(-n // each)
        screened = self.screen(sent, "structures" if each else "study", seed, units)
        first = self.submit(structures, sent, self.shared)
        received = [self.share(screened)] + ([] if each else [first])
        count = units if each else tasks or max(1, min(n, 4 * self.threads()))
        made = [
            self.submit(draws, sent, (n, seed, each), (number, count), self.shared, *received) for number in range(1, count + 1)
        ]
        self.collect("tasks of the study", made)
        put(self.folder, {name: data for name, data in first.result().items() if name.startswith(STATED)})

    def shots(self, design: Design, n: int, seed: int) -> None:
        """Computes the shots of drawn designs."""
        self.screen(self.share(Sent.of(design)), "shots", seed, n)

    def of_calibration(self, design: Design, measured: str, draws: int, seed: int) -> Callable[[list[bytes]], list[bytes]]:
        """A function that computes tasks of a calibration."""
        sent = self.share(Sent.of(design, _native.measurement_files(design._native, measured)))

        def results(tasks: list[bytes]) -> list[bytes]:
            futures = [self.submit(calibration_shots, sent, measured, draws, seed, points) for points in tasks]
            return [future.result() for future in futures]

        return results

    def levels(self, designs: Sequence[Design]) -> None:
        """Computes the levels of designs; those that share their structures wait for the first of them."""
        firsts: dict[str, Any] = {}
        futures = []
        for design in designs:
            sent = Sent.of(design)
            try:
                name = _native.structures(design._native)
            except _native.NailnoiseError:
                continue
            if name in firsts:
                futures.append(self.submit(levels, sent, self.shared, firsts[name]))
            else:
                firsts[name] = self.submit(structures, sent, self.shared)
        self.collect("points", [*firsts.values(), *futures])


def _enough(accepted: dict[int, int], want: int) -> bool:
    """Whether the blocks that are done without a gap hold enough candidates, or so many that more are of no use."""
    found = blocks = 0
    while blocks in accepted:
        found += accepted[blocks]
        blocks += 1
    drawn = blocks * _native.CANDIDATES
    return found >= want or drawn >= MOST * want or (found == 0 and drawn >= MOST_IN_VAIN)
