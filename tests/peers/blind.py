"""Writes the predictions of docs/validation.md that are stated before any comparison, or compares them with the program.

    blind.py NAILNOISE PAGE            the predictions of the designs as they are, to the digit (four runs)
    blind.py NAILNOISE PAGE --update   writes the tables; the intervals of the levels are those of the shipped studies
    ... --draws FILE                   with --update: draws.csv of `nailnoise study designs/n80cb-as-filmed.toml`, for
                                       the intervals between events and those of the accelerations, from the first 32
                                       draws, each a run; without it their cells stay empty

The source measured accelerations and events on grooved blocks and levels on plain ones; so do the designs here. No
table contains a measurement, and nothing outside the repository is read.
"""

import bisect
import csv
import json
import math
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

BEGIN = "<!-- stated before comparison: written by tests/peers/blind.py --update -->"
END = "<!-- end of the statements -->"
# Plain blocks of the wrapping tests.
DESIGNS = {"worktable": "designs/n80cb-as-tested.toml", "sandbox": "designs/n80cb-as-tested-sandbox.toml"}
# Grooved blocks of the synchronised tests; a setting puts them in the sandbox.
FILMED = "designs/n80cb-as-filmed.toml"
SETUPS = {"worktable": (), "sandbox": ("support.kind=sandbox",)}
GRAVITY = 9.80665
SENSORS = [("worktable", "TC"), ("worktable", "TE"), ("worktable", "W"), ("sandbox", "W")]
INTERVALS = [
    ("t0", "t2"), ("t2", "t6"), ("t0", "t6"), ("t6", "t9"), ("t9", "t12"), ("t12", "t13"), ("t13", "t14"), ("t9", "t14"),
    ("t14", "t15"), ("t15", "t16")
]
# Events of chapter 4 of the source, and their names in its chapter 1.
CHAPTER_1 = {"t0": "t0", "t4": "t1", "t6": "t2", "t7": "t4", "t8": "t5", "t9": "t6", "t14": "t9", "t15": "t11", "t16": "t12"}
LEADING = 10.0
# Number of drawn runs for the intervals of accelerations.
RUNS = 32
THIRDS = [50, 63, 80, 100, 125, 160, 200, 250, 315, 400, 500, 630, 800, 1000, 1250, 1600, 2000, 2500, 3150, 4000, 5000, 6300, 8000, 10000]


def run(program, design, settings=()):
    """The result of a run, and the spectra of its sensors."""
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "run", design, "--json", "--quiet", "--out", folder]
        for setting in settings:
            command += ["--set", setting]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode not in (0, 1, 3):
            raise SystemExit(done.stderr)
        with open(Path(folder) / "sensors-spectrum.csv", newline="") as file:
            return json.loads(done.stdout), list(csv.DictReader(file))


def third_octaves(spectrum, sensor):
    """RMS acceleration over 1 s in third octaves [m/s2], from the energy density at lines of equal spacing."""
    column = next(name for name in spectrum[0] if name.startswith(f"{sensor} ("))
    lines = [(float(row["frequency [Hz]"]), float(row[column])) for row in spectrum]
    step = lines[1][0] - lines[0][0]
    middles = [1000.0 * 10 ** (0.1 * round(10 * math.log10(hz / 1000.0))) for hz in THIRDS]
    edges = [middle * 10**-0.05 for middle in middles] + [middles[-1] * 10**0.05]
    sums = [0.0] * len(THIRDS)
    for hz, density in lines:
        place = bisect.bisect_right(edges, hz) - 1
        if 0 <= place < len(sums):
            sums[place] += density * step
    return [total**0.5 for total in sums]


def markdown(header, rows):
    alignment = ["---"] + ["--:" if name.endswith("]") else "---" for name in header[1:]]
    return "".join("| " + " | ".join(line) + " |\n" for line in [header, alignment, *rows])


def sensors(program, results, draws):
    def rms(setup, draw):
        result, _ = run(program, FILMED, [*SETUPS[setup], *draw])
        return {own["name"]: own["rms_g"] for own in result["sensors"]}

    shots = {setup: [rms(setup, draw) for draw in draws[:RUNS]] for setup in SETUPS}
    rows = []
    for setup, name in SENSORS:
        result, spectrum = results[setup]
        own = next((sensor for sensor in result["sensors"] if sensor["name"] == name), None)
        if own is None:
            continue
        bands = third_octaves(spectrum, name)
        loudest = sorted(range(len(bands)), key=lambda place: -bands[place])[:3]
        largest = ", ".join(f"{THIRDS[place]} Hz {bands[place] / GRAVITY:.2f}" for place in loudest)
        found = [shot[name] for shot in shots[setup] if name in shot]
        interval = f"{quantile(found, 0.05):.1f} .. {quantile(found, 0.95):.1f}" if found else ""
        rows.append([f"{name}, {setup}", f"{own['rms_g']:.2f}", interval, f"{own['peak_g']:.0f}", largest])
    header = ["sensor", "RMS over 1 s [g]", "5 .. 95 % [g]", "peak [g]", "largest third octaves, RMS in g"]
    return markdown(header, rows)


def levels(results):
    rows = []
    for setup, (result, _) in results.items():
        studied = {own["source"]: own for own in (result["study"] or {}).get("sources", [])}
        stated = (result["study"] or {}).get("ends") != "extremes"
        for source in result["ranking"]:
            own = studied.get(source["source"]) if stated else None
            interval = f"{own['low_db']:.1f} .. {own['high_db']:.1f}" if own else ""
            first = f"{own['first']:.2f}" if own else ""
            rows.append([f"{source['source']}, {setup}", f"{source['lwa_db']:.1f}", interval, first])
    return markdown(["source", "L_WA,1s [dB(A)]", "5 .. 95 % [dB(A)]", "P(first) [-]"], rows)


