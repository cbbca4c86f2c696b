"""Assertions of `kugelblitz.testing`: what is right passes, and of what is spoilt the message tells."""

import kugelblitz as kb
import numpy as np
import pytest
from conftest import cloud
from kugelblitz.testing import assert_hits, assert_picture

SIZE = (60, 40)
VIEW = kb.Camera((0, 1, 6), (0.5, 0, 0), fov=40)
SCENE = kb.Scene.parse("""
    background = "#20242c"
    sphere = [
        { center = [0, 0, 0], radius = 1, color = "#d62728", name = "red" },
        { center = [1.5, 0, -1], radius = 1, color = "#1f77b4", name = "blue" },
    ]
    plane = [{ point = [0, -1, 0], normal = [0, 1, 0], color = "#8c8c8c", name = "floor" }]
    light = [{ position = [3, 5, 4] }]
    ambient = 0.1
""").replace(camera=VIEW, size=SIZE)
ORIGINS = np.tile([0.0, 1.0, 6.0], (200, 1))
RAYS = ORIGINS, np.random.default_rng(6).normal([0.5, 0, 0], 1, (200, 3)) - ORIGINS


@pytest.fixture(scope="module")
def picture():
    return SCENE.render()


@pytest.fixture
def hits():
    return SCENE.trace(*RAYS)


def message(array, call=assert_picture, **options):
    """What is said of a picture or of hits that are wrong."""
    with pytest.raises(AssertionError) as raised:
        call(array, SCENE, **options)
    return str(raised.value)


def message_of(hits, **options):
    return message(hits, assert_hits, rays=RAYS, **options)


def test_what_is_right_passes(hits, picture, tmp_path):
    for claims in [hits, {"id": hits.id}, {"t": hits.t.astype("f8"), "id": hits.id.astype("i8")}]:
        assert_hits(claims, SCENE, RAYS)
    assert_hits(hits, SCENE, np.hstack(RAYS))
    picture.save(tmp_path / "p.npy")
    for array in [picture, picture.rgb8, picture.rgb, picture.rgb.astype("f8"), picture.rgb16, np.load(tmp_path / "p.npy")]:
        assert_picture(array, SCENE)
    assert_picture(SCENE.render(samples=2).rgb8, SCENE, samples=2)
    assert_picture(cloud(200).render(VIEW, SIZE).rgb8, cloud(200), VIEW)


def test_a_wrong_pixel_is_named(picture):
    spoilt = picture.rgb8.copy()
    y, x = np.argwhere(picture.id == 1)[40]
    spoilt[y, x] += 1
    right = "#" + bytes(picture.rgb8[y, x]).hex()
    text = message(spoilt)
    assert f"{x},{y}: is " in text and f"exact: {right}, object 1 “red”" in text
    # Why: the numbers of that ray.
    assert f"why {x},{y} is {right}" in text and "red" in text.split("why")[1] and "D = " in text
    for allow in ["levels=1", "pixels=1"]:
        assert_picture(spoilt, SCENE, allow=allow)
    spoilt[y, x, 1] ^= 128
    assert f"{x},{y}: is " in message(spoilt, allow="levels=1")


def test_wrong_floats_are_named(picture):
    for spoil in [lambda c: np.nextafter(c, np.float32(2)), lambda c: c * np.nan, lambda c: c + np.float32(0.01)]:
        spoilt = picture.rgb.copy()
        spoilt[7, 9] = spoil(spoilt[7, 9])
        assert "9,7: is (" in message(spoilt)
    assert_picture(spoilt, SCENE, allow="difference=0.011")


def test_a_part_and_16_bits(picture):
    part, crop = picture.rgb16[10:30, 20:50].copy(), (20, 10, 30, 20)
    assert_picture(part, SCENE, crop=crop)
    part[3, 4] += 256
    text = message(part, crop=crop)
    assert "24,13: is #" in text and "why 24,13" in text
    assert_picture(part, SCENE, crop=crop, allow="levels=256")


