"""The rows of a manifest on a Ray cluster of two workers on this machine, one of them killed midway."""

import os
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import fsspec
import pyarrow
import pyarrow.parquet
import pytest
import servo_lab
from conftest import run

ray = pytest.importorskip("ray")
from ray.cluster_utils import Cluster  # noqa: E402
from servo_lab import ray as servo_ray  # noqa: E402

# More, as 49, show the time of a diagnosis on the cluster rather than that of its start, and of an odd row that nobody shares.
ROWS = int(os.environ.get("FLEET_ROWS", "4"))


@pytest.fixture(scope="module")
def manifest(folder: Path) -> Path:
    """A row for each of two pairs of recordings over and over, and one whose file is not there."""
    rows = [f"m.toml,{'ab'[row % 2]}.parquet,{'ba'[row % 2]}.parquet,2026-03-{row % 28 + 1:02}" for row in range(ROWS)]
    rows[3] = "m.toml,missing.csv,,"
    file = folder / "fleet.csv"
    file.write_text("machine,recordings,holdout,date\n" + "\n".join(rows) + "\n")
    return file


@pytest.fixture(scope="module")
def table(folder: Path, manifest: Path) -> tuple[pyarrow.Table, float]:
    """What `servo-lab fleet` writes, and in how many seconds."""
    begin = time.monotonic()
    # The row without an answer is its exit code.
    with pytest.raises(AssertionError, match="missing.csv"):
        run(folder, "fleet", manifest.name, "-o", "fleet.parquet", "--jobs", "2")
    return pyarrow.parquet.read_table(folder / "fleet.parquet"), time.monotonic() - begin


@pytest.fixture(scope="module")
def cluster() -> Iterator[Cluster]:
    """A head that computes nothing, and two workers of one core."""
    os.environ["RAY_DATA_DISABLE_PROGRESS_BARS"] = "1"
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "include_dashboard": False})
    ray.init(address=cluster.address, log_to_driver=False, configure_logging=False)
    for _ in range(2):
        cluster.add_node(num_cpus=1, object_store_memory=100 << 20)
    cluster.wait_for_nodes()
    yield cluster
    ray.shutdown()
    cluster.shutdown()


def test_the_table_of_a_cluster_is_that_of_one_machine(
    cluster: Cluster, inside: Path, manifest: Path, table: tuple[pyarrow.Table, float], capsys: pytest.CaptureFixture[str]
) -> None:
    expected, alone_s = table
    # Processes start, and import, before the time is taken.
    short = inside / "short.csv"
    short.write_text("".join(manifest.read_text().splitlines(True)[i] for i in (0, 4, 4)))
    assert servo_ray.fleet(short.name)["error"].to_pylist() == ["missing.csv: No such file or directory (os error 2)"] * 2
    begin = time.monotonic()
    rows = servo_ray.fleet(manifest.name)
    ray_s = time.monotonic() - begin
    assert rows.to_pydict().keys() == expected.to_pydict().keys()
    assert rows.schema == servo_ray.SCHEMA
    assert repr(rows.to_pydict()) == repr(expected.to_pydict()), "repr, as NaN is not equal to itself"
    with capsys.disabled():
        done = ROWS - 1
        print(
            f"\n{done} diagnoses on two cores: servo-lab fleet {alone_s:.2f} s, Ray {ray_s:.2f} s; "
            f"per core {done / 2 / alone_s:.2f} and {done / 2 / ray_s:.2f} diagnoses/s ({100 * alone_s / ray_s:.0f} %)"
        )
    # A few rows show how long a cluster takes to begin, and not what a core does.
    assert ROWS < 49 or alone_s / ray_s >= 0.9


def test_a_worker_that_is_killed_midway_changes_nothing(
    cluster: Cluster, inside: Path, manifest: Path, table: tuple[pyarrow.Table, float]
) -> None:
    nodes = list(cluster.worker_nodes)
    assert len(nodes) == 2
    results: list[pyarrow.Table] = []
    thread = threading.Thread(target=lambda: results.append(servo_ray.fleet(manifest.name)))
    thread.start()
    # Midway by the time that all of it takes.
    time.sleep(0.5 * table[1])
    assert thread.is_alive()
    cluster.remove_node(nodes[0], allow_graceful=False)
    # Of a hang, and not of a slow computer.
    thread.join(600)
    assert results, "all rows are diagnosed by the worker that is left"
    assert repr(results[0].to_pydict()) == repr(table[0].to_pydict())
    assert len([node for node in ray.nodes() if node["Alive"]]) == 2, "the head and one worker"


def test_files_behind_urls_are_fetched(manifest: Path, table: tuple[pyarrow.Table, float]) -> None:
    rows = servo_ray.tasks(f"file://{manifest}").slice(2, 2)
    done = servo_ray.diagnose_batch(rows).to_pydict()
    expected = table[0].slice(2, 2).to_pydict()
    missing = f"file://{manifest.parent}/missing.csv"
    assert done.pop("error")[1].startswith(f"{missing}: ") and expected.pop("error")
    assert repr(done) == repr(expected)


def test_rows_of_an_object_store_are_diagnosed_and_what_cannot_be_had_is_their_error(
    manifest: Path, table: tuple[pyarrow.Table, float]
) -> None:
    class Denied(fsspec.AbstractFileSystem):
        protocol = "denied"

        def _open(self, path: str, *_: object, **__: object) -> object:
            raise PermissionError(f"403 Forbidden: {path}")

    fsspec.register_implementation("denied", Denied, clobber=True)
    store = fsspec.filesystem("memory")
    for name in ("m.toml", "a.parquet", "b.parquet"):
        store.pipe(f"/fleet/{name}", (manifest.parent / name).read_bytes())
    rows = [
        "m.toml,a.parquet,b.parquet,2026-03-01",
        "m.toml,denied://bucket/a.parquet,,",
        "m.toml,nowhere://bucket/a.parquet,,",
        "m.toml,a.parquet;gone.parquet,,",
    ]
    store.pipe("/fleet/list.csv", ("machine,recordings,holdout,date\n" + "\n".join(rows) + "\n").encode())
    done = servo_ray.diagnose_batch(servo_ray.tasks("memory://fleet/list.csv"))
    found = done.to_pydict()
    assert found["error"] == [
        "",
        "denied://bucket/a.parquet: PermissionError: 403 Forbidden: bucket/a.parquet",
        "nowhere://bucket/a.parquet: ValueError: Protocol not known: nowhere",
        "memory://fleet/gone.parquet: FileNotFoundError: /fleet/gone.parquet",
    ]
    assert found["verdict"][1:] == [""] * 3
    assert found["answer"][0] == table[0]["answer"][0].as_py(), "the same as of the file"
    with pytest.raises(servo_lab.ServoLabError, match="denied://bucket/list.csv: PermissionError"):
        servo_ray.tasks("denied://bucket/list.csv")
