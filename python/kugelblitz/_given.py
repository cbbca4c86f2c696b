"""What users give, as texts and arrays that the library reads."""

# Masked arrays are without types.
# mypy: disable-error-code="attr-defined, no-untyped-call"

import io
import json
import os
from collections.abc import Callable, Mapping, Sequence
from operator import getitem
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

from ._kugelblitz import Picture, linear_color, linear_from_srgb, require

#: Lists and dictionaries within each other that a value of a scene file may have.
MAX_DEPTH = 4


def toml(subject: str, given: Any, depth: int = MAX_DEPTH) -> str:
    """The value of a scene file that an object stands for; ``subject`` names it in errors."""
    if isinstance(given, bool):
        return str(given).lower()
    if isinstance(given, int):
        return int.__repr__(given)
    if isinstance(given, float):
        return float.__repr__(given)
    if isinstance(given, str):
        # What JSON may leave as it is, TOML may not.
        return json.dumps(given, ensure_ascii=False).replace("\x7f", "\\u007f")
    if depth > 0:
        if isinstance(given, dict) and all(isinstance(key, str) for key in given):
            entries = ((key, toml(f"{subject}, {key}", entry, depth - 1)) for key, entry in given.items())
            return "{ " + ", ".join(f"{toml(subject, key)} = {entry}" for key, entry in entries) + " }"
        # Arrays and scalars of numpy.
        if hasattr(type(given), "tolist"):
            return toml(subject, given.tolist(), depth - 1)
        if isinstance(given, Sequence) and not isinstance(given, (bytes, bytearray)):
            return "[" + ", ".join(toml(subject, entry, depth - 1) for entry in given) + "]"
    kind = type(given).__name__
    raise TypeError(f"{subject}: a {kind} has no meaning here; give numbers, texts, lists or dictionaries")


def lines(names: list[str], given: dict[str, Any]) -> list[str]:
    """Those of these arguments that are there, as lines of a scene file."""
    return [f"{name} = {toml(name, given[name])}" for name in names if given.get(name) is not None]


def scene(given: dict[str, Any]) -> list[tuple[str, str]]:
    """The lines of a scene file that say what is there beside spheres, and which argument each of them is of."""
    found = [(line.partition(" ")[0], line) for line in lines(["background", "ambient", "sky"], given)]
    for name, key in [("planes", "plane"), ("lights", "light")]:
        entries = given.get(name)
        if entries is None:
            continue
        each = [(f"{name}[{n}]", toml(f"{name}[{n}]", entry) + ",") for n, entry in enumerate(listed(name, entries))]
        found += [(name, f"{key} = ["), *each, (name, "]")]
    return found


def listed(name: str, entries: Any) -> list[Any]:
    """Returns the dictionaries of planes or of lights."""
    try:
        if not isinstance(entries, (dict, str)):
            return list(entries)
    except Exception:
        pass
    raise TypeError(f"{name}: give a list of dictionaries, also for one")


def in_linear(given: dict[str, Any], names: list[str], is_linear: bool) -> dict[str, Any]:
    """Returns the arguments with linear colours: those of these names, of planes and of lights."""
    made = dict(given)
    for name in names:
        value = given.get(name)
        # A number is the intensity of white light.
        is_number = isinstance(value, (int, float, np.number)) or isinstance(value, np.ndarray) and value.ndim == 0
        if value is not None and not (name == "ambient" and is_number):
            made[name] = color(name, value, is_linear)
    for name in ["planes", "lights"]:
        if given.get(name) is not None:
            made[name] = listed(name, given[name])
            for n, entry in enumerate(made[name]):
                if isinstance(entry, dict) and entry.get("color") is not None:
                    made[name][n] = {**entry, "color": color(f"{name}[{n}], color", entry["color"], is_linear)}
    return made


