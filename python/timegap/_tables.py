"""Columns as Arrow tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

if TYPE_CHECKING:
    import pandas as pd
    import polars as pl

Table = Any
"""A `pyarrow.Table`."""


def of_floats(columns: Iterable[tuple[str, bytes]]) -> Table:
    """A table of 8-byte floats; NaN stands for no value."""
    arrays, names = [], []
    for name, content in columns:
        values = np.frombuffer(content, dtype="<f8")
        arrays.append(pa.array(values, mask=np.isnan(values)))
        names.append(name)
    return pa.table(arrays, names=names)


def of_typed(columns: Iterable[tuple[str, str, bytes]]) -> Table:
    """A table of columns with numpy's types."""
    arrays, names = [], []
    for name, kind, content in columns:
        if kind.startswith("|V"):
            width = int(kind[2:])
            count = len(content) // width
            array = pa.FixedSizeBinaryArray.from_buffers(pa.binary(width), count, [None, pa.py_buffer(content)])
        else:
            array = pa.array(np.frombuffer(content, dtype=kind))
        arrays.append(array)
        names.append(name)
    return pa.table(arrays, names=names)


def of_rows(rows: Sequence[dict[str, Any]], first: Sequence[str] = ()) -> Table:
    """A table of rows; a key that a row lacks has no value. The columns `first` lead."""
    names = list(dict.fromkeys([*first, *(key for row in rows for key in row)]))
    return pa.table({name: pa.array([row.get(name) for row in rows]) for name in names})


def to_pandas(table: Table) -> pd.DataFrame:
    """The table as a pandas DataFrame."""
    frame: pd.DataFrame = table.to_pandas()
    return frame


def to_polars(table: Table) -> pl.DataFrame:
    """The table as a polars DataFrame."""
    import polars as pl

    frame = pl.from_arrow(table)
    assert isinstance(frame, pl.DataFrame)
    return frame
