"""What the package computes is what the command line computes, to the byte."""

import dataclasses
import json
import pickle
from pathlib import Path

import pandas
import polars
import pyarrow
import pyarrow.parquet
import pytest
import servo_lab
from conftest import Reader, run

ONLY = ["coulomb_friction", "viscous_friction"]
READERS: list[Reader] = [pandas.read_parquet, polars.read_parquet, pyarrow.parquet.read_table]


def without_provenance(text: str) -> str:
    """The text of the JSON without its first key, byte for byte."""
    before, rest = text.split('  "provenance": {\n', 1)
    return before + rest.split("\n  },\n", 1)[1]


@pytest.fixture(scope="module")
def answer(folder: Path) -> str:
    """The JSON of the command line."""
    run(folder, "diagnose", "--machine", "m.toml", "a.parquet", "--holdout", "b.parquet", "--only", ",".join(ONLY),
        "--json", "answer.json", "--html", "answer.html", "--write-model", "improved.toml")  # fmt: skip
    return (folder / "answer.json").read_text()


@pytest.mark.parametrize("read", READERS)
def test_a_table_in_memory_gives_the_json_of_the_command_line(inside: Path, answer: str, read: Reader) -> None:
    tables = [{name: read(inside / name)} for name in ("a.parquet", "b.parquet")]
    done = servo_lab.diagnose("m.toml", tables[0], tables[1], only=ONLY)
    assert without_provenance(done.json) == without_provenance(answer)


def test_files_give_everything_that_the_command_line_writes(inside: Path, answer: str) -> None:
    done = servo_lab.diagnose(inside / "m.toml", ["a.parquet"], ["b.parquet"], only=ONLY, page=True, jobs=1)
    assert without_provenance(done.json) == without_provenance(answer)
    assert done.improved_machine == (inside / "improved.toml").read_text()
    # How to reproduce it is on the page, and the command is another one.
    page = (inside / "answer.html").read_text()
    assert done.page is not None
    assert done.page.split("<main>")[0] == page.split("<main>")[0]
    assert done.page.split('id="plot">')[1] == page.split('id="plot">')[1]
    # The dataclass holds what the JSON says, and goes where pickle takes it.
    read = json.loads(done.json)
    assert (done.verdict, done.effects[0].id) == (read["verdict"], read["effects"][0]["id"])
    assert [dataclasses.asdict(value) for value in done.effects[0].parameters] == read["effects"][0]["parameters"]
    assert pickle.loads(pickle.dumps(done)) == done
    assert done.effects[0].id in done._repr_html_() and done.effects[0].text in str(done)


def test_text_columns_and_whole_numbers_of_any_kind_are_read(inside: Path) -> None:
    table = pandas.read_parquet("a.parquet")
    table["mode"] = table["mode"].astype("category")
    table["seq"] = table["seq"].astype("int32")
    table["humidity"] = pandas.Timestamp("2026-03-31")
    recordings = {"a.parquet": table}
    done, plain = (servo_lab.compare("m.toml", given) for given in (recordings, ["a.parquet"]))
    assert done.recordings[0].nominal == plain.recordings[0].nominal
    assert "column `humidity` is not one of the format and is not used" in str(done)


def test_compare_prints_and_draws_what_the_command_does(inside: Path, answer: str) -> None:
    printed = run(inside, "compare", "--machine", "m.toml", "--improved", "improved.toml", "a.parquet")
    done = servo_lab.compare("m.toml", {"a.parquet": polars.read_parquet("a.parquet")}, improved="improved.toml")
    assert str(done) == "".join(line for line in printed.splitlines(True) if not line.startswith("wrote "))
    assert done.recordings[0].svg == (inside / "compare-a.svg").read_text()
    nominal, improved = done.recordings[0].nominal[0], (done.recordings[0].improved or ())[0]
    assert improved.rms < 0.5 * nominal.rms and nominal.horizon_s == 0.05


def test_simulate_gives_the_recording_of_the_command(inside: Path) -> None:
    words = ["--duration-s", "0.5", "--disturbance", "0.1,0.05,8", "--sensor-noise-rad", "1e-5", "--hold"]
    printed = run(inside, "simulate", "ramp", *words, "-o", "ramp.parquet")
    done = servo_lab.simulate("ramp", duration_s=0.5, disturbance=[(0.1, 0.05, 8.0)], sensor_noise_rad=1e-5, hold=True)
    assert printed.endswith(str(done))
    table, file = pyarrow.table(done.recording), pyarrow.parquet.read_table("ramp.parquet")
    assert table.to_pydict() == file.to_pydict()
    assert polars.DataFrame(done.recording).rows() == polars.read_parquet("ramp.parquet").rows()
    assert pandas.DataFrame.from_arrow(done.recording).equals(pandas.read_parquet("ramp.parquet"))
    assert len(done.recording) == len(file) and done.recording.column_names == file.column_names


def test_tune_gives_the_machine_of_the_command(inside: Path) -> None:
    printed = run(inside, "tune", "--machine", "m.toml", "--uncertainty-percent", "20", "--out", "tuned")
    done = servo_lab.tune(machine="m.toml", uncertainty_percent=20)
    assert printed.startswith(done.summary) and done.machine == (inside / "tuned/tuned.toml").read_text()
    assert done.svg == (inside / "tuned/tune.svg").read_text()
    assert done.k_p_nm_rad > 0 and f"{done.k_p_nm_rad:.4g}" in done._repr_html_()
