"""Train the skeleton model that depth sensing uses, from the project's own bodies and motions.

    python scripts/train_skeleton.py                      # under five minutes on two cores
    python scripts/train_skeleton.py --small --out small.npz

Needs the extra ``train`` (scikit-learn). The same seed gives the same arrays on the same machine. On other machines
libraries may round differently, so compare models by their figures (scripts/evaluate_skeleton.py).
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from pathlib import Path

from sjasim.core.errors import SjasimError
from sjasim.skeleton_training.train import SMALL, Recipe, train

MODEL_PATH = Path(__file__).resolve().parents[1] / "sjasim" / "assets" / "skeleton.npz"
"""Model of the package."""


def main() -> int:
    """Train a model and write it."""
    parser = argparse.ArgumentParser(description="Train the skeleton model of depth sensing.")
    parser.add_argument("--small", action="store_true", help="train a small model in less than a minute")
    parser.add_argument("--seed", type=int, default=0, help="seed of everything random")
    parser.add_argument("--out", type=Path, default=MODEL_PATH, help="file of the model; default: the package's")
    options = parser.parse_args()

    recipe = dataclasses.replace(SMALL if options.small else Recipe(), seed=options.seed)
    try:
        model = train(recipe, lambda line: print(line, file=sys.stderr))
    except SjasimError as error:
        print(f"train_skeleton: {error}", file=sys.stderr)
        return 2

    model.save(options.out)
    print(f"{options.out}: {options.out.stat().st_size / 1000:.0f} kB, sha256 {model.digest()[:16]}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
