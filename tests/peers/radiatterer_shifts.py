#!/usr/bin/env python3
"""The Radiatterer near the frequencies of its reference: how far the two are apart in frequency.

    cargo build --release -p nailnoise-acoustics --example radiatterer
    python3 tests/peers/radiatterer_shifts.py target/release/examples/radiatterer FILE 109 115 125 140 180 240

The cavities have sharp resonances, the sharpest less than 0.5 Hz wide. Next to one of them a small difference in its
frequency changes a level by decibels. The script computes the power and the levels at the three points within 2 Hz of
each given frequency, in steps of 0.25 Hz, and finds the shift of the frequency at which the largest of the four
differences from the reference is smallest. FILE receives the computed curves; rows that it has are not computed again.
"""

import csv
import math
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).parents[2]
EXAMPLE = ROOT / "acoustics" / "examples" / "radiatterer.rs"
WIDTH, STEP, FINE = 2.0, 0.25, 0.01


def reference():
    """Power in dB re 1 W and three levels in dB, by frequency."""
    body = re.search(r"const REFERENCE: [^=]*= \[(.*?)\n\];", EXAMPLE.read_text(), re.DOTALL)[1]
    numbers = [float(n) for n in re.findall(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", body)]
    rows = (numbers[i : i + 5] for i in range(0, len(numbers), 5))
    return {hz: [10.0 * math.log10(watts), *levels] for hz, watts, *levels in rows}


def computed(path):
    """The same of the rows in a file that the example wrote."""
    with open(path, newline="") as file:
        rows = [row for row in csv.reader(file) if row and row[0] != "Hz"]
    return {float(row[0]): [10.0 * math.log10(float(row[1])), *map(float, row[2:5])] for row in rows}


def at(curve, hz):
    """The levels at a frequency, linear between the frequencies of the curve."""
    below = max(own for own in curve if own <= hz)
    above = min(own for own in curve if own >= hz)
    part = 0.0 if above == below else (hz - below) / (above - below)
    return [(1.0 - part) * a + part * b for a, b in zip(curve[below], curve[above])]


def main():
    program, path = sys.argv[1], pathlib.Path(sys.argv[2])
    wanted, expected = [float(hz) for hz in sys.argv[3:]], reference()
    count = round(WIDTH / STEP)
    around = sorted({hz + i * STEP for hz in wanted for i in range(-count, count + 1)})
    known = computed(path) if path.exists() else {}
    missing = [f"{hz:g}" for hz in around if hz not in known]
    if missing:
        with open(path, "a") as file:
            subprocess.run([program, *missing], stdout=file, check=True)
    curve = computed(path)
    print("Hz,largest difference [dB],shift [Hz],largest difference after it [dB]")
    for hz in wanted:
        def worst(shift):
            return max(abs(a - b) for a, b in zip(at(curve, hz + shift), expected[hz]))

        steps = round(WIDTH / FINE)
        shift = min((FINE * i for i in range(-steps, steps + 1)), key=lambda own: (worst(own), abs(own)))
        print(f"{hz:g},{worst(0.0):.2f},{shift:+.2f},{worst(shift):.2f}")


if __name__ == "__main__":
    main()
