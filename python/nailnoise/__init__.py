"""Predicts and ranks the sound power of a pneumatic nailer's sources from its design.

    >>> import nailnoise as nn
    >>> design = nn.load("designs/n80cb.toml")
    >>> nn.run(design)
    >>> nn.run(design.with_({"supply.pressure": "80 psig"}))

Levels are A-weighted single-event sound power levels in dB re 1 pW s; all other numbers are in SI units. Tables are pandas
data frames where pandas is installed, else lists of dictionaries.
"""

from ._design import Design, load
from ._native import NailnoiseError, __version__, radiated_power
from ._results import Comparison, Cycle, Modes, Run, Study, Sweep
from ._work import compare, cycle, modes, run, study, study_task, sweep

__all__ = [
    "Comparison",
    "Cycle",
    "Design",
    "Modes",
    "NailnoiseError",
    "Run",
    "Study",
    "Sweep",
    "__version__",
    "compare",
    "cycle",
    "load",
    "modes",
    "radiated_power",
    "run",
    "study",
    "study_task",
    "sweep",
]
