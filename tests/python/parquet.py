"""Compares the tables of an export in Parquet with those in CSV, and prints their number.

Types come from Parquet: the text of each cell must be that in CSV.
"""

import csv
import math
import sys
from pathlib import Path

import pyarrow.parquet


def same(cell, text):
    if cell is None:
        return text == ""
    if isinstance(cell, float):
        return float(text) == cell or (math.isnan(cell) and text == "nan")
    return str(cell) == text


def main():
    run, compared = Path(sys.argv[1]), 0
    for path in sorted((run / "parquet").glob("*.parquet")):
        table = pyarrow.parquet.read_table(path)
        with open(run / "csv" / f"{path.name.removesuffix('.parquet')}.csv", newline="") as file:
            rows = list(csv.reader(file))
        assert table.column_names == rows[0], (path, table.column_names, rows[0])
        assert table.num_rows == len(rows) - 1, path
        for index, column in enumerate(table.columns):
            for row, cell in zip(rows[1:], column.to_pylist()):
                assert same(cell, row[index]), (path, rows[0][index], cell, row[index])
        compared += 1
    print(compared)


if __name__ == "__main__":
    main()
