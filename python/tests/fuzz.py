"""Mutated arguments, each case a line of Python that can be pasted; run by test_fuzz.py in a process of its own.

    python fuzz.py SEED N LOG
"""

import random
import resource
import sys
import traceback

import kugelblitz as kb
import numpy as np

#: What a wrong argument may raise; SceneError is a ValueError.
DOCUMENTED = (FileNotFoundError, ValueError, TypeError, OverflowError, MemoryError, kb.NoAdapterError)

#: Valid arguments of each call, as Python.
SPHERES = "np.array([[0, 0, 0, 1], [0.5, 0.25, 1, 0.75], [3, 0, 0, 2.0]])"
CENTERS = f"{SPHERES}[:, :3]"
RAYS = "np.array([[0, 0, 5.0], [0.25, 0, 5], [-3, 2, 1]])", "np.array([[0, 0, -1.0], [0, 0.125, -1], [1, -0.5, 0.25]])"
CAMERA = "kb.Camera((0, 0, 5), (0, 0, 0))"
CALLS = {
    "Scene": {
        "spheres": CENTERS,
        "radius": "np.array([1, 0.75, 2])",
        "color": "np.array([[1, 0, 0], [0, 1, 0], [0.5, 0.5, 0.5]])",
        "planes": "[{'point': [0, -1, 0], 'normal': [0, 1, 0], 'color': '#8c8c8c'}]",
        "lights": "[{'position': [4, 6, 3], 'intensity': 0.9}, {'direction': [-1, -2, -1]}]",
        "sky": "{'intensity': 0.5, 'directions': 4}",
        "ambient": "0.125",
        "background": "'#20242c'",
        "names": "['sun', None, 'moon']",
        "color_space": "'linear'",
    },
    "replace": {
        "background": "(0.5, 0.25, 1)",
        "planes": "[{'point': [0, -1, 0], 'normal': [0, 1, 0], 'color': [0.5, 0, 1, 1]}]",
        "color_space": "'srgb'",
    },
    "Scene by numbers": {
        "spheres": SPHERES,
        "color_by": "np.array([1, 2, 4.0])",
        "colormap": "lambda x: (x, 0.5, 1 - x)",
        "range": "(1, 3)",
        "missing_color": "(0.5, 0, 0)",
        "color_space": "None",
    },
    "Camera": {
        "position": "(0, 1, 6)",
        "look_at": "np.zeros(3)",
        "up": "[0, 1, 0]",
        "fov": "40.0",
        "height": "None",
    },
    "trace": {"origins": RAYS[0], "directions": RAYS[1], "device": "'cpu'", "kernel": "'certified'", "progress": "None"},
    "render": {
        "camera": CAMERA,
        "size": "(6, 4)",
        "samples": "2",
        "crop": "(1, 0, 3, 2)",
        "transparent": "False",
        "device": "'cpu'",
        "kernel": "'certified'",
        "epsilon": "0.0",
        "progress": "None",
    },
    "explain": {
        "camera": CAMERA,
        "pixel": "(3, 2)",
        "size": "(6, 4)",
        "samples": "1",
        "all": "False",
        "lang": "'en'",
        "digits": "6",
    },
    "compare": {
        "a": "{'id': np.array([2, 2, 0]), 't': np.array([3.5, 3.3125, inf])}",
        "b": f"kb.Scene({SPHERES})",
        "rays": f"({', '.join(RAYS)})",
        "transform": "'ids+1'",
        "allow": "'ids=any,t=any'",
        "worst": "3",
        "device": "'cpu'",
    },
    "Camera.frame": {
        "scene": f"kb.Scene({SPHERES})",
        "view": "'iso'",
        "up": "(0, 1, 0)",
        "fov": "40.0",
        "margin": "0.125",
        "look_at": "None",
        "size": "(6, 4)",
        "n_turns": "1",
    },
    "Scene.generate": {"count": "20", "distribution": "'lattice'", "seed": "3"},
}

