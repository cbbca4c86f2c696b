"""Hits as a structured array."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

DTYPE: np.dtype[Any] = np.dtype([("id", "=u4"), ("t", "=f4"), ("normal", "=f4", (3,)), ("level", "u1")])


class Hits(np.recarray):
    """Hits of rays: a structured array with ``id`` (0 is no hit), ``t`` (+inf without a hit), ``normal``
    (unit, towards the ray) and ``level`` (the stage that decided: 0 f32, 1 f64, 2 exact).

    ``counts`` says how many rays each stage decided; a part of the array has none.
    """

    counts = None

    def __array_finalize__(self, whole):
        super().__array_finalize__(whole)
        self.counts = None


def hits(records, counts):
    """The hits in these bytes."""
    array = records.view(DTYPE).view(Hits)
    array.counts = counts
    return array
