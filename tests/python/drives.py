"""Checks each row of runs.csv against its trajectory, by the study's keys, and prints the number of drives."""

import csv
import sys
from pathlib import Path

import pyarrow.parquet


def main():
    out, keys = Path(sys.argv[1]), sys.argv[2].split(",")
    with open(out / "runs.csv", newline="") as table:
        drives = list(csv.DictReader(table))
    assert list(drives[0])[4 : 4 + len(keys)] == keys, list(drives[0])
    steps = pyarrow.parquet.read_table(out / "trajectories.parquet").to_pylist()
    names = ["run", "law", "seed", *keys]

    def place(row):
        shown = lambda value: "" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
        number = lambda text: f"{float(text):g}" if text.replace(".", "", 1).isdigit() else text
        return tuple(number(shown(row[name])) for name in names)

    ends, gaps = {}, {}
    for step in steps:
        ends[place(step)] = max(step["time_s"], ends.get(place(step), 0.0))
        if step["gap_m"] is not None:
            gaps[place(step)] = min(step["gap_m"], gaps.get(place(step), float("inf")))
    assert len(ends) == len(drives), (len(ends), len(drives))
    for drive in drives:
        at = place(drive)
        assert abs(ends[at] - float(drive["duration_s"])) < 0.1, (drive, ends[at])
        # The gap of a collision is that of the vehicle that came in beside, which no step has ahead.
        if drive["min_gap_m"] and at in gaps and drive["outcome"] != "collision":
            assert abs(gaps[at] - float(drive["min_gap_m"])) < 0.5, (drive, gaps[at])
    print(len(drives))


if __name__ == "__main__":
    main()
