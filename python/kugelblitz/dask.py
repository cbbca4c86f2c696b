"""Pictures and hits on many machines, with Dask.

Every worker's bytes are the same, whatever device it has: with the kernel ``certified``, ids, depths, normals and
colours are those of exact arithmetic. So a task may be done by any worker, and twice, and nothing changes.
"""

import dask.array as da
import numpy as np
from dask import delayed

from ._hits import DTYPE

#: Fields of a picture, with the shape and type of a pixel.
FIELDS = {
    "rgb8": ((3,), np.uint8),
    "rgb": ((3,), np.float32),
    "id": ((), np.uint32),
    "t": ((), np.float32),
    "normal": ((3,), np.float32),
}


def render(scene, camera, size, *, field="rgb8", client=None, rows=None, **options):
    """A picture as a dask array, cut into bands of rows; each is a task.

    ``field`` is one of ``FIELDS``. ``client`` is a ``distributed.Client``: the scene is then sent to each worker
    once, and its tree built there once. ``rows`` of a band are chosen so that each worker gets several.
    ``options`` are those of :meth:`kugelblitz.Scene.render`, such as ``samples`` and ``device``.
    """
    shape, dtype = _field(field)
    width, height = size
    n_rows = rows or _band_rows(height, client)
    held = _held(scene, client)
    bands = []
    for y in range(0, height, n_rows):
        n = min(n_rows, height - y)
        band = delayed(_band, pure=False)(held, camera, size, (0, y, width, n), field, options)
        bands.append(da.from_delayed(band, (n, width, *shape), dtype))
    return da.concatenate(bands, axis=0)


def frames(scene, cameras, size, *, field="rgb8", client=None, **options):
    """The pictures of several cameras as a dask array, whose first axis is the camera; each is a task."""
    shape, dtype = _field(field)
    width, height = size
    held = _held(scene, client)
    crop = (0, 0, width, height)
    pictures = [
        da.from_delayed(
            delayed(_band, pure=False)(held, camera, size, crop, field, options),
            (height, width, *shape),
            dtype,
        )
        for camera in cameras
    ]
    return da.stack(pictures, axis=0)


def trace(scene, origins, directions, *, client=None, **options):
    """The hits of rays in dask arrays of shape (N, 3): a structured dask array of shape (N,), with the chunks of
    ``origins``. ``options`` are those of :meth:`kugelblitz.Scene.trace`."""
    origins = da.asarray(origins).rechunk({1: -1})
    directions = da.asarray(directions).rechunk({0: origins.chunks[0], 1: -1})
    held = _held(scene, client)
    parts = zip(origins.to_delayed().ravel(), directions.to_delayed().ravel(), origins.chunks[0])
    hits = [
        da.from_delayed(delayed(_hits, pure=False)(held, o, d, options), (n,), DTYPE)
        for o, d, n in parts
    ]
    return da.concatenate(hits, axis=0)


def _field(name):
    if name not in FIELDS:
        raise ValueError(f"field: there is no {name!r}; give one of {', '.join(FIELDS)}")
    return FIELDS[name]


def _held(scene, client):
    """The scene as a task takes it: on each worker already, where there is a client."""
    if client is None:
        return delayed(scene, pure=False, traverse=False)
    return client.scatter(scene, broadcast=True, hash=False)


def _band_rows(height, client):
    """Rows of a band: some four for each worker, so that a slow one holds up little."""
    n_workers = len(client.nthreads()) if client is not None else 1
    return max(1, -(-height // (4 * n_workers)))


def _band(scene, camera, size, crop, field, options):
    return getattr(scene.render(camera, size, crop=crop, **options), field)


def _hits(scene, origins, directions, options):
    return np.asarray(scene.trace(origins, directions, **options)).view(DTYPE)
