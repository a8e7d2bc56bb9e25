"""Compares the markers of virtual recordings with the events of their cycles.

    markers.py NAILNOISE DESIGN COUNT [SEED]

COUNT shots that drive the nail and return the piston are drawn from the ranges by `nailnoise study`; quantities of the structures are
those of the design, so that modes and radiation are computed once. Each shot is recorded by `nailnoise test` without scatter and
processed by `nailnoise measure`. The markers of the total that represent events are compared with those of `nailnoise
cycle`: t4 with t7, t11 with t15 (transducer PT-I), t12 with t16 (handle). The limit is 0.1 ms. The burst t12 at the
microphones, with only the body bare, is compared with t16. The limit is 1.5 ms.
"""

import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path

# Configuration, marker, event, and largest error [s].
MARKERS = [
    ("total", "t4", "t7", 0.1e-3),
    ("total", "t11", "t15", 0.1e-3),
    ("total", "t12", "t16", 0.1e-3),
    ("body", "t12 at the microphones", "t16", 1.5e-3),
]

# Keys that shape bodies or their modes.
STRUCTURE = (
    "nail.", "piston.stroke", "piston.bore", "piston.rod_", "tool.mass", "wood.density", "wood.elastic", "support.", "body.",
    "workpiece.", "exhaust.fitting", "method.",
)  # fmt: skip


def value(program, *arguments):
    done = subprocess.run([program, *arguments, "--json", "--quiet"], capture_output=True, text=True)
    # Status 3 is a failed check of a valid result.
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
    """Instants of the markers by configuration and name."""
    measured = value(program, "measure", str(manifest), "--out", str(out))
    each = ((own["configuration"], marker) for own in measured["configurations"] for marker in own["markers"])
    return {(configuration, marker["name"]): marker["seconds"] for configuration, marker in each}


def main(program, design, count, seed):
    still = ["--set", "test.pressure_scatter=0", "--set", "test.resistance_scatter=0", "--set", "test.repeats=1"]
    worst, missing, shots = dict.fromkeys(MARKERS, 0.0), dict.fromkeys(MARKERS, 0), 0
    for changes, events in drawn(program, design, count, seed):
        shots += 1
        with tempfile.TemporaryDirectory() as folder:
            value(program, "test", design, *changes, *still, "--out", folder)
            found = markers(program, Path(folder) / "manifest.toml", Path(folder) / "measured")
        for marker in MARKERS:
            configuration, name, event, limit = marker
            at, event = found.get((configuration, name)), events[event]
            if at is None:
                missing[marker] += 1
                print(f"{name}: missing: {' '.join(changes)}")
                continue
            worst[marker] = max(worst[marker], abs(at - event))
            if abs(at - event) > limit:
                print(f"{name}: {1e3 * at:.3f} ms, event at {1e3 * event:.3f} ms: {' '.join(changes)}")
    print(f"{shots} shots")
    for marker, error in worst.items():
        print(f"  {marker[1]} and {marker[2]}: at most {1e3 * error:.3f} ms apart, {missing[marker]} missing")
    sys.exit(shots < count or any(missing.values()) or any(error > limit for (*_, limit), error in worst.items()))


main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]) if len(sys.argv) > 4 else 1)
