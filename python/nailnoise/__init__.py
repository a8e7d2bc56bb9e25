"""Predicts and ranks the sound power of a pneumatic nailer's sources from its design.

    >>> import nailnoise as nn
    >>> design = nn.load("designs/n80cb.toml")
    >>> nn.run(design)
    >>> nn.run(design.with_({"supply.pressure": "80 psig"}))

Levels are A-weighted single-event sound power levels in dB re 1 pW s; all other numbers are in SI units. Tables are pandas
data frames where pandas is installed, else lists of dictionaries; ``to_xarray()`` gives arrays with coordinates.
"""

from ._blocks import (
    Elastic,
    ExhaustLevels,
    MeshModes,
    SignalLevels,
    exhaust_levels,
    mesh_modes,
    radiated_power,
    signal_levels,
)
from ._calibrate import Calibration, calibrate
from ._design import Design, load
from ._draws import shots, study, study_task, sweep
from ._measure import Measurement, WrappingTest, measure, test_energies
from ._native import NailnoiseError, __version__
from ._optimise import Optimisation, optimise
from ._penetration import Penetration, PenetrationFit, fit_penetration, penetration, penetration_names
from ._results import Comparison, Cycle, Modes, Run, Shots, Study, Sweep
from ._trial import Proposal
from ._work import compare, cycle, modes, run

__all__ = [
    "Calibration",
    "Comparison",
    "Cycle",
    "Design",
    "Elastic",
    "ExhaustLevels",
    "Measurement",
    "MeshModes",
    "Modes",
    "NailnoiseError",
    "Optimisation",
    "Penetration",
    "PenetrationFit",
    "Proposal",
    "Run",
    "Shots",
    "SignalLevels",
    "Study",
    "Sweep",
    "WrappingTest",
    "__version__",
    "calibrate",
    "compare",
    "cycle",
    "exhaust_levels",
    "fit_penetration",
    "load",
    "measure",
    "mesh_modes",
    "modes",
    "optimise",
    "penetration",
    "penetration_names",
    "radiated_power",
    "run",
    "shots",
    "signal_levels",
    "study",
    "study_task",
    "sweep",
    "test_energies",
]
