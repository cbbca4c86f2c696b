import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Protocol, SupportsIndex, TypedDict, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Required, disjoint_base

from ._drawings import Drawing, Tinted
from ._hits import Hits

__version__: str
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

_Color = str | Sequence[float] | NDArray[Any]
_Vector = Sequence[float] | NDArray[Any]
_ColorSpace = Literal["srgb", "linear"]
_ColorMap = str | Callable[[float], Any]
_Column = str | int | Literal[False]
_Coordinate = _Column | float
_Path = str | os.PathLike[str]
_Kernel = Literal["certified", "double", "stable", "lecture"]
_View = Literal["quarter", "iso", "x", "-x", "y", "-y", "z", "-z"]
_Lang = Literal["en", "de"]
_Size = tuple[int, int]
_Crop = tuple[int, int, int, int]

class _Bar(Protocol):
    n: float
    total: float | None
    def update(self, n: float) -> Any: ...

_Progress = bool | _Bar | Callable[[int, int], object] | None

class _Plane(TypedDict, total=False):
    name: str
    point: Required[_Vector]
    normal: Required[_Vector]
    color: Required[_Color]

class _Light(TypedDict, total=False):
    position: _Vector | Literal["eye"]
    direction: _Vector
    color: _Color
    intensity: float
    shadows: bool

class _Sky(TypedDict, total=False):
    intensity: Required[float]
    directions: int

class _Columns(TypedDict, total=False):
    x: _Coordinate
    y: _Coordinate
    z: _Coordinate
    radius: _Column
    diameter: _Column
    red: _Column
    green: _Column
    blue: _Column
    color: _Column
    element: _Column

class _Finding(TypedDict):
    kind: Literal["wrong id", "wrong id at a silhouette", "t", "normal"]
    ray: int
    pixel: list[int] | None
    says: str
    exact: str

class SceneError(ValueError):
    """A scene, or a file that it names, is wrong."""

class NoAdapterError(RuntimeError):
    """No Vulkan device fits."""

class DeviceError(RuntimeError):
    """The device was lost, failed, or took too long."""

@final
class Camera:
    """A camera: perspective with `fov`, the vertical field of view in degrees (45 without it), or orthographic with
    `height`, the height of the picture in world units."""

    def __new__(
        cls,
        position: _Vector,
        look_at: _Vector,
        up: _Vector | None = None,
        fov: float | None = None,
        height: float | None = None,
    ) -> Camera: ...
    @staticmethod
    def frame(
        scene: Scene,
        view: _View | None = None,
        *,
        up: _Vector | None = None,
        fov: float | None = None,
        height: float | Literal["auto"] | None = None,
        margin: float | None = None,
        look_at: _Vector | None = None,
        size: _Size | None = None,
        n_turns: int = 1,
    ) -> Camera:
        """A camera that has all spheres of a scene in its picture, as near as can be."""
    def turntable(self, n: int) -> list[Camera]:
        """Cameras that go once around the point that is looked at, in `n` equal steps."""
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
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

@final
class Picture:
    """A picture in memory: arrays, row by row from the top, and files of them. A notebook shows it."""

    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def rgb8(self) -> NDArray[np.uint8]:
        """Colours in sRGB, bytes; shape (height, width, 3)."""
    @property
    def rgb16(self) -> NDArray[np.uint16]:
        """Colours in sRGB, 16 bits a channel; painted when they are first asked for."""
    @property
    def rgb(self) -> NDArray[np.float32]:
        """Linear colours, the nearest floats; painted when they are first asked for."""
    @property
    def alpha(self) -> NDArray[np.float32] | None: ...
    @property
    def id(self) -> NDArray[np.uint32]: ...
    @property
    def t(self) -> NDArray[np.float32]:
        """Depths; like normals traced when they are first asked for, which takes a second trace of the same rays.
        The scene's next pictures then have both from the start."""
    @property
    def normal(self) -> NDArray[np.float32]:
        """Unit normals that face the camera; traced as `t` is."""
    @property
    def level(self) -> NDArray[np.uint8]: ...
    @property
    def counts(self) -> dict[str, int]: ...
    def digest(self) -> str:
        """One hash of the picture's exact content, the same on every device."""
    def save(
        self,
        path: _Path,
        *,
        bits: Literal[8, 16] = 8,
        certificates: bool = False,
        progress: _Progress = None,
    ) -> None:
        """Writes a file; its ending (.png, .exr, .ppm, .npy) tells the format."""
    def _repr_png_(self) -> bytes: ...

