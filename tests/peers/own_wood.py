"""Repeats the loop from a plan of tests to a shot, and counts how often the interval covers the truth.

    own_wood.py NAILNOISE DESIGN MACHINE WORK [ROUNDS] [DRAWS] [LEVELS] [FIRST]

DESIGN is the design whose law the virtual machine MACHINE uses (`designs/n80cb.toml` and `examples/penetration/machine.toml`).
WORK is a folder for the files. Each round (default 100) has a different seed, from FIRST (default 1) on:

- `prf machine --virtual 7` computes tests of the plan for 70 J, `prf fit` fits poly(x,7), and `cycle --draw` draws the fitted
  law (default 200 draws) with all other quantities fixed at the values of DESIGN;
- the 95 % interval of the depth of one shot, mean -+ t s sqrt(1 + 1/n) of the draws, is compared with a shot by the true law
  into a specimen drawn from the true scatter.

The depth represents the workpiece's level, because the remaining energy of the piston decides both: an interval covers
a monotone function of a quantity if it covers the quantity. For the first LEVELS rounds (default 5; 10 s of computing
each once bodies are cached) the level by the fitted law is compared with that by the true law. The rank correlation of
level and depth over the draws of a study is printed.

The script fails if an interval covers the truth in less than 90 % of the rounds, or a level differs by more than 0.3 dB.
"""

import csv
import json
import math
import re
import statistics
import subprocess
import sys
import tomllib
from pathlib import Path

FORM = "poly(x,7)"
WORKPIECE = "L_WA,1s workpiece [dB]"


def command(program, *arguments):
    """Runs the program; its standard output."""
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, arguments))}\n{done.stderr}")
    return done.stdout


def ranged(table, group=""):
    """Keys with a range, and their values as the file writes them."""
    for key, value in table.items():
        name = f"{group}{key}"
        if isinstance(value, dict) and "value" in value:
            if "range" in value:
                yield name, value["value"]
        elif isinstance(value, dict) and name != "study":
            yield from ranged(value, f"{name}.")


def point(value):
    """The range that contains this value only."""
    number, _, unit = str(value).partition(" ")
    return f"{number} .. {number} {unit}".strip()


def design(path, base, fit):
    """Writes the design without ranges, with the fitted law of this file."""
    lines = [f"base = {json.dumps(str(base.resolve()))}"]
    with base.open("rb") as file:
        lines += [f"{key} = {{ value = {json.dumps(value)}, range = {json.dumps(point(value))} }}" for key, value in ranged(tomllib.load(file))]
    lines += [
        'wood.penetration_law = "fitted"',
        f"wood.penetration_fit = {json.dumps(str(fit.resolve()))}",
        "study.require = []",
    ]
    path.write_text("\n".join(lines) + "\n")
    return path


def rows(out):
    """Rows of draws.csv."""
    with next(out.glob("**/draws.csv")).open(newline="") as file:
        return list(csv.DictReader(file))


def shots(program, path, out, draws, seed):
    """Depths of drawn shots [mm]."""
    command(program, "cycle", path, "--draw", draws, "--seed", seed, "--out", out)
    return [1e3 * float(row["penetration [m]"]) for row in rows(out)]


def level(program, path, out, draws=1):
    """Workpiece's level by the law itself, and levels [dB] and depths [mm] of draws without the errors of methods."""
    result = json.loads(command(program, "study", path, "-n", draws, "--quiet", "--json", "--out", out))
    nominal = next(own["level"]["nominal_db"] for own in result["sources"] if own["source"] == "workpiece")
    drawn = [(float(row[WORKPIECE]) - float(row["method.workpiece [dB]"]), 1e3 * float(row["penetration [m]"])) for row in rows(out)]
    return nominal, drawn


def rank_correlation(pairs):
    """Spearman's correlation."""
    ranks = [[sorted(column).index(value) for value in column] for column in zip(*pairs)]
    return statistics.correlation(*ranks)


def changed(fit, path, **numbers):
    """The fit with other numbers, as a file."""
    text = fit.read_text()
    for key, value in numbers.items():
        text = re.sub(rf"^{key} = .*$", f"{key} = {value}", text, flags=re.M)
    path.write_text(text)
    return path


def t_quantile(freedom):
    """97.5 % quantile of Student's t (Cornish-Fisher, 1e-4 above 30 degrees of freedom)."""
    z = 1.959963985
    terms = [z**3 + z, 5 * z**5 + 16 * z**3 + 3 * z, 3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z]
    return z + sum(term / scale / freedom**k for k, (term, scale) in enumerate(zip(terms, (4, 96, 384)), 1))


def main():
    program, base, machine, work = sys.argv[1], *map(Path, sys.argv[2:5])
    rounds, draws, levels, first = [int(word) for word in sys.argv[5:9]] + [100, 200, 5, 1][len(sys.argv) - 5 :]
    work.mkdir(parents=True, exist_ok=True)
    plan = work / "plan.csv"
    command(program, "prf", "plan", "--nail", "12d", "--energy", "70J", "--out", plan)
    scatter = tomllib.loads(machine.read_text())["scatter"]["sigma_between"]

    def fitted(source, name, seed):
        tests, out = work / f"{name}-tests", work / f"{name}-fit"
        command(program, "prf", "machine", source, "--virtual", 7, "--plan", plan, "--seed", seed, "--out", tests)
        command(program, "prf", "fit", tests / "drives.csv", "--form", FORM, *EXTRA, "--out", out)
        return out / "fit.toml"

    # The true law: tests without noise, scatter or lag.
    clean = machine.read_text()
    for key in ("depth_noise", "force_noise", "cell_frequency", "sigma_between"):
        clean = re.sub(rf"^{key} = .*$", f"{key} = 0", clean, flags=re.M)
    exact = work / "exact.toml"
    exact.write_text(clean)
    truth = changed(fitted(exact, "true", 1), work / "true.toml", sigma_between=scatter)
    true_design = design(work / "true-design.toml", base, truth)
    true_shots = shots(program, true_design, work / "true-out", first + rounds - 1, 12345)[first - 1 :]
    print(f"true law: shots {statistics.mean(true_shots):.2f} +- {statistics.stdev(true_shots):.2f} mm", flush=True)
    if levels > 0:
        true_level, drawn = level(program, true_design, work / "true-study", 16)
        print(f"true law: {true_level:.2f} dB; rank correlation of level and depth {rank_correlation(drawn):.3f}", flush=True)

    differences, inside = [], 0
    t = t_quantile(draws - 1)
    for seed, shot in enumerate(true_shots, first):
        fit = fitted(machine, "round", seed)
        own = design(work / "round.toml", base, fit)
        one = shots(program, own, work / "round-out", draws, seed)
        half = t * statistics.stdev(one) * math.sqrt(1 + 1 / draws)
        inside += abs(shot - statistics.mean(one)) <= half
        line = f"{seed}: one shot +-{half:.2f} mm, covered {inside}"
        if seed < first + levels:
            differences.append(level(program, own, work / "level-out")[0] - true_level)
            line += f"; level {differences[-1]:+.3f} dB"
        print(line, flush=True)
    print(f"{rounds} rounds: the interval of one shot covers {inside}", end="")
    most = max(map(abs, differences), default=0.0)
    print(f"; levels differ by {most:.3f} dB at most" if differences else "")
    sys.exit(most > 0.3 or inside < 0.9 * rounds)


EXTRA = []

if __name__ == "__main__":
    main()
