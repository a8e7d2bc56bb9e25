"""Whether an optimisation of 60 designs finds quieter ones than the best of 100 points of a Sobol' sequence.

    optimise.py DESIGN [SEEDS]

Two dimensions of the exhaust and the supply are varied under the constraint that the nail is driven fully. The packages nailnoise
and scipy must be installed. The script prints both levels for each seed and fails if the optimiser wins in fewer than eight of ten.
"""

import sys
import tempfile

import nailnoise as nn
from nailnoise._optimise import Constraint, _figures, _levels
from scipy.stats import qmc

VARY = {
    "exhaust.holes": "2..16",
    "exhaust.hole_diameter": "3 mm..9 mm",
    "supply.pressure": "80psig..110psig",
}
HELD = ["outcome == drives", "penetration >= 82.55 mm"]


def best_of_sobol(design: nn.Design, points: int, seed: int, cache: str) -> float:
    constraints = [Constraint.parse(text) for text in HELD]
    levels = [float("inf")]
    for holes, diameter, pressure in qmc.Sobol(3, seed=seed).random(128)[:points]:
        values = {
            "exhaust.holes": 2 + int(15 * holes),
            "exhaust.hole_diameter": f"{3 + 6 * diameter} mm",
            "supply.pressure": f"{80 + 30 * pressure} psig",
        }
        own = design.with_(values)
        figures = _figures(own)
        if all(constraint.excess(figures) <= 0.0 for constraint in constraints):
            levels.append(_levels(own, "exhaust.holes", cache)["total"])
    return min(levels)


def main() -> int:
    design, seeds = nn.load(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 10
    won = 0
    with tempfile.TemporaryDirectory() as cache:
        for seed in range(1, seeds + 1):
            found = nn.optimise(design, VARY, subject_to=HELD, trials=60, seed=seed, cache=cache).best
            levels = [found.figures["total"] if found else float("inf"), best_of_sobol(design, 100, seed, cache)]
            won += levels[0] < levels[1]
            print(f"seed {seed}: {levels[0]:.3f} dB by 60 designs of the optimiser, {levels[1]:.3f} dB by 100 of Sobol'", flush=True)
    print(f"the optimiser is ahead in {won} of {seeds} seeds")
    return 0 if won >= 0.8 * seeds else 1


if __name__ == "__main__":
    sys.exit(main())
