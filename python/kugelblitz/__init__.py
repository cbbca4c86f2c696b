"""Certified ray tracing of spheres and planes: arrays in, hits and pictures out."""

from ._hits import Hits
from ._kugelblitz import (
    Camera,
    DeviceError,
    Difference,
    Drawing,
    Explanation,
    Judgement,
    NoAdapterError,
    Picture,
    Scene,
    SceneError,
    Tinted,
    Verification,
    __version__,
    adapters,
    compare,
    figure,
    info,
    read,
)

__all__ = [
    "Camera",
    "DeviceError",
    "Difference",
    "Drawing",
    "Explanation",
    "Hits",
    "Judgement",
    "NoAdapterError",
    "Picture",
    "Scene",
    "SceneError",
    "Tinted",
    "Verification",
    "__version__",
    "adapters",
    "compare",
    "figure",
    "generate",
    "info",
    "read",
]

generate = Scene.generate
