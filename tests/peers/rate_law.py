"""Compares the laws of the resistance over the ranges of a design: outcomes, and speeds of the nails that are driven.

    rate_law.py NAILNOISE PAGE [DRAWS]     prints the table of docs/validation.md anew
    rate_law.py NAILNOISE PAGE --update    writes it

All laws have the same draws (a Latin hypercube with a fixed seed) of the inputs in DRAWN, from their ranges in
designs/n80cb.toml. The rod's protrusion is that of the tested tools. A shot counts if it drives the nail; the source
excludes contact of piston and bumper until the nail stops.
"""

import json
import random
import re
import statistics
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

RANGES = Path("designs/n80cb.toml")
BEGIN = "<!-- laws over the ranges: written by tests/peers/rate_law.py --update -->"
END = "<!-- end of the laws -->"
SPECIMENS = {"plain": "designs/n80cb-as-tested.toml", "grooved": "designs/n80cb-as-filmed.toml"}
LAWS = {
    "quasi-static": [],
    "quasi-static, head yields": ["wood.head_law=yields"],
    "falls with speed": ["wood.rate=speed"],
    "falls with speed, head yields": ["wood.rate=speed", "wood.head_law=yields"],
}
# Inputs that determine the energy of the piston and the resistance of the wood. The pressure is that of the source.
DRAWN = [
    "piston.bore", "piston.mass", "head_valve.lift", "chambers.above_piston", "chambers.below_piston",
    "chambers.return_volume", "chambers.return_hole_area", "chambers.supply_volume", "supply.hose_area", "wood.density",
    "wood.hardness_modulus", "wood.resistance_scale", "wood.friction_share", "wood.crushing_rate",
    "wood.friction_at_rest", "wood.friction_sliding", "wood.friction_speed", "wood.head_yield_scale",
    "wood.head_stiffness_scale",
]
PROTRUSION = ("piston.rod_protrusion", 16.0, 18.7, "mm")


def ranges():
    with open(RANGES, "rb") as file:
        design = tomllib.load(file)
    found = []
    for key in DRAWN:
        entry = design
        for name in key.split("."):
            entry = entry[name]
        low, high, unit = re.match(r"([-\d.e]+) \.\. ([-\d.e]+)\s*(.*)", entry["range"]).groups()
        found.append((key, float(low), float(high), unit))
    return [*found, PROTRUSION]


def hypercube(count):
    chance = random.Random(1)
    columns = []
    for key, low, high, unit in ranges():
        places = list(range(count))
        chance.shuffle(places)
        column = [low + (high - low) * (place + chance.random()) / count for place in places]
        columns.append([f"{key}={value:.6g} {unit}".strip() for value in column])
    return list(zip(*columns))


def shot(program, design, settings):
    command = [program, "cycle", design, "--json", "--quiet"]
    for setting in settings:
        command += ["--set", setting]
    done = subprocess.run(command, capture_output=True, text=True)
    return json.loads(done.stdout) if done.returncode in (0, 1, 3) and done.stdout else None


def row(program, specimen, law, draws):
    with ThreadPoolExecutor(2) as pool:
        shots = list(pool.map(lambda draw: shot(program, SPECIMENS[specimen], [*draw, *LAWS[law]]), draws))
    shots = [own for own in shots if own]
    drives = [own for own in shots if own["outcome"] == "drives"]
    events = [own["events"] for own in drives]
    free = [own for own, at in zip(drives, events) if at["t10"] is None or at["t10"] > at["t9"]]
    speeds = [own["summary"]["mean_drive_speed"] for own in free]
    outcomes = [own["outcome"] for own in shots]
    others = ", ".join(f"{name} {outcomes.count(name)}" for name in sorted(set(outcomes) - {"drives"}))
    # Quantiles in steps of 5 %; they need at least two speeds.
    steps = statistics.quantiles(speeds, n=20, method="inclusive") if len(speeds) > 1 else [float("nan")] * 19
    spread = [f"{speed:.1f}" for speed in (steps[0], steps[9], steps[18], max(speeds, default=float("nan")))]
    return [specimen, law, f"{len(drives)} of {len(shots)}", others, str(len(free)), *spread]


def main():
    program, page = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2])
    count = next((int(word) for word in sys.argv[3:] if word.isdigit()), 512)
    draws = hypercube(count)
    header = [
        "block", "law", "drive the nail", "others", "no bumper before t9", "mean speed of these, 5 % [m/s]",
        "median [m/s]", "95 % [m/s]", "largest [m/s]"
    ]
    lines = [header, ["---", "---", "--:", "---", *["--:"] * 5]]
    lines += [row(program, specimen, law, draws) for specimen in SPECIMENS for law in LAWS]
    table = "".join("| " + " | ".join(line) + " |\n" for line in lines)
    if "--update" not in sys.argv:
        print(table)
        return
    before, rest = page.read_text().split(BEGIN)
    page.write_text(before + BEGIN + "\n" + table + END + rest.split(END)[1])


if __name__ == "__main__":
    main()