#: Other right values.
RIGHT = {
    "names": ["{1: 'b'}", "[None] * 3", "{np.int64(2): ''}"],
    "radius": ["0.5", "np.float32(2)", "np.array(1)", "5", "[1, 2, 3]"],
    "color": ["'#d62728'", "(0, 0.5, 1)", "'tomato'", "np.zeros((3, 3), 'u1')", "np.array([0.5, 0.5, 0.5])",
              "['red', '#d62728', 'Tomato']", "np.array(['red'] * 3)", "np.full((3, 4), 255, 'u1')", "(0, 1, 0.5, 1)", "np.ones((3, 4), 'f4')"],
    "color_space": ["'srgb'", "None", "np.str_('linear')"],
    "colormap": ["'magma_r'", "None", "lambda x: 'red'", "lambda x: np.array([x, x, x, 1])"],
    "range": ["None", "[0, 1e9]", "np.array([0, 1])"],
    "missing_color": ["'red'", "None", "np.zeros(3, 'u1')", "(0, 0, 0, 1)"],
    "planes": ["[]", "()", "[{'point': np.zeros(3), 'normal': (0, 1, 1), 'color': [0.5, 0.5, 0.5], 'name': 'floor'}]"],
    "lights": ["[]", "[{'position': 'eye', 'shadows': False}]", "[{'position': np.array([4, 6, 3]), 'color': '#ffffff'}]"],
    "sky": ["{'intensity': np.float64(1)}", "{'intensity': 1, 'directions': np.int64(2)}"],
    "ambient": ["0", "1", "'#101010'", "[0.1, 0.1, 0.1]", "np.float32(0.25)", "np.full(3, 0.5)"],
    "background": ["'#fff'", "(1, 1, 1)", "'black'", "np.zeros(3)", "[0.0, 1, 0.5]"],
    "position": ["[0, 0, 6.5]", "np.array([1, 2, 3])", "np.array([1, 2, 3], '>f4')", "(np.int64(1), 2, 3)", "[1e10, 5, 6]"],
    "look_at": ["(0, 0, 1)", "[0.5, 0, 0]", "np.array([0, 0.25, 0], 'f4')"],
    "up": ["(0, 0, 1)", "[1, 0, 0]", "np.array([0, 1, 0])"],
    "fov": ["1", "179.5", "np.float32(30)"],
    "size": ["(7, 5)", "[6, 4]", "np.array([6, 4])", "(np.int64(8), np.uint8(5))"],
    "samples": ["1", "3", "np.int64(2)"],
    "crop": ["None", "(0, 0, 1, 1)", "[2, 1, 1, 1]"],
    "transparent": ["True"],
    "kernel": ["'lecture'", "'stable'", "'double'"],
    "epsilon": ["0", "-0.0"],
    "progress": ["False", "lambda done, total: None"],
    "view": ["'x'", "'-z'", "'quarter'", "None"],
    "lang": ["'de'"],
    "digits": ["1", "12"],
    "pixel": ["(0, 0)", "[5, 3]", "np.array([1, 1])"],
    "count": ["1", "np.int64(7)"],
    "distribution": ["'packing'", "'uniform'"],
    "normals": ["'either'", "'outward'"],
}

