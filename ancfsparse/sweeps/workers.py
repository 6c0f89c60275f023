"""Runs of a sweep on a Dask cluster, local or remote."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.sweeps.forks import WORKER_ENDED
from ancfsparse.sweeps.point import Row, Task, evaluate_all
from ancfsparse.sweeps.samples import ParameterPoint

BATCH_SECONDS = 0.25  # s, duration of a batch; a call takes milliseconds
MIN_CALLS_PER_WORKER = 8  # calls, so that all workers end at about the same time
CONNECTION_TIMEOUT = 10  # s


@contextmanager
def connect(workers: int, cluster: Any) -> Iterator[Any]:
    """Open a Dask client: an existing one, one of an address, or one of a local cluster.

    Parameters
    ----------
    workers : int
        Processes of a local cluster.
    cluster : None, str or distributed.Client
        Address or client of a cluster; None and ``"local"`` start a local one.

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
            client = Client(cluster, timeout=CONNECTION_TIMEOUT)
        except (OSError, ValueError) as error:  # a time-out is an OSError
            raise InputError(
                f"no cluster answers at {cluster!r} within {CONNECTION_TIMEOUT} s: check the "
                "address, or leave `cluster` out for a local one"
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


def run_on_cluster(
    client: Any, task: Task, points: list[ParameterPoint], seconds: float
) -> Iterator[tuple[ParameterPoint, Row]]:
    """Run points in batches, and yield results as they arrive.

    Parameters
    ----------
    client : distributed.Client
        Client of the cluster.
    task : Task
        The computation at a point.
    points : list of dict
        The points.
    seconds : float
        Approximate time of a point [s].

    Yields
    ------
    point, row
        In any order.  The points of a worker that has ended run again one by one.
    """
    from dask.distributed import as_completed
    from distributed.scheduler import KilledWorker

    n_workers = max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
    largest = max(1, len(points) // (MIN_CALLS_PER_WORKER * n_workers))
    size = min(largest, max(1, round(BATCH_SECONDS / max(seconds, 1e-6))))
    batches = [points[k : k + size] for k in range(0, len(points), size)]

    def submit(batch: list[ParameterPoint]) -> Any:
        future = client.submit(evaluate_all, task, batch, pure=False)
        future.points = batch
        return future

    suspects: list[ParameterPoint] = []  # points of workers that have ended
    for future in as_completed([submit(batch) for batch in batches]):
        try:
            yield from zip(future.points, future.result(), strict=True)
        except KilledWorker:
            suspects += future.points
        future.release()
    for point in suspects:  # one by one, to find the one that ends its worker
        try:
            row = submit([point]).result()[0]
        except KilledWorker:
            values = dict.fromkeys(task.quantities, math.nan)
            row = Row(values, WORKER_ENDED)
        yield point, row
