"""Writes the same table as Parquet in each packing: python make_parquet.py

polars.parquet is what polars 2 makes by default, which packs with zstd; the others are of pyarrow 26 and named by their packing.
pyarrow's lz4 is the one that Parquet calls LZ4_RAW.
"""

import math

import polars
import pyarrow
import pyarrow.parquet

ROWS = 200
columns = {
    "t_s": [0.001 * row for row in range(ROWS)],
    "position_rad": [math.sin(0.005 * row) for row in range(ROWS)],
    "torque_cmd_nm": [0.5 * math.cos(0.005 * row) for row in range(ROWS)],
    "step": [row // 50 for row in range(ROWS)],
    "note": ["rest" if row < 50 else "move" for row in range(ROWS)],
}
for packing in ["none", "snappy", "gzip", "lz4", "zstd", "brotli"]:
    pyarrow.parquet.write_table(pyarrow.table(columns), f"{packing}.parquet", compression=packing)
polars.DataFrame(columns).write_parquet("polars.parquet")
# A column that no recording has, with nothing in half of its rows, as an event log joined to the samples leaves it.
notes = ["rest" if row < 50 else None for row in range(ROWS)]
pyarrow.parquet.write_table(pyarrow.table({**columns, "note": notes}), "nulls.parquet", compression="none")
