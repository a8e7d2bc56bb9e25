"""Draws on a cluster of Dask, and the same draws on threads.

    cluster.py DESIGN [DRAWS [SECONDS]]

Three checks with DRAWS drawn shots (2000 unless given, minimum 384) on a local cluster of two workers:

1. The wall time is within 15 % of that on two threads (not demanded below 1000 draws, where it is only noise), and the
   numbers are the same. The time a task spends outside its work is printed.
2. A worker is killed by its process number three times on the way. Every draw comes once, with the same numbers.
3. A simulated cluster: DRAWS tasks (2000 and 10 000 for the long run) that sleep for SECONDS, a tenth of the 2.4 s that the sound of a
   draw takes unless given, on 20 workers. That gives the scheduler as much to do as 200 workers with real draws. It takes less than 5 %
   of the wall time (25 % with fewer than 1000 draws, where the last tasks of all workers weigh more). The time of a
   task that does nothing gives the number of workers that one scheduler can occupy.
"""

import contextlib
import os
import signal
import sys
import tempfile
import time
from collections.abc import Iterator

import nailnoise as nn
from distributed import Client, LocalCluster, as_completed, get_task_stream
from nailnoise._native import CANDIDATES

#: Largest ratio of the wall time on a cluster to that on threads, and largest share of scheduling.
RATIO, SHARE = 1.15, 0.05
#: Workers that are killed, and the least blocks of candidates that leave time for it: progress is reported after each block.
KILLS, BLOCKS = 3, 6
#: Simulated workers, and the time of a simulated and of a real draw [s].
WORKERS, PAUSE, REAL = 20, 0.24, 2.4


@contextlib.contextmanager
def local() -> Iterator[tuple[LocalCluster, Client]]:
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        client.wait_for_workers(2)
        yield cluster, client


def once(made: nn.Shots, draws: int) -> None:
    """Every draw comes once."""
    numbers = [draw["candidate"] for draw in made.data["draws"]]
    assert len(numbers) == draws and len(set(numbers)) == draws, f"{len(numbers)} draws, {len(set(numbers))} different ones"


def compared(design: nn.Design, draws: int) -> nn.Shots:
    """Draws on threads and on a cluster; they are the same."""
    begin = time.perf_counter()
    alone = nn.shots(design, draws)
    of_threads = time.perf_counter() - begin
    with local() as (_, client):
        # Load imports, design and sampler before the timing starts, as on a cluster in use.
        nn.shots(design, 2 * CANDIDATES, seed=9, client=client)
        with get_task_stream(client) as stream:
            begin = time.perf_counter()
            spread = nn.shots(design, draws, client=client)
            of_cluster = time.perf_counter() - begin
    assert spread.json == alone.json, "the numbers of the cluster are others than those of threads"
    once(spread, draws)
    blocks = -(-spread.data["candidates"] // CANDIDATES)
    steps = [step for task in stream.data for step in task["startstops"] if task["status"] == "OK"]
    work = [step["stop"] - step["start"] for step in steps if step["action"] == "compute"]
    assert len(work) >= blocks, f"{len(work)} tasks for {blocks} blocks"
    moved = sum(step["stop"] - step["start"] for step in steps if step["action"] != "compute")
    ratio = of_cluster / of_threads
    print(f"{draws} draws of {spread.data['candidates']} candidates: {of_threads:.1f} s on two threads, {of_cluster:.1f} s on two workers, "
          f"ratio {ratio:.3f}; {len(work)} tasks of {sum(work) / len(work):.2f} s; a task costs {1e3 * moved / len(work):.1f} ms of "
          f"transfers, and {1e3 * (of_cluster - sum(work) / 2) / len(work):.0f} ms of the wall time are not its work")  # fmt: skip
    if draws >= 1000:
        assert ratio <= RATIO, f"the cluster takes {ratio:.2f} times as long as threads, more than {RATIO}"
    return alone


def killed(design: nn.Design, alone: nn.Shots, draws: int) -> None:
    """The same draws while a worker is killed three times."""
    kills: list[int] = []
    with local() as (cluster, client), tempfile.TemporaryDirectory() as store:

        def alive() -> list[int]:
            """Workers that were not killed; a killed one is listed until its nanny has noticed."""
            return [worker.pid for worker in cluster.workers.values() if worker.pid and worker.pid not in kills]

        def kill(stage: str, done: int, of: int) -> None:
            if len(kills) < KILLS and done >= of * (len(kills) + 1) / BLOCKS:
                while not (processes := alive()):
                    time.sleep(0.05)
                os.kill(processes[0], signal.SIGKILL)
                kills.append(processes[0])

        spread = nn.shots(design, draws, client=client, store=store, progress=kill)
        left = [name for name in os.listdir(store) if not name.endswith(".entry")]
    assert len(kills) == KILLS, f"{len(kills)} workers were killed"
    once(spread, draws)
    assert spread.json == alone.json, "the numbers changed when workers died"
    print(f"workers {', '.join(map(str, kills))} killed: every draw once, same numbers; left over: {len(left)} files of claims")


def slept(seconds: float, number: int) -> int:
    time.sleep(seconds)
    return number


def simulated(pause: float, counts: list[int]) -> None:
    """Tasks that sleep instead of computing."""
    options = {"processes": False, "dashboard_address": None}
    with LocalCluster(n_workers=2, threads_per_worker=WORKERS // 2, **options) as cluster, Client(cluster) as client:
        client.gather(client.map(slept, [0.01] * 200, range(200), pure=False))
        for tasks in counts:
            begin = time.perf_counter()
            futures = client.map(slept, [pause] * tasks, range(tasks), pure=False)
            done = sorted(future.result() for future in as_completed(futures))
            wall = time.perf_counter() - begin
            assert done == list(range(tasks))
            share = 1.0 - pause * tasks / WORKERS / wall
            print(f"simulated: {tasks} draws of {pause:.2f} s on {WORKERS} workers: {wall:.1f} s, scheduling {share:.1%}")
            assert share < (SHARE if tasks >= 1000 else 5 * SHARE), f"scheduling takes {share:.1%} of the time"
        begin = time.perf_counter()
        client.gather(client.map(slept, [0.0] * 2000, range(2000), pure=False))
        cost = (time.perf_counter() - begin) / 2000
    print(f"a task costs the scheduler {1e3 * cost:.2f} ms: it is fully busy with {REAL / cost:.0f} workers whose tasks take {REAL} s")


def main() -> int:
    design = nn.load(sys.argv[1])
    draws = max(int(sys.argv[2]) if len(sys.argv) > 2 else 2000, BLOCKS * CANDIDATES)
    killed(design, compared(design, draws), draws)
    pause = float(sys.argv[3]) if len(sys.argv) > 3 else PAUSE
    simulated(pause, [400] if draws < 1000 else [2000, 10_000])
    return 0


if __name__ == "__main__":
    sys.exit(main())
