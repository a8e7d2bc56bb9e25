"""The pages state the results of the studies that come with the program.

    studies.py FOLDER            compares the pages with designs/studies in the folder of the repository
    studies.py FOLDER --update   writes the tables and sentences anew

Rows of tables of `nailnoise run` in the README and the pages take interval and P(first); the block of docs/study.md between its marks is
written whole. It needs no program: the numbers are those of the files, which `nailnoise provide designs/studies` makes.
"""

import json
import re
import sys
from pathlib import Path

BEGIN = "<!-- the study of the N80CB: written by tests/peers/studies.py --update -->"
END = "<!-- end of the study -->"
ALL = "<!-- all studies: written by tests/peers/studies.py --update -->"
ALL_END = "<!-- end of all studies -->"
TABLES = ["README.md", "docs/reading-a-result.md", "docs/exhaust-first.md"]


def half(estimate):
    low, high = estimate["interval"]
    return None if low is None or high is None else 0.5 * (high - low)


def with_error(estimate, digits):
    error = half(estimate)
    return f"{estimate['value']:.{digits}f}" + ("" if error is None else f" +-{error:.{digits}f}")


def interval(level):
    return f"{level['level_db']['p05']['value']:.1f} .. {level['level_db']['p95']['value']:.1f}"


def table(study):
    lines = ["| source | design | draws below it | P5 | P50 | P95 | P(first) | silenced |", "|---|---|---|---|---|---|---|---|"]
    for own in [*study["sources"], {"source": "total", "level": study["total"]}]:
        level = own["level"]
        cells = [own["source"], f"{level['nominal_db']:.1f}", f"{100 * level['below_nominal']:.0f} %"]
        cells += [with_error(level["level_db"][p], 1) for p in ("p05", "p50", "p95")]
        cells += [with_error(own["first"], 2), with_error(own["silencing_db"], 1)] if "first" in own else ["", ""]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def wrapped(text, width=120):
    lines, line = [], ""
    for word in text.split():
        if line and len(line) + 1 + len(word) > width:
            lines.append(line)
            line = word
        else:
            line = f"{line} {word}".strip()
    return "\n".join([*lines, line]) + "\n"


def sentences(study):
    of = {own["source"]: own for own in study["sources"]}
    order = study["orders"][0]
    candidates = study["candidates"]
    share = 100 * candidates["outcomes"].get("drives", 0) / sum(candidates["outcomes"].values())
    pair = next(own for own in study["louder"] if {own["source"], own["than"]} == {"exhaust", "body"})
    text = [
        f"The most frequent order is {' > '.join(order['order'])}, in {100 * order['probability']['value']:.0f} % of the draws. "
        + " ".join(
            f"The {name} is the loudest in {100 * own['first']['value']:.0f} %; silencing it completely lowers the total by "
            f"{own['silencing_db']['value']:.1f} dB on average."
            for name, own in of.items()
        )
        + f" The {pair['source']} is louder than the {pair['than']} with a probability of {with_error(pair['probability'], 2)}."
    ]
    decide = []
    for own in study["contributions"]:
        named = [
            f"`{one['variable']}` ({one['first_order']:.2f}, {one['effect_db']:+.1f} dB between its outer thirds)"
            for one in own["inputs"][:3]
        ]
        if named and " less " not in own["output"]:
            decide.append(f"of the {own['output']} {', '.join(named)}")
    if decide:
        text.append("Inputs that explain more of a level's variance than chance does: " + "; ".join(decide) + ". The other inputs share the rest.")
    text.append(
        f"The {study['draws']} draws needed {candidates['drawn']} candidates, of which {share:.1f} % drive the nail. Another seed moves these "
        "figures by about their intervals."
    )
    return "\n".join(wrapped(one) for one in text)


def overview(studies):
    lines = ["| design | draws | total, 90 % of draws dB | K dB | loudest | P(first) |", "|---|---|---|---|---|---|"]
    for name in sorted(studies):
        study = studies[name]
        first = max(study["sources"], key=lambda own: own["first"]["value"])
        ends = study["total"]["level_db"]
        k = int(0.5 * (ends["p95"]["value"] - ends["p05"]["value"]) + 0.5)
        cells = [f"`{name}`", str(study["draws"]), interval(study["total"]), str(k), first["source"], with_error(first["first"], 2)]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def with_rows(text, study):
    """Interval and P(first) in the rows of `nailnoise run`, as it prints them and as Markdown."""
    for own in [*study["sources"], {"source": "total", "level": study["total"]}]:
        ends = interval(own["level"])
        first = f"{own['first']['value']:.2f}" if "first" in own else None

        def printed(match, ends=ends, first=first):
            begin, old, gap, probability, rest = match.groups()
            line = begin + ends.rjust(len(old))
            return line + (gap + first.rjust(len(probability)) + rest if first and probability else gap + (probability or "") + rest)

        pattern = rf"^(  {own['source']} +[\d.]+ +?)( *[\d.]+ \.\. [\d.]+)( *)(\d\.\d\d)?(.*)$"
        text = re.sub(pattern, printed, text, flags=re.M)
        if first:
            pattern = rf"^(\| {own['source']} \| [\d.]+ \| )[\d.]+ \.\. [\d.]+ \| \d\.\d\d \|$"
            text = re.sub(pattern, rf"\g<1>{ends} | {first} |", text, flags=re.M)
    shares = [(" > ".join(own["order"]), own["probability"]["value"]) for own in study["orders"][:2]]
    certain = "" if shares[0][1] >= 0.95 else "not certain: "
    lines = f"  ranking {certain}{shares[0][0]} in {100 * shares[0][1]:.0f} % of the draws"
    if len(shares) > 1:
        lines += f",\n    {shares[1][0]} in {100 * shares[1][1]:.0f} % of the draws"
    text = re.sub(r"^  ranking .*% of the draws(,\n    .*% of the draws)?$", lines, text, flags=re.M)
    ends = study["total"]["level_db"]
    k = int(0.5 * (ends["p95"]["value"] - ends["p05"]["value"]) + 0.5)
    return re.sub(r"K = \d+ dB \(1\.645 sigma of the draws\)", f"K = {k} dB (1.645 sigma of the draws)", text)


def between(text, begin, end, new):
    before, rest = text.split(begin)
    _, after = rest.split(end)
    return f"{before}{begin}\n{new}{end}{after}"


def main(folder, update):
    root = Path(folder)
    studies = {}
    for path in sorted((root / "designs/studies").glob("*.json")):
        file = json.loads(path.read_text())
        studies[file["design"]] = file["result"]
    base = studies["n80cb.toml"]
    pages = {name: with_rows((root / name).read_text(), base) for name in TABLES}
    page = (root / "docs/study.md").read_text()
    page = between(page, BEGIN, END, table(base) + "\n" + sentences(base))
    pages["docs/study.md"] = between(page, ALL, ALL_END, overview(studies))
    differ = [name for name, text in pages.items() if text != (root / name).read_text()]
    for name in differ:
        print(name, "written" if update else "states other numbers than designs/studies")
        if update:
            (root / name).write_text(pages[name])
    few = {name: study["draws"] for name, study in studies.items() if study["draws"] < 128}
    if few:
        print("fewer than 128 draws:", few)
    sys.exit(bool(few) or bool(differ and not update))


main(sys.argv[1], "--update" in sys.argv[2:])
