"""Assertions of `kugelblitz.testing`: what is right passes, and of what is spoilt the message tells."""

import kugelblitz as kb
import numpy as np
import pytest
from conftest import cloud
from kugelblitz.testing import assert_hits, assert_picture

SIZE = (60, 40)


@pytest.fixture(scope="module")
def scene():
    return kb.Scene.parse("""
        background = "#20242c"
        sphere = [
            { center = [0, 0, 0], radius = 1, color = "#d62728", name = "red" },
            { center = [1.5, 0, -1], radius = 1, color = "#1f77b4", name = "blue" },
        ]
        plane = [{ point = [0, -1, 0], normal = [0, 1, 0], color = "#8c8c8c", name = "floor" }]
        light = [{ position = [3, 5, 4] }]
        ambient = 0.1
    """)


@pytest.fixture(scope="module")
def view():
    return kb.Camera((0, 1, 6), (0.5, 0, 0), fov=40)


@pytest.fixture(scope="module")
def picture(scene, view):
    return scene.render(view, SIZE)


@pytest.fixture(scope="module")
def rays():
    rng = np.random.default_rng(6)
    origins = np.tile([0.0, 1.0, 6.0], (200, 1))
    return origins, rng.normal([0.5, 0, 0], 1, (200, 3)) - origins


def message(call, *arguments, **options):
    with pytest.raises(AssertionError) as raised:
        call(*arguments, **options)
    return str(raised.value)


def test_what_is_right_passes(scene, view, picture, rays):
    hits = scene.trace(*rays)
    assert_hits(hits, scene, rays)
    assert_hits(hits, scene, np.hstack(rays))
    assert_hits({"id": hits.id}, scene, rays)
    assert_hits({"t": hits.t.astype("f8"), "id": hits.id.astype("i8")}, scene, rays)
    assert_picture(picture, scene, view)
    assert_picture(picture.rgb8, scene, view)
    assert_picture(picture.rgb, scene, view)
    assert_picture(picture.rgb.astype("f8"), scene, view)
    assert_picture(picture.rgb16, scene, view)
    assert_picture(scene.render(view, SIZE, samples=2).rgb8, scene, view, samples=2)
    assert_picture(cloud(200).render(view, SIZE).rgb8, cloud(200), view)


def test_files_pass(scene, view, picture, tmp_path):
    picture.save(tmp_path / "p.npy")
    assert_picture(np.load(tmp_path / "p.npy"), scene, view)


def test_a_wrong_pixel_is_named(scene, view, picture):
    spoilt = picture.rgb8.copy()
    y, x = np.argwhere(picture.id == 1)[40]
    spoilt[y, x] += 1
    right = "#" + bytes(picture.rgb8[y, x]).hex()
    text = message(assert_picture, spoilt, scene, view)
    assert f"{x},{y}: is " in text
    assert f"exact: {right}, object 1 “red”" in text
    # Why: the numbers of that ray.
    assert f"why {x},{y} is {right}" in text and "red" in text.split("why")[1] and "D = " in text
    assert_picture(spoilt, scene, view, allow="levels=1")
    assert_picture(spoilt, scene, view, allow="pixels=1")
    spoilt[y, x, 1] ^= 128
    assert f"{x},{y}: is " in message(assert_picture, spoilt, scene, view, allow="levels=1")


def test_wrong_floats_are_named(scene, view, picture):
    for spoil in [lambda c: np.nextafter(c, np.float32(2)), lambda c: c * np.nan, lambda c: c + np.float32(0.01)]:
        spoilt = picture.rgb.copy()
        spoilt[7, 9] = spoil(spoilt[7, 9])
        assert "9,7: is (" in message(assert_picture, spoilt, scene, view)
    assert_picture(spoilt, scene, view, allow="difference=0.011")


def test_a_part_and_16_bits(scene, view, picture):
    with_size = scene.replace(camera=view, size=SIZE) if hasattr(scene, "replace") else scene
    part = picture.rgb16[10:30, 20:50].copy()
    crop = (20, 10, 30, 20)
    assert_picture(part, with_size, crop=crop)
    part[3, 4] += 256
    text = message(assert_picture, part, with_size, crop=crop)
    assert "24,13: is #" in text and "why 24,13" in text
    assert_picture(part, with_size, crop=crop, allow="levels=256")


