#!/usr/bin/env python3
"""Runs the virtual test of a silencer by discharge, and checks the tables of its page.

    silencer.py NAILNOISE PAGE.md OUT

Needs the Python package. With NAILNOISE_UPDATE_DOCS set, writes the tables into the page.
"""

import os
import subprocess
import sys
from pathlib import Path

import nailnoise
import numpy as np

EXAMPLES = Path(__file__).parents[2] / "examples" / "silencer"
MARKS = "<!-- made by tests/peers/silencer.py -->\n\n", "\n<!-- end -->\n"
# Number of holes, diameter [m] and pitch [m], from the files.
TESTS = {"bare": (1, 8e-3, None), "silencer": (100, 1e-3, 4e-3)}
VESSEL, TEMPERATURE, AMBIENT = 2e-3, 293.15, 101_325.0
GAS_CONSTANT, RATIO = 287.05, 1.4
# Standard reference atmosphere of ISO 8778: density [kg/m3].
REFERENCE_DENSITY = 1.185
DISCHARGE_COEFFICIENT = 0.8
# Half of the interval over which the slope of the pressure is taken [s].
HALF = 1e-3


def columns(path):
    with open(path, encoding="utf-8") as file:
        names = file.readline().strip().split(",")
        values = np.loadtxt(file, delimiter=",")
    return dict(zip(names, values.T))


def conductance(time, pressure):
    """Mass flow over pressure against pressure, by the fall of the pressure in a vessel of constant temperature."""
    steps = round(HALF / (time[1] - time[0]))
    slope = (pressure[2 * steps :] - pressure[: -2 * steps]) / (2 * HALF)
    flow = -slope * VESSEL / (GAS_CONSTANT * TEMPERATURE)
    return pressure[steps:-steps], flow


def tested(program, out, name):
    subprocess.run(
        [program, "cycle", EXAMPLES / f"{name}.toml", "--out", out / name, "--quiet"],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    opening, history = columns(out / name / "openings.csv"), columns(out / name / "histories.csv")
    time, vessel = history["time [s]"], history["vessel_pressure [Pa]"]
    pressure, flow = conductance(time, vessel)
    at = {gauge: int(np.argmax(pressure < 1e5 * gauge + AMBIENT)) for gauge in (6, 4, 2, 1, 0.5)}
    # C from the choked flow; b from the flow that is not choked.
    choked = flow[at[4]] / pressure[at[4]]
    ratios = []
    for back in (0.6, 0.7, 0.8):
        i = int(np.argmax(AMBIENT / pressure > back))
        phi = flow[i] / (choked * pressure[i])
        ratios.append(1.0 - (1.0 - back) / (1.0 - np.sqrt(1.0 - phi * phi)))
    holes, diameter, pitch = TESTS[name]
    levels = nailnoise.exhaust_levels(
        opening["time [s]"][1],
        np.maximum(opening["outlet_mass_flow [kg/s]"], 0.0),
        opening["outlet_pressure [Pa]"],
        opening["outlet_temperature [K]"],
        holes=holes,
        diameter=diameter,
        discharge_coefficient=DISCHARGE_COEFFICIENT,
        pitch=pitch,
        air=(TEMPERATURE, AMBIENT),
    )
    gauge = vessel - AMBIENT
    i = int(np.argmax(vessel < 4e5 + AMBIENT))
    behind = "silencer_pressure [Pa]" if name == "silencer" else "port_pressure [Pa]"
    return {
        "level": levels.lwa,
        "at_1m": levels.lwa - 10.0 * np.log10(4.0 * np.pi),
        "duration": 1e3 * time[int(np.argmax(gauge < 0.2 * gauge[0]))],
        "c": 1e8 * choked / REFERENCE_DENSITY,
        "b": float(np.mean(ratios)),
        "behind": 1e-5 * (history[behind][i] - AMBIENT),
        "parts": levels.parts,
        "flow": {gauge: 6e4 * flow[i] / REFERENCE_DENSITY for gauge, i in at.items()},
    }


def tables(bare, silenced):
    rows = [
        ("A-weighted sound power level of the discharge, L_WA,1s, dB", "level", 1),
        ("the same at 1 m in a free field, mean over all directions, L_AE, dB", "at_1m", 1),
        ("mixing noise of the jets, dB(A)", ("parts", "mixing"), 1),
        ("shock noise of the jets, dB(A)", ("parts", "shock"), 1),
        ("unsteady outflow, dB(A)", ("parts", "unsteady flow"), 1),
        ("time to a fifth of the gauge pressure, ms", "duration", 0),
        ("sonic conductance C, dm³/(s bar)", "c", 2),
        ("critical back-pressure ratio b", "b", 2),
        ("gauge pressure before the last opening at 4 bar in the vessel, bar", "behind", 2),
    ]
    text = "| quantity | open port | silencer | difference |\n|---|---|---|---|\n"
    for label, key, digits in rows:
        found = [own[key] if isinstance(key, str) else own[key[0]][key[1]] for own in (bare, silenced)]
        cells = [f"{value:.{digits}f}" for value in (*found, found[1] - found[0])]
        text += f"| {label} | {' | '.join(cells)} |\n"
    text += "\n| gauge pressure in the vessel, bar | flow, open port, l/min (ANR) | with silencer |\n|---|---|---|\n"
    for gauge, flow in bare["flow"].items():
        text += f"| {gauge} | {flow:.0f} | {silenced['flow'][gauge]:.0f} |\n"
    return text


def main():
    program, page, out = Path(sys.argv[1]).resolve(), Path(sys.argv[2]), Path(sys.argv[3])
    bare, silenced = (tested(program, out, name) for name in TESTS)
    text = page.read_text(encoding="utf-8")
    before, rest = text.split(MARKS[0])
    _, after = rest.split(MARKS[1])
    made = before + MARKS[0] + tables(bare, silenced) + MARKS[1] + after
    if "NAILNOISE_UPDATE_DOCS" in os.environ:
        page.write_text(made, encoding="utf-8")
    elif made != text:
        sys.exit(f"{page} is old: run this script with NAILNOISE_UPDATE_DOCS=1")
    assert abs(silenced["c"] / bare["c"] - 1.0) < 0.1, "the silencer throttles the port"
    print(f"the silencer lowers the discharge by {bare['level'] - silenced['level']:.1f} dB(A)")


if __name__ == "__main__":
    main()