@final
class Explanation:
    """One ray in numbers: the lecture's formulas at work, and what f32 makes of them."""

    @property
    def id(self) -> int:
        """Id of the object that the ray sees, exactly; 0 is the background."""
    def to_dict(self) -> dict[str, Any]: ...
    def latex(self) -> str: ...
    def _repr_latex_(self) -> str: ...

@disjoint_base
class Verdict:
    """Result of a comparison. True if no error exceeds the allowed one; `str()` is the text that the program prints."""

    @property
    def kept(self) -> bool: ...
    @property
    def broken(self) -> list[str]:
        """Errors beyond the allowed ones, a sentence each."""
    def to_dict(self) -> dict[str, Any]:
        """The whole result, under the keys of the program's `--json`."""
    def __bool__(self) -> bool: ...

@final
class Verification(Verdict):
    """Check of the promises of each kernel, on a device and on the CPU."""

@final
class Difference(Verdict):
    """Differences of two pictures. True if none exceeds the allowed one."""

    @property
    def explained_by(self) -> str | None: ...
    @property
    def n_pixels(self) -> int:
        """Number of compared pixels; 0 if the sizes differ."""
    @property
    def n_differing(self) -> int: ...
    @property
    def first(self) -> list[int] | None:
        """Column and row of the first pixel with any difference."""
    @property
    def beyond(self) -> NDArray[np.int64]:
        """Indices of the pixels, row by row, with a difference beyond the allowed one."""
    @property
    def channels(self) -> list[dict[str, Any]]: ...
    @property
    def picture(self) -> Tinted | None: ...

@final
class HitDifference(Verdict):
    """Differences of hits from the exact ones."""

    @property
    def explained_by(self) -> str | None: ...
    @property
    def by_object(self) -> list[dict[str, Any]]: ...
    @property
    def allowed(self) -> str: ...
    @property
    def n_rays(self) -> int: ...
    @property
    def away(self) -> dict[str, Any]:
        """Numbers of rays with wrong ids, and spread of errors, away from silhouettes; for a list of rays, of all rays."""
    @property
    def silhouettes(self) -> dict[str, Any] | None: ...
    @property
    def counts(self) -> dict[str, int]: ...
    @property
    def wrong(self) -> NDArray[np.int64]:
        """Indices of the rays or pixels, row by row, with an error beyond the allowed one."""
    @property
    def worst(self) -> list[_Finding]: ...
    @property
    def picture(self) -> Tinted | None: ...
    def at(self, at: SupportsIndex | Sequence[int]) -> list[_Finding]:
        """Errors of one ray beyond the allowed ones, by its index or a pixel's (column, row), as in `worst`."""
    def explain(
        self,
        at: SupportsIndex | Sequence[int],
        *,
        all: bool = False,
        lang: _Lang = "en",
        digits: int = 6,
    ) -> Explanation: ...

@final
class Comparison(Verdict):
    """Differences of a picture or hits from a scene."""

    @property
    def hits(self) -> HitDifference | None: ...
    @property
    def colors(self) -> Difference | None: ...
    @property
    def explained_by(self) -> str | None: ...
    @property
    def picture(self) -> Tinted | None: ...

