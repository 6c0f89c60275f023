"""Motion of points as CSV files."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.file_names import check_target
from ancfsparse.messages import format_value
from ancfsparse.results.fields.motion import UNITS, Motion
from ancfsparse.scene import Point, check_point


def write_csv(
    run: Motion, path: str | Path, points: Sequence[Point], quantities: Sequence[str]
) -> Path:
    """Write a CSV file; see `Trajectory.to_csv`."""
    target = check_target("a table", path, (".csv",))
    for what, values, example in (
        ("points", points, "[rod.end]"), ("quantities", quantities, "['position']")
    ):  # fmt: skip
        if not isinstance(values, (list, tuple)) or not values:
            raise InputError(f"{what} must be a list such as {example}, got {format_value(values)}")
    names, columns = ["t [s]"], [run.t]
    for point in points:
        check_point("a table", point)
        for quantity in quantities:
            check_choice("quantity", quantity, UNITS)
            vectors = getattr(run, quantity)(point)
            for letter, column in zip("xyz", vectors.T, strict=False):
                names.append(f"{quantity} {letter} of {point!r} [{UNITS[quantity]}]")
                columns.append(column)
    try:
        with target.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(names)
            writer.writerows(np.column_stack(columns).tolist())
    except OSError as error:
        raise InputError(f"the table cannot be written to {target}: {error.strerror}") from error
    return target
