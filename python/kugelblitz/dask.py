"""Pictures and hits on many machines, with Dask.

Every worker's bytes are the same, whatever device it has: with the kernel ``certified``, ids, depths, normals and
colours are those of exact arithmetic. So a task may be done by any worker, and twice, and nothing changes.
"""

# Most of what Dask has is without types.
# mypy: disable-error-code="no-untyped-call, no-any-return"

from __future__ import annotations

import uuid
from collections.abc import Iterable
from typing import Any
from weakref import WeakKeyDictionary

import dask.array as da
import numpy as np
from dask.delayed import delayed
from distributed import Client, WorkerPlugin, default_client, get_worker, wait
from numpy.typing import ArrayLike, NDArray

from . import Camera, Scene
from ._hits import DTYPE

#: Fields of a picture, with the shape and type of a pixel.
FIELDS: dict[str, tuple[tuple[int, ...], Any]] = {
    "rgb8": ((3,), np.uint8),
    "rgb": ((3,), np.float32),
    "id": ((), np.uint32),
    "t": ((), np.float32),
    "normal": ((3,), np.float32),
}

#: Most pixels of a band. A worker holds some 24 bytes for each while it draws.
BAND_PIXELS = 1 << 21


def render(
    scene: Scene,
    camera: Camera | None = None,
    size: tuple[int, int] | None = None,
    *,
    field: str = "rgb8",
    client: Client | None = None,
    rows: int | None = None,
    **options: Any,
) -> da.Array:
    """A picture as a dask array, cut into bands of rows; each is a task.

    ``camera`` and ``size`` (width, height) are the scene's own unless they are given. ``field`` is one of
    ``FIELDS``. ``client`` is a ``distributed.Client``, the current one if there is one: it sends the scene to each
    worker once, where its tree is built once. ``rows`` of a band are chosen so that each worker gets several and
    none needs much memory. ``options`` are those of :meth:`kugelblitz.Scene.render` but ``crop`` and ``progress``, such
    as ``samples`` and ``device``; what is wrong in them is said at once.
    """
    shape, dtype = _field(field)
    width, height = _size(scene, size)
    camera = _camera(scene, camera, (width, height))
    _check_render(camera, (width, height), options)
    client = _client(client)
    n_rows = _band_rows(width, height, client) if rows is None else int(rows)
    if n_rows < 1:
        raise ValueError(f"rows: {rows}, but a band has one row or more")
    held = _held(scene, client)
    bands = []
    for y in range(0, height, n_rows):
        n = min(n_rows, height - y)
        band = delayed(_band, pure=False)(held, camera, (width, height), (0, y, width, n), field, options)
        bands.append(da.from_delayed(band, (n, width, *shape), dtype))
    return da.concatenate(bands, axis=0)


def frames(
    scene: Scene,
    cameras: Iterable[Camera],
    size: tuple[int, int] | None = None,
    *,
    field: str = "rgb8",
    client: Client | None = None,
    **options: Any,
) -> da.Array:
    """The pictures of several cameras as a dask array, whose first axis is the camera; each is a task.

    ``size`` is the scene's own unless it is given; ``options`` are those of :func:`render`."""
    shape, dtype = _field(field)
    width, height = _size(scene, size)
    cameras = list(cameras)
    if not cameras:
        raise ValueError("cameras: there is none")
    for camera in cameras:
        _check_render(camera, (width, height), options)
    held = _held(scene, _client(client))
    crop = (0, 0, width, height)
    pictures = [
        da.from_delayed(
            delayed(_band, pure=False)(held, camera, (width, height), crop, field, options),
            (height, width, *shape),
            dtype,
        )
        for camera in cameras
    ]
    return da.stack(pictures, axis=0)


def trace(
    scene: Scene,
    origins: ArrayLike | da.Array,
    directions: ArrayLike | da.Array,
    *,
    client: Client | None = None,
    **options: Any,
) -> da.Array:
    """The hits of rays in dask arrays of shape (N, 3): a structured dask array of shape (N,), with the chunks of
    ``origins``. ``options`` are those of :meth:`kugelblitz.Scene.trace` but ``progress``."""
    _refuse(options, "progress")
    Scene().trace([[0, 0, 0]], [[0, 0, 1]], **_on_the_cpu(options))
    starts, ways = da.asarray(origins), da.asarray(directions)
    for name, array in [("origins", starts), ("directions", ways)]:
        if array.ndim != 2 or array.shape[1] != 3:
            raise ValueError(f"{name}: the shape is {array.shape}, but {name} are (N, 3)")
    if starts.shape != ways.shape:
        raise ValueError(f"directions: {len(ways)} rows, but `origins` has {len(starts)}")
    starts = starts.rechunk({1: -1})
    ways = ways.rechunk({0: starts.chunks[0], 1: -1})
    held = _held(scene, _client(client))
    parts = zip(starts.to_delayed().ravel(), ways.to_delayed().ravel(), starts.chunks[0])
    hits = [da.from_delayed(delayed(_hits, pure=False)(held, o, d, options), (n,), DTYPE) for o, d, n in parts]
    return da.concatenate(hits, axis=0)


