"""Whether an optimisation of 60 trials finds quieter designs than the best of 100 points of a Sobol' sequence.

    optimise.py DESIGN [SEEDS]

Two dimensions of the exhaust and the supply are varied under the constraint that the nail is driven fully. A trial of the optimiser is a
design whose levels are computed; a shot that breaks the constraint only costs a cycle. The sequence is searched twice:
over its first 100 points, and on until 100 points have met the constraint. The packages nailnoise and scipy must be
installed. The script prints the levels for each seed and fails if the optimiser is ahead of the first 100 points in
fewer than eight of ten.
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


def searched(design: nn.Design, seed: int, cache: str) -> tuple[float, float]:
    """The lowest levels of the first 100 points of a Sobol' sequence, and of its first 100 points that meet the constraints."""
    constraints = [Constraint.parse(text) for text in HELD]
    first, levels = float("inf"), []
    for number, (holes, diameter, pressure) in enumerate(qmc.Sobol(3, seed=seed).random(1024)):
        if number == 100:
            first = min(levels, default=first)
        values = {
            "exhaust.holes": 2 + int(15 * holes),
            "exhaust.hole_diameter": f"{3 + 6 * diameter} mm",
            "supply.pressure": f"{80 + 30 * pressure} psig",
        }
        own = design.with_(values)
        figures = _figures(own)
        if all(constraint.excess(figures) <= 0.0 for constraint in constraints):
            levels.append(_levels(own, "exhaust.holes", cache)["total"])
        if len(levels) == 100:
            break
    return first, min(levels)


def main() -> int:
    design, seeds = nn.load(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 10
    ahead = [0, 0]
    with tempfile.TemporaryDirectory() as cache:
        for seed in range(1, seeds + 1):
            found = nn.optimise(design, VARY, subject_to=HELD, trials=60, seed=seed, cache=cache)
            own = found.best.figures["total"] if found.best else float("inf")
            others = searched(design, seed, cache)
            ahead = [count + (own < other) for count, other in zip(ahead, others)]
            print(
                f"seed {seed}: {own:.3f} dB by 60 trials among {len(found.trials)} candidates of the optimiser; "
                f"of Sobol' {others[0]:.3f} dB by 100 points, {others[1]:.3f} dB by 100 that meet the constraints",
                flush=True,
            )
    print(f"the optimiser is ahead of 100 points in {ahead[0]} of {seeds} seeds, of 100 that meet the constraints in {ahead[1]}")
    return 0 if ahead[0] >= 0.8 * seeds else 1


if __name__ == "__main__":
    sys.exit(main())
