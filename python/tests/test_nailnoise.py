"""The package does what the command does, to the last bit, and fails as a Python package should."""

import json
import logging
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import nailnoise as nn
import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
SMALL = ROOT / "tests/data/small.toml"
COMMAND = Path(os.environ.get("NAILNOISE", ROOT / "target/release/nailnoise"))


@pytest.fixture(scope="session")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(scope="session")
def small() -> nn.Design:
    return nn.load(SMALL)


def command(cache: Path, folder: Path, *arguments: str) -> dict:
    environment = dict(os.environ, NAILNOISE_CACHE=str(cache))
    text = subprocess.run([COMMAND, *arguments, "--json"], cwd=folder, env=environment, capture_output=True, check=True).stdout
    return json.loads(text)


def test_a_design_is_a_mapping_of_its_values(small: nn.Design) -> None:
    assert small["exhaust.holes"] == 5
    assert small.entry("piston.mass")["unit"] == "kg"
    assert len(small) == len(list(small)) > 200
    other = small.with_({"supply.pressure": "80 psig", "exhaust.holes": 3})
    assert other["exhaust.holes"] == 3 and small["exhaust.holes"] == 5
    assert {"supply.pressure", "exhaust.holes"} <= set(small.differences(other).index)
    assert other.with_({"exhaust.holes": 5, "supply.pressure": small["supply.pressure"]}) == small
    assert small.with_(supply__pressure="80 psig", exhaust__holes=3) == other
    assert small.with_({"exhaust.holes": 4}, exhaust__hole_diameter="4 mm")["exhaust.hole_diameter"] == 0.004


def test_a_run_is_that_of_the_command(small: nn.Design, cache: Path, tmp_path: Path) -> None:
    run = nn.run(small, cache=cache)
    expected = command(cache, tmp_path, "run", str(SMALL))
    for result in (run.data, expected):
        result.pop("timing")
    assert run.data == expected
    total = 10 * np.log10(sum(10 ** (level / 10) for level in run.levels.values() if level is not None))
    assert abs(total - run.total_db) < 1e-9
    assert run.sound["total"].shape == (9, run.sound["exhaust"].shape[1])
    assert run.bands["exhaust"].notna().any()
    assert "exhaust" in repr(run) and "<table>" in run._repr_html_() and "image/svg+xml" in run._repr_html_()
    assert all(svg.startswith("<svg") for svg in run.charts.values())
    arrays = run.to_xarray()
    assert float(arrays["lwa"].sel(source="exhaust")) == run.levels["exhaust"]
    assert arrays["pressure"].sel(heard="total").shape == run.sound["total"].shape


def test_a_run_states_the_study_that_serves_it(tmp_path: Path) -> None:
    file, cache = tmp_path / "any.toml", tmp_path / "cache"
    outcomes = '["drives", "underdriven", "overdriven", "strikes_bumper"]'
    file.write_text(f'base = "{SMALL}"\n[study]\nrequire = {outcomes}\n')
    design = nn.load(file)
    without = nn.run(design, cache=cache)
    assert without.study is None and "screening" in without.no_study
    assert len(without.intervals) == 0 and without.orders == [] and without.k_db is None
    study = nn.study(design, 3, cache=cache)
    run = nn.run(design, cache=cache)
    assert run.no_study is None and run.study["draws"] == 3 and run.study["ends"] == "extremes"
    for source, first in study.first.items():
        own = run.intervals.loc[source]
        assert own["low_db"] <= run.levels[source] <= own["high_db"] and own["first"] == first
    assert sum(share for _, share in run.orders) == pytest.approx(1.0)
    assert run.k_db is None and "32 draws" in run.data["declaration"]["k_not_stated"]
    assert "3 draws dB" in repr(run)


def test_a_cycle_has_the_histories_of_the_command(small: nn.Design, cache: Path, tmp_path: Path) -> None:
    cycle = nn.cycle(small)
    expected = command(cache, tmp_path, "cycle", str(SMALL))
    assert cycle.data["events"] == expected["events"] and cycle.outcome == expected["outcome"]
    assert cycle["piston_velocity"].shape == cycle.time.shape and cycle.units["piston_velocity"] == "m/s"
    assert list(cycle.histories.columns)[0] == "piston_position"
    assert cycle.to_xarray()["piston_velocity"].attrs["units"] == "m/s"


def test_a_grid_of_nothing_or_of_one_key_twice_is_a_wrong_value(small: nn.Design) -> None:
    for vary in ({}, {"exhaust.holes": [3, 5], " exhaust.holes": [4, 6]}, {"exhaust.holes": []}):
        with pytest.raises(ValueError, match="vary|varies|value"):
            nn.sweep(small, vary, cache=False)
    with pytest.raises(ValueError, match="vary"):
        nn.optimise(small, {})