def _field(name: str) -> tuple[tuple[int, ...], Any]:
    if name not in FIELDS:
        raise ValueError(f"field: there is no {name!r}; give one of {', '.join(FIELDS)}")
    return FIELDS[name]


def _camera(scene: Scene, camera: Camera | None, size: tuple[int, int]) -> Camera:
    """The camera, the scene's own, or one that frames all spheres."""
    camera = scene.camera if camera is None else camera
    if camera is None and scene.n_spheres == 0:
        raise ValueError("camera: the scene has none, and no spheres that one could frame; give one, for example "
                         "Camera((0, 1, 6), (0, 0, 0))")
    return Camera.frame(scene, size=size) if camera is None else camera


def _size(scene: Scene, size: tuple[int, int] | None) -> tuple[int, int]:
    """Width and height, whole numbers as :meth:`kugelblitz.Scene.render` takes them."""
    if size is None:
        return scene.size or (1280, 720)
    checked = Scene().replace(size=size).size
    assert checked is not None
    return checked


def _refuse(options: dict[str, Any], *names: str) -> None:
    for name in names:
        if name in options:
            why = "bands are parts of the picture already; cut the array instead" if name == "crop" else "see the client's"
            raise TypeError(f"{name}: this is not for many machines: {why}")


def _on_the_cpu(options: dict[str, Any]) -> dict[str, Any]:
    """The options with the device of this machine that there always is: which ones workers have, they know."""
    device = options.get("device", "auto")
    if not (isinstance(device, str) and device):
        raise ValueError(f"device: {device!r}; give auto, gpu, cpu or a part of an adapter's name")
    return {**options, "device": "cpu"}


def _check_render(camera: Camera, size: tuple[int, int], options: dict[str, Any]) -> None:
    """Raises what a worker would raise, by a pixel of nothing."""
    _refuse(options, "crop", "progress")
    Scene().render(camera, size, crop=(0, 0, 1, 1), **_on_the_cpu(options))


def _client(client: Client | None) -> Client | None:
    """The client that is given or current, or None."""
    if client is not None:
        return client
    try:
        return default_client()
    except ValueError:
        return None


def _band_rows(width: int, height: int, client: Client | None) -> int:
    """Rows of a band: some four for each worker, so that a slow one holds up little."""
    n_workers = max(1, len(client.nthreads())) if client is not None else 1
    return max(1, min(-(-height // (4 * n_workers)), BAND_PIXELS // width))


# A scene on the workers. A plugin takes it there: Dask gives it to each worker once, also to those that join later or
# start again, before they get tasks. Data that is scattered would be lost with the workers that have it, and Dask
# drops copies that no task waits for, and the tree with them.
#
# Tasks depend on an anchor, a future whose value is the plugin's name. It tells how long the scene is needed: the
# scheduler forgets it when the scene is none of the last ones, whose anchors are kept here, and no array or result of it
# is left.

_PREFIX = "kugelblitz-scene-"
_LAST_SCENES = 2
_ANCHORS: WeakKeyDictionary[Any, list[tuple[Scene, Any]]] = WeakKeyDictionary()


class _Carrier(WorkerPlugin):  # type: ignore[misc, unused-ignore]
    """Carries a scene to a worker."""

    def __init__(self, name: str, scene: Scene) -> None:
        self.name = name
        self.scene = scene


def _held(scene: Scene, client: Client | None) -> Any:
    """The scene as a task takes it: with a client, the anchor of the one that each worker has."""
    if client is None:
        return delayed(scene, pure=False, traverse=False)
    anchors = _ANCHORS.setdefault(client, [])
    for known, anchor in anchors:
        if known is scene and not anchor.cancelled():
            return anchor
    del anchors[: 1 - _LAST_SCENES]
    name = _PREFIX + uuid.uuid4().hex
    anchor = client.submit(str, name, key=name)
    anchors.append((scene, anchor))
    # By then the scheduler knows of the anchors that were let go.
    wait(anchor)
    _forget_unused(client)
    client.register_plugin(_Carrier(name, scene))
    return anchor


def _forget_unused(client: Client) -> None:
    """Takes scenes from the workers that no array needs any more."""

    def unused(dask_scheduler: Any) -> list[str]:
        names = [name for name in dask_scheduler.worker_plugins if name.startswith(_PREFIX)]
        return [name for name in names if name not in dask_scheduler.tasks]

    for name in client.run_on_scheduler(unused):
        client.unregister_worker_plugin(name)


def _scene(held: Any) -> Scene:
    """The scene, in a task."""
    if not isinstance(held, str):
        return held
    plugins: Any = get_worker().plugins
    return plugins[held].scene


def _band(
    held: Any,
    camera: Camera,
    size: tuple[int, int],
    crop: tuple[int, int, int, int],
    field: str,
    options: dict[str, Any],
) -> Any:
    return getattr(_scene(held).render(camera, size, crop=crop, **options), field)


def _hits(held: Any, origins: ArrayLike, directions: ArrayLike, options: dict[str, Any]) -> NDArray[Any]:
    return np.asarray(_scene(held).trace(origins, directions, **options)).view(DTYPE)
