"""Holds the markers of virtual recordings to the events of the cycles behind them.

    markers.py NAILNOISE DESIGN COUNT [SEED]

COUNT shots that drive the nail are drawn from the ranges of the cycle. Each is recorded by `nailnoise test` without scatter and
processed by `nailnoise measure`. The markers of the total that stand for events are compared with those of `nailnoise cycle`:
t4 with t7, t11 with t15 (transducer PT-I), t12 with t16 (handle). The limit is 0.1 ms.
"""

import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path

PAIRS = [("t4", "t7"), ("t11", "t15"), ("t12", "t16")]
LIMIT = 0.1e-3


def value(program, *arguments):
    done = subprocess.run([program, *arguments, "--json", "--quiet"], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def drawn(program, design, count, seed):
    """Assignments of the first shots that drive the nail."""
    with tempfile.TemporaryDirectory() as folder:
        shots = value(program, "cycle", design, "--draw", str(4 * count), "--seed", str(seed), "--out", folder)
        with open(shots["file"], newline="") as file:
            rows = list(csv.DictReader(file))
    found = []
    for row in rows:
        if row["fate"] == "drives":
            # Columns of keys have a dot in their names: `supply.pressure [Pa]`.
            pairs = [(name.split(" ")[0], number) for name, number in row.items() if "." in name.split(" ")[0] and number]
            found.append([word for key, number in pairs for word in ("--set", f"{key}={number}")])
    return found[:count]


def main(program, design, count, seed):
    still = ["--set", "test.pressure_scatter=0", "--set", "test.resistance_scatter=0", "--set", "test.repeats=1"]
    worst, missing = {pair: 0.0 for pair in PAIRS}, {pair: 0 for pair in PAIRS}
    shots = drawn(program, design, count, seed)
    for changes in shots:
        with tempfile.TemporaryDirectory() as folder:
            events = value(program, "cycle", design, *changes)["events"]
            value(program, "test", design, *changes, *still, "--out", folder)
            manifest = str(Path(folder) / "manifest.toml")
            measured = value(program, "measure", manifest, "--out", str(Path(folder) / "measured"))
        total = next(own for own in measured["configurations"] if own["configuration"] == "total")
        markers = {own["name"]: own["seconds"] for own in total["markers"]}
        for marker, event in PAIRS:
            if events[event] is None:
                continue
            if marker not in markers:
                missing[marker, event] += 1
                continue
            error = abs(markers[marker] - events[event])
            worst[marker, event] = max(worst[marker, event], error)
            if error > LIMIT:
                print(f"{marker} at {1e3 * markers[marker]:.3f} ms, {event} at {1e3 * events[event]:.3f} ms: {' '.join(changes)}")
    print(f"{len(shots)} shots; worst:", {f"{a}/{b}": f"{1e3 * error:.3f} ms" for (a, b), error in worst.items()}, "missing:", missing)
    sys.exit(any(error > LIMIT for error in worst.values()) or any(missing.values()))


main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]) if len(sys.argv) > 4 else 1)
