"""Holds the markers of virtual recordings to the events of the cycles behind them.

    markers.py NAILNOISE DESIGN COUNT [SEED]

COUNT shots that drive the nail and return the piston are drawn from the ranges by `nailnoise study`; quantities of the structures are
those of the design, so that modes and radiation are computed once. Each shot is recorded by `nailnoise test` without scatter and
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

# What shapes bodies or their modes.
STRUCTURE = (
    "nail.", "piston.stroke", "piston.bore", "piston.rod_", "tool.mass", "wood.density", "wood.elastic", "support.", "body.",
    "workpiece.", "exhaust.fitting", "method.",
)  # fmt: skip


def value(program, *arguments):
    done = subprocess.run([program, *arguments, "--json", "--quiet"], capture_output=True, text=True)
    # Status 3 is a failed check of a result that stands.
    assert done.returncode in (0, 3), done.stderr
    return json.loads(done.stdout)


def assigned(row):
    """Values of the keys in a row of the study; columns of keys have a dot in their names: `supply.pressure [Pa]`."""
    own = [(title.split(" ")[0], number) for title, number in row.items() if number]
    own = [(key, number) for key, number in own if "." in key and not key.startswith(STRUCTURE)]
    return [word for key, number in own for word in ("--set", f"{key}={number}")]


def drawn(program, design, count, seed):
    """Assignments and events of the first shots that drive the nail and return the piston."""
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "study", design, "-n", str(3 * count), "--seed", str(seed), "--out", folder, "--quiet"]
        # Status 3: a candidate could not be computed.
        assert subprocess.run(command, capture_output=True).returncode in (0, 3)
        (table,) = Path(folder).rglob("draws.csv")
        with open(table, newline="") as file:
            rows = list(csv.DictReader(file))
    found = 0
    for row in rows:
        changes = assigned(row)
        shot = value(program, "cycle", design, *changes)
        if shot["outcome"] == "drives" and shot["events"]["t16"] is not None:
            yield changes, shot["events"]
            found += 1
            if found == count:
                return


def markers(program, manifest, out):
    measured = value(program, "measure", str(manifest), "--out", str(out))
    total = next(own for own in measured["configurations"] if own["configuration"] == "total")
    return {own["name"]: own["seconds"] for own in total["markers"]}


def main(program, design, count, seed):
    still = ["--set", "test.pressure_scatter=0", "--set", "test.resistance_scatter=0", "--set", "test.repeats=1"]
    worst, missing, shots = dict.fromkeys(PAIRS, 0.0), dict.fromkeys(PAIRS, 0), 0
    for changes, events in drawn(program, design, count, seed):
        shots += 1
        with tempfile.TemporaryDirectory() as folder:
            value(program, "test", design, *changes, *still, "--out", folder)
            found = markers(program, Path(folder) / "manifest.toml", Path(folder) / "measured")
        for pair in PAIRS:
            at, event = found.get(pair[0]), events[pair[1]]
            if at is None:
                missing[pair] += 1
                print(f"{pair}: no marker: {' '.join(changes)}")
                continue
            worst[pair] = max(worst[pair], abs(at - event))
            if abs(at - event) > LIMIT:
                print(f"{pair}: {1e3 * at:.3f} and {1e3 * event:.3f} ms: {' '.join(changes)}")
    print(f"{shots} shots")
    for (marker, event), error in worst.items():
        print(f"  {marker} and {event}: at most {1e3 * error:.3f} ms apart, {missing[marker, event]} missing")
    sys.exit(shots < count or any(missing.values()) or any(error > LIMIT for error in worst.values()))


main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]) if len(sys.argv) > 4 else 1)
