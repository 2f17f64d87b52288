"""Recordings that the command line simulates, and the command line itself."""

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

MACHINE = """\
schema = 1
name = "m"
[axis]
kind = "rotary"
sample_period_s = 1e-3
resolution = 1.3e-5
[plant]
inertia = 0.075
coulomb = 0.763
torque_limit = 30.0
torque_delay_s = 0.005
"""


def binary() -> str:
    """The program that the package is held against; `cargo xtask python` builds it and tells where."""
    default = Path(__file__).parents[3] / "target/release/servo-lab"
    return os.environ.get("SERVO_LAB", str(default))


def run(folder: Path, *words: str) -> str:
    """What the command prints; it must succeed."""
    done = subprocess.run([binary(), *words], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def error(folder: Path, *words: str) -> str:
    """The message of a command that must fail."""
    done = subprocess.run([binary(), *words], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 2, done.stdout
    return done.stderr.removeprefix("error: ").strip()


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two recordings of an axis with more friction than its machine file says, as Parquet and CSV."""
    folder = tmp_path_factory.mktemp("axis")
    (folder / "m.toml").write_text(MACHINE)
    (folder / "real.toml").write_text(MACHINE.replace("0.763", "1.2"))
    simulate = ["simulate", "steps", "--machine", "real.toml", "--duration-s", "1.5", "--dwell-s", "0.3"]
    for seed, name in ("1", "a"), ("2", "b"):
        for kind in "parquet", "csv":
            run(folder, *simulate, "--torque-noise-nm", "0.02", "--seed", seed, "-o", f"{name}.{kind}")
    return folder


@pytest.fixture
def inside(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The same folder, with the test in it."""
    monkeypatch.chdir(folder)
    return folder


Reader = Callable[[Path], object]
