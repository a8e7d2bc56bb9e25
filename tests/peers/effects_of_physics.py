"""Writes the tables of docs/validation.md of what each option of the shot's physics changes, switched on alone.

    effects_of_physics.py NAILNOISE PAGE           compares the table of the cycle with the program, to the digit, and
                                                   that of the levels with the file next to the page
    effects_of_physics.py NAILNOISE PAGE --update  writes both tables
    effects_of_physics.py NAILNOISE PAGE --missing makes the runs of the options that the file does not have yet
    effects_of_physics.py NAILNOISE PAGE --runs    makes all runs, minutes each; writes that file and both tables

A row of the cycle has the outcome, the events, the speed of the rod at the nail, the mean speed of the nail, the
kinetic energy left at full depth, the depth of the head, the peak force on the wood and that on the bumper. An event
that does not happen has an empty cell. The file `effects-of-options.csv` has sensors, levels and third octaves of all
sources.
"""

import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path

DESIGN = "designs/n80cb-as-tested.toml"
BEGIN = "<!-- effects of the options: written by tests/peers/effects_of_physics.py --update -->"
END = "<!-- end of the effects -->"
LEVELS_BEGIN = "<!-- levels of the options: written by tests/peers/effects_of_physics.py --update -->"
LEVELS_END = "<!-- end of the levels -->"
MUFFLER = "exhaust.muffler.kind=insertion_loss"
OCTAVES = "exhaust.muffler.octaves=[0, 0, 0, 0, 5, 10, 15, 15, 15]"
PROTRUSION = "piston.rod_protrusion=12.2mm"
AZ91 = {"young_modulus": "45 GPa", "poisson_ratio": "0.35", "density": "1810 kg/m3"}
AS_HOUSING = {part: [f"body.{part}.{key}={value}" for key, value in AZ91.items()] for part in ("cap", "sleeve")}
SPEED, HEAD = "wood.rate=speed", "wood.head_law=yields"
OPTIONS = [
    ("as tested, all options off", []),
    ("groove of 6.35 mm", ["workpiece.groove=6.35mm"]),
    ("rod's protrusion 12.2 mm, not 16 mm", [PROTRUSION]),
    ("groove and protrusion of 12.2 mm", ["workpiece.groove=6.35mm", PROTRUSION]),
    ("resistance depends on speed", [SPEED]),
    ("head yields", [HEAD]),
    ("both", [SPEED, HEAD]),
    ("coated nail, friction x 0.6", ["nail.coating=0.6"]),
    ("blow as waves", ["model.blow=elastic"]),
    ("growth rings, tip resistance +-20 %", ["wood.ring_amplitude=0.2"]),
    ("discharge of the exhaust 0.7", ["exhaust.discharge_coefficient=0.7"]),
    ("discharge of the holes at the foot 0.62", ["chambers.return_hole_coefficient=0.62"]),
    ("discharge of the check holes 0.62", ["chambers.check_hole_coefficient=0.62"]),
    ("discharge of leak and hose 0.62", ["chambers.leak_coefficient=0.62", "supply.hose_coefficient=0.62"]),
    ("trigger fills through 28 mm2", ["trigger.fill_area=28mm2"]),
    ("no fitting on the exhaust", ["exhaust.fitting.kind=none"]),
    ("fitting filled with ambient air", ["exhaust.fitting.gas=ambient"]),
    ("wall of the fitting 3.2 mm, not 5.5 mm", ["exhaust.fitting.wall_thickness=3.2mm"]),
    ("cap and wall of the fitting counted to the body", ["sources.convention=physical"]),
    ("trigger vent counted to the exhaust", ["sources.trigger_vent=exhaust"]),
    ("muffler of 5 to 15 dB above 500 Hz in its place", ["exhaust.fitting.kind=none", MUFFLER, OCTAVES]),
    ("foam on housing and cap", ["body.cover.surfaces=both"]),
    ("foam that does not move with the wall", ["body.cover.surfaces=both", "body.cover.frame=resting"]),
    ("loss factor of the table 0.06, not 0.03", ["support.worktable.loss_factor=0.06"]),
    ("loss factor of the table 0.01", ["support.worktable.loss_factor=0.01"]),
    ("cap of magnesium, not steel", AS_HOUSING["cap"]),
    ("cylinder of magnesium, not aluminium", AS_HOUSING["sleeve"]),
]
EVENTS = range(5, 15)
COLUMNS = ["option", "outcome", *(f"t{n} [ms]" for n in EVENTS), "rod at nail [m/s]", "mean of nail [m/s]"]
COLUMNS += ["left at full depth [J]", "head below [mm]", "peak force [N]", "bumper [N]"]


def compute(command, program, settings, folder):
    arguments = [program, command, DESIGN, "--json", "--quiet", "--out", folder]
    for setting in settings:
        arguments += ["--set", setting]
    done = subprocess.run(arguments, capture_output=True, text=True)
    if done.returncode not in (0, 1, 3):
        raise SystemExit(done.stderr)
    return json.loads(done.stdout)


