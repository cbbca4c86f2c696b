"""Arguments of all kinds: an exception or a result, never a crash."""

import random

import kugelblitz as kb
import numpy as np

SEED = 20261122
N = 2000


def odd_numbers(rng, shape):
    pool = [0.0, -0.0, 1.0, -1.0, 1e-320, 1e308, -1e308, float("nan"), float("inf"), 1e30, 0.5]
    return np.array([rng.choice(pool) for _ in range(int(np.prod(shape)))]).reshape(shape)


def array(rng):
    shape = rng.choice([(3, 3), (3, 4), (0, 3), (1, 4), (4,), (2, 2, 3), (3, 7), (), (5, 3)])
    kind = rng.random()
    made = odd_numbers(rng, shape) if kind < 0.4 else np.array(rng.random()) * np.ones(shape)
    dtype = rng.choice(["f8", "f4", ">f8", "<f2", "i1", "u8", "bool", "c16", "O", "S3", "M8[s]", "f8"])
    try:
        with np.errstate(all="ignore"):
            made = made.astype(dtype)
    except (ValueError, TypeError):
        pass
    if made.ndim and rng.random() < 0.2:
        made = made[::-1]
    if rng.random() < 0.1:
        made.flags.writeable = False
    return made


def thing(rng):
    return rng.choice(
        [
            lambda: array(rng),
            lambda: array(rng).tolist(),
            lambda: None,
            lambda: rng.choice(["", "#fff", "#ffffff", "eye", "cpu", "certified", "\0", "é" * 50]),
            lambda: rng.choice([0, 1, -1, 2**31, 2**32, 2**70, 16, 17]),
            lambda: rng.choice([0.0, 1.0, float("nan"), float("inf"), -1e308]),
            lambda: (rng.choice([0, 1, 5, -3]),) * rng.choice([1, 2, 3, 4]),
            lambda: {"point": [0, 0, 0], "normal": array(rng), "color": "#ffffff"},
            lambda: [{"position": array(rng)}, {"direction": thing(rng)}],
            lambda: {rng.choice(["intensity", "directions", 7]): thing(rng)},
            lambda: [thing(rng) for _ in range(rng.choice([0, 1, 3]))],
            lambda: object(),
            lambda: kb.Camera((0, 0, 5), (0, 0, 0)),
        ]
    )()


def test_mutated_arguments_raise_or_work():
    rng = random.Random(SEED)
    ball = kb.Scene([[0, 0, 0, 1]])
    camera = kb.Camera((0, 0, 5), (0, 0, 0))
    expected = (ValueError, TypeError, OverflowError, MemoryError, RuntimeError)
    n_worked = n_raised = 0
    for n in range(N):
        name = rng.choice(["scene", "camera", "trace", "render"])
        if name == "scene":
            keys = ["spheres", "radius", "color", "planes", "lights", "sky", "ambient", "background"]
            given = {key: thing(rng) for key in rng.sample(keys, rng.choice([1, 2, 3]))}
            call = lambda: kb.Scene(**given).render(camera, (2, 2))
        elif name == "camera":
            given = {"position": thing(rng), "look_at": thing(rng)}
            given |= {key: thing(rng) for key in rng.sample(["up", "fov", "height"], 1)}
            call = lambda: ball.render(kb.Camera(**given), (2, 2))
        elif name == "trace":
            given = {"origins": array(rng), "directions": array(rng)}
            given |= {"kernel": thing(rng)} if rng.random() < 0.2 else {}
            call = lambda: ball.trace(**given, device="cpu")
        else:
            keys = ["camera", "size", "samples", "crop", "transparent", "kernel", "epsilon", "progress"]
            given = {"camera": camera, "size": (2, 2)}
            given |= {key: thing(rng) for key in rng.sample(keys, 2)}
            # A picture of 2**31 pixels a side would only take long.
            call = lambda: ball.render(**given, device="cpu")
        try:
            call()
            n_worked += 1
        except expected as error:
            assert str(error) or isinstance(error, MemoryError), (n, name, given)
            n_raised += 1
        except BaseException as error:
            raise AssertionError(f"case {n} of seed {SEED}: {name}({given!r})") from error
    assert n_worked > N / 50 and n_raised > N / 2, (n_worked, n_raised)