@final
class Scene:
    """Spheres, planes and their light."""

    def __new__(
        cls,
        spheres: ArrayLike | None = None,
        *,
        radius: ArrayLike | None = None,
        color: _Color | Sequence[str] | ArrayLike | None = None,
        color_by: ArrayLike | None = None,
        colormap: _ColorMap | None = None,
        range: tuple[float, float] | Sequence[float] | None = None,
        missing_color: _Color | None = None,
        names: Sequence[str | None] | Mapping[int, str] | None = None,
        planes: Sequence[_Plane] | None = None,
        lights: Sequence[_Light] | None = None,
        sky: _Sky | None = None,
        ambient: float | _Color | None = None,
        background: _Color | None = None,
        camera: Camera | None = None,
        size: _Size | None = None,
        samples: int | None = None,
        color_space: _ColorSpace | None = None,
    ) -> Scene: ...
    @staticmethod
    def open(
        path: _Path,
        *,
        radius: float | None = None,
        color: _Color | None = None,
        color_by: str | int | None = None,
        color_space: _ColorSpace | None = None,
        colormap: _ColorMap | None = None,
        range: tuple[float, float] | Sequence[float] | None = None,
        missing_color: _Color | None = None,
        columns: _Columns | None = None,
        header: int | None = None,
        missing: Literal["skip"] | None = None,
        frame: int | None = None,
        view: _View | None = None,
        up: _Vector | None = None,
        fov: float | None = None,
        height: float | Literal["auto"] | None = None,
        margin: float | None = None,
        size: _Size | None = None,
        samples: int | None = None,
        progress: _Progress = None,
    ) -> Scene:
        """Reads a scene file (.toml), or makes a scene of data: NumPy arrays, tables of text, .xyz, LAMMPS dumps, also
        compressed with gzip."""
    @staticmethod
    def parse(text: str, path: _Path = "scene.toml") -> Scene: ...
    @staticmethod
    def generate(
        count: int,
        distribution: Literal["uniform", "lattice", "packing"] = "uniform",
        *,
        seed: int = 0,
    ) -> Scene:
        """A cloud of spheres made up from a seed, the same on every machine, with a camera."""
    def replace(
        self,
        *,
        camera: Camera | None = ...,
        size: _Size | None = ...,
        samples: int | None = ...,
        planes: Sequence[_Plane] | None = ...,
        lights: Sequence[_Light] | None = ...,
        sky: _Sky | None = ...,
        ambient: float | _Color | None = ...,
        background: _Color | None = ...,
        color_space: _ColorSpace | None = None,
    ) -> Scene:
        """The scene with some things changed; None takes one away. The spheres are shared."""
    def save(self, path: _Path) -> None: ...
    @property
    def n_spheres(self) -> int: ...
    @property
    def n_planes(self) -> int: ...
    @property
    def spheres(self) -> NDArray[np.float64]: ...
    @property
    def colors(self) -> NDArray[np.float64]:
        """Linear colours of the spheres, shape (N, 3)."""
    @property
    def camera(self) -> Camera | None: ...
    @property
    def size(self) -> _Size | None: ...
    @property
    def samples(self) -> int | None: ...
    @property
    def is_lit(self) -> bool: ...
    @property
    def notes(self) -> list[str]:
        """What the reader of its files chose or understood: sentences."""
    def name(self, id: int) -> str | None: ...
    def hash(self) -> str: ...
    def legend(self) -> Drawing | None: ...
    def check(self, camera: Camera | None = None, size: _Size | None = None) -> dict[str, Any]:
        """What the scene holds and what a picture of it takes."""
    def export(
        self,
        path: _Path,
        language: Literal["pov", "tachyon"] = "pov",
        camera: Camera | None = None,
        size: _Size | None = None,
    ) -> str:
        """Writes the scene for another renderer; returns the command that renders it."""
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
        size: _Size | None = None,
        *,
        samples: int | None = None,
        crop: _Crop | None = None,
        transparent: bool = False,
        device: str = "auto",
        kernel: _Kernel = "certified",
        epsilon: float = 0.0,
        progress: _Progress = None,
    ) -> Picture: ...
    def explain(
        self,
        camera: Camera | None = None,
        pixel: tuple[int, int] | None = None,
        *,
        ray: tuple[_Vector, _Vector] | None = None,
        size: _Size | None = None,
        samples: int | None = None,
        all: bool = False,
        lang: _Lang = "en",
        digits: int = 6,
        device: str = "cpu",
    ) -> Explanation: ...
    def verify(
        self,
        camera: Camera | None = None,
        size: _Size | None = None,
        *,
        crop: _Crop | None = None,
        samples: int | None = None,
        seed: int = 0,
        kernel: _Kernel | Literal["all"] = "certified",
        device: str = "auto",
        progress: _Progress = None,
    ) -> Verification: ...
    def digest(
        self,
        camera: Camera | None = None,
        size: _Size | None = None,
        *,
        samples: int | None = None,
        crop: _Crop | None = None,
        device: str = "auto",
        progress: _Progress = None,
    ) -> str:
        """The digest of a picture, band by band: that of `render(…).digest()`."""
    def show(
        self,
        what: str,
        camera: Camera | None = None,
        size: _Size | None = None,
        *,
        crop: _Crop | None = None,
        device: str = "auto",
        kernel: _Kernel = "certified",
        progress: _Progress = None,
    ) -> Tinted:
        """What a picture shows beside colours: "depth", "normal", "error", "stage" and others."""

