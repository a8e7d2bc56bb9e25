"""Types of the native module. Results are JSON text, histories bytes of 64-bit floats in the order of the machine."""

from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

__version__: str

#: Candidates of a block.
CANDIDATES: int

#: Names of the sources, in the order of every table.
SOURCES: list[str]

#: Names of the sources that a wrapping test separates.
ROLES: list[str]

Report = Callable[[str, str, int, int], None]
Charts = list[tuple[str, str]]
Bands = list[tuple[float, float | None, float | None]]

def command(arguments: Sequence[str]) -> int:
    """Runs a command line; returns its exit status."""

class NailnoiseError(Exception):
    help: str | None
    code: str | None
    file: str | None
    line: int | None
    key: str | None
    status: int

class NoCacheError(NailnoiseError): ...

class Design:
    @staticmethod
    def load(path: str | PathLike[str], assignments: list[str]) -> Design: ...
    def with_assignments(self, more: list[str]) -> Design: ...
    @property
    def name(self) -> str: ...
    @property
    def digest(self) -> str: ...
    @property
    def path(self) -> Path: ...
    @property
    def warnings(self) -> list[str]: ...
    def files(self) -> list[Path]: ...
    def entries(self) -> str: ...
    def drawn_derived(self) -> str: ...

class Candidates:
    @staticmethod
    def of_study(design: Design, seed: int, structures: bool) -> Candidates: ...
    @staticmethod
    def of_shots(design: Design, seed: int) -> Candidates: ...
    def outcomes(self, block: int, folder: str) -> tuple[int, list[str]]: ...

class CalibrationWorker:
    def __init__(self, design: Design, measured: str | PathLike[str], draws: int, seed: int) -> None: ...
    def result(self, task: bytes) -> bytes: ...

def cache_folder() -> Path: ...
def run(
    design: Design, cache: str | None, keep: bool, report: Report | None
) -> tuple[str, dict[str, list[bytes]], Charts]: ...
def cycle(design: Design, report: Report | None) -> tuple[str, dict[str, tuple[str, bytes]], Charts]: ...
def modes(design: Design, body: str, cache: str | None, keep: bool, report: Report | None) -> dict[str, Any]: ...
def compare(results: list[str]) -> str: ...
def compare_draws(
    designs: list[Design],
    draws: int,
    seed: int,
    structures: int | None,
    cache: str | None,
    keep: bool,
    report: Report | None,
) -> str: ...
def study(
    design: Design,
    draws: int,
    seed: int,
    structures: int | None,
    cache: str | None,
    keep: bool,
    folder: str | None,
    report: Report | None,
) -> tuple[str, str, Charts]: ...
def shots(
    design: Design, draws: int, seed: int, cache: str | None, keep: bool, report: Report | None
) -> str: ...
def sweep(
    design: Design,
    vary: list[str],
    draws: int | None,
    seed: int,
    cache: str | None,
    keep: bool,
    report: Report | None,
) -> tuple[str, Charts]: ...
def axis_values(vary: list[str]) -> list[tuple[str, list[str]]]: ...
def study_task(
    design: Design,
    draws: int,
    seed: int,
    structures: int | None,
    task: tuple[int, int],
    screened: bool,
    folder: str,
    report: Report | None,
) -> tuple[int, list[str]]: ...
def levels_task(design: Design, folder: str) -> list[str]: ...
def structures(design: Design) -> str: ...
def calibrate(
    design: Design,
    measured: str | None,
    draws: int,
    moves: int,
    seed: int,
    hold_out: list[str],
    conflict: str,
    next: bool,
    levels: int,
    redraw: list[str],
    folder: str,
    cache: str | None,
    keep: bool,
    shared: str | None,
    report: Report | None,
    tasks: Callable[[list[bytes]], list[bytes]] | None,
    workers: int,
) -> tuple[str, str, str, str, Charts]: ...
def measurement_files(design: Design, measured: str | PathLike[str]) -> list[Path]: ...
def measure(
    manifest: str, reading: str, paired: bool, total_less_residual: bool, report: Report | None
) -> tuple[str, Charts]: ...
def test_energies(
    design: Design, perfect_wraps: bool, cache: str | None, keep: bool, report: Report | None
) -> str: ...
def penetration_names() -> tuple[list[str], list[str], list[str]]: ...
def penetration_curve(
    law: str | None, table: str | None, wood: str, nail: str, speed: float, depths: list[float] | None
) -> dict[str, Any]: ...
def fit_penetration(
    files: list[str],
    form: str | None,
    method: str | None,
    reduce: bool,
    leave: str | None,
    split: bool,
    start: float | None,
    rate: str | None,
    friction_share: float | None,
    extrapolate: bool,
    report: Report | None,
) -> dict[str, Any]: ...
def radiated_power(
    points: Sequence[tuple[float, float, float]],
    triangles: Sequence[tuple[int, int, int]],
    velocity: Sequence[float],
    hz: float,
) -> float: ...
def mesh_modes(
    nodes: Sequence[tuple[float, float, float]],
    elements: Sequence[Sequence[int]],
    constants: tuple[float, float, float, float, float, float, float, float, float],
    density: float,
    top_hz: float,
    held: Sequence[int],
) -> dict[str, Any]: ...
def exhaust_levels(
    sample_interval: float,
    mass_flow: Sequence[float],
    pressure: Sequence[float],
    temperature: Sequence[float],
    holes: tuple[int, float, float, float | None],
    air: tuple[float, float],
    range_hz: tuple[float, float],
) -> dict[str, Any]: ...
def signal_levels(pressure: Sequence[float], sample_rate: float) -> dict[str, Any]: ...
