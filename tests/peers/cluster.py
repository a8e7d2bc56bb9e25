"""Draws on a cluster of Dask beside the same draws on threads.

    cluster.py DESIGN [DRAWS [SECONDS]]

Three checks with DRAWS drawn shots (2000 unless given) on a local cluster of two workers:

1. The wall time is within 15 % of that on two threads (not demanded below 1000 draws, where it is no more than noise), and the numbers
   are the same. The time a task spends outside its work is printed.
2. A worker is killed by its process number three times on the way. Every draw comes once, with the same numbers.
3. A simulated cluster: tasks that sleep for SECONDS (as long as the blocks of check 1 took, unless given) on as many workers as one
   scheduler on this machine carries. Scheduling takes less than 5 % of the wall time up to 10 000 draws. Where a task's cost bounds the
   workers that one scheduler keeps busy is printed.
"""

import contextlib
import os
import signal
import sys
import tempfile
import threading
import time

import nailnoise as nn
from distributed import Client, LocalCluster, as_completed
from nailnoise._native import CANDIDATES

#: Largest ratio of the wall time on a cluster to that on threads, and largest share of scheduling.
RATIO, SHARE = 1.15, 0.05
#: Simulated workers, and the shortest time that a task sleeps [s].
WORKERS, SHORTEST = 40, 0.5


@contextlib.contextmanager
def local() -> "contextlib.AbstractContextManager[Client]":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        client.wait_for_workers(2)
        yield client


def once(made: nn.Shots, draws: int) -> None:
    """Every draw comes once."""
    numbers = [draw["candidate"] for draw in made.data["draws"]]
    assert len(numbers) == draws and len(set(numbers)) == draws, f"{len(numbers)} draws, {len(set(numbers))} different ones"


def compared(design: nn.Design, draws: int) -> tuple[nn.Shots, float]:
    """Draws on threads and on a cluster; those, and the seconds of a block on one worker."""
    begin = time.perf_counter()
    alone = nn.shots(design, draws)
    of_threads = time.perf_counter() - begin
    with local() as client:
        # Imports, the design and the sampler are there before the clock runs, as they are on a cluster that is at work.
        nn.shots(design, 2 * CANDIDATES, seed=9, client=client)
        begin = time.perf_counter()
        spread = nn.shots(design, draws, client=client)
        of_cluster = time.perf_counter() - begin
        tasks = client.get_task_stream(start=begin_of(client, of_cluster)) if hasattr(client, "get_task_stream") else []
    assert spread.json == alone.json, "the numbers of the cluster are others than those of threads"
    once(spread, draws)
    blocks = -(-spread.data["candidates"] // CANDIDATES)
    work = [stop["stop"] - stop["start"] for task in tasks for stop in task["startstops"] if stop["action"] == "compute"]
    block = sorted(work)[len(work) // 2] if work else 2 * of_threads / blocks
    ratio = of_cluster / of_threads
    outside = (2 * of_cluster - sum(work)) / max(1, len(work))
    print(f"{draws} draws of {spread.data['candidates']} candidates: {of_threads:.1f} s on two threads, {of_cluster:.1f} s on two workers, "
          f"ratio {ratio:.3f}; {len(work)} tasks of {block:.2f} s, {1e3 * outside:.1f} ms of a worker outside each")  # fmt: skip
    if draws >= 1000:
        assert ratio <= RATIO, f"the cluster takes {ratio:.2f} times as long as threads, more than {RATIO}"
    return alone, block


def begin_of(client: Client, seconds: float) -> float:
    """A moment before the last so many seconds, by the clock of the scheduler."""
    return time.time() - seconds


def killed(design: nn.Design, alone: nn.Shots, draws: int) -> None:
    """The same draws while a worker is killed three times."""
    kills: list[int] = []
    with local() as client, tempfile.TemporaryDirectory() as store:

        def kill(stage: str, done: int, of: int) -> None:
            if len(kills) < 3 and done >= of * (len(kills) + 1) / 5:
                process = next(iter(client.run(os.getpid).values()))
                os.kill(process, signal.SIGKILL)
                kills.append(process)

        spread = nn.shots(design, draws, client=client, store=store, progress=kill)
        left = [name for name in os.listdir(store) if not name.endswith(".entry")]
    assert len(set(kills)) == 3, f"{len(kills)} workers were killed"
    once(spread, draws)
    assert spread.json == alone.json, "the numbers changed when workers died"
    print(f"workers {', '.join(map(str, kills))} killed: every draw once, same numbers; left over: {len(left)} files of claims")


def slept(seconds: float, number: int) -> int:
    time.sleep(seconds)
    return number


def simulated(seconds: float, counts: list[int]) -> None:
    """Tasks that sleep as long as measured ones."""
    pause = max(SHORTEST, seconds)
    options = {"processes": False, "dashboard_address": None}
    with LocalCluster(n_workers=4, threads_per_worker=WORKERS // 4, **options) as cluster, Client(cluster) as client:
        client.gather(client.map(slept, [0.01] * 200, range(200), pure=False))
        for draws in counts:
            tasks = -(-draws // CANDIDATES) * 4  # a quarter of the candidates counts
            tasks = max(tasks, 2 * WORKERS)
            tasks -= tasks % WORKERS
            begin = time.perf_counter()
            futures = client.map(slept, [pause] * tasks, range(tasks), pure=False)
            done = sorted(future.result() for future in as_completed(futures))
            wall = time.perf_counter() - begin
            assert done == list(range(tasks))
            ideal = pause * tasks / WORKERS
            share = (wall - ideal) / wall
            print(f"simulated: {draws} draws, {tasks} tasks of {pause:.2f} s on {WORKERS} workers: {wall:.1f} s, scheduling {share:.1%}")
            assert share < SHARE, f"scheduling takes {share:.1%} of the time"
        begin = time.perf_counter()
        client.gather(client.map(slept, [0.0] * 2000, range(2000), pure=False))
        cost = (time.perf_counter() - begin) / 2000
    print(f"a task costs the scheduler {1e3 * cost:.2f} ms: it keeps {pause / cost:.0f} workers busy with tasks of {pause:.2f} s, and "
          f"{SHARE * pause / cost:.0f} below {SHARE:.0%} of the time if nothing overlapped; beyond, give longer tasks")  # fmt: skip


def main() -> int:
    design = nn.load(sys.argv[1])
    draws = int(sys.argv[2]) if len(sys.argv) > 2 else 2000
    alone, block = compared(design, draws)
    killed(design, alone, draws)
    seconds = float(sys.argv[3]) if len(sys.argv) > 3 else block
    simulated(seconds, [draws] if draws < 1000 else [2000, 10_000])
    assert threading.active_count() < 100
    return 0


if __name__ == "__main__":
    sys.exit(main())
