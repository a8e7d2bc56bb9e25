"""What commands of nailnoise call: ``optimise``, and ``study-on`` and ``sweep-on``, which compute on a cluster of Dask."""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import sys
import traceback
from pathlib import Path

from . import Design, NailnoiseError, load, optimise


def _pair(text: str) -> tuple[str, str]:
    key, found, value = text.partition("=")
    if not found or not key.strip() or not value.strip():
        raise argparse.ArgumentTypeError(f"`{text}` is no KEY=VALUES")
    return key.strip(), value.strip()


def _threads(text: str) -> int:
    if not (text.isdecimal() and 1 <= int(text) <= 1024):
        raise argparse.ArgumentTypeError(f"`{text}` is no number of threads from 1 to 1024")
    return int(text)


def _varied(pairs: list[tuple[str, str]]) -> dict[str, str]:
    """Ranges by key. The last of two for one key would replace the first without a word."""
    ranges = dict(pairs)
    if len(ranges) < len(pairs):
        twice = next(key for place, (key, _) in enumerate(pairs) if any(key == before for before, _ in pairs[:place]))
        raise ValueError(f"--vary gives `{twice}` twice; give all its values at once: {twice}=LOW..HIGH or {twice}=A,B,C")
    return ranges


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
    parser.add_argument("--scheduler", metavar="ADDRESS", help="compute the designs on a cluster of Dask")
    parser.add_argument("--batch", metavar="N", type=int, help="designs at a time on the cluster [default: its threads]")
    parser.add_argument("--store", metavar="DIR", help="a folder that the workers of the cluster share")
    parser.add_argument("--json", action="store_true", help="print exactly one JSON value instead of a table")
    parser.add_argument("--threads", metavar="N", type=_threads, help="number of threads; results do not depend on it")
    parser.add_argument("--quiet", action="store_true", help="print no progress")
    return parser.parse_args(sys.argv[2:])


def _progress(what: str, done: int, of: int) -> None:
    if sys.stderr.isatty():
        print(f"\r{done} of {of} {what}", end="\n" if done == of else "", file=sys.stderr, flush=True)


def _refused(error: Exception) -> int:
    """Prints an error as the command does; its exit status."""
    help_ = error.help if isinstance(error, NailnoiseError) else None
    print(f"error: {error}" + (f"\n  help: {help_}" if help_ else ""), file=sys.stderr)
    return error.status if isinstance(error, NailnoiseError) else 2


def _on_cluster(command: str) -> int:
    """Fills the folder of a study or sweep on a cluster; the command that asks for it states the result."""
    parser = argparse.ArgumentParser(f"nailnoise {command}")
    parser.add_argument("design")
    parser.add_argument("--scheduler", required=True)
    parser.add_argument("--folder", required=True, help="where the client collects results")
    parser.add_argument("--shared", action="store_true", help="workers share that folder")
    parser.add_argument("--set", metavar="KEY=VALUE", type=_pair, action="append", default=[])
    parser.add_argument("--draws", type=int, default=256)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--structures", type=int)
    parser.add_argument("--vary", metavar="KEY=VALUES", action="append", default=[])
    given = parser.parse_args(sys.argv[2:])
    from distributed import Client

    from ._cluster import Cluster
    from ._draws import _points

    try:
        design: Design = load(given.design, dict(given.set))
        with Client(given.scheduler, timeout=30) as client:  # type: ignore[no-untyped-call]
            # Workers use separate working folders.
            folder = os.path.abspath(given.folder)
            cluster = Cluster(client, folder if given.shared else None, folder, _progress)
            if command == "study-on":
                cluster.study(design, given.draws, given.seed, given.structures, None)
            else:
                cluster.levels(_points(design, given.vary))
    except (NailnoiseError, ValueError, RuntimeError, OSError) as error:
        return _refused(error)
    return 0


def main() -> int:
    """The exit status: 0, 1 where no design meets the constraints, 2 for wrong input, 101 for a fault, 130 after an interruption."""
    try:
        return _main()
    except KeyboardInterrupt:
        print("interrupted: what was computed for later runs is kept", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # A reader that has seen enough; Python would complain about it once more when it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception:
        # 1, the status of Python, would say that no design meets the constraints.
        traceback.print_exc()
        print("error: this is a fault of nailnoise\n  help: report the command and the design", file=sys.stderr)
        return 101


def _main() -> int:
    command = sys.argv[1] if len(sys.argv) > 1 else ""
    if command in ("study-on", "sweep-on"):
        return _on_cluster(command)
    if command != "optimise":
        print("usage: python -m nailnoise optimise DESIGN --vary KEY=LOW..HIGH ...", file=sys.stderr)
        return 2
    return _optimise(_arguments())


def _optimise(given: argparse.Namespace) -> int:
    try:
        if given.trials < 1:
            raise ValueError("an optimisation needs at least one trial")
        vary = _varied(given.vary)
        if given.threads:
            # The pool of threads reads it when it is first used.
            os.environ["RAYON_NUM_THREADS"] = str(given.threads)
        with contextlib.ExitStack() as stack:
            client = None
            if given.scheduler:
                from distributed import Client

                client = stack.enter_context(Client(given.scheduler, timeout=30))  # type: ignore[no-untyped-call]
            found = optimise(
                load(given.design, dict(given.set)),
                vary,
                minimise=given.minimise,
                subject_to=given.subject_to or ("outcome == drives",),
                pareto=given.pareto,
                trials=given.trials,
                seed=given.seed,
                cache=False if given.no_cache else None,
                client=client,
                store=given.store,
                batch=given.batch,
                progress=None if given.quiet else _progress,
            )
    except (NailnoiseError, ValueError, OSError, ModuleNotFoundError) as error:
        return _refused(error)
    try:
        files = found.write(given.out or Path("out") / found.design.name / "optimised")
    except OSError as error:
        return _refused(error)
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
