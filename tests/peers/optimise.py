"""Whether `nailnoise optimise` finds quieter designs with 60 trials than 100 points of a Sobol' sequence, and than Optuna.

    NAILNOISE=target/release/nailnoise optimise.py DESIGN [SEEDS [OTHERS]]

Two dimensions of the exhaust and the supply are varied under the constraint that the nail is driven fully. A trial is a
design whose levels are computed; a shot that breaks the constraint only costs a cycle. The first 100 points of the
sequence are always searched. OTHERS are `feasible`, which searches the sequence on until 100 points have met the
constraint, and the samplers of Optuna `tpe` and `gp`, which needs torch, each up to 60 trials; the default is
`feasible,tpe`, and `none` leaves all out. The packages optuna and scipy must be installed. The script prints the levels
for each seed and fails if nailnoise is ahead of the first 100 points in fewer than 14 of 15 seeds.
"""

import functools
import json
import os
import subprocess
import sys
import tempfile

import optuna
from scipy.stats import qmc

NAILNOISE = os.environ.get("NAILNOISE", "nailnoise")
DEPTH = 82.55e-3
TRIALS, CANDIDATES, POINTS = 60, 1200, 100


def values(holes: int, diameter: float, pressure: float) -> tuple[str, ...]:
    return (f"exhaust.holes={holes}", f"exhaust.hole_diameter={diameter:.6g} mm", f"supply.pressure={pressure:.6g} psig")


def command(*arguments: str) -> dict:
    done = subprocess.run([NAILNOISE, *arguments, "--json", "--quiet"], capture_output=True, text=True)
    # Status 3: a check failed, for example because the nail is overdriven.
    if done.returncode not in (0, 1, 3):
        raise RuntimeError(done.stderr)
    return json.loads(done.stdout)


@functools.cache
def excess(design: str, own: tuple[str, ...]) -> float:
    """How far a shot is from full drive, in parts of the depth; at most 0 where it drives."""
    shot = command("cycle", design, *(part for text in own for part in ("--set", text)))
    missing = (DEPTH - shot["summary"]["penetration"]) / DEPTH
    return max(missing, 0.0 if shot["outcome"] == "drives" else 1.0)


@functools.cache
def level(design: str, own: tuple[str, ...], out: str) -> float:
    vary = [part for text in own for part in ("--vary", text)]
    return command("sweep", design, *vary, "--out", out)["points"][0]["total_db"]


def by_nailnoise(design: str, seed: int, out: str) -> float:
    ranges = ["exhaust.holes=2..16", "exhaust.hole_diameter=3mm..9mm", "supply.pressure=80psig..110psig"]
    vary = [part for text in ranges for part in ("--vary", text)]
    held = ["--subject-to", "outcome == drives", "--subject-to", f"penetration >= {1e3 * DEPTH} mm"]
    found = command("optimise", design, *vary, *held, "--trials", str(TRIALS), "--seed", str(seed), "--out", out)
    return found["trials"][found["front"][0]]["total_db"] if found["front"] else float("inf")


def by_optuna(design: str, sampler: optuna.samplers.BaseSampler, out: str) -> float:
    study = optuna.create_study(sampler=sampler)
    levels: list[float] = []
    for _ in range(CANDIDATES):
        trial = study.ask()
        own = values(trial.suggest_int("holes", 2, 16), trial.suggest_float("diameter", 3, 9), trial.suggest_float("pressure", 80, 110))
        beyond = excess(design, own)
        trial.set_constraint("drives", beyond)
        if beyond <= 0.0:
            levels.append(level(design, own, out))
        study.tell(trial, levels[-1] if beyond <= 0.0 else 1e9)
        if len(levels) == TRIALS:
            break
    return min(levels, default=float("inf"))


def by_sobol(design: str, seed: int, out: str, feasible: bool) -> float:
    """The lowest level of the first 100 points of a Sobol' sequence, or of its first 100 points that meet the constraint."""
    levels: list[float] = []
    for number, (holes, diameter, pressure) in enumerate(qmc.Sobol(3, seed=seed).random(1024)):
        own = values(2 + int(15 * holes), 3 + 6 * diameter, 80 + 30 * pressure)
        if excess(design, own) <= 0.0:
            levels.append(level(design, own, out))
        if (len(levels) if feasible else number + 1) == POINTS:
            break
    return min(levels, default=float("inf"))


def main() -> int:
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    design, seeds = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 15
    asked = sys.argv[3] if len(sys.argv) > 3 else "feasible,tpe"
    searches = {
        "feasible": ("100 points that meet the constraint", lambda seed, out: by_sobol(design, seed, out, feasible=True)),
        "tpe": ("Optuna's TPE", lambda seed, out: by_optuna(design, optuna.samplers.TPESampler(seed=seed), out)),
        "gp": ("Optuna's GP", lambda seed, out: by_optuna(design, optuna.samplers.GPSampler(seed=seed), out)),
    }
    first = "the first 100 points"
    others = {first: lambda seed, out: by_sobol(design, seed, out, feasible=False)}
    others |= dict(searches[name] for name in asked.split(",") if name != "none")
    ahead = dict.fromkeys(others, 0)
    with tempfile.TemporaryDirectory() as out:
        for seed in range(1, seeds + 1):
            own = by_nailnoise(design, seed, out)
            found = {name: search(seed, out) for name, search in others.items()}
            for name, other in found.items():
                ahead[name] += own < other
            print(f"seed {seed}: {own:.3f} dB; " + ", ".join(f"{name} {other:.3f}" for name, other in found.items()), flush=True)
    for name, count in ahead.items():
        print(f"nailnoise is ahead of {name} in {count} of {seeds} seeds")
    return 0 if ahead[first] >= 14 / 15 * seeds else 1


if __name__ == "__main__":
    sys.exit(main())
