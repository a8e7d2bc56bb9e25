"""Compares the tables of docs/validation.md with the program, or writes them anew.

    validation.py NAILNOISE PAGE           the predictions of the designs as they are, to the digit; no draws
    validation.py NAILNOISE PAGE --update  writes all tables, with the intervals of 128 draws
    validation.py NAILNOISE PAGE --update-values
                                           writes the predictions; a row keeps its interval and takes its distance

Each measured quantity is compared with the designs of its own specimen (`specimen` in the measured file): those of the
wrapping tests are plain blocks, those of the synchronised tests have a groove. A quantity whose specimen is unsaid is
compared with both. Quantities implied by published levels belong to the plain blocks, as those levels do.

A row has the quantity, the specimen, the design, the measured and the predicted value, the interval of the draws and
the distance of both intervals. A second table has the mean speed of the nail by each definition that the source admits.
"""

import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path

BEGIN = "<!-- predicted and measured: written by tests/peers/validation.py --update -->"
END = "<!-- end of the table -->"
SPEED_BEGIN = "<!-- mean speed by its definition: written by tests/peers/validation.py --update -->"
SPEED_END = "<!-- end of the definitions -->"
MEASURED = "designs/measured/n80cb.json"
FILMED = "designs/n80cb-as-filmed.toml"
DESIGNS = {"plain": [f"designs/n80cb-as-tested{kind}.toml" for kind in ("", "-sandbox", "-sandbox-floor")], "grooved": [FILMED]}
# The wrapping tests in the sandbox are shipped designs; the synchronised ones differ in the support only.
FILMED_SANDBOX = "n80cb-as-filmed-sandbox.toml"
SHORT = [("n80cb-as-tested-", ""), ("n80cb-as-tested", "tested"), ("n80cb-as-", "")]
DRAWS = 128


def compared(program, draws, specimen):
    """Rows of all quantities by the designs of one kind of block."""
    with tempfile.TemporaryDirectory() as folder:
        designs = list(DESIGNS[specimen])
        if specimen == "grooved":
            sandbox = Path(folder) / FILMED_SANDBOX
            sandbox.write_text(f'base = "{Path(FILMED).resolve().as_posix()}"\nsupport.kind = "sandbox"\n')
            designs.append(str(sandbox))
        command = [program, "compare", *designs, "--measured", MEASURED, "--json", "--quiet"]
        done = subprocess.run([*command, "--draws", str(draws), "--out", folder], capture_output=True, text=True)
    if done.returncode not in (0, 1, 3):
        raise SystemExit(done.stderr)
    return json.loads(done.stdout)["rows"]


def paired(program, draws):
    """Rows of each quantity by the designs of its specimen, in the order of the measured file."""
    with open(MEASURED) as file:
        entries = {entry["id"]: entry["specimen"] for entry in json.load(file)["entries"]}
    rows = {specimen: compared(program, draws, specimen) for specimen in DESIGNS}
    order = list(dict.fromkeys(row["id"] for specimen in rows for row in rows[specimen]))
    found = []
    for quantity in order:
        stated = entries.get(quantity, "plain")
        for specimen in [stated] if stated in rows else rows:
            found += [{**row, "specimen": stated} for row in rows[specimen] if row["id"] == quantity]
    return found


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
    design = row["design"]
    for long, short in SHORT:
        design = design.replace(long, short)
    value = [measured(row["measured"]), f"{row['predicted']:.1f}"]
    return [row["quantity"], row["specimen"], design, unit(row), *value, interval, f"{row['distance']:+.1f}"]


def markdown(lines, numbers):
    header, *rows = lines
    alignment = ["---"] * (len(header) - numbers) + ["--:"] * numbers
    return "".join("| " + " | ".join(line) + " |\n" for line in [header, alignment, *rows])


def table(rows):
    header = ["quantity", "specimen", "design", "unit", "measured", "predicted", "5 .. 95 %", "distance"]
    return markdown([header, *rows], 4)


def summary(rows):
    """Which predictions lie apart from the measurement with their whole interval."""
    # A row without an interval states the distance of a single value, which has little meaning.
    known = [row for row in rows if row[6]]
    apart = [row for row in known if abs(float(row[7])) >= 0.05]
    text = "\n"
    if len(known) < len(rows):
        text += f"{len(rows) - len(known)} rows have no draws yet; their distance is that of the design itself.\n"
    text += f"Of {len(known)} rows with an interval, {len(known) - len(apart)} overlap within 0.05 of their unit."
    if not apart:
        return text + "\n"
    text += " These do not:\n\n"
    for quantity, _, design, of_unit, *_, distance in sorted(apart, key=lambda row: -abs(float(row[7]))):
        text += f"- {quantity} ({design}): {distance} {of_unit}\n"
    return text


