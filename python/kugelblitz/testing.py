"""Assertions for tests: hits and pictures are those that exact arithmetic gives.

Messages say which ray or pixel is wrong, what is right there, and why.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import Camera, Difference, Explanation, HitDifference, Picture, Scene, compare

#: What ``allow`` says of colours; the rest of it is of ids, depths and normals.
OF_COLORS = ("levels", "ulp", "difference", "pixels")

#: Most lines of the explanation of the worst ray or pixel in a message.
WHY_LINES = 60


def assert_hits(
    hits: Mapping[str, ArrayLike] | NDArray[Any],
    scene: Scene,
    rays: tuple[ArrayLike, ArrayLike] | ArrayLike,
    *,
    allow: str | None = None,
    transform: str | Sequence[str] | None = None,
) -> None:
    """Fails unless hits of rays are the exact ones.

    ``hits`` is what :meth:`kugelblitz.Scene.trace` gives, another structured array with ``id`` and perhaps ``t`` and
    ``normal``, or a dictionary of arrays with those keys. ``rays`` is (origins, directions), or an array of shape
    (N, 6). ``allow`` sets the limits of allowed errors, as ``kugelblitz compare --allow`` takes them: ``"ids=0.1%,t=1e-5"``.
    ``transform`` names other conventions, as ``kugelblitz compare --transform`` does: ``"ids+1"``.
    """
    __tracebackhide__ = True
    if not isinstance(rays, tuple):
        array = np.asarray(rays)
        if array.ndim != 2 or array.shape[1] != 6:
            raise ValueError(f"rays: the shape is {array.shape}; give (origins, directions), or an array of (N, 6)")
        rays = array[:, :3], array[:, 3:]
    _require(compare(hits, scene, rays=rays, allow=allow, transform=transform).hits, "hits")


def assert_picture(
    array: Picture | ArrayLike,
    scene: Scene,
    camera: Camera | None = None,
    *,
    samples: int | None = None,
    crop: tuple[int, int, int, int] | None = None,
    allow: str | None = None,
    device: str = "auto",
) -> None:
    """Fails unless a picture is the exact one.

    ``array`` has shape (height, width, 3), with the first row on top: sRGB as bytes or 16 bits, or linear floats,
    which are compared as f32. Or it is a structured array of shape (height, width) with ``id`` and perhaps ``t``,
    ``normal`` and ``rgb``, or a :class:`kugelblitz.Picture`, of which all is looked at. With ``crop`` (left column, top
    row, width, height) it is a part of the picture whose size the scene has. ``allow`` says how far colours may be
    off, as ``kugelblitz compare --allow`` takes it: ``"levels=1,pixels=0.1%"``; and for a structured array or a picture
    how far ids, depths and normals may be, as :func:`assert_hits` takes it: ``"levels=1,t=1e-5"``.
    """
    __tracebackhide__ = True
    of_colors, of_hits = _split(allow)
    if isinstance(array, Picture):
        hits = {"id": array.id, "t": array.t, "normal": array.normal}
        _require(compare(hits, scene, camera=camera, crop=crop, allow=of_hits).hits, "pixels")
        array, of_hits = array.rgb8, None
    array = np.asarray(array)
    if array.dtype.names:
        has_colors = "rgb" in array.dtype.names
        if of_colors and not has_colors:
            raise ValueError(f"allow: {of_colors!r} is of colours, but the array has no rgb")
        hits = {field: array[field] for field in array.dtype.names if field != "rgb"}
        _require(compare(hits, scene, camera=camera, crop=crop, allow=of_hits).hits, "pixels")
        if not has_colors:
            return
        array, of_hits = array["rgb"], None
    if of_hits is not None:
        raise ValueError(f"allow: {of_hits!r} is of ids, depths or normals, but an array of colours has none; give "
                         f"{', '.join(OF_COLORS)}, or a structured array")
    encoding = {"u1": "rgb8", "u2": "rgb16"}.get(array.dtype.str[1:], "rgb" if array.dtype.kind == "f" else None)
    if array.ndim != 3 or array.shape[2] != 3 or encoding is None:
        raise ValueError(f"array: shape {array.shape} of {array.dtype}; a picture has (height, width, 3) of uint8, "
                         "uint16 or floats")
    size = (array.shape[1], array.shape[0]) if crop is None else None
    exact = scene.render(camera, size, samples=samples, crop=crop, device=device)
    right = getattr(exact, encoding)
    difference = compare(array, right, allow=of_colors)
    if not difference:
        raise AssertionError(_about_colors(array, right, difference, of_colors, scene, camera, exact, crop, samples))


def _split(allow: str | None) -> tuple[str, str | None]:
    """What is allowed of colours, and of the rest where anything is."""
    of_colors: list[str] = []
    of_hits: list[str] = []
    for part in (allow or "").split(","):
        is_of_colors = part.partition("=")[0].strip() in OF_COLORS
        (of_colors if is_of_colors else of_hits).append(part.strip())
    return ",".join(of_colors), ",".join(of_hits) or None


def _about_colors(
    array: NDArray[Any],
    right: NDArray[Any],
    difference: Difference,
    allow: str,
    scene: Scene,
    camera: Camera | None,
    exact: Picture,
    crop: tuple[int, int, int, int] | None,
    samples: int | None,
) -> str:
    lines = [f"the picture is not the exact one: {'; '.join(difference.broken)}"]
    beyond = np.asarray(difference.beyond)
    off = abs(array.astype(float) - right).max(axis=2).ravel()[beyond]
    # The worst first; not a number is worse than any.
    worst = beyond[np.argsort(-np.nan_to_num(off, nan=np.inf), kind="stable")]
    left, top = (0, 0) if crop is None else crop[:2]
    for place in worst[:3]:
        y, x = divmod(int(place), exact.width)
        id = int(exact.id[y, x])
        name = scene.name(id) if id else None
        sees = f"object {id}" + (f" “{name}”" if name else "") if id else "the background"
        lines.append(f"  {left + x},{top + y}: is {_color(array[y, x])}; exact: {_color(right[y, x])}, {sees}")
    if difference.explained_by:
        lines.append(f"  with transform={difference.explained_by!r} nearly all of it is right")
    elif len(compare(array[..., ::-1], right, allow=allow).beyond) < len(beyond) / 2:
        lines.append("  far more of it would be right if the channels were red, green, blue")
    y, x = divmod(int(worst[0]), exact.width)
    size = (exact.width, exact.height) if crop is None else None
    why = scene.explain(camera, (left + x, top + y), size=size, samples=samples)
    lines += [f"why {left + x},{top + y} is {_color(right[y, x])}:", *_why(why)]
    return "\n".join(lines)


def _color(color: NDArray[Any]) -> str:
    if color.dtype.kind == "u":
        return "#" + "".join(f"{channel:0{2 * color.itemsize}x}" for channel in color)
    return "(" + ", ".join(f"{channel:.9g}" for channel in color) + ")"


def _require(hits: HitDifference | None, what: str) -> None:
    __tracebackhide__ = True
    if hits is None or hits:
        return
    lines = [f"{what} are not the exact ones: {'; '.join(hits.broken)}", str(hits)]
    wrong = hits.worst
    if wrong:
        at = wrong[0]["ray"]
        lines += ["why:", *_why(hits.explain(at))]
    raise AssertionError("\n".join(lines))


def _why(explanation: Explanation) -> list[str]:
    """The verdicts and formulas of an explanation, without its tables and notes."""
    lines: list[str] = []
    is_note = False
    for line in str(explanation).splitlines():
        if line.startswith(("The kernel certified decided", "Formulas:")):
            break
        is_of_table = "  " in line.strip() or line.endswith("ulp")
        is_note = line.startswith(("  In the table", "  d is ")) or is_note and not is_of_table
        if not (is_of_table or is_note):
            lines.append(line)
    return lines if len(lines) <= WHY_LINES else [*lines[:WHY_LINES], "…"]
