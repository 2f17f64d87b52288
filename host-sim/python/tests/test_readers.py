"""What the command line writes, read by the readers of others."""

import csv
import io
import json
from pathlib import Path

import mcap.records
import pyarrow
import pyarrow.parquet
import pytest
from conftest import run
from mcap.reader import make_reader
from mcap.stream_reader import CRCValidationError


@pytest.fixture(scope="module")
def columns(folder: Path) -> dict[str, list[float | str]]:
    """The columns of the CSV; numbers as Python reads them."""

    def cell(text: str) -> float | str:
        try:
            return float(text)
        except ValueError:
            return text

    rows = list(csv.reader(io.StringIO("".join(line for line in open(folder / "a.csv") if not line.startswith("#")))))
    return {name: [cell(row[index]) for row in rows[1:]] for index, name in enumerate(rows[0])}


def messages(data: bytes) -> list[tuple[mcap.records.Schema, mcap.records.Channel, mcap.records.Message]]:
    """The messages by Foxglove's reader, which checks the sums of the chunks."""
    return list(make_reader(io.BytesIO(data), validate_crcs=True).iter_messages())


def test_foxgloves_own_reader_takes_what_convert_writes(folder: Path, columns: dict[str, list[float | str]]) -> None:
    run(folder, "convert", "a.csv", "-o", "a.mcap")
    data = (folder / "a.mcap").read_bytes()
    rows = len(columns["t_s"])
    summary = make_reader(io.BytesIO(data), validate_crcs=True).get_summary()
    assert summary is not None and summary.statistics is not None
    assert summary.statistics.message_count == rows
    assert [channel.topic for channel in summary.channels.values()] == ["recording"]
    [schema] = summary.schemas.values()
    assert schema.encoding == "jsonschema"
    properties = json.loads(schema.data)["properties"]
    assert set(properties) == set(columns)
    assert (properties["t_s"]["type"], properties["mode"]["type"]) == ("number", "string")
    read = messages(data)
    assert len(read) == rows
    assert {channel.message_encoding for _, channel, _ in read} == {"json"}
    begin_s = columns["t_s"][0]
    for row, (_, _, message) in enumerate(read):
        assert json.loads(message.data) == {name: cells[row] for name, cells in columns.items()}
        assert message.log_time == round(1e9 * (columns["t_s"][row] - begin_s))  # type: ignore[operator]


def test_a_bit_that_fell_over_is_seen_by_that_reader(folder: Path) -> None:
    run(folder, "convert", "a.csv", "-o", "broken.mcap")
    data = bytearray((folder / "broken.mcap").read_bytes())
    assert messages(bytes(data))
    # In the first message, where a number stands.
    at = data.index(b'"position_rad"') + 16
    data[at] ^= 1
    with pytest.raises(CRCValidationError):
        messages(bytes(data))


def test_arrow_reads_the_parquet(folder: Path, columns: dict[str, list[float | str]]) -> None:
    run(folder, "convert", "a.csv", "-o", "again.parquet")
    table = pyarrow.parquet.read_table(folder / "again.parquet")
    assert table.schema.field("t_s").type == pyarrow.float64()
    assert table.column_names == list(columns)
    assert table.to_pydict() == columns
