"""Hits against an oracle of another make: Python's fractions, and decimals of 80 digits for the roots."""

from contextlib import contextmanager
from decimal import Decimal, localcontext
from fractions import Fraction

import kugelblitz as kb
import numpy as np
import pytest
from conftest import ROOT, cloud

FLOAT32 = np.finfo(np.float32)


@contextmanager
def digits(n):
    with localcontext() as context:
        context.prec = n
        yield


def exact(numbers):
    return [Fraction(float(x)) for x in numbers]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def decimal(x):
    return Decimal(x.numerator) / Decimal(x.denominator)


def roots(sphere, origin, direction):
    """The roots of a sphere, the lesser first; fractions decide whether there are any."""
    *center, radius = exact(sphere)
    to_origin = [o - c for o, c in zip(origin, center)]
    a, b = dot(direction, direction), 2 * dot(direction, to_origin)
    k = dot(to_origin, to_origin) - radius * radius
    discriminant = b * b - 4 * a * k
    if discriminant < 0:
        return []
    root = decimal(discriminant).sqrt()
    return [(decimal(-b) + sign * root) / decimal(2 * a) for sign in (-1, 1)]


def nearest(spheres, planes, origin, direction):
    """The id and t of what a ray sees."""
    origin, direction = exact(origin), exact(direction)
    seen = []
    for id, sphere in enumerate(spheres, 1):
        seen += [(t, id) for t in roots(sphere, origin, direction) if t > 0]
    for id, (point, normal) in enumerate(planes, 1 + len(spheres)):
        point, normal = exact(point), exact(normal)
        across = dot(direction, normal)
        if across:
            t = decimal(dot([a - o for a, o in zip(point, origin)], normal) / across)
            seen += [(t, id)] if t > 0 else []
    if not seen:
        return 0, None
    least = min(t for t, _ in seen)
    # Roots that agree to 60 digits are one: the lower id wins.
    return min((id, t) for t, id in seen if t - least <= least * Decimal("1e-60"))


def assert_exact(spheres, planes, origins, directions):
    scene = kb.Scene(
        spheres if len(spheres) else None,
        planes=[dict(point=point, normal=normal, color="#ffffff") for point, normal in planes],
    )
    for device in ["cpu", "gpu"]:
        hits = scene.trace(origins, directions, device=device)
        with digits(80):
            for row, (origin, direction) in enumerate(zip(origins, directions)):
                id, t = nearest(spheres, planes, origin, direction)
                case = f"row {row} on {device}: origin {origin!r}, direction {direction!r}"
                assert hits.id[row] == id, case
                if id == 0:
                    assert hits.t[row] == np.inf and not hits.normal[row].any(), case
                    continue
                found = hits.t[row]
                off = abs(Decimal(float(found)) - t)
                for other in np.nextafter(found, np.float32([-np.inf, np.inf])):
                    assert off <= abs(Decimal(float(other)) - t), case
                assert abs(float(np.linalg.norm(hits.normal[row].astype(float))) - 1) < 1e-6, case
                assert float(hits.normal[row].astype(float) @ np.asarray(direction, float)) <= 1e-6, case
    return scene.trace(origins, directions)


def test_random_rays():
    rng = np.random.default_rng(11)
    spheres = np.hstack([rng.normal(0, 2, (12, 3)), rng.uniform(0.1, 1, (12, 1))])
    planes = [((0, -2, 0), (0, 1, 0)), ((0, 0, -6), (0.1, 0.2, 1))]
    hits = assert_exact(spheres, planes, rng.normal(0, 3, (300, 3)), rng.normal(0, 1, (300, 3)))
    assert len(set(hits.id)) > 10


def test_whole_numbers_touch_and_tie():
    """Tangents, equal roots, origins on and in spheres, rays along planes."""
    spheres = np.array([[0, 0, 0, 5], [0, 0, 0, 5], [3, 4, -24, 5], [8, 0, 0, 3], [0, 10, 0, 5]], float)
    planes = [((0, 0, -24), (0, 0, 1)), ((0, 5, 0), (0, 2, 0))]
    origins = np.array([[x, y, z] for x in (-5, 0, 3, 5) for y in (0, 3, 4, 5) for z in (0, 4, 30)], float)
    directions = np.array([[0, 0, -1], [1, 0, 0], [0, 1, 0], [3, 4, 0], [0, -3, 4]], float)
    all_origins = np.repeat(origins, len(directions), 0)
    hits = assert_exact(spheres, planes, all_origins, np.tile(directions, (len(origins), 1)))
    assert 2 not in hits.id and {0, 1, 3} <= set(hits.id)
    assert hits.counts["exact"] > 0


