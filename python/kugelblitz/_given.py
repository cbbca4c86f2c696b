"""What users give, as texts and arrays that the library reads."""

# Masked arrays are without types.
# mypy: disable-error-code="attr-defined, no-untyped-call"

import json
import re
from collections.abc import Sequence
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

from ._kugelblitz import Picture

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


def entries(name: str, given: Any) -> list[str]:
    """The entries of the list argument ``name``, each as :func:`toml` has it."""
    try:
        listed = None if isinstance(given, (dict, str)) else list(given)
    except Exception:
        listed = None
    if listed is None:
        raise TypeError(f"{name}: give a list of dictionaries, also for one")
    return [toml(f"{name}[{n}]", entry) for n, entry in enumerate(listed)]


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


#: The channels of what is called so in pictures, hits and arguments, where they have other names: one, or three along an
#: array's last axis.
CHANNELS = {
    "t": ["Z"], "zbuffer": ["Z"], "normal": ["N.X", "N.Y", "N.Z"],
    **dict.fromkeys(["rgb", "rgb8", "color"], ["R", "G", "B"]),
}

#: What an array is called in errors, and in its picture; and the array.
Part = tuple[str, str, Any]


def parts(name: str, given: Any) -> list[Part]:
    """Colours, where they are one array; the fields of a structured array, a picture or hits."""
    is_picture = isinstance(given, Picture)
    fields = ["rgb8", "id", "t", "normal"] if is_picture else getattr(getattr(given, "dtype", None), "names", None)
    if not fields:
        return [(name, "rgb", given)]
    return [(f'{name}["{field}"]', field, getattr(given, field) if is_picture else given[field]) for field in fields]


def channels(parts: list[Part]) -> tuple[tuple[int, ...], list[tuple[str, NDArray[Any]]]]:
    """The axes that all parts have, (height, width) or (N,), and the numbers of each channel."""
    common: tuple[int, ...] = ()
    found: list[tuple[str, NDArray[Any]]] = []
    for name, field, given in parts:
        made, names = array(name, given), CHANNELS.get(field, [field])
        n_axes = made.ndim - (len(names) > 1)
        axes, last = made.shape[:n_axes], made.shape[n_axes:]
        wrong = f"{name}: the shape is {[*made.shape]}, but"
        if n_axes not in (1, 2) or last not in ((), (len(names),)):
            inner = ", 3" if len(names) > 1 else ""
            raise ValueError(f"{wrong} it is (height, width{inner}) for a picture, (N{inner}) for rays")
        common = common or axes
        if axes != common:
            lengths = ["{} rays", "{} rows and {} columns"][len(common) - 1].format(*common)
            raise ValueError(f"{wrong} there are {lengths}")
        found += [(channel, made[..., n] if last else made) for n, channel in enumerate(names)]
    return common, found


def filled(numbers: Any) -> Any:
    """Numbers of which what is masked is NaN."""
    return numbers.astype("f8").filled(np.nan) if isinstance(numbers, np.ma.MaskedArray) else numbers


def names(given: Any, n: int) -> list[tuple[int, str]]:
    """Rows and their names, out of a name or None for each of ``n`` spheres, or of {row: name}."""
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


def arguments(options: str) -> str:
    """The command line's options as arguments: ``--id-offset 1`` as ``id_offset=1``."""
    return ", ".join(_argument(*match) for match in re.findall(r"--([\w-]+)[ =]?((?:(?! *--).)*)", options))


def _argument(option: str, value: str) -> str:
    name = option.replace("-", "_")
    if name == "as":
        return f"the arrays given as {', '.join('t' if word == 'depth' else word for word in value.split(','))}"
    try:
        float(value)
    except ValueError:
        return f"{name}={json.dumps(value) if value else True}"
    return f"{name}={value}"
