"""Searches for the shortest time from the trigger's release to the exhaust, t12 to t13, over all ranges together.

    head_valve.py NAILNOISE PAGE            runs the cases of the table of docs/validation.md again, to the digit
    head_valve.py NAILNOISE PAGE --update   searches anew and writes the table, some hundred cycles

The search is a descent along one input after the other, to the ends of its declared range and half-way to them, from
the design itself and from a start with a small volume, a small lift and a strong spring. The resistance of the wood is
searched within each step, because a valve that opens later leaves the nail underdriven. The supply pressure is that of
the source's figure. No other outcome counts than a driven nail, except in the last row.
"""

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

DESIGN = Path("designs/n80cb-as-tested.toml")
RANGES = Path("designs/n80cb.toml")
BEGIN = "<!-- filling of the head valve: written by tests/peers/head_valve.py --update -->"
END = "<!-- end of the filling -->"
AREA = "trigger.fill_area"
WOOD = "wood.resistance_scale"
SCALES = (1.0, 0.8, 0.6)
# The declared upper end, and the bore of the channel: a trigger valve is not wider than the channel that it fills.
LIMITS = {"declared range": 10.0, "bore of the channel": 28.0}
SEARCHED = [
    "chambers.above_valve",
    "head_valve.lift",
    "head_valve.spring_scale",
    "head_valve.spring_preload",
    "head_valve.exhaust_lap",
    "head_valve.intake_lap",
    "head_valve.mass",
    "head_valve.seat_diameter",
    "head_valve.inner_diameter",
    "head_valve.outer_diameter",
    "head_valve.friction.static_force",
    "head_valve.friction.sliding_force",
    "trigger.vent_area",
    "trigger.channel_length",
    "trigger.channel_diameter",
    "chambers.wall_above_valve",
    "chambers.above_piston",
    "chambers.return_volume",
]
# Result of the published simulation [ms].
SOURCE = 1.9
SMALL = {"chambers.above_valve": 0, "head_valve.lift": 0, "head_valve.spring_scale": 1, "head_valve.spring_preload": 1}


def declared():
    """Value, ends and unit of each searched input, from the base design."""
    with open(RANGES, "rb") as file:
        design = tomllib.load(file)
    found = {}
    for key in SEARCHED:
        entry = design
        for name in key.split("."):
            entry = entry[name]
        number, _, unit = str(entry["value"]).partition(" ")
        low, high = re.match(r"([-\d.]+) \.\. ([-\d.]+)", entry["range"]).groups()
        found[key] = (float(number), (float(low), float(high)), unit)
    return found


class Cycles:
    """Cycles of the design with other inputs; each is computed once."""

    def __init__(self, program):
        self.program, self.known = str(Path(program).resolve()), {}

    def of(self, settings):
        """Outcome and t13 - t12 [ms]; the time is none if the exhaust does not open or the design is refused."""
        settings = tuple(settings)
        if settings not in self.known:
            command = [self.program, "cycle", str(DESIGN), "--json", "--quiet"]
            for setting in settings:
                command += ["--set", setting]
            done = subprocess.run(command, capture_output=True, text=True)
            outcome, time = "refused", None
            if done.returncode in (0, 1, 3) and done.stdout:
                result = json.loads(done.stdout)
                outcome, events = result["outcome"], result["events"]
                if events["t12"] is not None and events["t13"] is not None:
                    time = 1e3 * (events["t13"] - events["t12"])
            self.known[settings] = (outcome, time)
        return self.known[settings]


def written(area, values, inputs, scale):
    """The settings of a case; inputs at the value of the design are left out."""
    settings = [f"{AREA}={area:g} mm2"]
    for key in SEARCHED:
        own, _, unit = inputs[key]
        if values[key] != own:
            settings.append(f"{key}={values[key]:g} {unit}".strip())
    return settings + ([] if scale == 1.0 else [f"{WOOD}={scale:g}"])


def best_wood(cycles, area, values, inputs, driven):
    """Shortest time of a case, by the wood with which the nail is driven, and its settings."""
    for scale in SCALES if driven else SCALES[:1]:
        settings = written(area, values, inputs, scale)
        outcome, time = cycles.of(settings)
        if time is not None and (outcome == "drives" or not driven):
            return time, settings
    return None, None


def descent(cycles, area, inputs, start, driven):
    values = dict(start)
    time, settings = best_wood(cycles, area, values, inputs, driven)
    for half in (False, True):
        for key in SEARCHED:
            _, ends, _ = inputs[key]
            for end in ends:
                other = {**values, key: 0.5 * (values[key] + end) if half else end}
                if other == values:
                    continue
                found, of_found = best_wood(cycles, area, other, inputs, driven)
                if found is not None and (time is None or found < time - 1e-3):
                    time, settings, values = found, of_found, other
    return time, settings


def row(name, cycles, settings):
    outcome, time = cycles.of(settings)
    return [name, outcome, f"{time:.2f}", ", ".join(f"`{setting}`" for setting in settings)]


def smallest_area(cycles, area, settings):
    """The case with the smallest fill area, in steps of 0.5 mm2, that meets the source's time and drives the nail."""
    while area < LIMITS["bore of the channel"]:
        area += 0.5
        larger = [f"{AREA}={area:g} mm2", *settings[1:]]
        outcome, time = cycles.of(larger)
        if outcome == "drives" and time <= SOURCE:
            return larger
    return None


def search(cycles):
    inputs = declared()
    design = {key: value for key, (value, _, _) in inputs.items()}
    small = {**design, **{key: inputs[key][1][end] for key, end in SMALL.items()}}
    rows = []
    for driven, limits in ((True, LIMITS), (False, dict(list(LIMITS.items())[-1:]))):
        for name, area in limits.items():
            found = [descent(cycles, area, inputs, start, driven) for start in (design, small)]
            time, settings = min((own for own in found if own[0] is not None), key=lambda own: own[0])
            rows.append(row(f"{name}, {area:g} mm2", cycles, settings))
            if time > SOURCE:
                met = smallest_area(cycles, area, settings)
                rows += [row(f"smallest with {SOURCE} ms, {met[0].split('=')[1]}", cycles, met)] if met else []
    print(f"{len(cycles.known)} cycles")
    return rows


def main():
    cycles, page = Cycles(sys.argv[1]), Path(sys.argv[2])
    text = page.read_text()
    before, rest = text.split(BEGIN)
    old, after = rest.split(END)
    if "--update" in sys.argv:
        header = ["largest fill area", "outcome", "shortest t13 - t12 [ms]", "inputs that differ from the design"]
        lines = [header, ["---", "---", "--:", "---"], *search(cycles)]
        table = "".join("| " + " | ".join(line) + " |\n" for line in lines)
        page.write_text(before + BEGIN + "\n" + table + END + after)
        return
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in old.strip().splitlines()[2:]]
    wrong = 0
    for name, outcome, time, inputs in rows:
        found = cycles.of(re.findall(r"`([^`]+)`", inputs))
        if (outcome, time) != (found[0], f"{found[1]:.2f}" if found[1] is not None else ""):
            print(f"{page}: {name}: page {outcome}, {time} ms; program {found}")
            wrong += 1
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