@pytest.mark.parametrize("spoil, words", [
    (lambda a: a[::-1], "if the first row were the top one"),
    (lambda a: a[:, ::-1], "if columns began on the left"),
    (lambda a: a[..., ::-1], "if the channels were red, green, blue"),
])
def test_another_convention_is_found(scene, view, picture, spoil, words):
    for array in [picture.rgb8, picture.rgb]:
        assert words in message(assert_picture, spoil(array), scene, view)


def test_a_wrong_id_is_named(scene, view, rays, picture):
    hits = scene.trace(*rays)
    row = int(np.argwhere(hits.id == 2)[3, 0])
    spoilt = hits.copy()
    spoilt["id"][row] = 1
    text = message(assert_hits, spoilt, scene, rays)
    assert "1 " in text.splitlines()[0] and f"{row}: says " in text and "blue" in text and "why:" in text
    assert "smallest" in text.split("why:")[1] or "visible" in text.split("why:")[1]
    for wrong in [0, 3]:
        spoilt["id"][row] = wrong
        assert f"{row}: says" in message(assert_hits, spoilt, scene, rays)
    # A miss that is said to be a hit.
    row = int(np.argwhere(hits.id == 0)[0, 0]) if (hits.id == 0).any() else None
    if row is not None:
        spoilt = hits.copy()
        spoilt["id"][row] = 1
        assert f"{row}: says" in message(assert_hits, spoilt, scene, rays)
    ids = picture.id.copy()
    ids[0, 0] = 2
    with pytest.raises(AssertionError, match="0,0: says"):
        assert_picture(np.rec.fromarrays([ids, picture.t], names="id,t"), scene, view)


def test_a_wrong_depth_is_named(scene, rays):
    hits = scene.trace(*rays)
    spoilt, row = hits.copy(), np.flatnonzero(hits.id)[5]
    spoilt["t"][row] = np.nextafter(hits.t[row], np.float32(0))
    text = message(assert_hits, spoilt, scene, rays)
    assert f"ray {row}: says t = " in text and "ulp" in text.splitlines()[0]
    assert_hits(spoilt, scene, rays, allow="t=2ulp")
    spoilt["t"][row] *= 1.01
    message(assert_hits, spoilt, scene, rays, allow="t=1e-3")
    assert_hits(spoilt, scene, rays, allow="t=0.02")


def test_a_wrong_normal_is_named(scene, rays):
    hits = scene.trace(*rays)
    spoilt, row = hits.copy(), np.flatnonzero(hits.id)[7]
    spoilt["normal"][row] = -hits.normal[row]
    assert f"ray {row}: says " in message(assert_hits, spoilt, scene, rays)


def test_conventions_of_others(scene, rays):
    hits = scene.trace(*rays)
    theirs = {"id": np.where(hits.id == 0, -1, hits.id.astype(int) - 1)}
    assert "id_offset=1" in message(assert_hits, theirs, scene, rays)
    assert_hits(theirs, scene, rays, id_offset=1)


def test_what_is_no_picture(scene, view, rays):
    for array in [np.zeros((4, 4)), np.zeros((4, 4, 4)), np.zeros((4, 4, 3), "i8")]:
        with pytest.raises(ValueError, match="array: "):
            assert_picture(array, scene, view)
    with pytest.raises(ValueError, match="rays"):
        assert_hits(scene.trace(*rays), scene, rays[0])


def test_what_is_allowed_reaches_what_it_is_of(scene, view, picture):
    spoilt = np.rec.fromarrays([picture.id, picture.t.copy()], names="id,t")
    y, x = np.argwhere(picture.id)[0]
    spoilt.t[y, x] *= np.float32(1 + 3e-6)
    assert "says t = " in message(assert_picture, spoilt, scene, view)
    assert_picture(spoilt, scene, view, allow="t=1e-5")
    assert "says t = " in message(assert_picture, spoilt, scene, view, allow="t=1e-7")
    whole = np.zeros(picture.id.shape, [("id", "u4"), ("t", "f4"), ("rgb", "u1", (3,))])
    whole["id"], whole["t"], whole["rgb"] = picture.id, spoilt.t, picture.rgb8
    whole["rgb"][y, x, 0] ^= 1
    assert_picture(whole, scene, view, allow="t=1e-5, levels=1")
    assert "is #" in message(assert_picture, whole, scene, view, allow="t=1e-5")
    for array, allow in [(picture.rgb8, "t=1e-5"), (picture.rgb8, "levels=1,ids=1%"), (spoilt, "levels=1"), (spoilt, "tt=1")]:
        with pytest.raises(ValueError, match="allow|called"):
            assert_picture(array, scene, view, allow=allow)
