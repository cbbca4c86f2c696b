"""Drawings, and pictures that no camera took."""

from __future__ import annotations

import os
from typing import final

import numpy as np
from numpy.typing import NDArray

from . import _kugelblitz


@final
class Drawing:
    """A drawing in SVG. A notebook shows it; ``str()`` is its text."""

    def __init__(self, svg: str) -> None:
        self._svg = svg

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a file, whose name ends in .svg."""
        _write(path, ".svg", "a drawing", self._svg.encode())

    def _repr_svg_(self) -> str:
        return self._svg

    def __str__(self) -> str:
        return self._svg

    def __repr__(self) -> str:
        return f"<Drawing: {len(self._svg.encode())} bytes of SVG>"


@final
class Tinted:
    """A picture of numbers: depths, errors or others as colours, with their legend. A notebook shows it."""

    def __init__(self, rgb8: NDArray[np.uint8], legend: list[tuple[str, str, int | None]]) -> None:
        self._rgb8, self._legend = rgb8, legend

    @property
    def rgb8(self) -> NDArray[np.uint8]:
        """Colours in sRGB, bytes; shape (height, width, 3)."""
        return self._rgb8.copy()

    @property
    def legend(self) -> list[tuple[str, str, int | None]]:
        """What the colours mean: ("#rrggbb", meaning, pixels or None)."""
        return self._legend.copy()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a file, whose name ends in .png."""
        _write(path, ".png", "this picture", self._repr_png_())

    def _repr_png_(self) -> bytes:
        height, width, _ = self._rgb8.shape
        return _kugelblitz.png([width, height], self._rgb8.tobytes())

    def __repr__(self) -> str:
        height, width, _ = self._rgb8.shape
        return f"<Tinted: {width}×{height} pixels, {len(self._legend)} colours with a meaning>"


def _write(path: str | os.PathLike[str], ending: str, what: str, content: bytes) -> None:
    """Writes a file that appears whole or not at all."""
    if not os.fspath(path).lower().endswith(ending):
        raise ValueError(f"path: {what} is a file that ends in {ending}, not {os.fspath(path)}")
    _kugelblitz.write(path, content)