def cycle(program, settings):
    with tempfile.TemporaryDirectory() as folder:
        result = compute("cycle", program, settings, folder)
        with open(Path(folder) / "histories.csv", newline="") as file:
            return result, list(csv.DictReader(file))


def left_at_full_depth(result, histories):
    """M v^2/2 of piston and nail when the head meets the wood; none if it does not."""
    at = result["summary"]["full_penetration"]
    if at is None:
        return None
    row = min(histories, key=lambda row: abs(float(row["time [s]"]) - at))
    return 0.5 * float(row["moving_mass [kg]"]) * float(row["piston_velocity [m/s]"]) ** 2


def cells(name, result, histories):
    events, shot = result["events"], result["summary"]

    def text(value, factor=1.0, digits=2):
        return "" if value is None else f"{factor * value:.{digits}f}"

    row = [name, result["outcome"].replace("_", " "), *(text(events[f"t{n}"], 1e3) for n in EVENTS)]
    row += [text(shot["speed_before_impact"]), text(shot["mean_drive_speed"])]
    row += [text(left_at_full_depth(result, histories)), text(shot["head_depth"], 1e3)]
    return row + [text(shot[f"peak_{name}_force"], digits=0) for name in ("penetration", "bumper")]


def table(program):
    lines = [COLUMNS, ["---"] * 2 + ["--:"] * (len(COLUMNS) - 2)]
    for name, settings in OPTIONS:
        lines.append(cells(name, *cycle(program, settings)))
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def run_options(program, path, options):
    """Adds the sensors, the levels and the third octaves of a run with each option."""
    with open(path, "a", newline="") as file:
        writer = csv.writer(file)
        for name, settings in options:
            with tempfile.TemporaryDirectory() as folder:
                result = compute("run", program, settings, folder)
            for sensor in result["sensors"]:
                writer.writerow([name, f"{sensor['name']} RMS [g]", "", f"{sensor['rms_g']:.3f}"])
            for source in result["ranking"]:
                writer.writerow([name, f"{source['source']} L_WA [dB(A)]", "", f"{source['lwa_db']:.2f}"])
                for band in source["bands"]:
                    if band["lw_db"] is not None:
                        writer.writerow([name, f"{source['source']} L_W [dB]", f"{band['hz']:g}", f"{band['lw_db']:.2f}"])
            file.flush()


def level_table(path):
    """Sensors and levels of each option, and the largest change of a third octave of each source."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    values = {(row["option"], row["quantity"], row["band [Hz]"]): float(row["value"]) for row in rows}
    first = OPTIONS[0][0]
    sensors = ["W RMS [g]", "table_centre RMS [g]"]
    sources = [row["quantity"] for row in rows if row["option"] == first and row["quantity"].endswith("L_WA [dB(A)]")]
    names = [name.split()[0] for name in sources]
    header = ["option", "W [g]", "table's centre [g]", *(f"{name} [dB(A)]" for name in names)]
    header += [f"{name}: largest change of a third octave" for name in names]
    lines = [header, ["---"] + ["--:"] * (len(header) - 1)]
    for option, _ in OPTIONS:
        line = [option, *(f"{values[option, name, '']:.1f}" for name in sensors)]
        line += [f"{values[option, name, '']:.1f}" for name in sources]
        for name in names:
            quantity = f"{name} L_W [dB]"
            bands = [band for own, what, band in values if own == option and what == quantity]
            changes = [(values[option, quantity, b] - values[first, quantity, b], b) for b in bands]
            change, band = max(changes, key=lambda own: abs(own[0]))
            line.append("" if option == first else f"{change:+.1f} dB at {band} Hz" if abs(change) >= 0.05 else "none")
        lines.append(line)
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def replaced(text, begin, end, table):
    """The page with a table in place of that between two comments, and the table that it had."""
    start, stop = text.index(begin) + len(begin) + 1, text.index(end)
    return text[:start] + table + text[stop:], text[start:stop]


def main():
    program, page = sys.argv[1], Path(sys.argv[2])
    path = page.parent / "effects-of-options.csv"
    if "--runs" in sys.argv:
        path.write_bytes(b"option,quantity,band [Hz],value\r\n")
    if "--runs" in sys.argv or "--missing" in sys.argv:
        with open(path, newline="") as file:
            known = {row["option"] for row in csv.DictReader(file)}
        run_options(program, path, [own for own in OPTIONS if own[0] not in known])
    text = page.read_text()
    tables = [(BEGIN, END, table(program)), (LEVELS_BEGIN, LEVELS_END, level_table(path))]
    update = any(mode in sys.argv for mode in ("--update", "--runs", "--missing"))
    for begin, end, found in tables:
        text, before = replaced(text, begin, end, found)
        if not update and before != found:
            raise SystemExit(f"{page}: the table differs from the program\n{found}")
    if update:
        page.write_text(text)


if __name__ == "__main__":
    main()
