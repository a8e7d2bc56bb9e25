"""Calibrates the N80CB with the published figures as far as they agree, and writes docs/calibrated-n80cb.md.

    calibrated_n80cb.py NAILNOISE WORK [PAGE] [--draws 512] [--levels 128]

The figures are those of designs/measured/n80cb.json. The design is designs/n80cb-as-tested.toml, on the worktable; the
figures of the sandbox are not used, because its sources have other methods. WORK is a folder for the files; without
PAGE the page is printed. No value of a shipped design follows from it.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DESIGN = ROOT / "designs" / "n80cb-as-tested.toml"
# A reading of the file of measurements for a published figure: the fields that are not the value.
READINGS = {
    "mean_penetration_speed": {"quantity": "mean_drive_speed", "unit": "m/s", "scatter": "3 %", "error": "2 %"},
    "lwa_workpiece_worktable": {
        "quantity": "level",
        "source": "workpiece",
        "unit": "dB",
        "scatter": "0.5 dB",
        "error": "0.5 dB",
        "shots": 5,
    },
    "rms_w_worktable": {
        "quantity": "rms_acceleration",
        "sensor": "W",
        "unit": "g",
        "error": "5 %",
    },
}


def measurements(entries):
    """The file of measurements."""
    lines = ['schema = "nailnoise-calibration/1"', "[condition]", 'tested = { outcome = "drives" }', "[measured]"]
    for name, own in READINGS.items():
        entry = entries[name]
        value = "at_most" if entry["kind"] == "upper_bound" else "value"
        fields = {"condition": "tested", **own, value: f"{entry['value']} {own['unit']}"}
        del fields["unit"]
        text = ", ".join(f"{key} = {json.dumps(field)}" for key, field in fields.items())
        lines.append(f"{name} = {{ {text} }}")
    return "\n".join(lines) + "\n"


# Units of the page for SI units, with their factors.
UNITS = {
    "m": ("mm", 1e3),
    "N": ("kN", 1e-3),
    "Pa": ("kPa", 1e-3),
    "kg": ("g", 1e3),
    "kg/s": ("g/s", 1e3),
}


def number(value, factor=1.0):
    return "-" if value is None else f"{factor * value:.3g}"


def interval(own, factor=1.0):
    return f"{number(own[0], factor)} .. {number(own[-1], factor)}"


def level(own):
    return "-" if own is None else f"{own[1]:.1f} ({own[0]:.1f} .. {own[2]:.1f})"


def wrapped(text, width=120):
    """A paragraph in lines of the width of the documentation."""
    lines, line = [], ""
    for word in text.split():
        if line and len(line) + 1 + len(word) > width:
            lines.append(line)
            line = word
        else:
            line = f"{line} {word}".strip()
    return "\n".join([*lines, line])


def page(result, file, arguments):
    """The page."""
    used = [own["name"] for own in result["measurements"] if own["counts"]]
    parts = ["# The N80CB calibrated with published figures"]
    parts.append(
        wrapped(
            "The published tests of this tool state a few figures of its shot ([validation](validation.md)). This "
            "page conditions the ranges of `n80cb-as-tested.toml` on those that the model can predict on the worktable, "
            "as far as they agree. It is the only place where a published figure conditions anything: no value of a "
            "shipped design follows from it. `tests/peers/calibrated_n80cb.py` makes the page, with "
            f"`--draws {arguments.draws} --levels {arguments.levels}`."
        )
    )
    parts.append("## Figures\n\n```toml\n" + file.rstrip() + "\n```")
    parts.append(
        wrapped(
            "The errors are assumptions: none is published. The level of the workpiece is an upper bound. The mean "
            "penetration energy and the penetration time are the mean speed in other words. The closure and the fall "
            "from worktable to sandbox refer to several tests at once, and the figures of the sandbox to another "
            "support; they are not used."
        )
    )
    rows = ["| figure | published | unit | before, 90 % | now, 90 % | difference left, sd | probability | verdict |"]
    rows.append("|---|---|---|---|---|---|---|---|")
    for own in result["measurements"]:
        low, high = own["reading"]
        value = number(low) if low == high else f"at most {number(high)}"
        verdict = own["verdict"].replace("_", " ") + ("" if own["counts"] else ", left out")
        rows.append(
            f"| {own['name']} | {value} | {own['unit']} | {interval(own['before'])} | {interval(own['now'])} "
            f"| {own['left_over']:+.1f} | {own['probability']:.2g} | {verdict} |"
        )
    parts.append("## What agrees\n\n" + "\n".join(rows))
    if not result["converged"]:
        parts.append("The sampler has not converged: " + "; ".join(result["faults"]) + ".")
    for own in result["conflicts"]:
        other = own["partner"] or "the others and the ranges together"
        text = f"**Conflict**: {own['measurement']} contradicts {other}; its probability is {own['probability']:.1e}."
        if own["nearest"] is not None:
            nearest = number(own["nearest"])
            text = f"**Not reached**: no draw comes near {own['measurement']}; the nearest has {nearest}."
        remedies = "".join(f"\n- {remedy}" for remedy in own["remedies"])
        parts.append(wrapped(text + " It is left out of all intervals. What would have to give:") + "\n" + remedies)
    if not result["conflicts"]:
        parts.append(
            wrapped(
                f"The figures agree within their errors: {', '.join(used)} condition the draws."
            )
        )
    rows = ["| input | unit | before, 90 % | now, 90 % | ratio of widths |", "|---|---|---|---|---|"]
    moved = [own for own in result["inputs"] if own["ratio"] < result["moved_below"]]
    for own in moved:
        ends = f"{interval(own['before'])} | {interval(own['now'])}"
        rows.append(f"| `{own['name']}` | {own['unit']} | {ends} | {own['ratio']:.2f} |")
    parts.append(
        "## What moved\n\n"
        + ("\n".join(rows) + "\n\n" if moved else "")
        + wrapped(
            f"{len(moved) or 'No'} inputs are narrower by more than chance explains with these draws (ratio of the "
            f"widths below {result['moved_below']:.2f}); the figures do not identify the other {result['unidentified']}."
        )
    )
    rows = ["| figure of the shot | before, P50 (90 %) | now |", "|---|---|---|"]
    for own in result["figures"]:
        unit, factor = UNITS.get(own["unit"], (own["unit"], 1.0))
        before, now = (f"{number(own[key][1], factor)} ({interval(own[key], factor)})" for key in ("before", "now"))
        rows.append(f"| {own['name']}, {unit} | {before} | {now} |")
    parts.append("\n".join(rows))
    rows = ["| L_WA,1s, dB re 1 pW s, P50 (90 %) | study of the ranges | given the speed | given all | P(first) |"]
    rows.append("|---|---|---|---|---|")
    for own in result["levels"]:
        first = "" if own["first"] is None else f"{own['first'][0]:.2f} to {own['first'][1]:.2f}"
        rows.append(
            f"| {own['output']} | {level(own['ranges'])} | {level(own['before'])} | {level(own['now'])} | {first} |"
        )
    work = result["level_work"]
    parts.append(
        "## What follows for the levels\n\n"
        + "\n".join(rows)
        + "\n\n"
        + wrapped(
            f"The levels of {work['shots']} shots were computed, with {work['errors']} errors of the methods each; "
            f"weighted by the figures, they count as {work['effective']:.0f} shots."
        )
    )
    return "\n\n".join(parts) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("work", type=Path)
    parser.add_argument("page", type=Path, nargs="?")
    parser.add_argument("--draws", default="512")
    parser.add_argument("--levels", default="128")
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    published = json.loads((ROOT / "designs" / "measured" / "n80cb.json").read_text())
    text = measurements({own["id"]: own for own in published["entries"]})
    file = arguments.work / "published.toml"
    file.write_text(text)
    out = arguments.work / "out"
    command = [arguments.program, "calibrate", DESIGN, "--measured", file, "--out", out, "--quiet"]
    command += ["--draws", arguments.draws, "--levels", arguments.levels]
    done = subprocess.run([str(own) for own in command], stdout=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1, 3):
        sys.exit(done.returncode)
    result = json.loads((out / "calibration" / "calibration.json").read_text())
    made = page(result, text, arguments)
    if arguments.page:
        arguments.page.write_text(made)
    else:
        print(made, end="")


if __name__ == "__main__":
    main()
