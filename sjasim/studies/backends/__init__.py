"""Backends of a study: where its chunks are computed."""

from __future__ import annotations

import importlib
from collections.abc import Generator, Sequence
from typing import NamedTuple, Protocol, cast

from ...core.errors import ConfigError

BACKENDS = {"local": "local_processes", "dask": "dask_workers", "ray": "ray_workers"}
"""Name of a backend -> its module."""


Parts = Generator[tuple[int, bytes], None, None]
"""Numbers of chunks and the bytes of their parts, in any order. Closing the generator stops the computation."""


class Results(Protocol):
    """What the module of a backend has as ``results``."""

    def __call__(self, text: str, chunks: Sequence[int], jobs: int, address: str) -> Parts:
        """Compute chunks, and yield each chunk's number and the bytes of its part, in any order.

        Closing the iterator stops the computation.

        Args:
            text: the design as TOML.
            chunks: numbers of the chunks.
            jobs: number of processes that the backend starts; a running cluster has its own number.
            address: a running cluster, such as ``host:port``; "" to start the backend's own workers.

        Raises:
            WorkerError: workers were lost again and again, or the cluster cannot be reached.
            ConfigError: the backend is not installed.
        """
        ...


class BackendName(NamedTuple):
    """A backend as a user names it: ``local``, ``dask``, ``dask://host:port``, ``ray``, ``ray://host:port``."""

    name: str
    address: str

    @classmethod
    def parsed(cls, text: str) -> BackendName:
        """Read the name of a backend.

        Raises:
            ConfigError: there is no such backend.
        """
        name, separator, address = text.partition("://")
        if name not in BACKENDS or (separator and (not address or name == "local")):
            raise ConfigError("backend", text, "local, dask, dask://host:port, ray or ray://host:port")
        return cls(name, address)

    def results(self) -> Results:
        """The function that computes chunks on this backend."""
        module = importlib.import_module(f".{BACKENDS[self.name]}", __package__)
        return cast("Results", module.results)
