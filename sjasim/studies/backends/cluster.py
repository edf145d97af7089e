"""What backends with clusters have in common: chunks are handed out a few at a time, and again if a worker is lost."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Hashable, Sequence
from typing import Protocol

from ...core.errors import SjasimError
from ..study_parts import compute_chunk
from . import Parts

RETRIES = 3
"""How often a chunk is computed again after its worker was lost, before the study stops."""

WAITING_PER_WORKER = 3
"""Chunks that a cluster has at once for each worker; the others wait at the driver, however many there are."""


class WorkerError(SjasimError):
    """Workers are lost or cannot be reached. Parts that are finished are kept."""


class LostWorkerError(Exception):
    """A worker was lost before it returned its part."""


class Cluster(Protocol):
    """Workers that compute chunks."""

    @property
    def workers(self) -> int:
        """Number of chunks that are computed at the same time."""
        ...

    def submit(self, chunk: int) -> Hashable:
        """Hand out a chunk, and return a handle of its result."""
        ...

    def first_done(self, handles: Sequence[Hashable]) -> Hashable:
        """Wait until one of the chunks is done, and return its handle."""
        ...

    def result(self, handle: Hashable) -> bytes:
        """Return the part of a chunk that is done.

        Raises:
            LostWorkerError: the worker was lost.
        """
        ...


def numbered_part(text: str, chunk: int) -> tuple[int, bytes]:
    """Return a chunk's number and the bytes of its part; this is what a worker runs."""
    return chunk, compute_chunk(text, chunk)


def parts(cluster: Cluster, chunks: Sequence[int]) -> Parts:
    """Compute chunks on a cluster, and yield each chunk's number and the bytes of its part, in any order.

    Raises:
        WorkerError: workers of one chunk were lost again and again.
    """
    waiting = deque(chunks)
    losses: dict[int, int] = {}
    handles: dict[Hashable, int] = {}

    while waiting or handles:
        while waiting and len(handles) < WAITING_PER_WORKER * cluster.workers:
            chunk = waiting.popleft()
            handles[cluster.submit(chunk)] = chunk

        handle = cluster.first_done(list(handles))
        chunk = handles.pop(handle)
        try:
            part = cluster.result(handle)
        except LostWorkerError as error:
            losses[chunk] = losses.get(chunk, 0) + 1
            check_losses(chunk, losses[chunk], error)
            waiting.appendleft(chunk)
            continue
        yield chunk, part


def check_losses(chunk: int, losses: int, error: Exception) -> None:
    """Report on stderr that a worker was lost, or give up after `RETRIES` times.

    Args:
        chunk: the chunk that it computed.
        losses: how many workers this chunk has lost.
        error: what is known about the last one.

    Raises:
        WorkerError: too many workers were lost.
    """
    reason = " ".join(str(error).split())[:200]
    if losses > RETRIES:
        raise WorkerError(
            f"chunk {chunk} lost its worker {losses} times, perhaps for lack of memory ({reason}); "
            "finished chunks are kept: continue with --resume"
        )
    sys.stderr.write(f"a worker was lost: chunk {chunk} is computed again\n")


def no_cluster(kind: str, where: str, error: Exception) -> WorkerError:
    """Return the error for a cluster that cannot be reached or started."""
    return WorkerError(f"no {kind} cluster {where}: {' '.join(str(error).split())[:200]}")
