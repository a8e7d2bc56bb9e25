"""Compares the table of docs/validation.md with the program, or writes it anew.

    validation.py NAILNOISE PAGE           the predictions of the designs as they are, to the digit; no draws
    validation.py NAILNOISE PAGE --update  writes the whole table, with the intervals of 128 draws

The page's table is between two comments; each row has the quantity, the design, the measured and the predicted value,
the interval of the draws and the distance of both intervals.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

BEGIN = "<!-- predicted and measured: written by tests/peers/validation.py --update -->"
END = "<!-- end of the table -->"
DESIGNS = [f"designs/n80cb-as-tested{kind}.toml" for kind in ("", "-sandbox", "-sandbox-floor")]
DRAWS = 128


def compared(program, draws):
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "compare", *DESIGNS, "--measured", "designs/measured/n80cb.json", "--json", "--quiet"]
        done = subprocess.run([*command, "--draws", str(draws), "--out", folder], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)["rows"]


def measured(ends):
    low, high = ends
    if low is None:
        return f"<= {high:.2f}"
    if high is None:
        return f">= {low:.2f}"
    return f"{low:.2f} .. {high:.2f}"


def unit(row):
    return row["unit"].replace(" re 1 pW s", "")


def cells(row):
    low, high = row["interval"] or [None, None]
    interval = "" if low is None else f"{low:.1f} .. {high:.1f}"
    design = row["design"].replace("n80cb-as-tested", "tested").replace("tested-", "")
    return [row["quantity"], design, unit(row), measured(row["measured"]), f"{row['predicted']:.1f}", interval, f"{row['distance']:+.1f}"]


def table(rows):
    lines = [["quantity", "design", "unit", "measured", "predicted", "5 .. 95 %", "distance"], ["---", "---", "---", "--:", "--:", "--:", "--:"]]
    lines += [cells(row) for row in rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def summary(rows):
    """Which predictions lie apart from the measurement with their whole interval."""
    apart = [row for row in rows if abs(row["distance"]) >= 0.05]
    text = f"\nOf {len(rows)} rows, {len(rows) - len(apart)} overlap within 0.05 of their unit."
    if apart:
        text += " These do not:\n\n"
        for row in sorted(apart, key=lambda row: -abs(row["distance"])):
            quantity, design, of_unit, *_ = cells(row)
            text += f"- {quantity} ({design}): {row['distance']:+.1f} {of_unit}\n"
        return text
    return text + "\n"


def main(program, page, update):
    text = Path(page).read_text()
    before, rest = text.split(BEGIN)
    old, after = rest.split(END)
    program = str(Path(program).resolve())
    if update:
        rows = compared(program, DRAWS)
        Path(page).write_text(before + BEGIN + "\n" + table(rows) + summary(rows) + END + after)
        return
    lines = [line for line in old.strip().splitlines() if line.startswith("|")]
    stated = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]
    found = [cells(row) for row in compared(program, 2)]
    # Quantity, design, unit, measured and predicted; the intervals need the draws.
    wrong = [(a[:5], b[:5]) for a, b in zip(stated, found, strict=True) if a[:5] != b[:5]]
    for a, b in wrong:
        print("page", a, "program", b)
    print(f"{len(found)} rows, {len(wrong)} differ")
    sys.exit(bool(wrong))


main(sys.argv[1], sys.argv[2], "--update" in sys.argv[3:])
