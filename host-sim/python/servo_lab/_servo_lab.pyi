"""The native part of the package."""

from os import PathLike
from typing import Any, final

class ServoLabError(ValueError):
    """Why a command stopped, in the words of the command line."""

@final
class Table:
    """A table that every reader of Arrow takes without a copy."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...
    @property
    def column_names(self) -> list[str]: ...
    def __len__(self) -> int: ...

@final
class Diagnosed:
    json: str
    summary: str
    improved_machine: str
    reference_csv: str | None
    page: str | None

@final
class Beside:
    name: str
    summary: str
    svg: str
    noise: float
    nominal: list[tuple[float, float]]
    improved: list[tuple[float, float]] | None

_Path = str | PathLike[str]
_Row = tuple[int, str, str, str, str, str]

def diagnose(
    machine: _Path,
    recordings: list[tuple[str, Any]],
    holdout: list[tuple[str, Any]],
    only: list[str],
    without: list[str],
    jobs: int | None,
    page: bool,
) -> Diagnosed: ...
def simulate(words: list[str]) -> tuple[Table, str, str]: ...
def compare(
    machine: _Path, recordings: list[tuple[str, Any]], improved: _Path | None
) -> tuple[list[str], list[Beside]]: ...
def tune(words: list[str]) -> tuple[float, float, str, str, str]: ...
def manifest(file: _Path) -> list[_Row]: ...
def fleet(rows: list[_Row], jobs: int | None) -> Table: ...