def test_far_and_grazing():
    rng = np.random.default_rng(12)
    for offset in [1e4, 1e8]:
        center = np.array([offset, -offset, offset / 2])
        spheres = np.array([[*center, 1], [*(center + [0, 2, 0]), 1]])
        origins = np.tile(center + [0, 0, 7], (60, 1))
        rim = center + np.stack([np.cos(a := rng.uniform(0, 7, 60)), np.sin(a), 0 * a], 1) * (1 + 1e-9)
        assert_exact(spheres, [], origins, rim - origins)


def test_light_is_what_numpy_computes():
    """A lit ball and its shadow, in numpy's own f64, but for pixels whose decision is narrow."""
    sun = np.array([-1.0, -2.0, -1.0])
    ball, floor = np.array([0.0, 1.0, 0.0]), 0.0
    scene = kb.Scene(
        [[*ball, 1]], color=(1.0, 1.0, 1.0), planes=[dict(point=[0, 0, 0], normal=[0, 1, 0], color=[1, 1, 1])],
        lights=[dict(direction=sun.tolist())],
    )
    width = height = 64
    picture = scene.render(kb.Camera((0, 5, 0), (0, 0, 0), up=(0, 0, -1), height=8), (width, height))
    x = (2 * (np.arange(width) + 0.5) / width - 1) * 4
    x, z = np.meshgrid(x, x)
    rim = x**2 + z**2 - 1
    on_ball = rim < 0
    y = np.where(on_ball, ball[1] + np.sqrt(np.maximum(-rim, 0)), floor)
    normal = np.where(on_ball[..., None], np.stack([x, y - 1, z], -1), [0, 1, 0])
    to_sun = -sun / np.linalg.norm(sun)
    facing = normal @ to_sun
    # The line to the sun passes the ball's centre at this distance.
    from_ball = np.stack([x, y, z], -1) - ball
    miss = np.linalg.norm(np.cross(from_ball, to_sun), axis=-1) - 1
    shadow = ~on_ball & (miss < 0) & (from_ball @ to_sun < 0)
    linear = np.where(shadow, 0, np.maximum(facing, 0))
    is_narrow = (abs(rim) < 1e-6) | (abs(facing) < 1e-6) | (~on_ball & (abs(miss) < 1e-6))
    assert (np.where(on_ball, 1, 2) == picture.id)[~is_narrow].all()
    assert np.allclose(picture.rgb[..., 1][~is_narrow], linear[~is_narrow], rtol=1e-6, atol=1e-6)
    srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055) * 255
    assert (abs(picture.rgb8[..., 1] - srgb)[~is_narrow] < 0.51).all()
    assert shadow.any() and (~shadow & ~on_ball).any() and (facing[on_ball] < 0).any() == (picture.rgb[on_ball] == 0).any()


@pytest.mark.parametrize("name", ["figure2", "hard/coincident"])
def test_scenes_of_the_repository(name):
    scene = kb.Scene.open(ROOT / f"scenes/{name}.toml")
    camera = scene.camera
    rng = np.random.default_rng(13)
    aim = np.asarray(camera.look_at) + rng.normal(0, 1.5, (80, 3))
    origins = np.tile(camera.position, (80, 1))
    spheres = scene.spheres
    planes_seen = scene.trace(origins, aim - origins).id > len(spheres)
    keep = ~planes_seen
    assert_exact(spheres, [], origins[keep], (aim - origins)[keep])


def test_the_oracle_notices():
    scene = cloud(5)
    origin, direction = np.array([0.5, 0.5, 5.0]), np.array([0.0, 0.0, -1.0])
    spheres = [[0.5, 0.5, 0.5, 0.25], [0.5, 0.5, 0.0, 0.25]]
    with digits(80):
        assert nearest(spheres, [], origin, direction) == (1, Decimal("4.25"))
        assert nearest(spheres[::-1], [], origin, direction) == (2, Decimal("4.25"))
        assert nearest([], [((0, 0, 0), (0, 0, 2))], origin, direction) == (1, Decimal(5))
    assert scene.n_spheres == 5
