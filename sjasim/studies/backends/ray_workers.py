"""Backend ``ray``: workers of a ray cluster, on this computer or elsewhere."""

from __future__ import annotations

import contextlib
import logging
import os
from collections.abc import Hashable, Sequence
from typing import Any

from ...core.errors import ConfigError
from . import Parts
from .cluster import LostWorkerError, no_cluster, numbered_part, parts


def results(text: str, chunks: Sequence[int], jobs: int, address: str = "") -> Parts:
    """See `backends.Results`. A connection that the program has already is used and kept."""
    try:
        import ray
    except ImportError:
        raise ConfigError("backend", "ray", 'installed with pip install "sjasim[ray]"') from None

    with contextlib.ExitStack() as closing:
        if not ray.is_initialized():
            _connect(ray, jobs, address)
            closing.callback(ray.shutdown)
        yield from parts(_RayCluster(ray, text), chunks)


class _RayCluster:
    """Implements `cluster.Cluster` with ray.

    Args:
        ray: the package, connected to a cluster.
        text: the design as TOML.
    """

    def __init__(self, ray: Any, text: str) -> None:
        self._ray = ray
        self._text = text
        # `cluster.parts` hands out lost chunks again, so ray does not.
        self._task = ray.remote(max_retries=0)(numbered_part)
        errors = ray.exceptions
        self._lost = (
            errors.WorkerCrashedError,
            errors.NodeDiedError,
            errors.ObjectLostError,
            errors.OutOfMemoryError,
        )

    @property
    def workers(self) -> int:
        """See `cluster.Cluster`. It follows a cluster that grows."""
        return max(1, int(self._ray.cluster_resources().get("CPU", 1)))

    def submit(self, chunk: int) -> Hashable:
        """See `cluster.Cluster`."""
        reference: Hashable = self._task.remote(self._text, chunk)
        return reference

    def first_done(self, handles: Sequence[Hashable]) -> Hashable:
        """See `cluster.Cluster`."""
        (reference, *_), _ = self._ray.wait(list(handles), num_returns=1)
        found: Hashable = reference
        return found

    def result(self, handle: Hashable) -> bytes:
        """See `cluster.Cluster`."""
        try:
            _, part = self._ray.get(handle)
        except self._lost as error:
            raise LostWorkerError(str(error)) from error
        return bytes(part)


def _connect(ray: Any, jobs: int, address: str) -> None:
    """Connect to the cluster at an address, or to one that is started on this computer."""
    # Statistics of use would be sent to ray's makers.
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    quiet = {"logging_level": logging.ERROR, "log_to_driver": False}
    try:
        if address:
            ray.init(address=f"ray://{address}", **quiet)
        else:
            ray.init(num_cpus=jobs, include_dashboard=False, **quiet)
    except (ConnectionError, RuntimeError, ValueError) as error:
        raise no_cluster("ray", f"at ray://{address}" if address else "on this computer", error) from None
