"""Rows of a table: the same values of the same kinds that pandas hands out cell by cell."""

import numpy as np
import pandas as pd

from plumbline.harness.store.rows import records


def test_rows_are_those_of_to_dict_in_value_and_in_kind() -> None:
    frame = pd.DataFrame(
        {
            "word": pd.Series(["a", None, "é"], dtype=object),
            "text": ["x", "y", None],
            "number": [1.5, np.nan, np.inf],
            "count": np.array([1, 2, 3], dtype=np.int64),
            "holds": pd.Series([True, pd.NA, False], dtype="boolean"),
            "answered": [True, False, True],
        }
    )
    for table in (frame, frame[:0], frame[["holds"]]):
        mine, theirs = records(table), table.to_dict("records")
        assert repr(mine) == repr(theirs)
        assert [[type(cell) for cell in row.values()] for row in mine] == [[type(c) for c in row.values()] for row in theirs]
