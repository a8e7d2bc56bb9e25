"""Measures a virtual tool whose truth is known, calibrates the design with the readings, and compares.

    calibration.py NAILNOISE DESIGN WORK [DRAWS] [MOVES]

The virtual tool is DESIGN (designs/n80cb.toml) with the values of TRUTH. `nailnoise cycle` computes its shots at three
supply pressures; the readings are rounded as an owner would read them. WORK is a folder for the files. The script
prints the table of docs/calibration.md: the true figures of the shot, and the 90 % intervals before and after. It
fails if more than one of five figures lies outside its interval.
"""

import json
import subprocess
import sys
from pathlib import Path

# Values within the ranges of the design that differ from the design's values.
TRUTH = {
    "piston.bore": "57.5 mm",
    "head_valve.lift": "4.2 mm",
    "wood.resistance_scale": "1.0",
    "chambers.return_volume": "330 cm3",
}
PRESSURES = {"96 psig": "96psig", "80 psig": "80psig", "110 psig": "110psig"}


def cycle(program, design, pressure):
    """Result of a shot of the virtual tool."""
    values = [f"--set={key}={value}" for key, value in TRUTH.items()]
    done = subprocess.run(
        [program, "cycle", design, "--json", f"--set=supply.pressure={pressure}", *values],
        capture_output=True,
        text=True,
    )
    if not done.stdout:
        sys.exit(done.stderr)
    return json.loads(done.stdout)


def measurements(shots):
    """The file of measurements: head depths, times, air."""
    lines = ['schema = "nailnoise-calibration/1"', "[instrument]", 'gauge = { error = "1 %" }', "[condition]"]
    for name, shot in shots.items():
        outcome = f', outcome = "{shot["outcome"]}"' if name == "96 psig" else ""
        lines.append(
            f'"{name}" = {{ set = {{ "supply.pressure" = "{name}" }}, '
            f'instrument = {{ "supply.pressure" = "gauge" }}{outcome} }}'
        )
    lines.append("[measured]")
    for name, shot in shots.items():
        depth = round(1e4 * shot["summary"]["head_depth"]) / 10
        lines.append(
            f'depth-{name.split()[0]} = {{ condition = "{name}", quantity = "head_depth", value = "{depth} mm", '
            'shots = 5, scatter = "1.5 mm", error = "0.2 mm" }'
        )
    shot = shots["96 psig"]
    events, summary = shot["events"], shot["summary"]
    drive = round(1e4 * (events["t9"] - events["t6"])) / 10
    lines.append(
        'drive = { condition = "96 psig", quantity = "interval", events = ["t6", "t9"], '
        f'value = "{drive} ms", shots = 5, scatter = "3 %", error = "0.1 ms" }}'
    )
    mass = summary["exhaust_mass"] + summary["vent_mass"] + summary["leak_mass"]
    # Free air of 20 shots at 293.15 K and 101.325 kPa, on a gas meter with steps of 0.1 l.
    litres = round(10 * 20 * mass * 287.05 * 293.15 / 101.325e3 * 1e3) / 10
    lines.append(
        f'air = {{ condition = "96 psig", quantity = "air_per_shot", value = "{litres} l", shots = 20, error = "1 l" }}'
    )
    return "\n".join(lines) + "\n"


def main():
    program, design, work = sys.argv[1:4]
    draws, moves = (sys.argv[4:] + ["512", "24"][len(sys.argv[4:]) :])[:2]
    work = Path(work)
    work.mkdir(parents=True, exist_ok=True)
    shots = {name: cycle(program, design, pressure) for name, pressure in PRESSURES.items()}
    file = work / "my-shots.toml"
    file.write_text(measurements(shots))
    out = work / "out"
    arguments = ["calibrate", design, "--measured", file, "--draws", draws, "--moves", moves, "--out", out, "--quiet"]
    done = subprocess.run([program, *map(str, arguments)], text=True, stdout=subprocess.PIPE)
    print(file.read_text() + "\n" + done.stdout)
    if done.returncode not in (0, 1, 3):
        sys.exit(done.returncode)
    result = json.loads((out / "calibration" / "calibration.json").read_text())
    truth = {
        "speed before impact": shots["96 psig"]["summary"]["speed_before_impact"],
        "mean drive speed": shots["96 psig"]["summary"]["mean_drive_speed"],
        "head depth": shots["96 psig"]["summary"]["head_depth"],
        "peak penetration force": shots["96 psig"]["summary"]["peak_penetration_force"],
        "air through the exhaust": shots["96 psig"]["summary"]["exhaust_mass"],
    }
    readable = {"m": ("mm", 1e3), "N": ("kN", 1e-3), "kg": ("g", 1e3)}
    covered = 0
    print("| figure | true | before, 90 % | now, 90 % |\n|---|---|---|---|")
    for row in result["figures"]:
        if row["name"] not in truth:
            continue
        value = truth[row["name"]]
        (low, _, high), (now_low, _, now_high) = row["before"], row["now"]
        covered += now_low <= value <= now_high
        unit, factor = readable.get(row["unit"], (row["unit"], 1.0))
        ends = [f"{factor * low:.3g} .. {factor * high:.3g}", f"{factor * now_low:.3g} .. {factor * now_high:.3g}"]
        print(f"| {row['name']} [{unit}] | {factor * value:.3g} | {ends[0]} | {ends[1]} |")
    print(f"{covered} of {len(truth)} true figures lie in their intervals; converged: {result['converged']}")
    if covered < len(truth) - 1:
        sys.exit("too few")


if __name__ == "__main__":
    main()