def color(subject: str, given: Any, is_linear: bool) -> list[float]:
    """Returns a colour as linear floats: a text, or floats or bytes in sRGB (linear, if ``is_linear``), of which the fourth
    is alpha; ``subject`` names it in errors."""
    if isinstance(given, np.ndarray) and given.dtype == "u1":
        given = given / 255
    if hasattr(type(given), "tolist"):
        given = given.tolist()
    if isinstance(given, Sequence) and not isinstance(given, (str, bytes, bytearray)) and len(given) == 4:
        if not (isinstance(given[3], (int, float, np.number)) and given[3] == 1):
            raise ValueError(f"{subject}: expected an alpha of 1 (255 in bytes), as objects are opaque, found {given[3]!r}")
        given = given[:3]
    return linear_color(subject, toml(subject, given), is_linear)


def sampled(colormap: Callable[[float], Any], n: int, is_linear: bool) -> list[list[float]]:
    """Returns ``n`` linear colours of a colour map that is called with numbers from 0 to 1, as those of matplotlib are."""
    colors = []
    for number in np.linspace(0, 1, n).tolist():
        try:
            given = colormap(number)
        except Exception as error:
            raise TypeError(f"colormap: called with {number}, it raised {error!r}") from error
        colors.append(color(f"colormap: called with {number}", given, is_linear))
    return colors


def array(name: str, given: Any) -> NDArray[Any]:
    """What numpy makes an array of numbers of."""
    if isinstance(given, np.ma.MaskedArray) and (n := np.ma.count_masked(given)):
        raise ValueError(f"{name}: {n} values are masked, and nothing can stand for them; leave these rows out, or "
                         "fill them with .filled(…)")
    try:
        made = np.asarray(given)
    except Exception as error:
        raise TypeError(f"{name}: this is no array of numbers: {error}") from None
    if made.dtype.kind not in "fiu":
        raise TypeError(f"{name}: the array has the dtype {made.dtype}, but numbers are wanted: float64, float32 or "
                        "integers")
    return made


def wrong_shape(name: str, given: NDArray[Any], expected: str) -> ValueError:
    return ValueError(f"{name}: the shape is {[*given.shape]}, but {expected}")


def in_order(name: str, given: NDArray[Any], dtype: str = "=f8") -> NDArray[Any]:
    """Numbers in f64, one behind the other: where they lie, if they are that already."""
    # Also for what the library makes of them.
    require(f"{name}: {given.shape[0]} rows", 16 * given.size)
    return np.require(given, dtype, ["C", "A"])


def triples(name: str, given: Any, expected: str) -> NDArray[Any]:
    """Rows of three numbers."""
    made = array(name, given)
    if made.ndim != 2 or made.shape[1] != 3:
        raise wrong_shape(name, made, expected)
    return in_order(name, made)


