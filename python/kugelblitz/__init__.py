"""Certified ray tracing of spheres and planes: arrays in, hits and pictures out."""

from importlib import import_module

from ._kugelblitz import (
    Camera,
    Comparison,
    DeviceError,
    Difference,
    Explanation,
    HitDifference,
    NoAdapterError,
    Picture,
    Scene,
    SceneError,
    Verdict,
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
    "Comparison",
    "DeviceError",
    "Difference",
    "Drawing",
    "Explanation",
    "HitDifference",
    "Hits",
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

# Modules that need numpy, imported on first use: the command `kugelblitz` starts without it.
_MODULES = {"Drawing": "_drawings", "Hits": "_hits", "Tinted": "_drawings"}


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_MODULES[name]}", __name__), name)
