"""Arrays that users give, as the library borrows them."""

# Masked arrays are without types.
# mypy: disable-error-code="attr-defined, no-untyped-call"

from collections.abc import Mapping, Sequence
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

from ._kugelblitz import require


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
    given: Any, *, radius: Any = None, color: Any = None, color_by: Any = None, names: Any = None, **others: Any
) -> tuple[NDArray[np.float64], Any, tuple[str, NDArray[np.float64]] | None, list[tuple[int, str]]] | None:
    """Centres with radii, colours, what numbers for colours are called and the numbers, rows with their names."""
    if color_by is None and any(others.get(name) is not None for name in ["colormap", "range", "missing_color"]):
        raise ValueError("colormap, range, missing_color: they say how numbers are coloured; give them by `color_by`")
    if given is None:
        if any(argument is not None for argument in [radius, color, color_by, names]):
            raise ValueError("radius, color, color_by, names: there are no spheres that they are of")
        return None
    if color is not None and color_by is not None:
        raise ValueError("color: `color_by` gives each sphere its own; leave one of them out")
    made = balls(given, radius)
    return made, colors(color), None if color_by is None else numbers(color_by), named(names, len(made))


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


def colors(given: Any) -> Any:
    """Returns rows of red, green and blue in f64 or bytes, or a list of names; one colour of all as it is given."""
    if given is None:
        return None
    # Also arrays and series of texts.
    is_array = hasattr(type(given), "tolist") and hasattr(type(given), "dtype")
    texts = given.tolist() if is_array and getattr(given.dtype, "kind", "O") not in "fiu" else given
    if isinstance(texts, str):
        return texts
    if isinstance(texts, (list, tuple)) and texts and all(isinstance(text, str) for text in texts):
        return list(texts)
    made = array("color", given)
    if made.ndim == 1 and len(made) in (3, 4):
        return made
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
    return in_order("color", made, "u1" if are_bytes else "=f8")


def numbers(color_by: Any) -> tuple[str, NDArray[np.float64]]:
    """Numbers that become colours, NaN where one is masked, and what they are called, as a series of pandas says."""
    name = getattr(color_by, "name", None)
    if isinstance(color_by, np.ma.MaskedArray):
        color_by = color_by.astype("f8").filled(np.nan)
    made = array("color_by", color_by)
    if made.ndim != 1:
        raise wrong_shape("color_by", made, "one number for each sphere")
    return name if isinstance(name, str) else "color_by", in_order("color_by", made)


#: What an array is called in errors, and its field; and the array.
Part = tuple[str, str, Any]

#: Height and width, or the number of rays; and name, numbers and elements per pixel of each field.
Channels = tuple[tuple[int, ...], list[tuple[str, NDArray[Any], int | None]]]

#: Types of channels; others become the widest one of their kind.
TYPES = ("u1", "u2", "u4", "f2", "f4", "f8")


def picture(name: str, given: Any) -> Channels:
    """Returns the channels of an array of colours, or of the fields of a structured array."""
    fields = getattr(getattr(given, "dtype", None), "names", None)
    return channels([(f'{name}["{field}"]', field, given[field]) for field in fields] if fields else [(name, "rgb", given)])


def channels(parts: list[Part]) -> Channels:
    """Returns the channels of arrays of one shape, (height, width) or (N,); colours and normals have one axis more."""
    common: tuple[int, ...] = ()
    fields: list[tuple[str, NDArray[Any], int | None]] = []
    for name, part, given in parts:
        made, field = array(name, given), "rgb" if part == "rgb8" else part
        inner = (3,) if field in ("rgb", "normal") else ()
        axes = made.shape[: made.ndim - len(inner)]
        if len(axes) not in (1, 2) or made.shape != axes + inner:
            last = ", 3" if inner else ""
            raise wrong_shape(name, made, f"it is (height, width{last}) for a picture, (N{last}) for rays")
        common = common or axes
        if axes != common:
            lengths = ["{} rays", "{} rows and {} columns"][len(common) - 1].format(*common)
            raise wrong_shape(name, made, f"there are {lengths}")
        if made.size == 0:
            raise wrong_shape(name, made, "at least one number is needed")
        kind = made.dtype.str[1:]
        dtype = "=" + (kind if kind in TYPES else {"f": "f8"}.get(kind[0], "i8"))
        fields.append((field, in_order(name, made, dtype), *(inner or (None,))))
    return common, fields


#: Quantities of the command line by the keys of dictionaries.
QUANTITIES = {"id": "id", "t": "depth", "distance": "distance", "normal": "normal", "rgb": "color"}


def mapping(given: Mapping[str, Any]) -> tuple[Channels, list[str]]:
    """Returns the channels of a dictionary of arrays, and its quantities."""
    unknown = [key for key in given if key not in QUANTITIES]
    if unknown or not given:
        raise ValueError(f"a: {', '.join(map(str, unknown)) or 'nothing'} is given; give arrays as {', '.join(QUANTITIES)}")
    parts = [(f'a["{name}"]', name, array) for name, array in given.items()]
    return channels(parts), [QUANTITIES[name] for name in given]


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
