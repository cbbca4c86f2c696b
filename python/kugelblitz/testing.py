"""Assertions for tests: hits and pictures are those that exact arithmetic gives.

Messages say which ray or pixel is wrong, what is right there, and why.
"""

import numpy as np

from ._kugelblitz import Picture

#: Lines of the explanation of the worst ray or pixel in a message.
WHY_LINES = 60


def assert_hits(hits, scene, rays, *, allow=None, **conventions):
    """Fails unless hits of rays are the exact ones.

    ``hits`` is what :meth:`kugelblitz.Scene.trace` gives, another structured array with ``id`` and perhaps ``t`` and
    ``normal``, or a dictionary of arrays with those keys. ``rays`` is (origins, directions), or an array of shape
    (N, 6). ``allow`` says what may be wrong, as ``kugelblitz judge --allow`` takes it: ``"ids=0.1%,t=1e-5"``.
    ``conventions`` are those of :meth:`kugelblitz.Scene.judge`, such as ``id_offset=1``.
    """
    __tracebackhide__ = True
    if not isinstance(rays, tuple):
        array = np.asarray(rays)
        if array.ndim != 2 or array.shape[1] != 6:
            raise ValueError(f"rays: the shape is {array.shape}; give (origins, directions), or an array of (N, 6)")
        rays = array[:, :3], array[:, 3:]
    claims = dict(hits) if isinstance(hits, dict) else {"against": hits}
    _require(scene.judge(rays, **claims, allow=allow, **conventions), "hits")


def assert_picture(array, scene, camera=None, *, samples=None, transparent=False, levels=0, atol=0.0, pixels=0,
                   device="auto"):
    """Fails unless a picture is the exact one.

    ``array`` has shape (height, width, 3), with the first row on top: sRGB as bytes, or linear floats, which are
    compared as f32. So may be a structured array of shape (height, width) with ``id`` and perhaps ``t``, ``normal``
    and ``rgb``, or a :class:`kugelblitz.Picture`, of which all is looked at. Bytes may be off by ``levels``, floats
    by ``atol``, and ``pixels`` of them by more.
    """
    __tracebackhide__ = True
    if isinstance(array, Picture):
        fields = {name: getattr(array, name) for name in ("id", "t", "normal")}
        _require(scene.judge(camera, **fields), "pixels")
        array = array.rgb8
    array = np.asarray(array)
    if array.dtype.names:
        _require(scene.judge(camera, **{n: array[n] for n in ("id", "t", "normal") if n in array.dtype.names}), "pixels")
        if "rgb" not in array.dtype.names:
            return
        array = array["rgb"]
    is_bytes = array.dtype == np.uint8
    if array.ndim != 3 or array.shape[2] != 3 or not (is_bytes or array.dtype.kind == "f"):
        raise ValueError(f"array: shape {array.shape} of {array.dtype}; a picture has (height, width, 3) bytes or floats")
    height, width = array.shape[:2]
    exact = scene.render(camera, (width, height), samples=samples, transparent=transparent, device=device)
    right = exact.rgb8 if is_bytes else exact.rgb
    off, allowed = _off(array, right), levels if is_bytes else atol
    # Not a number is off by anything.
    wrong = ~(off <= allowed)
    if wrong.sum() <= pixels:
        return
    raise AssertionError(_about_colors(array, right, off, wrong, allowed, scene, camera, exact))


def _off(array, right):
    """How far each pixel is off, in its worst channel."""
    array = array.astype(np.int64) if array.dtype == np.uint8 else array.astype(np.float32).astype(np.float64)
    with np.errstate(invalid="ignore"):
        return abs(array - right).max(axis=2)


def _about_colors(array, right, off, wrong, allowed, scene, camera, exact):
    height, width = wrong.shape
    lines = [f"{wrong.sum()} of {width}×{height} pixels are off by more than {allowed}"]
    worst = np.where(wrong, np.where(np.isnan(off), np.inf, off), -1)
    for place in np.argsort(-worst, axis=None, kind="stable")[: min(3, wrong.sum())]:
        y, x = divmod(int(place), width)
        id = int(exact.id[y, x])
        name = scene.name(id) if id else None
        sees = f"object {id}" + (f" “{name}”" if name else "") if id else "the background"
        lines.append(f"  {x},{y}: is {_color(array[y, x])}; exact: {_color(right[y, x])}, {sees}")
    for convention, other in [
        ("the first row were the top one", array[::-1]),
        ("columns began on the left", array[:, ::-1]),
        ("the channels were red, green, blue", array[..., ::-1]),
    ]:
        if (~(_off(other, right) <= allowed)).sum() < wrong.sum() / 2:
            lines.append(f"  far more of it would be right if {convention}")
    y, x = divmod(int(np.argmax(worst)), width)
    why = scene.explain(camera, (x, y), size=(width, height))
    lines += [f"why {x},{y} is {_color(right[y, x])}:", *_head(str(why))]
    return "\n".join(lines)


def _color(color):
    if color.dtype == np.uint8:
        return "#" + "".join(f"{channel:02x}" for channel in color)
    return "(" + ", ".join(f"{channel:.9g}" for channel in color) + ")"


def _require(judgement, what):
    __tracebackhide__ = True
    if judgement:
        return
    lines = [f"{what} are not the exact ones: {'; '.join(judgement.broken)}", str(judgement)]
    wrong = judgement.worst
    if wrong:
        at = wrong[0]["ray"]
        lines += ["why:", *_head(str(judgement.explain(at)))]
    raise AssertionError("\n".join(lines))


def _head(text):
    lines = text.splitlines()
    return lines if len(lines) <= WHY_LINES else [*lines[:WHY_LINES], "…"]
