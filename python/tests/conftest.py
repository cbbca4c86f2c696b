import os
import shutil
from pathlib import Path

import numpy as np
import pytest

import kugelblitz as kb

ROOT = Path(__file__).resolve().parents[2]


def cloud(n, seed=1, **options):
    """Spheres in the unit cube, as `kugelblitz generate cloud` scales them."""
    centers = np.random.default_rng(seed).random((n, 3))
    return kb.Scene(centers, radius=0.3 * n ** (-1 / 3), **options)


@pytest.fixture
def camera():
    return kb.Camera((1.9, 1.4, 2.2), (0.5, 0.5, 0.5), fov=40)


@pytest.fixture
def ball():
    return kb.Scene([[0, 0, 0, 1]], color="#d62728", background="#20242c")


@pytest.fixture(scope="session")
def program():
    """The command line: KUGELBLITZ names it, else it is what `cargo build --release` built."""
    built = ROOT / "target/release/kugelblitz"
    path = os.environ.get("KUGELBLITZ") or (built if built.exists() else shutil.which("kugelblitz"))
    assert path, "build the program (cargo build --release), or name it by KUGELBLITZ=PATH"
    return str(path)
