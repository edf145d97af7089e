"""A trained policy as a fully connected network, read from an npz file and evaluated with NumPy alone."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..core import Array
from ..core.errors import ConfigError
from .observation import MOVES

MAX_STEP_HZ = 120
"""Largest number of decisions per second that a policy may have been trained with."""


@dataclass(frozen=True, slots=True)
class PolicyNetwork:
    """A fully connected network with tanh between its layers.

    Attributes:
        mean: (N,) means of the features in training.
        std: (N,) their standard deviations.
        clip: bound of the normalised features.
        layers: weights (out, in) and biases (out,), from the first layer to the last.
        step_hz: decisions per second in training.
    """

    mean: Array
    std: Array
    clip: float
    layers: tuple[tuple[Array, Array], ...]
    step_hz: int

    @classmethod
    def read(cls, path: str | Path) -> PolicyNetwork:
        """Read an npz file with ``mean``, ``std``, ``clip``, ``step_hz`` and ``w0``, ``b0``, ``w1``, ...

        Raises:
            ConfigError: the file cannot be read, its arrays do not fit together, or its scores are not finite.
        """
        try:
            with np.load(path, allow_pickle=False) as stored:
                arrays = {name: np.asarray(stored[name], dtype=np.float64) for name in stored.files}
            count = sum(name.startswith("w") for name in arrays)
            layers = tuple((arrays[f"w{k}"], arrays[f"b{k}"]) for k in range(count))
            network = cls(arrays["mean"], arrays["std"], float(arrays["clip"]), layers, int(arrays["step_hz"].item()))
            scores = network.scores(network.mean)
        except (OSError, KeyError, ValueError) as problem:
            # For a file of another kind NumPy only advises to allow pickles, which is unsafe.
            why = "it is none" if "pickle" in str(problem) else problem
            raise ConfigError("learned.policy", str(path), f"the npz file of a trained policy ({why})") from problem

        is_valid = scores.shape == (len(MOVES),) and np.isfinite(scores).all() and 1 <= network.step_hz <= MAX_STEP_HZ
        if not is_valid:
            raise ConfigError("learned.policy", str(path), f"a policy with {len(MOVES)} finite scores")
        return network

    def scores(self, features: Array) -> Array:
        """(4,) score of each of `observation.MOVES`, for (N,) features; the highest one is the policy's choice."""
        x = np.clip((features - self.mean) / self.std, -self.clip, self.clip)
        for weights, bias in self.layers[:-1]:
            x = np.tanh(weights @ x + bias)
        weights, bias = self.layers[-1]
        return np.asarray(weights @ x + bias)
