"""Work on a cluster of Dask states what one process states, with a shared folder and without one."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nailnoise as nn
import pytest
from distributed import Client, LocalCluster

ROOT = Path(__file__).parents[2]
SMALL = ROOT / "tests/data/small.toml"
COMMAND = Path(os.environ.get("NAILNOISE", ROOT / "target/release/nailnoise"))
ANY = '[study]\nrequire = ["drives", "underdriven", "overdriven", "strikes_bumper"]\n'


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        yield client


@pytest.fixture
def drawn(tmp_path: Path) -> nn.Design:
    file = tmp_path / "drawn.toml"
    file.write_text(f"base = {json.dumps(str(SMALL))}\n{ANY}")
    return nn.load(file)


@pytest.mark.parametrize("structures", [None, 2])
def test_results_by_value_state_the_study_of_one_process(drawn: nn.Design, client: Client, structures: int | None) -> None:
    alone = nn.study(drawn, 4, structures=structures, cache=False)
    spread = nn.study(drawn, 4, structures=structures, client=client, cache=False)
    assert spread.json == alone.json and spread.csv == alone.csv


def test_a_design_travels_with_its_bases(tmp_path: Path) -> None:
    from nailnoise._cluster import Sent

    base = tmp_path / "base.toml"
    base.write_text(f"base = {json.dumps(str(SMALL))}\n")
    own = tmp_path / "own.toml"
    own.write_text('base = "base.toml"\n')
    design = nn.load(own, {"exhaust.holes": 4})
    sent = Sent.of(design)
    assert {str(own), str(base), str(SMALL)} <= {str(Path(name).resolve()) for name, _ in sent.files}
    assert sent.design() == design


def _text(sent: Any, path: str) -> str:
    return str(sent.place(path).read_text())


def test_each_state_of_a_file_of_measurements_has_its_own_copy(drawn: nn.Design, client: Client, tmp_path: Path) -> None:
    from nailnoise._cluster import Sent

    file = tmp_path / "shots.toml"
    sent = []
    for text in ["first", "second"]:
        file.write_text(text)
        sent.append(Sent.of(drawn, [file]))
    file.unlink()
    found = [client.submit(_text, own, str(file), pure=False).result() for own in [sent[0], sent[1], sent[0]]]
    assert found == ["first", "second", "first"]


def test_a_shared_value_outlives_the_worker_that_holds_it() -> None:
    from nailnoise._cluster import Cluster, itself

    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        work = Cluster(client, None, "", None)
        value = work.share({"a": b"1"})
        assert value.result() == {"a": b"1"}
        os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)
        assert work.submit(itself, value).result(timeout=60) == {"a": b"1"}


def test_points_of_a_sweep_are_those_of_one_process(drawn: nn.Design, client: Client, tmp_path: Path) -> None:
    vary = {"exhaust.holes": [3, 5], "supply.pressure": "90psig..100psig:2"}
    alone = nn.sweep(drawn, vary, cache=False)
    assert nn.sweep(drawn, vary, client=client, cache=False).points == alone.points
    assert nn.sweep(drawn, vary, client=client, store=tmp_path / "shared").points == alone.points
    assert list((tmp_path / "shared").glob("levels-*.entry"))


def test_drawn_shots_are_those_of_one_process(drawn: nn.Design, client: Client) -> None:
    assert nn.shots(drawn, 70, client=client).json == nn.shots(drawn, 70).json


def test_trials_on_a_cluster_are_those_of_their_seed_and_batch(drawn: nn.Design, client: Client) -> None:
    vary = {"exhaust.holes": "2..12"}
    found = [nn.optimise(drawn, vary, trials=4, batch=2, client=client, cache=False) for _ in range(2)]
    assert [own.values for own in found[0].trials] == [own.values for own in found[1].trials]
    assert found[0].best is not None and found[0].best.figures["total"] == found[1].best.figures["total"]


MEASURED = """
schema = "nailnoise-calibration/1"
[condition]
90 = { set = { "supply.pressure" = "90 psig" }, outcome = ["drives", "underdriven", "overdriven"] }
[measured]
depth = { condition = "90", quantity = "head_depth", value = "-3 mm", error = "1 mm", shots = 5 }
rise = { condition = "90", quantity = "pressure", of = "above_piston", file = "p1.csv", align = "t6", points = 2, error = "3 %" }
"""


def test_a_calibration_is_that_of_one_process(drawn: nn.Design, client: Client, tmp_path: Path) -> None:
    measured = tmp_path / "shots.toml"
    measured.write_text(MEASURED)
    (tmp_path / "p1.csv").write_text("time [ms],p1 [kPa]\n0,400\n1,430\n")
    alone = nn.calibrate(drawn, measured, draws=64, moves=3, cache=False)
    spread = nn.calibrate(drawn, measured, draws=64, moves=3, cache=False, client=client)
    assert spread.json == alone.json and spread.csv == alone.csv


def test_a_worker_refuses_tasks_of_another_calibration(drawn: nn.Design, tmp_path: Path) -> None:
    from nailnoise import _native

    measured = tmp_path / "shots.toml"
    measured.write_text(MEASURED)
    (tmp_path / "p1.csv").write_text("time [ms],p1 [kPa]\n0,400\n1,430\n")
    tasks: list[bytes] = []

    def keep(given: list[bytes]) -> list[bytes]:
        tasks.extend(given)
        raise RuntimeError("no workers")

    others = _native.CalibrationWorker(drawn._native, measured, 64, 2)
    with pytest.raises(RuntimeError, match="no workers"):
        _native.calibrate(
            drawn._native, str(measured), 64, 3, 1, [], "leave-out", False, 128, [], str(tmp_path), None, False, None, None, keep, 2
        )
    assert len(tasks) == 2
    with pytest.raises(nn.NailnoiseError, match="another version"):
        others.result(tasks[0])


def test_the_command_reaches_a_scheduler(drawn: nn.Design, client: Client, tmp_path: Path) -> None:
    environment = dict(os.environ, NAILNOISE_CACHE=str(tmp_path / "cache"), NAILNOISE_PYTHON=sys.executable)

    def command(*arguments: str) -> bytes:
        done = subprocess.run([COMMAND, *arguments, "--json"], cwd=tmp_path, env=environment, capture_output=True)
        assert done.returncode == 0, done.stderr.decode()
        return done.stdout

    address = client.scheduler_info()["address"]
    study = ("study", drawn.path, "-n", "3")
    alone = command(*study, "--no-cache")
    assert command(*study, "--scheduler", address) == alone
    assert command(*study, "--scheduler", address, "--store", "shared") == alone
    assert len(list((tmp_path / "shared").glob("levels-*.entry"))) >= 3 and not Path("shared").exists()
    sweep = ("sweep", drawn.path, "--vary", "exhaust.holes=3,5", "--set", "supply.pressure=95 psig")
    assert command(*sweep, "--scheduler", address) == command(*sweep, "--no-cache")
    refused = subprocess.run(
        [COMMAND, *study, "--scheduler", address], cwd=tmp_path, env={**environment, "NAILNOISE_PYTHON": "/nowhere"}, capture_output=True, text=True
    )
    assert refused.returncode == 2 and "NAILNOISE_PYTHON" in refused.stderr


def test_slurm_workers_are_asked_for_as_documented() -> None:
    jobqueue = pytest.importorskip("dask_jobqueue")
    page = (ROOT / "docs/cluster.md").read_text()
    (block,) = [own.split("```")[0] for own in page.split("```python\n")[1:] if "SLURMCluster(" in own]
    call = block[: block.index("cluster.scale")]
    scope: dict = {}
    exec(call, scope)
    cluster = scope["cluster"]
    try:
        script = cluster.job_script()
    finally:
        cluster.close()
    assert isinstance(cluster, jobqueue.SLURMCluster)
    for line in ("#SBATCH --cpus-per-task=8", "#SBATCH -t 02:00:00", "distributed.cli.dask_worker", "--nthreads 1", "--nworkers 8"):
        assert line in script, script
