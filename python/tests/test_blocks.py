"""Building blocks, penetration laws and the measurement side beside closed forms and the command."""

import json
import os
import subprocess
from pathlib import Path

import nailnoise as nn
import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
SMALL = ROOT / "tests/data/small.toml"
COMMAND = Path(os.environ.get("NAILNOISE", ROOT / "target/release/nailnoise"))


def command(folder: Path, *arguments: str) -> dict:
    done = subprocess.run([COMMAND, *arguments, "--json"], cwd=folder, capture_output=True, check=True)
    return json.loads(done.stdout)


def test_a_tone_of_a_second_has_its_level_in_its_band() -> None:
    tone = 0.2 * np.sin(2 * np.pi * 1000 * np.arange(48_000) / 48_000)
    levels = nn.signal_levels(tone, 48_000)
    expected = 20 * np.log10(0.2 / np.sqrt(2) / 20e-6)
    assert levels.exposure["Z"] == pytest.approx(expected, abs=1e-6)
    assert levels.exposure["A"] == pytest.approx(expected, abs=0.01)
    assert levels.bands.loc[1000.0, "unweighted_db"] == pytest.approx(expected, abs=0.02)
    assert levels.bands["unweighted_db"].idxmax() == 1000.0
    assert nn.signal_levels(np.zeros(4800), 48_000).exposure["A"] is None
    with pytest.raises(ValueError):
        nn.signal_levels(tone, 0.0)


