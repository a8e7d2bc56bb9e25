"""Measures levels of a virtual tool whose truth is known, calibrates the design with them, and compares.

    calibration_levels.py NAILNOISE DESIGN WORK [DRAWS] [LEVELS]

The virtual tool is DESIGN (designs/n80cb.toml) with the values of TRUTH. `nailnoise run` computes its shot; an
accelerometer on the block, one microphone and the depth of the nail heads are read with errors. WORK is a folder for
the files. The script prints the readings, the levels before and after, and the true ones. It fails if the true total
is outside its interval, or if the interval is wider than half of that of the ranges.
"""

import json
import random
import subprocess
import sys
from pathlib import Path

# Values within the ranges of the design that differ from the design's values. None of them is a dimension of a body, so
# the virtual tool has the modes of the design.
TRUTH = {
    "head_valve.lift": "4.2 mm",
    "wood.resistance_scale": "0.95",
    "chambers.return_volume": "330 cm3",
    "chambers.discharge_coefficient": "0.75",
}
SENSOR, MICROPHONE = "block_top", 3
SHOTS = 5


def run(program, design, work):
    """Result of the virtual tool."""
    values = [f"--set={key}={value}" for key, value in TRUTH.items()]
    command = [program, "run", design, "--json", "--out", work / "truth", *values]
    done = subprocess.run([str(own) for own in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr)
    return json.loads(done.stdout)


def measurements(truth):
    """The file of measurements: depth of the heads, an acceleration, and a level."""
    errors = random.Random(52)
    [sensor] = [own for own in truth["sensors"] if own["name"] == SENSOR]
    level = truth["microphones"]["total"]["levels"][MICROPHONE - 1]["lae_db"] + errors.gauss(0.0, 0.7)
    rms = sensor["rms_g"] * (1.0 + errors.gauss(0.0, 0.05))
    depth = 1e3 * truth["performance"]["head_depth_m"] + errors.gauss(0.0, 0.7)
    return f"""schema = "nailnoise-calibration/1"
[condition]
own = {{ outcome = "drives" }}
[measured.depth]
condition = "own"
quantity = "head_depth"
value = "{depth:.1f} mm"
shots = {SHOTS}
scatter = "1.5 mm"
error = "0.2 mm"
[measured.block]
condition = "own"
quantity = "rms_acceleration"
sensor = "{SENSOR}"
value = "{rms:.2f} g"
shots = {SHOTS}
error = "5 %"
[measured.mic]
condition = "own"
quantity = "level"
of = "microphone-{MICROPHONE}"
value = "{level:.1f} dB"
shots = {SHOTS}
error = "0.7 dB"
"""


def main():
    program, design, work = sys.argv[1:4]
    draws, levels = (sys.argv[4:] + ["512", "128"][len(sys.argv[4:]) :])[:2]
    work = Path(work)
    work.mkdir(parents=True, exist_ok=True)
    truth = run(program, design, work)
    file = work / "my-levels.toml"
    file.write_text(measurements(truth))
    out = work / "out"
    command = [program, "calibrate", design, "--measured", file, "--draws", draws, "--moves", "12"]
    command += ["--levels", levels, "--out", out, "--quiet"]
    done = subprocess.run([str(own) for own in command], text=True, stdout=subprocess.PIPE)
    print(file.read_text() + "\n" + done.stdout)
    if done.returncode not in (0, 1, 3):
        sys.exit(done.returncode)
    result = json.loads((out / "calibration" / "calibration.json").read_text())
    true = {own["source"]: own["lwa_db"] for own in truth["ranking"]} | {"total": truth["total"]["lwa_db"]}
    print("| L_WA,1s, dB | true | ranges, 90 % | without levels | now |\n|---|---|---|---|---|")
    for row in result["levels"]:
        intervals = [row[key] for key in ("ranges", "before", "now")]
        intervals = [f"{own[0]:.1f} .. {own[2]:.1f}" if own else "-" for own in intervals]
        print(f"| {row['output']} | {true[row['output']]:.1f} | {' | '.join(intervals)} |")
    total = result["levels"][-1]
    width = lambda own: own[2] - own[0]
    prior = total["ranges"] or total["before"]
    ratio = width(total["now"]) / width(prior)
    work = result["level_work"]
    print(
        f"the interval of the total is {width(total['now']):.1f} dB wide, {ratio:.2f} of that of the ranges; "
        f"{work['effective']:.0f} effective shots of {work['shots']}; converged: {result['converged']}"
    )
    if not total["now"][0] <= true["total"] <= total["now"][2]:
        sys.exit("the true total is outside")
    if ratio > 0.5:
        sys.exit("the interval is too wide")


if __name__ == "__main__":
    main()
