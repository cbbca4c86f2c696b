import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
__all__: list[str]

_Color = str | Sequence[float]
_Vector = Sequence[float] | NDArray[Any]
_Path = str | os.PathLike[str]
_Kernel = Literal["certified", "double", "stable", "lecture"]

class _Bar(Protocol):
    n: float
    total: float | None
    def update(self, n: float) -> Any: ...

_Progress = bool | _Bar | Callable[[int, int], object] | None

class SceneError(ValueError): ...
class NoAdapterError(RuntimeError): ...
class DeviceError(RuntimeError): ...

class Hits(np.recarray[Any, Any]):
    counts: dict[str, int] | None
    id: NDArray[np.uint32]
    t: NDArray[np.float32]
    normal: NDArray[np.float32]
    level: NDArray[np.uint8]

class Camera:
    def __init__(
        self,
        position: _Vector,
        look_at: _Vector,
        up: _Vector = (0.0, 1.0, 0.0),
        fov: float | None = None,
        height: float | None = None,
    ) -> None: ...
    @property
    def position(self) -> list[float]: ...
    @property
    def look_at(self) -> list[float]: ...
    @property
    def up(self) -> list[float]: ...
    @property
    def fov(self) -> float | None: ...
    @property
    def height(self) -> float | None: ...

class Picture:
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def rgb8(self) -> NDArray[np.uint8]: ...
    @property
    def rgb(self) -> NDArray[np.float32]: ...
    @property
    def alpha(self) -> NDArray[np.float32] | None: ...
    @property
    def id(self) -> NDArray[np.uint32]: ...
    @property
    def t(self) -> NDArray[np.float32]: ...
    @property
    def normal(self) -> NDArray[np.float32]: ...
    @property
    def level(self) -> NDArray[np.uint8]: ...
    @property
    def counts(self) -> dict[str, int]: ...
    def digest(self) -> str: ...
    def save(
        self,
        path: _Path,
        *,
        bits: Literal[8, 16] = 8,
        certificates: bool = False,
        progress: _Progress = None,
    ) -> None: ...
    def _repr_png_(self) -> bytes: ...

class Scene:
    def __init__(
        self,
        spheres: ArrayLike | None = None,
        *,
        radius: ArrayLike | None = None,
        color: _Color | ArrayLike | None = None,
        planes: Sequence[Mapping[str, Any]] | None = None,
        lights: Sequence[Mapping[str, Any]] | None = None,
        sky: Mapping[str, Any] | None = None,
        ambient: float | _Color | None = None,
        background: _Color | None = None,
    ) -> None: ...
    @staticmethod
    def open(path: _Path, *, progress: _Progress = None) -> Scene: ...
    @staticmethod
    def parse(text: str, path: _Path = "scene.toml") -> Scene: ...
    def save(self, path: _Path) -> None: ...
    @property
    def n_spheres(self) -> int: ...
    @property
    def n_planes(self) -> int: ...
    @property
    def spheres(self) -> NDArray[np.float64]: ...
    @property
    def colors(self) -> NDArray[np.float64]: ...
    @property
    def camera(self) -> Camera | None: ...
    def name(self, id: int) -> str | None: ...
    def trace(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        device: str = "auto",
        kernel: _Kernel = "certified",
        progress: _Progress = None,
    ) -> Hits: ...
    def render(
        self,
        camera: Camera | None = None,
        size: tuple[int, int] | None = None,
        *,
        samples: int | None = None,
        crop: tuple[int, int, int, int] | None = None,
        transparent: bool = False,
        device: str = "auto",
        kernel: _Kernel = "certified",
        epsilon: float = 0.0,
        progress: _Progress = None,
    ) -> Picture: ...

def adapters() -> list[dict[str, Any]]: ...