#: Changes of an array that leave its values; `{}` is the array.
SAME = [
    "{}.astype('>f8')", "{}.astype('<f4')", "{}.astype('>f4')", "{}.astype('f2')", "np.asfortranarray({})",
    "{}.tolist()", "np.repeat({}, 2, 0)[::2]", "np.flip(np.flip({}).copy())", "readonly({})", "{}.astype(np.longdouble)",
    "tuple({}.tolist())", "np.ma.array({})", "unaligned({})", "np.repeat({}, 3, -1)[..., ::3]", "{}.view(np.recarray)",
    "np.broadcast_to({}, {}.shape)", "np.ascontiguousarray({}[::-1])[::-1]",
]
#: Changes that do not.
OTHER = [
    "{}.astype('i8')", "{}.astype('u1')", "{}.astype(bool)", "{}.astype(complex)", "{}.astype(object)",
    "{}.astype('S8')", "{}.astype('M8[s]')", "{}.ravel()", "{}[:0]", "{}[:1]", "{}[::-1]", "{}[None]", "{}.T",
    "{} * nan", "{} * inf", "-{}", "{} * 1e308", "{} * 1e-320", "{} * 0", "{} + 1e300", "np.vstack([{}, {}])",
    "np.broadcast_to({}[:1], (2**32, *{}.shape[1:]))", "np.broadcast_to({}[0], {}.shape)", "{}[..., :2]",
    "np.ma.array({}, mask=True)", "np.array([{}, {}], dtype=object)", "iter({})", "{}.tobytes()", "memoryview({})",
    "{}.view('u8')", "np.matrix({})", "hole({}, nan)", "hole({}, inf)", "hole({}, -1)", "hole({}, 1e39)", "hole({}, 0)",
]
ANYTHING = [
    "None", "True", "False", "0", "1", "-1", "16", "17", "2**31", "2**32", "-2**63", "2**64", "10**400", "0.0", "0.5", "-0.0",
    "nan", "inf", "-inf", "1e308", "5e-324", "180.0", "1j", "''", "'#fff'", "'#ffffff'", "'#gggggg'", "'eye'", "'cpu'",
    "'certified'", "'lecture'", "'stable'", "'\\0'", "'\\ud800'", "'é' * 50", "'a' * 10**5", "b'cpu'", "object()", "[]", "()", "{}", "[[]]",
    "[None]", "[[0, 0, 0]] * 3", "(1, 2)", "(1, 2, 3)", "(0, 0, 0, 1)", "(3, 2)", "(0, 5)", "(2**16, 2**16)", "(2**32, 1)",
    "(1.5, 2)", "(-1, 2)", "(0, 0, 6, 4)", "(5, 3, 1, 1)", "(2**32 - 1, 0, 1, 1)", "np.float32(0.5)", "np.int64(2)",
    "np.array(2)", "np.array('x')", "np.zeros(3)", "np.zeros((3, 3))", "np.zeros(0)", "[nan, 0, 0]", "[1e308] * 3", "['0', '0', '1']",
    "{'intensity': nan}", "{'intensity': -1}", "{'directions': 0}", "{'directions': 2**40}", "{7: 1}", "{'point': 1}",
    "[{}]", "[{'position': 'eye', 'direction': [0, 0, 1]}]", "[{'position': [0, 0, inf]}]", "[{'direction': [0, 0, 0]}]",
    "[{'point': [0, 0, 0], 'normal': [0, 0, 0], 'color': '#fff'}]", "[{'point': [0, 0, 0], 'normal': [0, 1e-320, 0], 'color': '#ffffff'}]",
    "lambda *a: None", "print", "kb", "kb.Scene", CAMERA, "kb.Camera((1, 2, 3), (0, 0, 0), height=3)", "range(3)",
    "(x for x in [1, 2, 3])", "{1, 2, 3}", "np.random", "type", "Raises()", "[[1, 2, 3], [4, 5]]", "[[[[1]]]]", "nested(500)",
    "np.datetime64('now')", "np.zeros((3, 3), [('a', 'f4')])", "np.full((3, 3), '1')", "np.array([[1, 2, None]])", "Lies()",
]


class Raises:
    """Something that raises whatever is asked of it."""

    def __getattr__(self, name):
        raise ValueError(f"no {name}")

    def __iter__(self):
        raise ValueError("no iteration")

    def __float__(self):
        raise ValueError("no number")


class Lies:
    """Something that says it were an array."""

    def __array__(self, *_, **__):
        return "no array"

    def __len__(self):
        return -1


def readonly(array):
    array.flags.writeable = False
    return array


def unaligned(array):
    return np.frombuffer(b"x" + array.tobytes(), "u1")[1:].view(array.dtype).reshape(array.shape)


