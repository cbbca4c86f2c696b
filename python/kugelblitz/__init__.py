"""Certified ray tracing of spheres and planes: arrays in, hits and pictures out."""

from ._drawings import Drawing, Tinted
from ._hits import Hits
from ._kugelblitz import (
    Camera,
    DeviceError,
    Explanation,
    NoAdapterError,
    Picture,
    Scene,
    SceneError,
    __version__,
    adapters,
    compare,
    figure,
    info,
    read,
)
from ._verdicts import Difference, Judgement, Verdict, Verification

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
    "Verdict",
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
