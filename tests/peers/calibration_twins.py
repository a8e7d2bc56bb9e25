"""Calibrates hidden twins of a design: tools drawn from its ranges, measured with the stated errors.

    calibration_twins.py NAILNOISE DESIGN WORK [--twins 20] [--draws 512] [--moves 24] [--threads N] [--wrong NAME]
                         [--record FILE]

A call of `nailnoise calibrate` with every reading held out draws tools that drive, with their true inputs, readings and
figures of the shot. Each twin is measured nine times, with errors drawn as the file of measurements states them, and
calibrated. `--wrong drive` multiplies that reading by 1.3 instead, and asks which readings the calibration names.

A twin whose result is in WORK is read from there, so that an interrupted call continues. `--record FILE` appends the
result of each twin as a line of JSON, with the version of the program. A twin that has a line for the same settings is
not calibrated again, even if another version made the line. The script prints a line for each twin and then the
coverage of 90 % intervals, of inputs and of figures, by the twins whose sampler converged; the others are counted
apart. It fails if figures are covered in less than 80 % or more than 98 % of the cases, or, with
`--wrong`, if the wrong reading is named in fewer than nine of ten twins.
"""

import argparse
import csv
import json
import math
import random
import statistics
import subprocess
import sys
from pathlib import Path

HEADER = """schema = "nailnoise-calibration/1"
[instrument]
gauge = { error = "1 %" }
[condition]
96 = { set = { "supply.pressure" = "96 psig" }, instrument = { "supply.pressure" = "gauge" }, outcome = "drives" }
70 = { set = { "supply.pressure" = "70 psig" }, instrument = { "supply.pressure" = "gauge" } }
110 = { set = { "supply.pressure" = "110 psig" }, instrument = { "supply.pressure" = "gauge" } }
[measured]
"""
DEPTH = {"quantity": "head_depth", "unit": "m", "shots": 5, "scatter": (0, 1.5e-3), "error": (0, 0.2e-3)}
TIME = {"quantity": "interval", "unit": "s", "shots": 5, "scatter": (0.03, 0)}
# Readings, with errors as (share of the value, amount). `model` is the default of the quantity, stated in the file so
# that both sides use the same. Half of the model error is common to all depths.
READINGS = {
    "depth-96": DEPTH | {"condition": "96", "model": (0.05, 1e-3), "common": "discrepancy.head_depth"},
    "depth-70": DEPTH | {"condition": "70", "model": (0.05, 1e-3), "common": "discrepancy.head_depth"},
    "depth-110": DEPTH | {"condition": "110", "model": (0.05, 1e-3), "common": "discrepancy.head_depth"},
    "air": {
        "condition": "96",
        "quantity": "air_per_shot",
        "unit": "m3",
        "shots": 1,
        "scatter": (0.01, 0),
        "error": (0.04, 0),
        "model": (0.04, 0),
    },
    "drive": TIME | {"condition": "96", "events": ["t6", "t9"], "error": (0, 0.1e-3), "model": (0.05, 0)},
    "valve": TIME | {"condition": "96", "events": ["t0", "t6"], "error": (0, 0.2e-3), "model": (0.03, 0)},
    "blow": TIME | {"condition": "96", "events": ["t6", "t14"], "error": (0, 0.2e-3), "model": (0.03, 0)},
    "speed": {
        "condition": "96",
        "quantity": "mean_drive_speed",
        "unit": "m/s",
        "shots": 5,
        "scatter": (0.03, 0),
        "error": (0.02, 0),
        "model": (0.05, 0),
    },
    "p1": {
        "condition": "96",
        "quantity": "peak_pressure",
        "of": "above_piston",
        "unit": "Pa",
        "shots": 1,
        "scatter": (0.01, 0),
        "error": (0.02, 0),
        "model": (0.08, 0),
        "common": "discrepancy.pressure.above_piston",
    },
}
TYPICAL = [1e-3, -5e-3, 3e-3, 1.2e-3, 4e-3, 12e-3, 50e-3, 20.0, 6e5]
# Predicted only, to show whether the exhaust ends within the record of 115 ms.
LAST = {"condition": "96", "quantity": "interval", "events": ["t0", "t17"], "unit": "s", "shots": 5}
LAST |= {"scatter": (0.03, 0), "error": (0, 1e-3), "model": (0.03, 0)}
RECORD = 0.11


