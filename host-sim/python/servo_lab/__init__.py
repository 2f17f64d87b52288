"""Find the physics that the model of a servo axis leaves out of its recordings.

The functions are the commands of ``servo-lab``: :func:`diagnose`, :func:`simulate`, :func:`compare`, :func:`tune`; what they compute is
computed by the same code and is the same to the byte. Recordings are paths, or tables of any library that offers Arrow (pandas from
2.2, polars, pyarrow), which are read where they lie. What goes wrong is a :class:`ServoLabError` with the message of the command line.
"""

from ._servo_lab import ServoLabError, Table
from .answer import (
    Alternative,
    AlternativeEffect,
    AlternativeValue,
    Correlation,
    Diagnosis,
    Effect,
    Evidence,
    Experiment,
    Fit,
    Interval,
    Location,
    Predictor,
    Region,
    Rejected,
    Remainder,
)
from .commands import Beside, Comparison, Simulation, Tuning, Window, compare, diagnose, simulate, tune

__all__ = [
    "Alternative",
    "AlternativeEffect",
    "AlternativeValue",
    "Beside",
    "Comparison",
    "Correlation",
    "Diagnosis",
    "Effect",
    "Evidence",
    "Experiment",
    "Fit",
    "Interval",
    "Location",
    "Predictor",
    "Region",
    "Rejected",
    "Remainder",
    "ServoLabError",
    "Simulation",
    "Table",
    "Tuning",
    "Window",
    "compare",
    "diagnose",
    "simulate",
    "tune",
]
