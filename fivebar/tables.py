"""Tables in time: CSV files, whose first column is time and increases."""

import csv
import math

import numpy as np


def must_increase(t, whose):
    """Refuse times from which no motion can be shown."""
    if len(t) < 2:
        raise ValueError(f"{whose} has {len(t)} samples: a motion needs at least 2")
    bad = np.flatnonzero(~np.isfinite(t))
    if len(bad):
        raise ValueError(f"{whose}: t[{bad[0]}] is {t[bad[0]]}, not finite")
    late = np.flatnonzero(np.diff(t) <= 0) + 1
    if len(late):
        raise ValueError(f"{whose}: t[{late[0]}] = {t[late[0]]} is not after t[{late[0] - 1}] = {t[late[0] - 1]}")


def read_columns(path, names):
    """The named columns of a CSV file as (n, len(names)) floats; the first column is time and must increase.

    Lines that begin with # are comments. ValueError with file and line number.
    """
    with open(path, newline="", encoding="utf-8-sig") as file:
        header, rows = None, []
        try:
            for number, cells in enumerate(csv.reader(file), start=1):
                if not cells or cells[0].startswith("#"):
                    continue
                if header is None:
                    header = [cell.strip() for cell in cells]
                    missing = [name for name in names if name not in header]
                    if missing:
                        raise ValueError(
                            f"{path}, line {number}: no column {', '.join(missing)}; found {', '.join(header)}; "
                            f"needed {', '.join(names)}"
                        )
                    columns = [header.index(name) for name in names]
                    continue
                rows.append(_row(path, number, cells, columns, names))
                if len(rows) > 1 and rows[-1][0] <= rows[-2][0]:
                    raise ValueError(
                        f"{path}, line {number}: time must increase, but {rows[-1][0]:g} follows {rows[-2][0]:g}"
                    )
        except (UnicodeDecodeError, csv.Error) as error:
            raise ValueError(f"{path}: not a CSV text file in UTF-8 ({error})") from None
    if header is None:
        raise ValueError(f"{path}: empty; needed a header with the columns {', '.join(names)}")
    if not rows:
        raise ValueError(f"{path}: no rows under the header")
    return np.array(rows)


def _row(path, number, cells, columns, names):
    row = []
    for column, name in zip(columns, names):
        try:
            value = float(cells[column])
        except (ValueError, IndexError):
            found = repr(cells[column]) if column < len(cells) else "nothing"
            raise ValueError(f"{path}, line {number}: {name} must be a number, not {found}") from None
        if not math.isfinite(value):
            raise ValueError(f"{path}, line {number}: {name} must be finite, not {value}")
        row.append(value)
    return row
