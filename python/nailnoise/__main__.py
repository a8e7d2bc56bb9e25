"""``python -m nailnoise optimise``: what `nailnoise optimise` calls."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from . import NailnoiseError, load, optimise


def _pair(text: str) -> tuple[str, str]:
    key, found, value = text.partition("=")
    if not found or not key.strip() or not value.strip():
        raise argparse.ArgumentTypeError(f"`{text}` is no KEY=VALUES")
    return key.strip(), value.strip()


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser("nailnoise optimise", description="Look for the design of the lowest level.")
    parser.add_argument("design", help="design file (TOML)")
    parser.add_argument(
        "--vary", metavar="KEY=LOW..HIGH", type=_pair, action="append", required=True,
        help="a key and its range, as supply.pressure=80psig..110psig, or its choices A,B,C; :log for a logarithmic range",
    )  # fmt: skip
    parser.add_argument("--minimise", metavar="WHAT", default="total", help="total, a source, or a figure of the shot")
    parser.add_argument(
        "--subject-to", metavar="CONSTRAINT", action="append",
        help='as "penetration >= 80 mm" or "exhaust <= 92 dB" [default: "outcome == drives"]',
    )  # fmt: skip
    parser.add_argument("--pareto", metavar="WHAT", help="a second objective; with a minus it is maximised, as =-drive_energy")
    parser.add_argument("--trials", metavar="N", type=int, default=60)
    parser.add_argument("--seed", metavar="SEED", type=int, default=1)
    parser.add_argument("--set", metavar="KEY=VALUE", type=_pair, action="append", default=[], help="another value of the design")
    parser.add_argument("--out", metavar="DIR", help="folder for the designs [default: out/NAME/optimised]")
    parser.add_argument("--no-cache", action="store_true")
    parser.add_argument("--json", action="store_true")
    return parser.parse_args(sys.argv[2:])


def main() -> int:
    """The exit status: 0, 1 where no design meets the constraints, 2 for wrong input."""
    if sys.argv[1:2] != ["optimise"]:
        print("usage: python -m nailnoise optimise DESIGN --vary KEY=LOW..HIGH ...", file=sys.stderr)
        return 2
    given = _arguments()

    def progress(_: str, done: int, of: int) -> None:
        if sys.stderr.isatty():
            print(f"\r{done} of {of} designs", end="\n" if done == of else "", file=sys.stderr, flush=True)

    try:
        if given.trials < 1:
            raise ValueError("an optimisation needs at least one trial")
        found = optimise(
            load(given.design, dict(given.set)),
            dict(given.vary),
            minimise=given.minimise,
            subject_to=given.subject_to or ("outcome == drives",),
            pareto=given.pareto,
            trials=given.trials,
            seed=given.seed,
            cache=False if given.no_cache else None,
            progress=progress,
        )
    except NailnoiseError as error:
        print(f"error: {error}" + (f"\n  help: {error.help}" if error.help else ""), file=sys.stderr)
        return error.status
    except (ValueError, ModuleNotFoundError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    files = found.write(given.out or Path("out") / found.design.name / "optimised")
    if given.json:
        rows = [{"values": own.values, "figures": own.figures, "feasible": own.feasible, "refused": own.refused} for own in found.trials]
        designs = [{"file": str(file), "values": own.values, "figures": own.figures} for file, own in zip(files, found.front)]
        print(json.dumps({"schema": "nailnoise-optimise/1", "designs": designs, "trials": rows}, indent=2))
    else:
        print(found)
        for file in files:
            print(f"  {file}")
        if files:
            print(f"\n  `nailnoise run {files[0]}` computes the best in full; `nailnoise compare --draws` says how sure the change is")
    return 0 if files else 1


if __name__ == "__main__":
    sys.exit(main())
