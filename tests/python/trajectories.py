"""Reads the kept trajectories of a sweep, checks them against its table, and prints the number of runs."""

import csv
import sys
from pathlib import Path

import pyarrow.parquet


def main():
    out = Path(sys.argv[1])
    file = pyarrow.parquet.ParquetFile(out / "trajectories.parquet")
    rows = file.read().to_pylist()
    assert b"figures.acc-mpc" in file.metadata.metadata, file.metadata.metadata
    runs = sorted({row["run"] for row in rows})
    assert [row["run"] for row in rows] == sorted(row["run"] for row in rows)
    with open(out / "runs.csv", newline="") as table:
        swept = list(csv.DictReader(table))
    for run in runs:
        steps = [row for row in rows if row["run"] == run]
        own = swept[run]
        assert {row["seed"] for row in steps} == {int(own["seed"])}, own
        assert {row["runtime.extra_delay_ms"] for row in steps} == {float(own["runtime.extra_delay_ms"])}, own
        assert all(a["time_s"] < b["time_s"] for a, b in zip(steps, steps[1:]))
        gaps = [row["gap_m"] for row in steps if row["gap_m"] is not None]
        assert abs(min(gaps) - float(own["min_gap_m"])) < 0.2, (min(gaps), own)
    print(len(runs))


if __name__ == "__main__":
    main()
