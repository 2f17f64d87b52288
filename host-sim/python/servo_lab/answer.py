"""The answer of a diagnosis, as ``docs/answer.md`` describes its JSON."""

from __future__ import annotations

import json
import types
import typing
from dataclasses import dataclass, field, fields, is_dataclass
from html import escape
from typing import Any, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Interval:
    """A value with its 95 % interval; the unit is the last part of the id, too."""

    id: str
    value: float
    low: float
    high: float
    unit: str
    nominal: float | None = None
    """What the nominal model has in its place; ``None`` where that is nothing."""


@dataclass(frozen=True)
class Evidence:
    """Why an effect is believed."""

    heldout_gain: float
    p_value: float
    excess_explained: float


@dataclass(frozen=True)
class Effect:
    """One effect of the best model."""

    id: str
    text: str
    equivalent: tuple[str, ...]
    parameters: tuple[Interval, ...]
    evidence: Evidence
    nuisances: tuple[str, ...] = ()
    recording: str | None = None


@dataclass(frozen=True)
class Fit:
    """Residuals before and after, root mean square, in ``unit``."""

    before_rms: float
    after_rms: float
    heldout_before_rms: float
    heldout_after_rms: float
    noise_floor_rms: float
    heldout_floor_rms: float
    excess_explained: float
    unit: str
    horizon_s: float


@dataclass(frozen=True)
class Location:
    """A span of time in which the nominal model fails most."""

    recording: str
    start_s: float
    end_s: float
    share: float
    share_low: float
    share_high: float
    text: str


@dataclass(frozen=True)
class Region:
    """A range of one channel of state in which the nominal model fails most."""

    channel: str
    low: float
    high: float
    share: float
    share_low: float
    share_high: float


@dataclass(frozen=True)
class Rejected:
    """An effect that was tried and not taken."""

    id: str
    heldout_gain: float | None
    why: str


@dataclass(frozen=True)
class Experiment:
    """What to record next; the reference itself is :attr:`Diagnosis.reference_csv`."""

    text: str
    separates: tuple[str, ...]
    reference_csv: str | None = None


@dataclass(frozen=True)
class AlternativeValue:
    """A value of an alternative, which has no interval of its own."""

    id: str
    value: float
    unit: str


@dataclass(frozen=True)
class AlternativeEffect:
    """An effect of an alternative."""

    id: str
    parameters: tuple[AlternativeValue, ...]
    recording: str | None = None


@dataclass(frozen=True)
class Alternative:
    """A model that these recordings do not exclude."""

    effects: tuple[AlternativeEffect, ...]


@dataclass(frozen=True)
class Correlation:
    """Correlation of the errors of the values."""

    values: tuple[str, ...]
    matrix: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Predictor:
    """How much of the remainder one channel predicts."""

    channel: str
    share: float
    p_value: float
    effort_rms: float | None


@dataclass(frozen=True)
class Remainder:
    """What the best model leaves and a channel predicts."""

    effort_rms: float
    unit: str
    unnamed: tuple[str, ...]
    predictors: tuple[Predictor, ...]


@dataclass(frozen=True)
class Diagnosis:
    """The answer, and beside it what the command line writes of it."""

    schema: int
    verdict: str
    """``none``, ``named``, ``partial``, ``ambiguous``, ``unknown`` or ``controller``."""
    effects: tuple[Effect, ...]
    fit: Fit
    locations: tuple[Location, ...]
    regions: tuple[Region, ...]
    rejected: tuple[Rejected, ...]
    experiment: Experiment | None
    warnings: tuple[str, ...]
    alternatives: tuple[Alternative, ...] = ()
    correlation: Correlation | None = None
    remainder: Remainder | None = None
    json: str = field(default="", repr=False)
    """What ``servo-lab diagnose --json`` writes."""
    summary: str = field(default="", repr=False)
    """What ``servo-lab diagnose`` prints."""
    improved_machine: str = field(default="", repr=False)
    """The machine file with the effects, as ``--write-model`` writes it."""
    reference_csv: str | None = field(default=None, repr=False)
    """The reference to record next, where the verdict is ``ambiguous``, as ``--experiment`` writes it."""
    page: str | None = field(default=None, repr=False)
    """The page of ``--html``, where it was asked for."""

    def __str__(self) -> str:
        return self.summary

    def _repr_html_(self) -> str:
        rows = [
            [effect.id, value.id, f"{value.value:.4g}", f"{value.low:.4g} to {value.high:.4g}", value.unit]
            for effect in self.effects
            for value in effect.parameters
        ]
        fit = self.fit
        parts = [f"<p>Verdict: <b>{escape(self.verdict)}</b></p>"]
        if rows:
            parts.append(table(["effect", "parameter", "value", "95 %", "unit"], rows))
        parts.append(
            f"<p>Residual on held-out data: {fit.heldout_before_rms:.3g} {escape(fit.unit)} before, "
            f"{fit.heldout_after_rms:.3g} after, {fit.heldout_floor_rms:.3g} is noise.</p>"
        )
        parts += [f"<p>Warning: {escape(warning)}</p>" for warning in self.warnings]
        return "".join(parts)


def table(head: list[str], rows: list[list[str]]) -> str:
    """Rows of texts as a table of HTML."""

    def line(tag: str, cells: list[str]) -> str:
        return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    body = "".join(line("td", row) for row in rows)
    return f"<table><thead>{line('th', head)}</thead><tbody>{body}</tbody></table>"


def diagnosis(text: str, **beside: str | None) -> Diagnosis:
    """The answer of a JSON text, with the texts beside it."""
    return _build(Diagnosis, {**json.loads(text), "json": text, **beside})


def _build(kind: type[T], value: dict[str, Any]) -> T:
    hints = typing.get_type_hints(kind)
    known = {one.name for one in fields(kind) if one.name in value}  # type: ignore[arg-type]
    return kind(**{name: _as(hints[name], value[name]) for name in known})


def _as(hint: Any, value: Any) -> Any:
    """JSON's value as the type of a field: objects as dataclasses, lists as tuples."""
    if value is None:
        return None
    if isinstance(hint, types.UnionType):
        hint = next(one for one in typing.get_args(hint) if one is not type(None))
    if typing.get_origin(hint) is tuple:
        return tuple(_as(typing.get_args(hint)[0], one) for one in value)
    return _build(hint, value) if isinstance(hint, type) and is_dataclass(hint) else value