def hole(array, number):
    array = array.copy()
    array.flat[array.size // 2] = number
    return array


def nested(depth):
    return [nested(depth - 1)] if depth else []


NAMES = dict(np=np, kb=kb, nan=np.nan, inf=np.inf, Raises=Raises, Lies=Lies, readonly=readonly, unaligned=unaligned,
             hole=hole, nested=nested)


def case(rng):
    """A call, its arguments as Python, those that are mutated, and what must come of them: the "same" bytes as
    before, a "right" result, or "any" that is documented."""
    name = rng.choice(list(CALLS))
    given = dict(CALLS[name])
    mutated = rng.sample(list(given), rng.choice([1, 1, 1, 2]))
    must = "same"
    for key in mutated:
        is_array = given[key].startswith("np.array(")
        kind = rng.random()
        if is_array and kind < 0.35:
            given[key] = rng.choice(SAME).replace("{}", given[key])
        elif is_array and kind < 0.8:
            given[key], must = rng.choice(OTHER).replace("{}", given[key]), "any"
        elif key in RIGHT and kind < 0.4:
            given[key] = rng.choice(RIGHT[key])
            if key == "size" and "crop" in given:
                given["crop"] = "None"
            must = "right" if must == "same" and len(mutated) == 1 else "any"
        elif kind < 0.95:
            given[key], must = rng.choice(ANYTHING), "any"
        else:
            del given[key]
            must = "any"
    return name, given, mutated, must


def line(name, given):
    """The case as it is pasted after `import numpy as np, kugelblitz as kb; from fuzz import *`."""
    arguments = ", ".join(f"{key}={value}" for key, value in given.items())
    call = name.partition(" ")[0]
    of = f"kb.{call}" if call[0].isupper() or call == "compare" else f"kb.Scene({SPHERES}).{call}"
    return f"{of}({arguments})"


#: What stands for a result.
TELL = {
    "explain": str,
    "compare": lambda comparison: repr(comparison.to_dict()),
    "Camera.frame": repr,
    "Scene.generate": lambda scene: scene.spheres.tobytes(),
    "Scene by numbers": lambda scene: scene.colors.tobytes(),
    "replace": lambda scene: scene.hash(),
}


def plain(array):
    return np.array(array, dtype=np.float64, order="C")


def result(name, text):
    """The case's result, told by bytes; asserts what is right of any result."""
    start = len(line(name, {})) - 1
    given = eval(f"dict({text[start:-1]})", NAMES)
    made = eval(text, NAMES)
    if name == "Scene":
        rows, spheres = made.spheres, given.get("spheres")
        assert np.isfinite(rows).all() and (rows[:, 3] > 0).all()
        assert len(rows) == 0 or (rows[:, :3] == plain(spheres)[:, :3]).all()
        radius = given.get("radius")
        if spheres is not None:
            assert (rows[:, 3] == (plain(spheres)[:, 3] if radius is None else plain(radius))).all()
        return made.render(eval(CAMERA, NAMES), (3, 2), device="cpu").digest()
    if name == "Camera":
        assert made.position == plain(given["position"]).tolist()
        assert (made.fov is None) != (made.height is None)
        ball = eval(f"kb.Scene({SPHERES})", NAMES)
        return ball.render(made, (3, 2), device="cpu").digest()
    if name in TELL:
        return TELL[name](made)
    if name == "trace":
        assert len(made) == len(given["origins"]) and made.id.max(initial=0) <= 3
        again = eval(f"kb.Scene({SPHERES})", NAMES).trace(
            plain(given["origins"]), plain(given["directions"]), kernel=given.get("kernel", "certified")
        )
        assert again.tobytes() == made.tobytes()
        return made.tobytes()
    width, height = given["size"] if given.get("size") is not None else (1280, 720)
    crop = given.get("crop")
    assert (made.width, made.height) == tuple(crop if crop is not None else (0, 0, width, height))[2:]
    assert made.id.max(initial=0) <= 3 and made.rgb8.shape == (made.height, made.width, 3)
    return made._repr_png_()


def names_the_argument(error, given, mutated):
    """Whether a message says what is wrong with which argument. What a callable for progress raises is its own,
    and so is what Python says of half a character."""
    text = " ".join([str(error), *getattr(error, "__notes__", [])])
    # Before Python 3.11 an exception has no notes, where the bindings name an argument.
    if sys.version_info < (3, 11):
        return True
    keys = [*mutated, *given, *(key.replace("_", "-") for key in mutated), "keyword", "positional"]
    return "progress" in mutated or isinstance(error, (UnicodeError, FileNotFoundError)) or any(key in text for key in keys)


def main():
    seed, n, log = int(sys.argv[1]), int(sys.argv[2]), open(sys.argv[3], "w")
    resource.setrlimit(resource.RLIMIT_AS, (16 << 30, 16 << 30))
    rng = random.Random(seed)
    right = {name: result(name, line(name, given)) for name, given in CALLS.items()}
    n_worked, n_raised, faults = 0, 0, 0
    for i in range(n):
        name, given, mutated, must = case(rng)
        text = line(name, given)
        # Whoever waits sees the last one if this process dies.
        log.write(text + "\n")
        log.flush()
        fault = None
        try:
            found = result(name, text)
            n_worked += 1
            if must == "same" and found != right[name]:
                fault = "other bytes, though the values are the same"
        except DOCUMENTED as error:
            n_raised += 1
            if must != "any":
                fault = f"raised, though the values are right: {error!r}"
            elif not isinstance(error, MemoryError) and not names_the_argument(error, given, mutated):
                fault = f"the message names no argument: {error!r}"
        except BaseException:
            fault = traceback.format_exc(limit=-2)
        if fault:
            faults += 1
            print(f"case {i} of seed {seed}: {text}\n  {fault}", flush=True)
    print(f"{n_worked} worked, {n_raised} raised, {faults} faults")
    sys.exit(faults > 0)


if __name__ == "__main__":
    main()
