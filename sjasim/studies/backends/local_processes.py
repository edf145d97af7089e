"""Backend ``local``: processes of this computer, through joblib."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures.process import BrokenProcessPool

from . import Parts
from .cluster import check_losses, numbered_part


def results(text: str, chunks: Sequence[int], jobs: int, address: str = "") -> Parts:
    """See `backends.Results`. One job computes in this process, which saves the start of another."""
    if jobs == 1 or len(chunks) == 1:
        for chunk in chunks:
            yield numbered_part(text, chunk)
        return

    left = dict.fromkeys(chunks)
    losses = 0
    while left:
        try:
            for chunk, part in _parallel(text, list(left), jobs):
                del left[chunk]
                losses = 0
                yield chunk, part
        except BrokenProcessPool as error:
            # joblib gives up all processes when one is killed; what they had not returned is computed again.
            losses += 1
            check_losses(next(iter(left)), losses, error)


def _parallel(text: str, chunks: Sequence[int], jobs: int) -> Parts:
    """Compute chunks in processes, and yield the results in any order."""
    from joblib import Parallel, delayed

    # Chunks are long enough to be handed out one by one.
    parallel = Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
    yield from parallel(delayed(numbered_part)(text, chunk) for chunk in chunks)
