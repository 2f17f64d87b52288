"""The commands."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Literal, Protocol

from . import _servo_lab
from ._servo_lab import Table
from .answer import Diagnosis, diagnosis, table

Path = str | os.PathLike[str]


class ArrowTable(Protocol):
    """Whatever offers an Arrow stream, as data frames of pandas from 2.2 and of polars, and tables of pyarrow do."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """The stream in a capsule."""
        ...


Recording = Path | ArrowTable
Recordings = Mapping[str, Recording] | Iterable[Recording]
"""Paths and tables; a mapping gives tables the names by which the answer calls them, otherwise they are ``recording 1`` and so on."""


def _named(recordings: Recordings, called: str) -> list[tuple[str, Recording]]:
    if isinstance(recordings, Mapping):
        return list(recordings.items())
    if isinstance(recordings, (str, os.PathLike)) or hasattr(recordings, "__arrow_c_stream__"):
        raise TypeError(f"{called}s: a list or a mapping of recordings is expected, not one recording")
    return [(f"{called} {number}", one) for number, one in enumerate(recordings, 1)]


def diagnose(
    machine: Path,
    recordings: Recordings,
    holdout: Recordings = (),
    *,
    only: Sequence[str] = (),
    without: Sequence[str] = (),
    jobs: int | None = None,
    page: bool = False,
) -> Diagnosis:
    """Find what the model leaves out of the recordings, with its parameters, or that they cannot tell: ``servo-lab diagnose``.

    ``machine`` is the machine file of the nominal model, with a ``[columns]`` section where columns have other names or units than
    the format. Recordings of ``holdout`` are only predicted; without one, blocks of the others are held out. ``only`` and ``without``
    restrict which effects may be named. ``jobs`` is the number of threads, as many as there are cores where it is None. ``page``
    also makes the page of ``--html``.
    """
    done = _servo_lab.diagnose(
        machine,
        _named(recordings, "recording"),
        _named(holdout, "held-out recording"),
        list(only),
        list(without),
        jobs,
        page,
    )
    return diagnosis(
        done.json,
        summary=done.summary,
        improved_machine=done.improved_machine,
        reference_csv=done.reference_csv,
        page=done.page,
    )


def _flags(values: Mapping[str, object]) -> list[str]:
    """Keyword arguments as the flags of the command; those that are None are left to its defaults."""
    words = []
    for name, value in values.items():
        flag = "--" + name.replace("_", "-")
        if value is True:
            words.append(flag)
        elif value is not None and value is not False:
            words.append(f"{flag}={os.fspath(value) if isinstance(value, os.PathLike) else value}")
    return words


@dataclass(frozen=True)
class Simulation:
    """A run of the closed loop."""

    recording: Table
    """As the drive would have logged it; :func:`diagnose`, pandas, polars and pyarrow take it."""
    summary: str
    """What the command prints."""
    svg: str = field(repr=False)
    """The picture of ``--plot``."""

    def __str__(self) -> str:
        return self.summary

    def _repr_html_(self) -> str:
        return f"{self.svg}<pre>{escape(self.summary)}</pre>"


def simulate(
    scenario: Literal["step", "steps", "multisine", "chirp", "ramp", "disturbance"] | None = None,
    *,
    machine: Path | None = None,
    reference: Path | None = None,
    fluid: Literal["none", "e", "q"] | None = None,
    dead_time_ms: float | None = None,
    lag_ms: float | None = None,
    as_printed: bool = False,
    drive_delay_ms: float | None = None,
    duration_s: float | None = None,
    amplitude_deg: float | None = None,
    dwell_s: float | None = None,
    low_hz: float | None = None,
    high_hz: float | None = None,
    tones: int | None = None,
    speed_rad_s: float | None = None,
    disturbance: Sequence[tuple[float, float, float]] = (),
    sensor_noise_rad: float | None = None,
    torque_noise_nm: float | None = None,
    seed: int | None = None,
    true_speed: bool = False,
    hold: bool = False,
) -> Simulation:
    """Run the closed loop of the flashed control law and the simulated plant: ``servo-lab simulate``.

    The arguments are the flags of the command (``servo-lab simulate --help``); None is its default. Each of ``disturbance`` is a push
    from outside: start s, duration s, torque N m.
    """
    given = dict(locals())
    pushes = [f"--disturbance={','.join(map(repr, push))}" for push in given.pop("disturbance")]
    first = [given.pop("scenario")] if scenario else []
    given.pop("scenario", None)
    recording, summary, svg = _servo_lab.simulate([*first, *pushes, *_flags(given)])
    return Simulation(recording, summary, svg)


@dataclass(frozen=True)
class Window:
    """What a model leaves of windows of one length."""

    horizon_s: float
    rms: float
    """rad (m)."""


@dataclass(frozen=True)
class Beside:
    """A recording beside a model."""

    name: str
    noise: float
    """Of the sensor: standard deviation of one sample, rad (m)."""
    nominal: tuple[Window, ...]
    improved: tuple[Window, ...] | None
    """None without an improved model."""
    summary: str
    """What the command prints."""
    svg: str = field(repr=False)
    """The picture that the command writes."""

    def _repr_html_(self) -> str:
        return f"{self.svg}<pre>{escape(self.summary)}</pre>"


@dataclass(frozen=True)
class Comparison:
    """Recordings beside a model."""

    recordings: tuple[Beside, ...]
    warnings: tuple[str, ...]

    def __str__(self) -> str:
        return "".join(f"warning: {warning}\n" for warning in self.warnings) + "".join(
            one.summary for one in self.recordings
        )

    def _repr_html_(self) -> str:
        warnings = "".join(f"<p>Warning: {escape(warning)}</p>" for warning in self.warnings)
        return warnings + "".join(one._repr_html_() for one in self.recordings)


def compare(machine: Path, recordings: Recordings, *, improved: Path | None = None) -> Comparison:
    """Drive the model with the recorded commands and show where the position disagrees: ``servo-lab compare``.

    ``improved`` is the machine file of an improved model, drawn and told beside the other.
    """

    def windows(given: list[tuple[float, float]]) -> tuple[Window, ...]:
        return tuple(Window(horizon_s, rms) for horizon_s, rms in given)

    def one(done: _servo_lab.Beside) -> Beside:
        improved = None if done.improved is None else windows(done.improved)
        return Beside(done.name, done.noise, windows(done.nominal), improved, done.summary, done.svg)

    warnings, all_done = _servo_lab.compare(machine, _named(recordings, "recording"), improved)
    return Comparison(tuple(map(one, all_done)), tuple(warnings))


@dataclass(frozen=True)
class Tuning:
    """Gains that keep margins over the uncertainty of every delay, and settle fast."""

    k_p_nm_rad: float
    k_d_nm_s_rad: float
    summary: str
    """What the command prints."""
    machine: str
    """The machine file with these gains."""
    svg: str = field(repr=False)
    """The picture of the trade-off."""

    def __str__(self) -> str:
        return self.summary

    def _repr_html_(self) -> str:
        gains = [["k_p", f"{self.k_p_nm_rad:.4g}", "N m/rad"], ["k_d", f"{self.k_d_nm_s_rad:.4g}", "N m s/rad"]]
        return table(["gain", "value", "unit"], gains) + f"{self.svg}<pre>{escape(self.summary)}</pre>"


def tune(
    *,
    machine: Path | None = None,
    fluid: Literal["none", "e", "q"] | None = None,
    dead_time_ms: float | None = None,
    lag_ms: float | None = None,
    as_printed: bool = False,
    drive_delay_ms: float | None = None,
    phase_margin_deg: float | None = None,
    gain_margin: float | None = None,
    delay_margin: float | None = None,
    uncertainty_percent: float | None = None,
    q1: float | None = None,
    step_deg: float | None = None,
    small_mrad: float | None = None,
    tolerance_mrad: float | None = None,
    overshoot_percent: float | None = None,
) -> Tuning:
    """Find gains that keep margins over the uncertainty of every delay, and settle fast: ``servo-lab tune``.

    The arguments are the flags of the command (``servo-lab tune --help``); None is its default.
    """
    k_p_nm_rad, k_d_nm_s_rad, summary, tuned, svg = _servo_lab.tune(_flags(locals()))
    return Tuning(k_p_nm_rad, k_d_nm_s_rad, summary, tuned, svg)
