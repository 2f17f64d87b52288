"""Whatever goes wrong is an exception with the message of the command line."""

import _thread
import threading
import time
from pathlib import Path

import pandas
import polars
import pyarrow
import pytest
import servo_lab
from conftest import error


def message(machine: str, recordings: object, **options: object) -> str:
    with pytest.raises(servo_lab.ServoLabError) as raised:
        servo_lab.diagnose(machine, recordings, **options)  # type: ignore[arg-type]
    return str(raised.value)


def test_errors_are_those_of_the_command_line(inside: Path) -> None:
    (inside / "bad.csv").write_text("t_s,position_rad,torque_cmd_nm\n0,0,0\n0,0,0\n")
    for machine, recording in [("no.toml", "a.csv"), ("m.toml", "no.csv"), ("m.toml", "bad.csv"), ("a.csv", "a.csv")]:
        words = ["diagnose", "--machine", machine, recording]
        assert message(machine, [recording]) == error(inside, *words), words
    words = ["diagnose", "--machine", "m.toml", "a.csv", "--only", "coulom_friction"]
    assert message("m.toml", ["a.csv"], only=["coulom_friction"]) == error(inside, *words)
    assert issubclass(servo_lab.ServoLabError, ValueError)


def test_a_bad_cell_of_a_table_is_told_with_column_and_row(inside: Path) -> None:
    table = pandas.read_parquet("a.parquet")
    table.loc[4, "position_rad"] = float("nan")
    assert message("m.toml", [table]) == "recording 1: position_rad: row 5: the cell is empty"
    table = pandas.read_parquet("a.parquet")
    table.loc[7, "t_s"] = 0.0
    assert "t_s: row 8: time runs back" in message("m.toml", {"mon": table})
    frame = polars.read_parquet("a.parquet")
    assert "is `torqe_cmd_nm` meant" in message("m.toml", [frame.rename({"torque_cmd_nm": "torqe_cmd_nm"})])
    texts = frame.with_columns(polars.lit("x").alias("position_rad"))
    assert "position_rad: row 1: `x` is text, not a number" in message("m.toml", [texts])
    flags = pyarrow.table({"t_s": [False], "position_rad": [0.0], "torque_cmd_nm": [0.0]})
    assert "t_s: row 1: holds Boolean" in message("m.toml", [flags])
    assert "few to diagnose" in message("m.toml", [frame.head(10)]) or "short" in message("m.toml", [frame.head(10)])


def test_what_is_no_recording_is_a_type_error(inside: Path) -> None:
    with pytest.raises(TypeError, match="recording 1: .*ndarray is neither the path of a recording nor a table"):
        servo_lab.diagnose("m.toml", [pandas.read_parquet("a.parquet")["t_s"].to_numpy()])
    with pytest.raises(TypeError, match="a list or a mapping of recordings is expected"):
        servo_lab.diagnose("m.toml", "a.csv")  # type: ignore[arg-type]


def test_arguments_are_checked_as_flags_are(inside: Path) -> None:
    with pytest.raises(servo_lab.ServoLabError, match="--phase-margin-deg: 200 is not allowed, 1 to 90 is"):
        servo_lab.tune(phase_margin_deg=200)
    with pytest.raises(servo_lab.ServoLabError, match="invalid value 'jump' for '\\[SCENARIO\\]'"):
        servo_lab.simulate("jump")  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        servo_lab.simulate(durations=1)  # type: ignore[call-arg]


def test_other_threads_of_python_run_meanwhile(inside: Path) -> None:
    done: list[servo_lab.Diagnosis] = []
    thread = threading.Thread(target=lambda: done.append(servo_lab.diagnose("m.toml", ["a.csv"])))
    thread.start()
    beats = 0
    while thread.is_alive():
        time.sleep(0.01)
        beats += 1
    assert done and beats > 3, beats


def test_ctrl_c_ends_the_wait(inside: Path) -> None:
    begin = time.monotonic()
    threading.Timer(0.2, _thread.interrupt_main).start()
    with pytest.raises(KeyboardInterrupt):
        servo_lab.tune()
    assert time.monotonic() - begin < 5.0