def adapters() -> list[dict[str, Any]]:
    """The Vulkan adapters of this machine, the best first."""

@overload
def compare(
    a: Scene,
    b: Scene,
    *,
    camera: Camera | None = None,
    size: _Size | None = None,
    crop: _Crop | None = None,
    samples: int | None = None,
    transform: str | Sequence[str] | None = None,
    allow: str | None = "",
    device: str = "auto",
) -> Difference: ...
@overload
def compare(
    a: Scene,
    b: _Path | Picture | ArrayLike | Mapping[str, ArrayLike],
    *,
    camera: Camera | None = None,
    rays: tuple[ArrayLike, ArrayLike] | None = None,
    size: _Size | None = None,
    crop: _Crop | None = None,
    samples: int | None = None,
    transform: str | Sequence[str] | None = None,
    allow: str | None = "",
    worst: int = 3,
    device: str = "auto",
    progress: _Progress = None,
) -> Comparison: ...
@overload
def compare(
    a: _Path | Picture | ArrayLike | Mapping[str, ArrayLike],
    b: Scene,
    *,
    camera: Camera | None = None,
    rays: tuple[ArrayLike, ArrayLike] | None = None,
    size: _Size | None = None,
    crop: _Crop | None = None,
    samples: int | None = None,
    transform: str | Sequence[str] | None = None,
    allow: str | None = "",
    worst: int = 3,
    device: str = "auto",
    progress: _Progress = None,
) -> Comparison:
    """Compares a picture or hits with the exact ones of a scene."""
@overload
def compare(
    a: _Path | Picture | ArrayLike,
    b: _Path | Picture | ArrayLike,
    *,
    transform: str | Sequence[str] | None = None,
    allow: str | None = "",
) -> Difference:
    """Compares two pictures channel by channel."""

def figure(
    number: Literal[2, 3, 4, 5],
    scene: Scene | None = None,
    camera: Camera | None = None,
    *,
    size: _Size | None = None,
    object: int | None = None,
    lang: _Lang = "en",
) -> Drawing:
    """Draws one of the lecture's figures, 3 and 4 as the camera sees them, 2 and 5 as plans."""

generate = Scene.generate

def info(path: _Path) -> dict[str, Any]:
    """What a picture's file says of itself."""

def read(path: _Path) -> dict[str, NDArray[Any]]:
    """Reads a picture or hits: an array for each channel, named as the file names it."""
