"""Backend ``dask``: workers of a dask cluster, on this computer or elsewhere."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Hashable, Sequence
from typing import Any

from ...core.errors import ConfigError
from . import Parts
from .cluster import LostWorkerError, no_cluster, numbered_part, parts

CONNECT_S = 30.0
"""Longest wait for a cluster to answer [s]."""


def results(text: str, chunks: Sequence[int], jobs: int, address: str = "") -> Parts:
    """See `backends.Results`."""
    try:
        import distributed
    except ImportError:
        raise ConfigError("backend", "dask", 'installed with pip install "sjasim[dask]"') from None

    with contextlib.ExitStack() as closing:
        client = _client(distributed, jobs, address, closing)
        yield from parts(_DaskCluster(distributed, client, text), chunks)


class _DaskCluster:
    """Implements `cluster.Cluster` with a client of dask.

    Args:
        distributed: the package.
        client: the client.
        text: the design as TOML.
    """

    def __init__(self, distributed: Any, client: Any, text: str) -> None:
        self._client = client
        self._text = text
        self._done = distributed.as_completed(loop=client.loop)
        # A future whose scheduler or worker has gone is cancelled; lost connections are errors of the system.
        self._lost = (distributed.scheduler.KilledWorker, distributed.CancelledError, OSError)

    @property
    def workers(self) -> int:
        """See `cluster.Cluster`. It follows a cluster that grows."""
        return max(1, int(sum(self._client.nthreads().values())))

    def submit(self, chunk: int) -> Hashable:
        """See `cluster.Cluster`."""
        # An impure task has a key of its own, so that a lost chunk is really computed again.
        future: Hashable = self._client.submit(numbered_part, self._text, chunk, pure=False)
        self._done.add(future)
        return future

    def first_done(self, handles: Sequence[Hashable]) -> Hashable:
        """See `cluster.Cluster`."""
        future: Hashable = next(self._done)
        return future

    def result(self, handle: Any) -> bytes:
        """See `cluster.Cluster`."""
        try:
            _, part = handle.result()
        except self._lost as error:
            raise LostWorkerError(str(error)) from error
        return bytes(part)


def _client(distributed: Any, jobs: int, address: str, closing: contextlib.ExitStack) -> Any:
    """Connect to the cluster at an address, or to one that is started on this computer."""
    if not address:
        cluster = distributed.LocalCluster(
            n_workers=jobs, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=logging.CRITICAL
        )
        return closing.enter_context(distributed.Client(closing.enter_context(cluster)))

    try:
        return closing.enter_context(distributed.Client(f"tcp://{address}", timeout=CONNECT_S))
    except (OSError, ValueError) as error:
        raise no_cluster("dask", f"at dask://{address}", error) from None
