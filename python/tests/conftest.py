import numpy as np
import pytest

import kugelblitz as kb


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