@pytest.mark.parametrize("turn, words", [
    (np.s_[::-1], "transform='flip-rows'"), (np.s_[:, ::-1], "transform='flip-columns'"),
    (np.s_[..., ::-1], "if the channels were red, green, blue"),
])
def test_another_convention_is_found(picture, turn, words):
    for array in [picture.rgb8, picture.rgb]:
        assert words in message(array[turn])


def test_a_wrong_id_is_named(hits, picture):
    def spoil(right, wrong, n=0):
        row = np.flatnonzero(hits.id == right)[n]
        spoilt = hits.copy()
        spoilt["id"][row] = wrong
        text = message_of(spoilt)
        assert f"{row}: has " in text
        return text

    text = spoil(2, 1, 3)
    assert "1 " in text.splitlines()[0] and "blue" in text
    assert "smallest" in text.split("why:")[1] or "visible" in text.split("why:")[1]
    for right, wrong in [(2, 0), (2, 3), (0, 1)]:
        spoil(right, wrong)
    ids = picture.id.copy()
    ids[0, 0] = 2
    assert "0,0: has" in message(np.rec.fromarrays([ids, picture.t], names="id,t"))


def test_wrong_depths_and_normals_are_named(hits):
    row = np.flatnonzero(hits.id)[5]
    turned, spoilt = hits.copy(), hits.copy()
    turned["normal"][row] *= -1
    assert f"ray {row}: has " in message_of(turned)
    spoilt["t"][row] = np.nextafter(hits.t[row], np.float32(0))
    text = message_of(spoilt)
    assert f"ray {row}: has t = " in text and "ulp" in text.splitlines()[0]
    assert_hits(spoilt, SCENE, RAYS, allow="t=2ulp")
    spoilt["t"][row] *= 1.01
    message_of(spoilt, allow="t=1e-3")
    assert_hits(spoilt, SCENE, RAYS, allow="t=0.02")


def test_conventions_of_others(hits):
    theirs = {"id": np.where(hits.id == 0, -1, hits.id.astype(int) - 1)}
    assert 'transform="ids+1"' in message_of(theirs)
    assert_hits(theirs, SCENE, RAYS, transform="ids+1")


def test_what_is_allowed_reaches_what_it_is_of(picture):
    spoilt = np.rec.fromarrays([picture.id, picture.t.copy()], names="id,t")
    y, x = np.argwhere(picture.id)[0]
    spoilt.t[y, x] *= np.float32(1 + 3e-6)
    for allow in [None, "t=1e-7"]:
        assert "has t = " in message(spoilt, allow=allow)
    assert_picture(spoilt, SCENE, allow="t=1e-5")
    whole = np.zeros(picture.id.shape, [("id", "u4"), ("t", "f4"), ("rgb", "u1", (3,))])
    whole["id"], whole["t"], whole["rgb"] = picture.id, spoilt.t, picture.rgb8
    whole["rgb"][y, x, 0] ^= 1
    assert_picture(whole, SCENE, allow="t=1e-5, levels=1")
    assert "is #" in message(whole, allow="t=1e-5")


def test_what_is_nothing_to_be_judged(picture):
    depths = np.rec.fromarrays([picture.id, picture.t], names="id,t")
    for array, allow, words in [
        *((np.zeros(shape, dtype), None, "array: ") for shape, dtype in [((4, 4), "f8"), ((4, 4, 4), "f8"), ((4, 4, 3), "i8")]),
        (picture.rgb8, "t=1e-5", "allow"), (picture.rgb8, "levels=1,ids=1%", "allow"), (depths, "levels=1", "allow"),
        (depths, "tt=1", "called"),
    ]:
        with pytest.raises(ValueError, match=words):
            assert_picture(array, SCENE, allow=allow)
    with pytest.raises(ValueError, match="rays"):
        assert_hits(SCENE.trace(*RAYS), SCENE, ORIGINS)