def amount(spread, value):
    """A standard deviation at a value."""
    share, absolute = spread
    return share * abs(value) + absolute


def line(name, reading, value):
    """A measurement of the file."""
    unit = reading["unit"]
    fields = {key: reading[key] for key in ("condition", "quantity", "of", "events", "shots") if key in reading}
    fields["value"] = f"{value:e} {unit}"
    for key, spread in (("scatter", "scatter"), ("error", "error"), ("discrepancy", "model")):
        fields[key] = f"{amount(reading[spread], value):e} {unit}"
    return f"{name} = {{ " + ", ".join(f"{key} = {json.dumps(own)}" for key, own in fields.items()) + " }\n"


def file_of(values):
    """The file of measurements with these values of the nine readings."""
    return HEADER + "".join(line(name, own, value) for (name, own), value in zip(READINGS.items(), values))


def calibrate(arguments, file, folder, *more):
    """The result of a calibration, and its draws."""
    result = folder / "calibration" / "calibration.json"
    if not result.exists():
        command = [arguments.program, "calibrate", arguments.design, "--measured", file, "--out", folder, "--quiet"]
        threads = ["--threads", arguments.threads] if arguments.threads else []
        done = subprocess.run([str(own) for own in [*command, *threads, *more]], stdout=subprocess.PIPE, text=True)
        if done.returncode not in (0, 1, 3):
            sys.exit(done.returncode)
    with open(folder / "calibration" / "posterior.csv", newline="") as draws:
        return json.loads(result.read_text()), list(csv.DictReader(draws))


def readings(tool, seed):
    """The readings of a tool, each with its error."""
    numbers = random.Random(seed)
    values = []
    for name, own in READINGS.items():
        true = float(tool[f"predicted.{name}"])
        model = amount(own["model"], true)
        common = own.get("common")
        half = math.sqrt(0.5) if common else 1.0
        independent = [amount(own["error"], true), amount(own["scatter"], true)]
        deviation = math.hypot(*(part / math.sqrt(own["shots"]) for part in independent), half * model)
        shared = half * model * float(tool[common]) if common else 0.0
        values.append(true + shared + numbers.gauss(0.0, deviation))
    return values


def covered(rows, tool, ends, name):
    """Number of true values inside their intervals, and of all."""
    pairs = [(float(tool[name(row)]), ends(row)) for row in rows if tool.get(name(row))]
    pairs = [(true, own) for true, own in pairs if None not in own]
    return [sum(low <= true <= high for true, (low, high) in pairs), len(pairs)]


def width(row):
    """Width of a figure's interval now, relative to that before."""
    return (row["now"][2] - row["now"][0]) / (row["before"][2] - row["before"][0])


def lines_of(record):
    """The rows of a record; none without a file."""
    if not record or not record.exists():
        return []
    return [json.loads(line) for line in record.read_text().splitlines()]


