"""What computes: each function releases the interpreter's lock, reports progress, and ends on Ctrl-C."""

from __future__ import annotations

import logging
import os
import warnings
from collections.abc import Callable
from typing import Any

from . import _native
from ._design import Design
from ._results import Comparison, Cycle, Modes, Run

_LOGGER = logging.getLogger("nailnoise")

Cache = str | os.PathLike[str] | bool | None
Progress = Callable[[str, int, int], None]
"""Called with the stage, and items done of how many; ``progress=True`` shows a bar of tqdm instead."""


def _bar() -> Progress:
    """A bar of tqdm, in a notebook or on a terminal."""
    try:
        from tqdm.auto import tqdm  # type: ignore[import-untyped, unused-ignore]
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError("progress=True needs tqdm: pip install tqdm; or give a function(stage, done, of)") from error
    bar: Any = tqdm()

    def show(stage: str, done: int, of: int) -> None:
        bar.set_description(stage, refresh=False)
        bar.total, bar.n = of or None, done
        bar.refresh()

    return show


def _shown(progress: Progress | bool | None) -> Progress | None:
    return _bar() if progress is True else progress or None


def _reporter(progress: Progress | bool | None) -> Callable[[str, str, int, int], None]:
    """Passes remarks to the logger, and stages and counts to ``progress(stage, done, of)``."""
    stage, progress = "", _shown(progress)

    def report(kind: str, text: str, done: int, of: int) -> None:
        nonlocal stage
        if kind == "note":
            _LOGGER.info(text)
            return
        if kind == "stage":
            stage = text
        if progress is not None:
            progress(text or stage, done, of)

    return report


def _cache(cache: Cache) -> tuple[str | None, bool]:
    """A folder and whether anything is kept: None is the user's cache, False is none, a path is that folder."""
    if cache is None or cache is True:
        try:
            _native.cache_folder()
        except _native.NoCacheError as error:
            # Once for each place that asks, by the usual filter of warnings.
            warnings.warn(f"results are not cached: {error}", stacklevel=3)
            return None, False
        return None, True
    if cache is False:
        return None, False
    return os.fspath(cache), True


def run(design: Design, *, cache: Cache = None, progress: Progress | bool | None = None) -> Run:
    """Ranks the sources of a design by their sound power.

    The first run of a design takes minutes. ``cache`` is a folder for results of stages, None for the user's own, or False;
    ``progress(stage, done, of)`` is called as the work goes on, and True shows a bar of tqdm.
    """
    return Run(*_native.run(design._native, *_cache(cache), _reporter(progress)))


def cycle(design: Design) -> Cycle:
    """Computes the nailing cycle alone: pressures, motions, forces and events."""
    return Cycle(design.name, *_native.cycle(design._native, _reporter(None)))


def modes(design: Design, body: str, *, cache: Cache = None, progress: Progress | bool | None = None) -> Modes:
    """Computes the vibration modes of a body: ``workpiece``, ``worktable`` or ``tool``."""
    return Modes(body, _native.modes(design._native, body, *_cache(cache), _reporter(progress)))


def compare(
    *runs: Run | Design,
    draws: int | None = None,
    seed: int = 1,
    structures: int | None = None,
    cache: Cache = None,
    progress: Progress | bool | None = None,
) -> Comparison:
    """Compares runs, or runs designs and compares them; the first is the reference. Equal names are followed by a number.

    With ``draws`` that many shots of all designs are drawn in common, and ``changes`` states how sure each change is; all arguments are
    designs then. ``structures`` draws block, table and tool body, too, a new structure every so many draws.
    """
    if len(runs) < 2:
        raise ValueError("a comparison needs two runs or designs")
    designs = [one for one in runs if isinstance(one, Design)]
    if draws is not None and len(designs) < len(runs):
        raise ValueError("draws are made from the ranges of designs: give designs, not runs")
    done = [run(one, cache=cache, progress=progress) if isinstance(one, Design) else one for one in runs]
    text = _native.compare([one.json for one in done])
    if draws is None:
        return Comparison(text)
    natives = [one._native for one in designs]
    return Comparison(text, _native.compare_draws(natives, draws, seed, structures, *_cache(cache), _reporter(progress)))
