"""Certified ray tracing of spheres and planes: arrays in, hits and pictures out."""

from ._hits import Hits
from ._kugelblitz import (
    Camera,
    DeviceError,
    NoAdapterError,
    Picture,
    Scene,
    SceneError,
    __version__,
    adapters,
)

__all__ = [
    "Camera",
    "DeviceError",
    "Hits",
    "NoAdapterError",
    "Picture",
    "Scene",
    "SceneError",
    "__version__",
    "adapters",
]
