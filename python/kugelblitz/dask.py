"""Pictures and hits on many machines, with Dask.

Every worker's bytes are the same, whatever device it has: with the kernel ``certified``, ids, depths, normals and
colours are those of exact arithmetic. So a task may be done by any worker, and twice, and nothing changes.
"""

import uuid
from weakref import WeakKeyDictionary

import dask.array as da
import numpy as np
from dask import delayed
from distributed import WorkerPlugin, default_client, get_worker, wait

from ._hits import DTYPE

#: Fields of a picture, with the shape and type of a pixel.
FIELDS = {
    "rgb8": ((3,), np.uint8),
    "rgb": ((3,), np.float32),
    "id": ((), np.uint32),
    "t": ((), np.float32),
    "normal": ((3,), np.float32),
}

#: Most pixels of a band. A worker holds some 24 bytes for each while it draws.
BAND_PIXELS = 1 << 21


def render(scene, camera=None, size=None, *, field="rgb8", client=None, rows=None, **options):
    """A picture as a dask array, cut into bands of rows; each is a task.

    ``camera`` and ``size`` (width, height) are the scene file's own unless they are given. ``field`` is one of
    ``FIELDS``. ``client`` is a ``distributed.Client``, the current one if there is one: it sends the scene to each
    worker once, where its tree is built once. ``rows`` of a band are chosen so that each worker gets several and
    none needs much memory. ``options`` are those of :meth:`kugelblitz.Scene.render`, such as ``samples`` and
    ``device``.
    """
    shape, dtype = _field(field)
    camera, (width, height) = _camera(scene, camera), _size(scene, size)
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


def frames(scene, cameras, size=None, *, field="rgb8", client=None, **options):
    """The pictures of several cameras as a dask array, whose first axis is the camera; each is a task."""
    shape, dtype = _field(field)
    width, height = _size(scene, size)
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
    if not pictures:
        raise ValueError("cameras: there is none")
    return da.stack(pictures, axis=0)


def trace(scene, origins, directions, *, client=None, **options):
    """The hits of rays in dask arrays of shape (N, 3): a structured dask array of shape (N,), with the chunks of
    ``origins``. ``options`` are those of :meth:`kugelblitz.Scene.trace`."""
    origins, directions = da.asarray(origins), da.asarray(directions)
    for name, array in [("origins", origins), ("directions", directions)]:
        if array.ndim != 2 or array.shape[1] != 3:
            raise ValueError(f"{name}: the shape is {array.shape}, but {name} are (N, 3)")
    if origins.shape != directions.shape:
        raise ValueError(f"directions: {len(directions)} rows, but `origins` has {len(origins)}")
    origins = origins.rechunk({1: -1})
    directions = directions.rechunk({0: origins.chunks[0], 1: -1})
    held = _held(scene, _client(client))
    parts = zip(origins.to_delayed().ravel(), directions.to_delayed().ravel(), origins.chunks[0])
    hits = [da.from_delayed(delayed(_hits, pure=False)(held, o, d, options), (n,), DTYPE) for o, d, n in parts]
    return da.concatenate(hits, axis=0)


def _field(name):
    if name not in FIELDS:
        raise ValueError(f"field: there is no {name!r}; give one of {', '.join(FIELDS)}")
    return FIELDS[name]


def _camera(scene, camera):
    if camera is None and scene.camera is None:
        raise ValueError("camera: the scene has none; give one, e.g. Camera((0, 1, 6), (0, 0, 0))")
    return scene.camera if camera is None else camera


def _size(scene, size):
    """Width and height as the scene takes them."""
    width, height = (1280, 720) if size is None else size
    return int(width), int(height)


def _client(client):
    """The client that is given or current, or None."""
    if client is not None:
        return client
    try:
        return default_client()
    except ValueError:
        return None


def _band_rows(width, height, client):
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
_ANCHORS = WeakKeyDictionary()


class _Carrier(WorkerPlugin):
    """Carries a scene to a worker."""

    def __init__(self, name, scene):
        self.name = name
        self.scene = scene


def _held(scene, client):
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


def _forget_unused(client):
    """Takes scenes from the workers that no array needs any more."""

    def unused(dask_scheduler):
        names = [name for name in dask_scheduler.worker_plugins if name.startswith(_PREFIX)]
        return [name for name in names if name not in dask_scheduler.tasks]

    for name in client.run_on_scheduler(unused):
        client.unregister_worker_plugin(name)


def _scene(held):
    """The scene, in a task."""
    return get_worker().plugins[held].scene if isinstance(held, str) else held


def _band(held, camera, size, crop, field, options):
    return getattr(_scene(held).render(camera, size, crop=crop, **options), field)


def _hits(held, origins, directions, options):
    return np.asarray(_scene(held).trace(origins, directions, **options)).view(DTYPE)
