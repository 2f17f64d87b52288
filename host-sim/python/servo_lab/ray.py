"""The rows of a manifest on a cluster, by Ray Data: the same table as ``servo-lab fleet`` writes.

There is no engine here: Ray schedules the rows, starts those of a machine that is lost again, and collects the table. Needs
``pip install servo_lab[ray]``.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any

import pyarrow as pa

from . import _servo_lab

_TEXTS = ["date", "machine", "recordings", "holdout", "error", "verdict", "effects", "unit", "warnings", "answer", "key"]
_NUMBERS = ["heldout_before_rms", "heldout_after_rms", "heldout_floor_rms", "excess_explained"]
SCHEMA = pa.schema(
    [pa.field("line", pa.uint64(), nullable=False)]
    + [pa.field(name, pa.string(), nullable=False) for name in _TEXTS]
    + [pa.field(name, pa.float64(), nullable=False) for name in _NUMBERS]
)
"""Of the table, as ``docs/fleet.md`` describes it."""

_TASKS = ["line", "machine", "recordings", "holdout", "date", "folder"]
_NAMED = "folder_as_named"


def tasks(manifest: str | os.PathLike[str]) -> pa.Table:
    """The rows of a manifest, CSV or Parquet, each with the folder its files are relative to, absolute and as it was named.

    The manifest may be a URL that fsspec opens (``s3://...``); its files are there too then.
    """
    place = os.fspath(manifest)
    if "://" in place:
        with tempfile.TemporaryDirectory() as near:
            try:
                rows = _servo_lab.manifest(_fetched(place, Path(near)))
            except NotFetched as missing:
                raise _servo_lab.ServoLabError(str(missing)) from missing
        rows = [(*row[:-1], place.rpartition("/")[0]) for row in rows]
    else:
        rows = _servo_lab.manifest(os.path.abspath(place))
    columns = [pa.array(cells) for cells in zip(*[(*row[:-1], os.fspath(row[-1]), os.path.dirname(place)) for row in rows])]
    return pa.table(dict(zip([*_TASKS, _NAMED], columns)))


def diagnose_batch(batch: pa.Table) -> pa.Table:
    """Diagnoses rows of :func:`tasks` on one core, for ``map_batches(diagnose_batch, batch_format="pyarrow", batch_size=1)``.

    What is wrong with a row is in its column ``error``. Files that are URLs are fetched by fsspec; why one cannot be had is there too.
    """
    rows = batch.to_pylist()
    with tempfile.TemporaryDirectory() as near:
        fetched: dict[str, str] = {}
        local = [_local(row, Path(near) / str(index), fetched) for index, row in enumerate(rows)]
        done = pa.table(_servo_lab.fleet([tuple(row[name] for name in _TASKS) for row, _ in local], 1))
    for name in ["machine", "recordings", "holdout"]:
        cells = pa.array([row[name] for row in rows], pa.string())
        done = done.set_column(done.column_names.index(name), SCHEMA.field(name), cells)
    # Messages have the names that the user gave.
    errors = [
        error.replace(f"{row['folder']}/", f"{row[_NAMED]}/" if row[_NAMED] else "")
        for error, row in zip(done["error"].to_pylist(), rows)
    ]
    for file, url in fetched.items():
        errors = [error.replace(file, url) for error in errors]
    errors = [why or error for (_, why), error in zip(local, errors)]
    done = done.set_column(done.column_names.index("error"), SCHEMA.field("error"), pa.array(errors, pa.string()))
    return done.cast(SCHEMA)


def fleet(manifest: str | os.PathLike[str], **options: Any) -> pa.Table:
    """Diagnoses the rows of a manifest on the Ray cluster in use, one core a row, and gives the table in the order of the manifest.

    ``options`` go to ``ray.data.Dataset.map_batches``; the manifest's folder must be the same on every machine, or a URL.
    """
    import ray

    given = tasks(manifest)
    # A block a row: what is lost with a machine is one diagnosis.
    blocks = [given.slice(row, 1) for row in range(given.num_rows)]
    options = {"batch_size": 1, "num_cpus": 1, **options}
    rows = ray.data.from_arrow(blocks).map_batches(diagnose_batch, batch_format="pyarrow", **options)
    done = [batch.cast(SCHEMA) for batch in rows.iter_batches(batch_format="pyarrow", batch_size=None)]
    return pa.concat_tables(done).sort_by("line").combine_chunks()


def _local(row: dict[str, Any], near: Path, fetched: dict[str, str]) -> tuple[dict[str, Any], str]:
    """The row with files that are URLs fetched, and why the first that is not there is not; ``fetched`` tells what they were."""
    why: list[str] = []

    def here(name: str, folder: Path) -> str:
        url = name if "://" in name else f"{row['folder']}/{name}"
        if not name or "://" not in url:
            return name
        try:
            file = _fetched(url, folder)
        except NotFetched as missing:
            why.append(str(missing))
            return name
        fetched[file] = url
        return file

    def all_here(cell: str, part: str) -> str:
        names = [name.strip() for name in cell.split(";") if name.strip()]
        # A folder each: the name stands in the answer, and two files may have one.
        return ";".join(here(name, near / part / str(index)) for index, name in enumerate(names))

    here_now = {
        **row,
        "machine": here(row["machine"], near / "machine"),
        "recordings": all_here(row["recordings"], "recordings"),
        "holdout": all_here(row["holdout"], "holdout"),
    }
    return here_now, "".join(why[:1])


class NotFetched(Exception):
    """A file behind a URL cannot be had; its text says which, and why."""


def _fetched(url: str, folder: Path) -> str:
    """Where the file of a URL is now."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / url.rpartition("/")[2]
    try:
        import fsspec

        with fsspec.open(url, "rb") as source, open(file, "wb") as target:
            while part := source.read(1 << 20):
                target.write(part)
    # Each store has exceptions of its own, for rights, lines and keys; whichever it is, the other rows go on.
    except Exception as error:
        raise NotFetched(f"{url}: {type(error).__name__}: {error}") from error
    return str(file)