def test_a_cache_that_is_no_folder_is_a_warning_and_a_named_folder_that_is_none_an_error(
    small: nn.Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "file"
    file.write_text("mine")
    for place in (file, file / "below", Path("/dev/null")):
        monkeypatch.setenv("NAILNOISE_CACHE", str(place))
        with pytest.warns(UserWarning, match="not cached"):
            assert nn.modes(small, "workpiece").rigid.sum() == 6
        for own in ({"cache": place}, {"store": place}):
            with pytest.raises(nn.NailnoiseError, match="the store"):
                nn.sweep(small, {"exhaust.holes": [5]}, **own)
    assert file.read_text() == "mine"


def test_modes_are_orthogonal_and_rigid_ones_come_first(small: nn.Design, cache: Path) -> None:
    modes = nn.modes(small, "workpiece", cache=cache)
    assert modes.rigid.sum() == 6 and np.all(np.diff(modes.hz) >= -1e-6)
    assert modes.shapes.shape == (len(modes.hz), len(modes.points), 3)
    # The faces are closed: each edge has a neighbour that runs the other way.
    faces, edges, at = modes.faces, set(), 0
    while at < len(faces):
        own = faces[at + 1 : at + 1 + faces[at]]
        edges |= set(zip(own.tolist(), np.roll(own, -1).tolist()))
        at += 1 + int(faces[at])
    assert edges and all((b, a) in edges for a, b in edges)
    moved = modes.moved(7, 1e-3) - modes.points
    assert np.linalg.norm(moved, axis=1).max() == pytest.approx(1e-3)


def test_a_comparison_is_that_of_its_runs(small: nn.Design, cache: Path) -> None:
    runs = [nn.run(design, cache=cache) for design in (small, small.with_({"exhaust.holes": 4}))]
    levels = nn.compare(*runs).levels
    assert levels.loc["total"].tolist() == [run.total_db for run in runs]
    # The variant of a design has its name, and is distinguished by a number.
    assert list(levels.columns) == ["small", "small (2)"]


def test_a_comparison_with_draws_states_how_sure_a_change_is(cache: Path, tmp_path: Path) -> None:
    file = tmp_path / "any.toml"
    outcomes = '["drives", "underdriven", "overdriven", "strikes_bumper"]'
    file.write_text(f'base = "{SMALL}"\n[study]\nrequire = {outcomes}\n')
    design = nn.load(file)
    other = design.with_(exhaust__holes=4)
    compared = nn.compare(design, other, draws=3, cache=cache)
    changes = compared.changes
    assert set(changes["source"]) == {"workpiece", "exhaust", "body", "total"}
    assert compared.data["paired"][0]["draws"] == 3
    with pytest.raises(ValueError, match="designs"):
        nn.compare(nn.run(design, cache=cache), other, draws=3)


def test_a_study_is_that_of_the_command(cache: Path, tmp_path: Path) -> None:
    design = tmp_path / "drawn.toml"
    outcomes = '["drives", "underdriven", "overdriven", "strikes_bumper"]'
    design.write_text(f"base = {json.dumps(str(SMALL))}\n[study]\nrequire = {outcomes}\n")
    study = nn.study(nn.load(design), 4, cache=cache)
    assert study.data == command(cache, tmp_path, "study", str(design), "-n", "4", "--no-cache")
    assert len(study.draws) == 4
    levels = study.to_xarray()
    assert levels.dims == ("draw", "source") and levels.shape == (4, 4) and "total" in levels.source
    assert abs(sum(study.first.values()) - 1.0) < 1e-12


def test_a_study_on_a_cluster_is_that_of_one_process_although_a_worker_dies(cache: Path, tmp_path: Path) -> None:
    from distributed import Client, LocalCluster

    design = tmp_path / "drawn.toml"
    outcomes = '["drives", "underdriven", "overdriven", "strikes_bumper"]'
    design.write_text(f"base = {json.dumps(str(SMALL))}\n[study]\nrequire = {outcomes}\n")
    drawn = nn.load(design).with_({"exhaust.holes": 4})
    alone = nn.study(drawn, 8, cache=cache)
    tasks: list[int] = []

    def kill_a_worker(stage: str, done: int, of: int) -> None:
        tasks.append(of)
        if done == 2:
            os.kill(next(iter(client.run(os.getpid).values())), 9)

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        spread = nn.study(drawn, 8, store=tmp_path / "store", client=client, tasks=6, cache=False, progress=kill_a_worker)
    assert spread.json == alone.json and spread.csv == alone.csv
    assert 6 in tasks


def test_a_sweep_has_a_row_for_each_point(small: nn.Design, cache: Path) -> None:
    swept = nn.sweep(small, {"exhaust.holes": [3, 5], "supply.pressure": "90psig..100psig:2"}, cache=cache)
    assert len(swept.table) == 4
    of_run = nn.run(small.with_({"supply.pressure": "100 psig"}), cache=cache)
    assert abs(swept.points[3]["total_db"] - of_run.total_db) < 1e-9


def test_a_small_pulsating_sphere_radiates_what_the_closed_form_says() -> None:
    radius, rings, around = 0.1, 14, 28
    points = [(0.0, 0.0, radius)]
    for ring in range(1, rings + 1):
        theta = np.pi * ring / (rings + 1)
        phi = 2 * np.pi * np.arange(around) / around
        points += [(radius * np.sin(theta) * np.cos(p), radius * np.sin(theta) * np.sin(p), radius * np.cos(theta)) for p in phi]
    points.append((0.0, 0.0, -radius))
    at = lambda ring, step: 1 + (ring - 1) * around + step % around  # noqa: E731
    triangles = [(0, at(1, s), at(1, s + 1)) for s in range(around)]
    triangles += [(at(rings, s), len(points) - 1, at(rings, s + 1)) for s in range(around)]
    for ring in range(1, rings):
        for s in range(around):
            triangles += [(at(ring, s), at(ring + 1, s), at(ring, s + 1)), (at(ring, s + 1), at(ring + 1, s), at(ring + 1, s + 1))]
    impedance, speed = 413.3, 343.2
    power = nn.radiated_power(points, triangles, [1.0] * len(points), speed / (2 * np.pi * radius))
    assert abs(power / (impedance * 4 * np.pi * radius**2 / 2) - 1) < 0.03


def test_errors_have_place_and_remedy(small: nn.Design, tmp_path: Path) -> None:
    design = tmp_path / "wrong.toml"
    design.write_text(f"base = {json.dumps(str(SMALL))}\n\npiston.mass = \"3 s\"\n")
    with pytest.raises(nn.NailnoiseError, match="piston.mass") as raised:
        nn.load(design)
    assert raised.value.line == 3 and "wrong.toml" in raised.value.file and raised.value.status == 2
    assert raised.value.key == "piston.mass" and "kg" in raised.value.help
    with pytest.raises(nn.NailnoiseError, match="none.toml"):
        nn.load(tmp_path / "none.toml")
    with pytest.raises(ValueError, match="no body"):
        nn.modes(small, "nail")
    with pytest.raises(ValueError):
        nn.study(small, 0)
    with pytest.raises(ValueError, match="lacks a key"):
        nn.sweep(small, {"": [1]})


def test_progress_reaches_the_callback_and_remarks_the_logger(caplog: pytest.LogCaptureFixture, small: nn.Design) -> None:
    stages: list[str] = []
    with caplog.at_level(logging.INFO, "nailnoise"):
        nn.run(small, cache=False, progress=lambda stage, done, of: stages.append(stage))
    assert any("modes" in stage for stage in stages)

    def fail(stage: str, done: int, of: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        nn.run(small, cache=False, progress=fail)
    nn.sweep(small, {"exhaust.holes": [3, 5]}, cache=False, progress=True)


def test_other_threads_go_on(small: nn.Design) -> None:
    ticks, ended = [], threading.Event()

    def tick() -> None:
        while not ended.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.monotonic()
    nn.run(small, cache=False)
    ended.set()
    thread.join()
    assert sum(tick >= begin for tick in ticks) > 20


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_an_interrupt_ends_the_work() -> None:
    script = f"""
import _thread, threading, nailnoise as nn
threading.Timer(1.0, _thread.interrupt_main).start()
try:
    nn.run(nn.load({str(ROOT / "designs/n80cb.toml")!r}), cache=False)
except KeyboardInterrupt:
    print("interrupted")
"""
    begin = time.monotonic()
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert done.stdout == "interrupted\n", done.stderr
    assert done.stderr == "" and time.monotonic() - begin < 60.0


VARY = {"exhaust.holes": "2..12", "exhaust.hole_diameter": "3 mm..8 mm", "supply.pressure": "80psig..110psig"}
HELD = ["outcome == drives", "penetration >= 82 mm"]


def test_an_optimisation_proposes_designs_that_meet_the_constraints(small: nn.Design, cache: Path, tmp_path: Path) -> None:
    found = nn.optimise(small, VARY, subject_to=HELD, trials=14, cache=cache)
    assert sum(own.has_levels for own in found.trials) == 14 and found.best is not None
    for own in found.feasible:
        assert own.figures["outcome"] == "drives" and own.figures["penetration"] >= 0.082
    assert all(own.figures.get("total") is None for own in found.trials if not own.feasible)
    (file,) = found.write(tmp_path)
    assert not any('"' in line for line in file.read_text().splitlines() if line.startswith("exhaust.holes"))
    assert nn.run(nn.load(file), cache=cache).total_db == pytest.approx(found.best.figures["total"], abs=1e-9)
    again = nn.optimise(small, VARY, subject_to=HELD, trials=14, cache=cache)
    assert [own.values for own in again.trials] == [own.values for own in found.trials]


def test_no_design_of_a_front_betters_another(small: nn.Design, cache: Path) -> None:
    found = nn.optimise(small, {"supply.pressure": "85psig..110psig"}, pareto="-drive_energy", trials=10, cache=cache)
    levels = [own.figures["total"] for own in found.front]
    energies = [own.figures["drive_energy"] for own in found.front]
    assert levels == sorted(levels) and energies == sorted(energies)


def test_an_optimisation_that_cannot_be_is_refused(small: nn.Design, cache: Path) -> None:
    held = nn.optimise(small, VARY, subject_to=["penetration >= 3 m"], trials=3, cache=cache)
    assert held.best is None and "loosen a constraint" in repr(held)
    for vary, more in (
        ({}, {}),
        ({"exhaust.hole": "1..3"}, {}),
        ({"exhaust.holes": "9..3"}, {}),
        ({"exhaust.holes": "3"}, {}),
        ({"exhaust.hole_diameter": "3 mm..8 m"}, {}),
        (VARY, {"subject_to": ["penetration > 3 mm"]}),
        (VARY, {"subject_to": ["penetration >= 3 kN"]}),
        (VARY, {"subject_to": ["depth >= 3 mm"]}),
        (VARY, {"minimise": "noise"}),
    ):
        with pytest.raises(ValueError):
            nn.optimise(small, vary, trials=2, cache=cache, **more)


SHOTS = """schema = "nailnoise-calibration/1"
[condition]
own = { set = { "supply.pressure" = "100 psig" } }
[measured]
depth = { condition = "own", quantity = "head_depth", value = "-8 mm", shots = 5, scatter = "1 mm", error = "0.5 mm" }
air = { condition = "own", quantity = "air_per_shot", value = "1.4 l", error = "4 %" }
"""


def test_a_calibration_is_that_of_the_command(cache: Path, tmp_path: Path) -> None:
    (tmp_path / "shots.toml").write_text(SHOTS)
    any_end = '["drives", "underdriven", "overdriven", "strikes_bumper"]'
    (tmp_path / "tool.toml").write_text(f"base = {json.dumps(str(SMALL))}\n[study]\nrequire = {any_end}\n")
    design = nn.load(tmp_path / "tool.toml")
    known = nn.calibrate(design, tmp_path / "shots.toml", draws=64, moves=3, hold_out=["air"], cache=cache)
    environment = dict(os.environ, NAILNOISE_CACHE=str(cache))
    arguments = ["calibrate", "tool.toml", "--measured", tmp_path / "shots.toml", "--draws", "64", "--moves", "3", "--hold-out", "air"]
    done = subprocess.run([COMMAND, *arguments, "--out", "out", "--json"], cwd=tmp_path, env=environment, capture_output=True)
    assert done.returncode in (0, 1, 3), done.stderr.decode()
    assert known.data == json.loads(done.stdout)
    out = tmp_path / "out" / "calibration"
    assert known.csv == (out / "posterior.csv").read_text()
    assert Path(known.design.path).with_name("calibrated.draws").read_text() == (out / "calibrated.draws").read_text()

    assert known.converged == (known.faults == [])
    assert list(known.measured.index) == ["depth", "air"]
    depth = known.measured.loc["depth"]
    assert depth["reading_low"] == depth["reading_high"] == -8e-3 and depth["now_low"] < depth["now_high"]
    assert not known.measured.loc["air", "counts"]
    assert len(known.draws) == 64 and "piston.mass" in known.draws.columns
    assert set(known.moved) <= set(known.inputs.index)
    ends = known.draws["piston.mass"].quantile([0.05, 0.95]).to_numpy()
    row = known.inputs.loc["piston.mass"]
    assert row["now_low"] - 1e-3 < ends[0] < ends[1] < row["now_high"] + 1e-3
    assert len(known.next) == 0
    assert "head_depth" not in repr(known) and "depth" in repr(known) and "image/svg+xml" in known._repr_html_()
    drawn = nn.study(known.design, 2, cache=cache).draws["piston.mass [kg]"]
    assert all(np.isclose(known.draws["piston.mass"], value).any() for value in drawn)


def test_a_calibration_that_cannot_be_is_refused(small: nn.Design, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="64 draws"):
        nn.calibrate(small, tmp_path / "shots.toml", draws=10)
    with pytest.raises(ValueError, match="next=True"):
        nn.calibrate(small)
    (tmp_path / "shots.toml").write_text(SHOTS.replace("head_depth", "head_dept"))
    with pytest.raises(nn.NailnoiseError) as raised:
        nn.calibrate(small, tmp_path / "shots.toml")
    assert raised.value.line == 5 and "head_depth" in (raised.value.help or "") and raised.value.status == 2
