"""The package is typed, strictly, stubs of the native part included."""

import subprocess
import sys
from pathlib import Path

import servo_lab
from servo_lab import _servo_lab


def test_mypy_finds_nothing() -> None:
    here = Path(__file__).parents[1]
    done = subprocess.run([sys.executable, "-m", "mypy"], cwd=here, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_the_stubs_name_what_is_there() -> None:
    stubs = Path(__file__).parents[1].joinpath("servo_lab/_servo_lab.pyi").read_text()
    for name in ["ServoLabError", "Table", "diagnose", "simulate", "compare", "tune", "manifest", "fleet"]:
        assert hasattr(_servo_lab, name) and f" {name}(" in stubs or f"class {name}:" in stubs, name
    assert all(hasattr(servo_lab, name) for name in servo_lab.__all__)