def rays(origins: Any, directions: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where rays start and go to."""
    ways, starts = [
        triples(name, given, f"{name} are (N, 3)") for name, given in [("directions", directions), ("origins", origins)]
    ]
    if len(starts) != len(ways):
        raise wrong_shape("directions", ways, f"`origins` has {len(starts)} rows")
    for name, numbers, are_right, why in [
        ("origins", starts, np.isfinite(starts).all(1), "not all numbers are finite"),
        ("directions", ways, np.isfinite(ways).all(1), "not all numbers are finite"),
        ("directions", ways, ways.any(1), "it points nowhere"),
    ]:
        if not are_right.all():
            row = int(are_right.argmin())
            raise ValueError(f"{name}: row {row} (counted from 0) is {(*numbers[row].tolist(),)}: {why}")
    return starts, ways


def spheres(
    given: Any, is_linear: bool, *, radius: Any = None, color: Any = None, color_by: Any = None, names: Any = None,
    **of_colors: Any,
) -> tuple[NDArray[np.float64], Any, tuple[str, NDArray[np.float64]] | None, list[tuple[int, str]]] | None:
    """Centres with radii, colours, what numbers for colours are called and the numbers, rows with their names."""
    if color_by is None and any(of_colors.get(name) is not None for name in ["colormap", "range", "missing_color"]):
        raise ValueError("colormap, range, missing_color: they say how numbers are coloured; give them by `color_by`")
    if given is None:
        if any(argument is not None for argument in [radius, color, color_by, names]):
            raise ValueError("radius, color, color_by, names: there are no spheres that they are of")
        return None
    if color is not None and color_by is not None:
        raise ValueError("color: `color_by` gives each sphere its own; leave one of them out")
    made = balls(given, radius)
    return made, colors(color, is_linear), None if color_by is None else numbers(color_by), named(names, len(made))


def balls(given: Any, radius: Any) -> NDArray[np.float64]:
    """Centres with radii in the fourth column, out of one array or two."""
    made = array("spheres", given)
    if made.ndim != 2 or made.shape[1] not in (3, 4):
        raise wrong_shape("spheres", made, "centres are (N, 3), and with radii (N, 4)")
    n, n_columns = made.shape
    if n_columns == 4:
        if radius is not None:
            raise ValueError("radius: `spheres` has radii already, in its fourth column; leave one of them out")
        return in_order("spheres", made)
    if radius is None:
        raise ValueError("radius: `spheres` has three columns, so give the radius of all, or one of each")
    radii = array("radius", radius)
    if radii.shape not in [(), (n,)]:
        raise wrong_shape("radius", radii, f"there are {n} spheres")
    require(f"spheres: {n} rows", 64 * n)
    both = np.empty((n, 4))
    both[:, :3], both[:, 3] = made, radii
    return both


def colors(given: Any, is_linear: bool) -> Any:
    """Returns a colour of each sphere in linear floats, or in bytes in sRGB; one of all as a list of linear floats."""
    if given is None:
        return None
    # Also arrays and series of texts.
    is_array = hasattr(type(given), "tolist") and hasattr(type(given), "dtype")
    texts = given.tolist() if is_array and getattr(given.dtype, "kind", "O") not in "fiu" else given
    if isinstance(texts, str):
        return color("color", texts, is_linear)
    if isinstance(texts, (list, tuple)) and texts and all(isinstance(text, str) for text in texts):
        return named_colors(texts, is_linear)
    made = array("color", given)
    if made.ndim == 1 and len(made) in (3, 4):
        return color("color", made, is_linear)
    if made.ndim != 2 or made.shape[1] not in (3, 4):
        raise wrong_shape("color", made, "one colour is (3,), colours are (N, 3); `color_by` takes numbers that a map turns "
                          "into colours")
    are_bytes = made.dtype == "u1"
    if made.shape[1] == 4:
        require(f"color: {len(made)} rows", made.size)
        is_opaque = made[:, 3] == (255 if are_bytes else 1)
        if not is_opaque.all():
            row = int(is_opaque.argmin())
            raise ValueError(f"color: row {row} (counted from 0): expected an alpha of {'255' if are_bytes else '1'}, as "
                             f"spheres are opaque, found {made[row, 3]}")
        made = made[:, :3]
    if are_bytes:
        made = in_order("color", made, "u1")
        return made / 255 if is_linear else made
    made = in_order("color", made)
    return made if is_linear else linear_from_srgb(made)


def named_colors(texts: Sequence[str], is_linear: bool) -> NDArray[np.float64]:
    """Returns the linear colours of names and "#rrggbb", a row each."""
    known: dict[str, int] = {}
    places = [known.setdefault(text, len(known)) for text in texts]
    palette = [color(f"color: row {texts.index(text)} (counted from 0)", text, is_linear) for text in known]
    return np.array(palette)[places]


def numbers(color_by: Any) -> tuple[str, NDArray[np.float64]]:
    """Numbers that become colours, NaN where one is masked, and what they are called, as a series of pandas says."""
    name = getattr(color_by, "name", None)
    if isinstance(color_by, np.ma.MaskedArray):
        color_by = color_by.astype("f8").filled(np.nan)
    made = array("color_by", color_by)
    if made.ndim != 1:
        raise wrong_shape("color_by", made, "one number for each sphere")
    return name if isinstance(name, str) else "color_by", in_order("color_by", made)


#: What the library calls the fields of arrays that have other names in pictures and arguments.
FIELDS = {"rgb8": "rgb"}

#: What an array is called in errors, and its field; and the array.
Part = tuple[str, str, Any]


def picture(name: str, given: Any) -> tuple[Any, Picture | None]:
    """The path of a picture; or colours, where they are one array, or the fields of a structured array, a picture or
    hits, as an NPY file, and the picture that they are of."""
    if isinstance(given, (str, os.PathLike)):
        return given, None
    is_picture = isinstance(given, Picture)
    fields = ["rgb8", "id", "t", "normal"] if is_picture else getattr(getattr(given, "dtype", None), "names", None)
    if not fields:
        return npy([(name, "rgb", given)]), None
    each = getattr if is_picture else getitem
    return npy([(f'{name}["{field}"]', field, each(given, field)) for field in fields]), given if is_picture else None


def npy(parts: list[Part]) -> bytes:
    """Arrays of one shape, (height, width) or (N,), as the fields of an NPY file; colours and normals have one axis more."""
    common: tuple[int, ...] = ()
    fields = {}
    for name, part, given in parts:
        made, field = array(name, given), FIELDS.get(part, part)
        inner = (3,) if field in ("rgb", "normal") else ()
        axes = made.shape[: made.ndim - len(inner)]
        if len(axes) not in (1, 2) or made.shape != axes + inner:
            last = ", 3" if inner else ""
            raise wrong_shape(name, made, f"it is (height, width{last}) for a picture, (N{last}) for rays")
        common = common or axes
        if axes != common:
            lengths = ["{} rays", "{} rows and {} columns"][len(common) - 1].format(*common)
            raise wrong_shape(name, made, f"there are {lengths}")
        # As records, in the file, and for its reader.
        require(f"{made.size} numbers", 4 * made.nbytes)
        fields[field] = made if made.itemsize <= 8 else made.astype("f8")
    records = np.empty(common, [(field, made.dtype, made.shape[len(common) :]) for field, made in fields.items()])
    for field, made in fields.items():
        records[field] = made
    file = io.BytesIO()
    np.lib.format.write_array(file, records, (3, 0))
    return file.getvalue()


#: Quantities of the command line by the keys of dictionaries.
QUANTITIES = {"id": "id", "t": "depth", "distance": "distance", "normal": "normal", "rgb": "color"}


def foreign(given: Any) -> tuple[tuple[Any, Picture | None], list[str]]:
    """Returns what is compared with a scene, as :func:`picture` has it, and its quantities if they are known."""
    if not isinstance(given, Mapping):
        return picture("a", given), []
    unknown = [key for key in given if key not in QUANTITIES]
    if unknown or not given:
        raise ValueError(f"a: {', '.join(map(str, unknown)) or 'nothing'} is given; give arrays as {', '.join(QUANTITIES)}")
    return (npy([(f'a["{name}"]', name, array) for name, array in given.items()]), None), [QUANTITIES[name] for name in given]


def named(given: Any, n: int) -> list[tuple[int, str]]:
    """Rows and their names, out of a name or None for each of ``n`` spheres, or of {row: name}."""
    if given is None:
        return []
    if isinstance(given, Sequence) and not isinstance(given, str):
        if len(given) != n:
            raise ValueError(f"names: {len(given)} of them for {n} spheres")
        given = {row: name for row, name in enumerate(given) if name is not None}
    is_named = isinstance(given, dict) and all(isinstance(name, str) for name in given.values())
    if not is_named or not all(isinstance(row, SupportsIndex) for row in given):
        raise TypeError("names: give a name or None for each sphere, or {row: name}")
    for row in given:
        if row not in range(n):
            raise ValueError(f"names: row {row} (counted from 0), but there are {n} spheres")
    return list(given.items())
