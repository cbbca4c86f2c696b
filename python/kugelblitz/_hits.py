"""Hits as a structured array."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

DTYPE: np.dtype[Any] = np.dtype([("id", "=u4"), ("t", "=f4"), ("normal", "=f4", (3,)), ("level", "u1")])


class Hits(np.recarray[Any, Any]):
    """Hits of rays: a structured array with ``id`` (0 is no hit), ``t`` (+inf without a hit), ``normal``
    (unit, towards the ray) and ``level`` (the stage that decided: 0 f32, 1 f64, 2 exact).

    ``counts`` says how many rays each stage decided; a part of the array has none.
    """

    counts: dict[str, int] | None = None
    id: NDArray[np.uint32]
    t: NDArray[np.float32]
    normal: NDArray[np.float32]
    level: NDArray[np.uint8]

    def __array_finalize__(self, whole: Any) -> None:
        super().__array_finalize__(whole)
        self.counts = None


def hits(records: NDArray[np.uint8], counts: dict[str, int]) -> Hits:
    """The hits in these bytes."""
    array = records.view(DTYPE).view(Hits)
    array.counts = counts
    return array