def test_an_array_of_another_shape_is_refused_and_not_read_row_by_row() -> None:
    """Two channels in one row after the other are another signal: 3 dB more, and an octave lower."""
    noise = np.random.default_rng(1).standard_normal((4800, 2))
    one = nn.signal_levels(noise[:, 0], 48_000)
    assert one.exposure == nn.signal_levels(list(noise[:, 0]), 48_000).exposure
    flow = [np.full(100, value) for value in (0.01, 2e5, 290.0)]
    shapes = ([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
    for refused in (
        lambda: nn.signal_levels(noise, 48_000),
        lambda: nn.signal_levels(noise[:, :1], 48_000),
        lambda: nn.signal_levels(np.float64(1.0), 48_000),
        lambda: nn.exhaust_levels(1e-5, np.stack([flow[0]] * 2), *flow[1:], holes=5, diameter=6e-3),
        lambda: nn.exhaust_levels(1e-5, flow[0], flow[1][:50], flow[2], holes=5, diameter=6e-3),
        lambda: nn.radiated_power(*shapes, np.ones((4, 1)), 100.0),
        lambda: nn.radiated_power(*shapes, np.ones(3), 100.0),
        lambda: nn.radiated_power(shapes[0], np.zeros((4, 4), dtype=int), np.ones(4), 100.0),
        lambda: nn.penetration(nn.penetration_names()["laws"][0], depths=np.ones((3, 2))),
        lambda: nn.mesh_modes(np.eye(3), np.arange(8), nn.Elastic.isotropic(1e9, 0.3, 500.0), 100.0),
    ):
        with pytest.raises(ValueError, match="shape|expected"):
            refused()


def test_a_free_bar_has_the_lowest_longitudinal_mode_of_a_bar() -> None:
    """Without contraction, half a wave at sqrt(E/rho) = 5 km/s fits into 1 m at 2500 Hz."""
    places = [(x, y, z) for z in (0.0, 0.04) for y in (0.0, 0.05) for x in np.linspace(0, 1, 41)]
    elements = np.array([[i, i + 1, i + 42, i + 41, i + 82, i + 83, i + 124, i + 123] for i in range(40)])
    modes = nn.mesh_modes(places, elements, nn.Elastic.isotropic(200e9, 0.0, 8000.0), 3000.0)
    assert modes.rigid.sum() == 6 and modes.shapes.shape == (len(modes.hz), len(places), 3)
    assert min(abs(modes.hz / 2500.0 - 1.0)) < 1e-3
    held = nn.mesh_modes(places, elements, nn.Elastic.isotropic(200e9, 0.0, 8000.0), 3000.0, held=[0, 41, 82, 123])
    assert held.rigid.sum() == 0
    with pytest.raises(ValueError, match="order of VTK"):
        nn.mesh_modes(places, [[0, 1, 2]], nn.Elastic.isotropic(200e9, 0.0, 8000.0), 3000.0)


def test_an_outflow_is_louder_through_one_hole_of_the_same_area_and_parts_sum_to_the_level() -> None:
    time = np.arange(4000) * 1e-5
    flow = (1e-5, 0.02 * np.exp(-time / 0.01), 101_325 + 3e5 * np.exp(-time / 0.01), np.full(len(time), 290.0))
    five = nn.exhaust_levels(*flow, holes=5, diameter=6e-3)
    parts = sum(10 ** (level / 10) for level in five.parts.values() if level is not None)
    assert 10 * np.log10(parts) == pytest.approx(five.lwa, abs=1e-9)
    assert five.mass == pytest.approx(0.02 * 1e-5 * np.exp(-time / 0.01).sum())
    one = nn.exhaust_levels(*flow, holes=1, diameter=6e-3 * np.sqrt(5))
    assert one.lwa > five.lwa  # finer jets sound higher, in part above 20 kHz
    with pytest.raises(ValueError, match="sampling"):
        nn.exhaust_levels(1e-4, *flow[1:], holes=5, diameter=6e-3)


def test_a_penetration_law_is_that_of_the_command(tmp_path: Path) -> None:
    assert {"general", "solid_wood"} <= set(nn.penetration_names()["laws"])
    law = nn.penetration("general", nail="8d", depths=[0.02, 0.04])
    assert np.all(np.diff(law.work) > 0) and law.band is not None and np.all(law.band[:, 0] < law.force)
    fine = nn.penetration("general", nail="8d", depths=np.linspace(1e-9, 0.04, 2001))
    assert law.work[1] == pytest.approx(np.trapezoid(fine.force, fine.depth), rel=1e-3)
    table = tmp_path / "own.csv"
    table.write_text("0,0\n0.1,1000\n")
    assert nn.penetration(table, depths=[0.05]).force[0] == pytest.approx(500.0)
    with pytest.raises(nn.NailnoiseError, match="generl") as raised:
        nn.penetration("generl")
    assert "general" in raised.value.help


DRIVES = """\
id,group,repeat,drive,nail,shank,wood,speed_m_s,file
a1,a,1,1,6d,smooth,pine,8.333e-3,a1.csv
a2,a,2,1,6d,smooth,pine,8.333e-3,a2.csv
b1,b,1,1,6d,smooth,pine,3.333e-4,b1.csv
b2,b,2,1,6d,smooth,pine,3.333e-4,b2.csv
"""


def recording(deviation: float) -> str:
    """Depth and force of a 6d nail in pine, from before the contact."""
    depth = (np.arange(220) - 20.0) * 50.8e-3 / 200.0
    x = np.maximum(depth / 50.8e-3, 0.0)
    force = 383_640.0 * 50.8e-3 * (0.9 * np.sqrt(x) * (1.0 - 0.5 * x) * (0.3 + deviation)) ** 2
    rows = zip(np.arange(220) / 100.0, depth, force)
    return "time_s,depth_m,force_n\n" + "".join(f"{t:.4f},{d:.7f},{f:.3f}\n" for t, d, f in rows)


def test_a_fit_is_that_of_the_command(tmp_path: Path) -> None:
    drives = tmp_path / "drives.csv"
    drives.write_text(DRIVES)
    for name, deviation in (("a1", 0.0), ("a2", 0.02), ("b1", -0.01), ("b2", 0.01)):
        (tmp_path / f"{name}.csv").write_text(recording(deviation))
    form = "x^0.5 + x"
    fit = nn.fit_penetration(drives, form=form)
    expected = command(tmp_path, "prf", "fit", str(drives), "--form", form)
    assert fit.data == expected["fit"] and fit.fitting["conditions"] == expected["conditions"]
    file = fit.write(tmp_path / "fit.toml")
    assert file.read_text() == (tmp_path / "out/prf-fit/fit.toml").read_text()
    assert "<img" in fit._repr_html_() and len(fit.terms) == 2


def test_a_fit_with_the_law_of_the_speed_is_that_of_the_command(tmp_path: Path) -> None:
    drives = tmp_path / "drives.csv"
    drives.write_text(DRIVES)
    for name in ("a1", "a2", "b1", "b2"):
        (tmp_path / f"{name}.csv").write_text(recording(0.0))
    options = ["--rate", "speed", "--friction-share", "0.5"]
    expected = command(tmp_path, "penetration", "fit", str(drives), "--form", "x^0.5 + x", *options)
    assert nn.fit_penetration(drives, form="x^0.5 + x", rate="speed", friction_share=0.5).data == expected["fit"]
    with pytest.raises(ValueError, match="there is no rate `fast`"):
        nn.fit_penetration(drives, rate="fast")


def test_a_wrapping_test_and_its_measurement_are_those_of_the_command(tmp_path: Path) -> None:
    environment = dict(os.environ, NAILNOISE_CACHE=str(tmp_path / "cache"))
    subprocess.run([COMMAND, "test", str(SMALL), "--out", "test", "--json"], cwd=tmp_path, env=environment, check=True, capture_output=True)
    expected = command(tmp_path, "measure", "test/manifest.toml", "--out", "measured")
    own = nn.measure(tmp_path / "test/manifest.toml")
    own.data.pop("manifest"), expected.pop("manifest")
    assert own.data == expected
    exact = nn.test_energies(nn.load(SMALL), cache=tmp_path / "cache")
    assert set(exact.levels.index) == {"workpiece", "exhaust", "body"}
    assert own.levels["workpiece"] == pytest.approx(exact.levels.loc["workpiece", "less_residual"], abs=3.0)