def joined(bands):
    """Bands as ranges of neighbours."""
    places, text = [THIRDS.index(band) for band in bands], []
    while places:
        last = 0
        while last + 1 < len(places) and places[last + 1] == places[last] + 1:
            last += 1
        first, end = THIRDS[places[0]], THIRDS[places[last]]
        text.append(f"{first}" if first == end else f"{first} to {end}")
        places = places[last + 1 :]
    return ", ".join(text) or "none"


def leading(results):
    rows = []
    for setup, (result, _) in results.items():
        table = {own["source"]: {round(band["hz"]): band["lwa_db"] for band in own["bands"]} for own in result["ranking"]}
        ahead = {source: [] for source in table}
        for band in THIRDS:
            known = {source: bands.get(band) for source, bands in table.items()}
            known = {source: level for source, level in known.items() if level is not None}
            if known:
                ahead[max(known, key=known.get)].append(band)
        for source, bands in ahead.items():
            rows.append([f"{source}, {setup}", joined(bands)])
    return markdown(["source", "leads in the third octaves, Hz"], rows)


def maxima(results):
    rows = []
    for setup, (result, _) in results.items():
        for source in result["ranking"]:
            known = [(round(b["hz"]), b["lwa_db"]) for b in source["bands"] if b["lwa_db"] is not None]
            top = max(level for _, level in known)
            peaks = []
            for place, (hz, level) in enumerate(known):
                near = [known[k][1] for k in (place - 1, place + 1) if 0 <= k < len(known)]
                if level >= top - LEADING and all(level >= other for other in near):
                    peaks.append(f"{hz} Hz {level:.1f}")
            rows.append([f"{source['source']}, {setup}", ", ".join(peaks)])
    return markdown(["source", f"maxima within {LEADING:.0f} dB of the largest, dB(A)"], rows)


def cycle(program, settings=()):
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "cycle", FILMED, "--json", "--quiet", "--out", folder]
        for setting in settings:
            command += ["--set", setting]
        done = subprocess.run(command, capture_output=True, text=True)
        return json.loads(done.stdout)["events"] if done.returncode in (0, 1, 3) else None


def drawn(path):
    """Settings of the shots of draws.csv."""
    with open(path, newline="") as file:
        draws = list(csv.DictReader(file))
    keys = [name for name in draws[0] if "." in name.split(" [")[0] and not name.startswith("method.")]

    def one(draw):
        settings = []
        for name in keys:
            key, unit = name[:-1].split(" [")
            if key == "exhaust.area":
                # It follows from number and diameter of the holes.
                diameter = math.sqrt(4.0 * float(draw[name]) / (math.pi * float(draw["exhaust.holes [-]"])))
                settings.append(f"exhaust.hole_diameter={diameter} m")
            elif draw[name]:
                value = draw[name] if unit == "-" else f"{draw[name]} {unit}"
                settings.append(f"{key}={value}")
        return settings

    return [one(draw) for draw in draws]


def quantile(values, share):
    values = sorted(values)
    place = share * (len(values) - 1)
    low = int(place)
    return values[low] + (place - low) * (values[min(low + 1, len(values) - 1)] - values[low])


def events(program, draws):
    own = cycle(program)
    with ThreadPoolExecutor(2) as pool:
        # The cycle refuses draws whose dimensions conflict.
        shots = [events for events in pool.map(lambda draw: cycle(program, draw), draws) if events]
    rows = []
    for start, end in INTERVALS:
        if own[start] is None or own[end] is None:
            continue
        found = [1e3 * (shot[end] - shot[start]) for shot in shots if shot.get(start) is not None and shot.get(end) is not None]
        interval = f"{quantile(found, 0.05):.2f} .. {quantile(found, 0.95):.2f}" if found else ""
        both = start in CHAPTER_1 and end in CHAPTER_1
        other = f"{CHAPTER_1[end]} - {CHAPTER_1[start]}" if both else "none"
        rows.append([f"{end} - {start}", f"{1e3 * (own[end] - own[start]):.2f}", interval, other])
    return markdown(["interval, events of ch. 4", "design [ms]", "5 .. 95 % [ms]", "in ch. 1"], rows)


def statements(program, path):
    draws = drawn(path) if path else []
    results = {setup: run(program, design) for setup, design in DESIGNS.items()}
    filmed = {setup: run(program, FILMED, settings) for setup, settings in SETUPS.items()}
    parts = [("Accelerometers (grooved block)", sensors(program, filmed, draws)), ("Levels (plain block)", levels(results))]
    parts += [("Leading source in each third octave (plain block)", leading(results))]
    parts += [("Maxima of the spectra (plain block)", maxima(results))]
    parts += [("Intervals between events (grooved block)", events(program, draws))]
    return "".join(f"\n### {name}\n\n{table}" for name, table in parts)


def nominal(text):
    """Rows without their cells of intervals, which need draws."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("|")]
    return [[cell for cell in row if " .. " not in cell and cell] for row in rows if not row[0].startswith("---")]


def main():
    program, page = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2])
    draws = sys.argv[sys.argv.index("--draws") + 1] if "--draws" in sys.argv else None
    before, rest = page.read_text().split(BEGIN)
    old, after = rest.split(END)
    found = statements(program, draws)
    if "--update" in sys.argv:
        page.write_text(before + BEGIN + "\n" + found + END + after)
        return
    # Shares of draws come from the studies, which may be absent.
    first = lambda rows: [row[:2] for row in rows]
    if first(nominal(old)) != first(nominal(found)):
        raise SystemExit(f"{page}: the statements differ from the program\n{found}")


main()
