"""Determines the elastic constants of ten measured plates of spruce and prints the tables of docs/calibration.md.

    plates.py NAILNOISE WORK [DRAWS] [MOVES]

The plates are those of examples/plates/spruce.toml. The script prints a row for each plate, then repeats the calibration
with the first four peaks of each and compares the prediction of the other two. WORK is a folder for the files. The
script fails if fewer than half of those peaks lie within the 90 % intervals of a mode.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

FILE = Path(__file__).parents[2] / "examples" / "plates" / "spruce.toml"
MODULI = {"e_l": "E_L", "e_r": "E_R", "g_lr": "G_LR"}


def calibrated(program, file, out, draws, moves):
    """Result of the plates of a file. Status 1 is a conflict, 3 a sampler that has not converged."""
    arguments = ["calibrate", "--structures", file, "--out", out, "--draws", draws, "--moves", moves, "--quiet"]
    done = subprocess.run([program, *map(str, arguments)], stdout=subprocess.DEVNULL)
    if done.returncode not in (0, 1, 3):
        sys.exit(done.returncode)
    return json.loads((out / "structures" / "structures.json").read_text())


def interval(values, size):
    low, middle, high = (value / size for value in values)
    return f"{middle:.3g} ({low:.3g} .. {high:.3g})"


def table(result):
    print("| plate | density, kg/m3 | " + " | ".join(f"{name}, GPa" for name in MODULI.values()), end="")
    print(" | peaks left out | converged |\n|---|---|---|---|---|---|---|")
    for plate in result["plates"]:
        inputs = {own["name"]: own["now"] for own in plate["inputs"]}
        cells = [plate["name"], interval(plate["density"], 1.0)]
        cells += [interval(inputs[key], 1e9) for key in MODULI]
        left_out = [own["name"] for own in plate["peaks"] if not own["counts"]]
        cells += [", ".join(left_out) or "none", "no" if plate["faults"] else "yes"]
        print("| " + " | ".join(cells) + " |")
    print("\n| plate | modes up to 600 Hz (nodal lines across, along the grain): Hz, P5 .. P95 |\n|---|---|")
    for plate in result["plates"]:
        modes = (
            f"({own['nodal_lines'][0]}, {own['nodal_lines'][1]}) {own['hz'][0]:.0f} .. {own['hz'][2]:.0f}"
            for own in plate["modes"]
        )
        print(f"| {plate['name']} | {'; '.join(modes)} |")


def held_back(text):
    """The file with the last two peaks of each plate as a check."""

    def split(found):
        peaks = [own.strip() for own in found[1].split(",")]
        return f"peaks = [{', '.join(peaks[:-2])}]\ncheck = [{', '.join(peaks[-2:])}]"

    return re.sub(r"peaks = \[(.*)\]", split, text)


def main():
    program, work = sys.argv[1], Path(sys.argv[2])
    draws, moves = (sys.argv[3:] + ["512", "24"][len(sys.argv[3:]) :])[:2]
    work.mkdir(parents=True, exist_ok=True)
    table(calibrated(program, FILE, work / "all", draws, moves))
    file = work / "held-back.toml"
    file.write_text(held_back(FILE.read_text()))
    within, total = 0, 0
    for plate in calibrated(program, file, work / "held-back", draws, moves)["plates"]:
        for own in plate["peaks"]:
            if own["counts"] or own["verdict"] not in ("predicted", "conflict") or own["nodal_lines"] is None:
                continue
            is_check = own["reading"] in [float(peak) for peak in checks(file, plate["name"])]
            if is_check:
                total += 1
                within += any(mode["hz"][0] <= own["reading"] <= mode["hz"][2] for mode in plate["modes"])
    print(f"\n{within} of {total} peaks that were held back lie in the 90 % interval of a mode")
    if 2 * within < total:
        sys.exit("too few")


def checks(file, plate):
    """Frequencies of the check of a plate."""
    section = file.read_text().split(f"[plate.{plate}]")[1]
    return re.findall(r"([\d.]+) Hz", re.search(r"check = \[(.*)\]", section)[1])


if __name__ == "__main__":
    main()
