"""Types of the native module. Results are JSON text, histories bytes of 64-bit floats in the order of the machine."""

from collections.abc import Callable
from os import PathLike

__version__: str

Report = Callable[[str, str, int, int], None]

class NailnoiseError(Exception):
    help: str | None
    code: str | None
    file: str | None
    line: int | None
    status: int

class Design:
    @staticmethod
    def load(path: str | PathLike[str], assignments: list[str]) -> Design: ...
    def with_assignments(self, more: list[str]) -> Design: ...
    @property
    def name(self) -> str: ...
    @property
    def digest(self) -> str: ...
    @property
    def path(self) -> str: ...
    @property
    def warnings(self) -> list[str]: ...
    def entries(self) -> str: ...

def run(
    design: Design, cache: str | None, keep: bool, report: Report | None
) -> tuple[str, dict[str, list[bytes]]]: ...
def cycle(design: Design, report: Report | None) -> tuple[str, dict[str, tuple[str, bytes]]]: ...
def modes(design: Design, body: str, cache: str | None, keep: bool, report: Report | None) -> dict[str, object]: ...
def compare(results: list[str]) -> str: ...
def study(
    design: Design,
    draws: int,
    seed: int,
    structures: int | None,
    cache: str | None,
    keep: bool,
    folder: str | None,
    report: Report | None,
) -> tuple[str, str]: ...
def study_task(
    design: Design,
    draws: int,
    seed: int,
    structures: int | None,
    task: tuple[int, int],
    folder: str,
    report: Report | None,
) -> int: ...
def sweep(
    design: Design,
    vary: list[str],
    draws: int | None,
    seed: int,
    cache: str | None,
    keep: bool,
    report: Report | None,
) -> str: ...
def radiated_power(
    points: list[tuple[float, float, float]],
    triangles: list[tuple[int, int, int]],
    velocity: list[float],
    hz: float,
) -> float: ...
