"""What commands of nailnoise call: ``study-on`` and ``sweep-on``, which compute on a cluster of Dask."""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
import traceback

from . import Design, NailnoiseError, load


def _pair(text: str) -> tuple[str, str]:
    key, found, value = text.partition("=")
    if not found or not key.strip() or not value.strip():
        raise argparse.ArgumentTypeError(f"`{text}` is no KEY=VALUES")
    return key.strip(), value.strip()


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
    parser.add_argument("--point", metavar="KEY = VALUE", type=_pair, nargs="+", action="append", default=[], help="one point without a grid")
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
                cluster.levels(_points(design, given.vary) if given.vary else _single(design, given.point))
    except (NailnoiseError, ValueError, RuntimeError, OSError) as error:
        return _refused(error)
    return 0


def _single(design: Design, points: list[list[tuple[str, str]]]) -> list[Design]:
    """The designs of points, without values that are none: the command itself says why."""
    designs = []
    for point in points:
        with contextlib.suppress(NailnoiseError):
            # Words are in the quotes of a design file.
            designs.append(design.with_({key: value.strip('"') for key, value in point}))
    return designs


def main() -> int:
    """The exit status: 0, 2 for wrong input, 101 for a fault, 130 after an interruption."""
    try:
        return _main()
    except KeyboardInterrupt:
        print("interrupted: what was computed for later runs is kept", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader has closed the pipe. Python would report this again at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception:
        # Status 1, which Python would return, means a limit that is not met.
        traceback.print_exc()
        print("error: this is a fault of nailnoise\n  help: report the command and the design", file=sys.stderr)
        return 101


def _main() -> int:
    command = sys.argv[1] if len(sys.argv) > 1 else ""
    if command not in ("study-on", "sweep-on"):
        print("usage: python -m nailnoise study-on|sweep-on DESIGN --scheduler ADDRESS --folder DIR ...", file=sys.stderr)
        return 2
    return _on_cluster(command)


if __name__ == "__main__":
    sys.exit(main())
