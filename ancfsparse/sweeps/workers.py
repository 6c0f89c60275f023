"""Points of a sweep on the workers of Dask: a local cluster, or any that runs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.sweeps.forks import ENDED
from ancfsparse.sweeps.point import Row, Task, evaluate_all
from ancfsparse.sweeps.samples import ParameterPoint

# Time that a call should take beside the milliseconds that a cluster needs for it [s], and the
# fewest calls for each worker, so that all end together.
BATCH_SECONDS, CALLS_PER_WORKER = 0.25, 8
# Time to find a cluster [s].
PATIENCE = 10


@contextmanager
def connected(workers: int, cluster: Any) -> Iterator[Any]:
    """Give a client of Dask: the one given, that of an address, or one of a local cluster.

    Parameters
    ----------
    workers : int
        Processes of a local cluster.
    cluster : None, str or distributed.Client
        Address of a cluster, or a client of it; None and ``"local"`` start one.

    Raises
    ------
    InputError
        If Dask is not installed, or no cluster answers.
    """
    try:
        import dask
        from dask.distributed import Client, LocalCluster
    except ModuleNotFoundError as error:
        raise InputError(
            "a sweep on a cluster needs Dask: pip install 'ancfsparse[sweep]', or leave `cluster` "
            "out on Linux, or set workers=1"
        ) from error
    if isinstance(cluster, Client):
        yield cluster
    elif isinstance(cluster, str) and cluster != "local":
        try:
            client = Client(cluster, timeout=PATIENCE)
        except (OSError, ValueError) as error:  # a time-out is an OSError
            raise InputError(
                f"no cluster answers at {cluster!r} within {PATIENCE} s: check the address, or "
                "leave `cluster` out for a local one"
            ) from error
        with client:
            yield client
    elif cluster is None or isinstance(cluster, str):
        with (
            dask.config.set({"distributed.scheduler.allowed-failures": 0}),
            LocalCluster(
                n_workers=workers, threads_per_worker=1, dashboard_address=None, silence_logs=50
            ) as local,
            Client(local) as client,
        ):
            yield client
    else:
        raise InputError(
            f"cluster must be an address or a client of Dask, got {format_value(cluster)}"
        )


def run_on(
    client: Any, task: Task, points: list[ParameterPoint], each: float
) -> Iterator[tuple[ParameterPoint, Row]]:
    """Run points in batches, and yield them as they end.

    Parameters
    ----------
    client : distributed.Client
        Of the cluster.
    task : Task
        What is done at every point.
    points : list of dict
        The points.
    each : float
        Time that a point takes, about [s].

    Yields
    ------
    point, row
        In any order.  Points that were on a worker whose process ended run once more, one at a
        time.
    """
    from dask.distributed import as_completed
    from distributed.scheduler import KilledWorker

    n_workers = max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
    most = max(1, len(points) // (CALLS_PER_WORKER * n_workers))
    size = min(most, max(1, round(BATCH_SECONDS / max(each, 1e-6))))
    batches = [points[k : k + size] for k in range(0, len(points), size)]

    def submit(batch: list[ParameterPoint]) -> Any:
        future = client.submit(evaluate_all, task, batch, pure=False)
        future.points = batch
        return future

    suspects: list[ParameterPoint] = []  # whatever was on a worker when it ended
    for future in as_completed([submit(batch) for batch in batches]):
        try:
            yield from zip(future.points, future.result(), strict=True)
        except KilledWorker:
            suspects += future.points
        future.release()
    for point in suspects:  # one at a time, so that the one that ends its worker is found
        try:
            row = submit([point]).result()[0]
        except KilledWorker:
            values = dict.fromkeys(task.quantities, math.nan)
            row = Row(values, ENDED)
        yield point, row
