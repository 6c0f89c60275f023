"""Sweeps over parameters: many independent runs, in parallel, into one table."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ancfsparse.checks import check_choice, check_count, check_flag, check_positive
from ancfsparse.errors import InputError
from ancfsparse.file_names import check_file_name
from ancfsparse.messages import format_value
from ancfsparse.solve import simulate
from ancfsparse.solve.preparation.progress_bar import progress_bar
from ancfsparse.sweeps.forks import can_fork, run_forked
from ancfsparse.sweeps.ledger import Ledger, key
from ancfsparse.sweeps.point import Row, Task, evaluate
from ancfsparse.sweeps.samples import ParameterPoint, check_points
from ancfsparse.sweeps.workers import connect, run_on_cluster
from ancfsparse.system_memory import count_processors

if TYPE_CHECKING:
    import pandas as pd

STATUS_COLUMNS = ("reason", "seconds")
"""Columns besides parameters and quantities."""
OWN_ARGUMENTS = ("scene", "t_end", "output", "progress")
"""Arguments of `simulate` that a sweep specifies itself."""


def sweep(
    build: Callable[..., Any],
    points: Any,
    quantities: Mapping[str, Callable[..., float]],
    t_end: float,
    *,
    file: str | Path | None = None,
    workers: int | None = None,
    cluster: Any = None,
    progress: bool = False,
    **options: Any,
) -> pd.DataFrame:
    """Simulate a scene for many values of its parameters.

    Parameters
    ----------
    build : callable
        Function of the parameters of a point by name; returns a scene, or a tuple of a scene and
        handles of it, such as ``(scene, rod)``.
    points : list of dict, or pandas.DataFrame
        The points, as `grid` and `latin_hypercube` return them: numbers and texts by name.
    quantities : dict of str to callable
        Quantities of each run: functions of the run and the handles that return one number, such as
        ``{"tip": lambda run, rod: run.position(rod.end)[-1, 1]}``.
    t_end : float
        Final time of every run [s].
    file : str or Path, optional
        File to which every finished point is written immediately.  If it exists, the sweep resumes
        with the missing points.
    workers : int, optional
        Processes on this machine, by default one for each processor; 1 runs all points in this
        process.  On Linux processes are forked; elsewhere they form a local Dask cluster, and
        scripts need ``if __name__ == "__main__":`` around a sweep.
    cluster : str or distributed.Client, optional
        Address or client of a Dask cluster on which to run instead; ``"local"`` starts a cluster of
        `workers` processes on this machine, which takes two or three seconds.
    progress : bool, optional
        Show a progress bar.
    **options
        Further arguments of `simulate`, such as ``dt``; ``threads`` is 1 by default.

    Returns
    -------
    pandas.DataFrame
        A row for each point in the given order: parameters, quantities, ``reason`` and ``seconds``.
        If a point failed, its quantities are NaN and ``reason`` states the cause; otherwise
        ``reason`` is empty.  The numbers do not depend on the number of workers.

    Raises
    ------
    InputError
        If an argument is invalid, a package is missing, no cluster answers, or the file is of
        another sweep or cannot be written.
    """
    try:
        import pandas as pd
    except ModuleNotFoundError as error:
        raise InputError("a sweep needs pandas: pip install 'ancfsparse[sweep]'") from error
    task = _check_task(build, quantities, t_end, options)
    every = check_points(points)
    for name in (*quantities, *STATUS_COLUMNS):
        if name in every[0]:
            raise InputError(
                f"{name!r} is the name of a parameter and of another column: rename it"
            )
    check_flag("progress", progress)
    count = count_processors() if workers is None else check_count("workers", workers)
    ledger = Ledger(task, None if file is None else check_file_name("the file of a sweep", file))
    remaining = list({key(point): point for point in every if point not in ledger}.values())
    with ledger.writing(), progress_bar("point", progress, len(every)) as bar:
        bar.update(len(every) - len(remaining))
        for point, row in _rows(task, remaining, count, cluster):
            ledger.add(point, row)
            bar.update()
    return pd.DataFrame([_line(point, ledger[point]) for point in every])


def _check_task(
    build: Callable[..., Any],
    quantities: Mapping[str, Callable[..., float]],
    t_end: float,
    options: Mapping[str, Any],
) -> Task:
    if not callable(build):
        raise InputError(
            f"build must be a function that returns a scene for a point, got {format_value(build)}"
        )
    if not isinstance(quantities, Mapping) or not quantities:
        raise InputError(
            "quantities must be a dictionary of functions of a run, such as "
            f"{{'energy': lambda run: run.energy.total[-1]}}, got {format_value(quantities)}"
        )
    for name, quantity in quantities.items():
        if not isinstance(name, str) or not callable(quantity) or name in STATUS_COLUMNS:
            raise InputError(
                f"quantity {format_value(name)} must be a function with a name that is not "
                f"{' or '.join(STATUS_COLUMNS)}, got {format_value(quantity)}"
            )
    allowed = inspect.signature(simulate).parameters
    for name in options:
        check_choice(
            "argument of a sweep", name, [each for each in allowed if each not in OWN_ARGUMENTS]
        )
    return Task(build, quantities, check_positive("t_end", t_end, "s"), {"threads": 1, **options})


def _rows(
    task: Task, points: list[ParameterPoint], workers: int, cluster: Any
) -> Iterator[tuple[ParameterPoint, Row]]:
    """Yield the results in any order; the first point runs here, to measure its time."""
    if not points:
        return
    row = evaluate(task, points[0])
    yield points[0], row
    if cluster is None and workers == 1:
        for point in points[1:]:
            yield point, evaluate(task, point)
    elif cluster is None and can_fork():
        yield from run_forked(task, points[1:], workers, row.seconds)
    elif points[1:]:
        with connect(workers, cluster) as client:
            yield from run_on_cluster(client, task, points[1:], row.seconds)


def _line(point: ParameterPoint, row: Row) -> dict[str, Any]:
    return {**point, **row.values, "reason": row.reason, "seconds": row.seconds}