def read(text):
    """Cells of the rows of a table of the page."""
    lines = [line for line in text.strip().splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def with_old_interval(row, old):
    """The row with the interval that the page has for it, and the distance from that."""
    known = next((own for own in old if own[:3] == row[:3]), None)
    if known is None or not known[6]:
        return row
    ends = [float(end) for end in known[6].split(" .. ")]
    low, high = (None if end is None else float(end) for end in bounds(row[4]))
    distance = ends[0] - high if high is not None and ends[0] > high else ends[1] - low if low is not None and ends[1] < low else 0.0
    return [*row[:6], known[6], f"{distance:+.1f}"]


def bounds(text):
    if text.startswith("<= "):
        return None, text[3:]
    if text.startswith(">= "):
        return text[3:], None
    return text.split(" .. ")


def crossing(histories, depth):
    """When the tip reaches a depth in the wood [s]."""
    for before, after in zip(histories, histories[1:]):
        if before[1] < depth <= after[1]:
            return before[0] + (after[0] - before[0]) * (depth - before[1]) / (after[1] - before[1])
    raise SystemExit(f"the tip does not reach {depth} m")


def speeds(program, design, groove):
    """Mean speed of the nail by each definition, with its words."""
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "cycle", design, "--json", "--quiet", "--out", folder]
        result = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
        with open(Path(folder) / "histories.csv", newline="") as file:
            histories = [(float(row["time [s]"]), float(row["tip_depth [m]"])) for row in csv.DictReader(file)]
    events, length = result["events"], LENGTH
    enters, full = events["t6"], result["summary"]["full_penetration"]
    flush = crossing(histories, length - groove)
    found = {
        "length of the nail over the time from the tip at the wood to the head at the wood (the program's)": length / (full - enters),
        "depth of the tip over the time until the nail stops": result["summary"]["penetration"] / (events["t9"] - enters),
    }
    if groove:
        found["length of the nail over the time in which it passes the block's top"] = length / (flush - crossing(histories, -groove))
        found["wood passed until the head is level with the block's top, over that time"] = (length - groove) / (flush - enters)
    return found


LENGTH, GROOVE = 0.08255, 0.00635


def speed_rows(program):
    plain, grooved = speeds(program, DESIGNS["plain"][0], 0.0), speeds(program, FILMED, GROOVE)
    reference = next(iter(grooved.values()))
    rows = []
    for name, value in grooved.items():
        other = f"{plain[name]:.1f}" if name in plain else "the first"
        rows.append([name, other, f"{value:.1f}", f"{100 * (value / reference - 1):+.0f} %"])
    return rows


def speed_table(rows):
    return markdown([["definition", "plain [m/s]", "grooved [m/s]", "change, grooved"], *rows], 3)


def replaced(text, begin, end, content):
    before, rest = text.split(begin)
    old, after = rest.split(end)
    return before + begin + "\n" + content + end + after, old


def main(program, page, mode):
    text = Path(page).read_text()
    program = str(Path(program).resolve())
    old = read(text.split(BEGIN)[1].split(END)[0])
    of_speed = speed_rows(program)
    rows = [cells(row) for row in paired(program, DRAWS if mode == "--update" else 2)]
    if mode == "--update-values":
        # Two draws do not give an interval.
        rows = [with_old_interval([*row[:6], "", row[7]], old) for row in rows]
    if mode:
        text, _ = replaced(text, BEGIN, END, table(rows) + summary(rows))
        text, _ = replaced(text, SPEED_BEGIN, SPEED_END, speed_table(of_speed))
        Path(page).write_text(text)
        return
    # Quantity, specimen, design, unit, measured and predicted; the intervals need the draws.
    wrong = [(a[:6], b[:6]) for a, b in zip(old, rows, strict=True) if a[:6] != b[:6]]
    stated = read(text.split(SPEED_BEGIN)[1].split(SPEED_END)[0])
    wrong += [(a, b) for a, b in zip(stated, of_speed, strict=True) if a != b]
    for a, b in wrong:
        print("page", a, "program", b)
    print(f"{len(rows) + len(of_speed)} rows, {len(wrong)} differ")
    sys.exit(bool(wrong))


main(sys.argv[1], sys.argv[2], sys.argv[3] if len(sys.argv) > 3 else "")