def calibrated(arguments, twin, tool):
    """Measures a hidden tool and calibrates it: what its intervals cover, its work and its conflicts."""
    values = readings(tool, twin)
    if arguments.wrong:
        values[list(READINGS).index(arguments.wrong)] *= 1.3
    kind = f"-{arguments.wrong}" if arguments.wrong else ""
    file = arguments.work / f"twin-{twin}{kind}.toml"
    file.write_text(file_of(values))
    folder = arguments.work / f"twin-{twin}{kind}-{arguments.draws}-{arguments.moves}"
    sampler = ["--draws", arguments.draws, "--moves", arguments.moves, "--seed", twin + 1]
    result, _ = calibrate(arguments, file, folder, *sampler)
    figure_name = lambda row: row["name"].replace(" ", "_")
    version = subprocess.run([arguments.program, "--version"], stdout=subprocess.PIPE, text=True).stdout.splitlines()
    return {
        "sources": next(line.split()[-1][:12] for line in version if line.startswith("sources")),
        "converged": result["converged"],
        "inputs": covered(result["inputs"], tool, lambda row: row["now"], lambda row: row["name"]),
        "figures": covered(result["figures"], tool, lambda row: row["now"][::2], figure_name),
        "widths": {row["name"]: round(width(row), 3) for row in result["figures"]},
        "halves_apart": round(result["halves_apart"], 3),
        "ancestors": result["ancestors"],
        "runs": result["work"]["runs"],
        "cycles": result["work"]["cycles"],
        "conflicts": [[name for name in (row["measurement"], row["partner"]) if name] for row in result["conflicts"]],
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("design")
    parser.add_argument("work", type=Path)
    parser.add_argument("--twins", type=int, default=20)
    parser.add_argument("--draws", default="512")
    parser.add_argument("--moves", default="24")
    parser.add_argument("--threads")
    parser.add_argument("--record", type=Path)
    parser.add_argument("--wrong", choices=[name for name in READINGS if not name.startswith("depth")])
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)

    file = arguments.work / "hidden.toml"
    file.write_text(file_of(TYPICAL) + line("last", LAST, 60e-3))
    held_out = ",".join([*READINGS, "last"])
    hidden = arguments.work / "hidden"
    count = max(64, 2 * arguments.twins)
    _, tools = calibrate(arguments, file, hidden, "--hold-out", held_out, "--draws", count, "--seed", "7777")
    tools = [own for own in tools if float(own["predicted.last"]) < RECORD][: arguments.twins]
    if len(tools) < arguments.twins:
        sys.exit(f"only {len(tools)} hidden tools end their exhaust within the record")

    settings = {"design": Path(arguments.design).stem, "draws": int(arguments.draws), "moves": int(arguments.moves)}
    settings["wrong"] = arguments.wrong
    recorded = lines_of(arguments.record)
    found = []
    for twin, tool in enumerate(tools):
        row = next((own for own in recorded if own["twin"] == twin and settings.items() <= own.items()), None)
        if row is None:
            row = {"twin": twin, **settings, **calibrated(arguments, twin, tool)}
            if arguments.record:
                with open(arguments.record, "a") as file:
                    file.write(json.dumps(row) + "\n")
        found.append(row)
        print(
            f"twin {twin}: converged {row['converged']}, inputs {row['inputs'][0]}/{row['inputs'][1]}, figures "
            f"{row['figures'][0]}/{row['figures'][1]}, halves {row['halves_apart']:.2f} apart, {row['ancestors']} ancestors, "
            f"{row['runs']} runs, {row['cycles']} cycles, conflicts {row['conflicts']}",
            flush=True,
        )
    named = sum(any(arguments.wrong in pair for pair in row["conflicts"]) for row in found)
    converged = [row for row in found if row["converged"]]
    inputs, figures = ([sum(pair) for pair in zip(*(row[kind] for row in converged))] for kind in ("inputs", "figures"))
    flagged = len(found) - len(converged)

    print(f"\n{flagged} of {len(tools)} not converged")
    if converged:
        share = figures[0] / figures[1]
        print(f"90 % intervals cover inputs {inputs[0] / inputs[1]:.3f}, figures {share:.3f}")
        for name in converged[0]["widths"]:
            middle = statistics.median(row["widths"][name] for row in converged)
            print(f"  {name}: width {middle:.2f} of that before (median)")
    if arguments.wrong:
        print(f"{arguments.wrong}, wrong by 1.3, named in {named} of {len(tools)} twins")
        if named < 0.9 * len(tools):
            sys.exit("the wrong reading is not named")
    elif not converged or not 0.8 <= share <= 0.98:
        sys.exit("coverage of figures")


if __name__ == "__main__":
    main()
