"""Scenes from arrays, and what is wrong with arrays."""

import errno
import pickle
from functools import partial

import kugelblitz as kb
import numpy as np
import pytest
from conftest import refuses


def test_a_ball_is_seen_where_it_is(ball):
    picture = ball.render(kb.Camera((0, 0, 5), (0, 0, 0)), (161, 121))
    assert picture.id[60, 80] == 1 and picture.t[60, 80] == 4
    assert picture.rgb8[60, 80].tolist() == [0xD6, 0x27, 0x28]
    assert picture.rgb8[0, 0].tolist() == [0x20, 0x24, 0x2C]
    assert np.isinf(picture.t[0, 0]) and picture.id[0, 0] == 0
    assert picture.normal[60, 80].tolist() == [0, 0, 1]
    assert picture.id.shape == (121, 161) and picture.rgb.shape == (121, 161, 3)


def test_whole_numbers_are_numbers():
    rows = [[0, 0, 0, 1], [3, 2, 1, 2], [9, 8, 7, 1]]
    for dtype in ["i4", "u2", ">i8"]:
        assert kb.Scene(np.array(rows, dtype)).spheres.tolist() == rows


def test_radii_and_colours():
    centers = np.zeros((3, 3))
    assert kb.Scene(centers, radius=2).spheres[:, 3].tolist() == [2, 2, 2]
    assert kb.Scene(centers, radius=[1, 2, 3]).spheres[:, 3].tolist() == [1, 2, 3]
    linear = [[0.1, 0.2, 0.3], [0, 0, 0], [1, 1, 1]]
    for color, expected in [
        (None, [[1, 1, 1]] * 3), (linear, linear), (np.array([[0, 255, 0]] * 3, np.uint8), [[0, 1, 0]] * 3),
        (np.array([0, 255, 0], np.uint8), [[0, 1, 0]] * 3), ("#00ff00", [[0, 1, 0]] * 3), ((0, 0.5, 0), [[0, 0.5, 0]] * 3),
    ]:
        assert kb.Scene(centers, radius=1, color=color).colors.tolist() == expected


def test_names_are_given_by_list_or_by_row():
    rows = [[0, 0, 0, 1], [3, 0, 0, 1], [6, 0, 0, 1]]
    for names in [["sun", None, "moon"], {0: "sun", np.int64(2): "moon"}]:
        scene = kb.Scene(rows, names=names)
        assert [scene.name(id) for id in (1, 2, 3)] == ["sun", None, "moon"]
    wrong = [["sun"], {3: "x"}, "sun", [1, 2, 3], {"a": "b"}]
    words = ["1 of them for 3", "row 3", "names", "names", "names"]
    refuses(partial(kb.Scene, rows), (ValueError, TypeError), *((dict(names=n), w) for n, w in zip(wrong, words)))


WRONG = [
    (dict(spheres=np.zeros((2, 5))), ValueError, ["spheres", "[2, 5]", "(N, 3)"]),
    (dict(spheres=np.zeros(4)), ValueError, ["spheres", "[4]"]),
    (dict(spheres=np.zeros((2, 3))), ValueError, ["radius"]),
    (dict(spheres=np.ones((2, 4)), radius=1), ValueError, ["radius", "fourth column"]),
    (dict(spheres=np.ones((2, 3)), radius=[1, 2, 3]), ValueError, ["radius", "[3]", "2 spheres"]),
    (dict(spheres=[[0, 0, 0, 1], [0, 0, np.nan, 1]]), ValueError, ["spheres", "row 1", "NaN"]),
    (dict(spheres=[[0, 0, 0, 0]]), ValueError, ["spheres", "row 0", "radius"]),
    (dict(spheres=[[0, 0, 0, -1]]), ValueError, ["row 0", "-1"]),
    (dict(spheres=["a", "b"]), TypeError, ["spheres", "dtype"]),
    (dict(spheres=np.zeros((2, 4), complex)), TypeError, ["spheres", "complex"]),
    (dict(spheres=np.zeros((2, 4), object)), TypeError, ["spheres", "object"]),
    (dict(spheres=[[0, 0, 0, 1], [0, 0]]), TypeError, ["spheres"]),
    (dict(radius=1), ValueError, ["radius"]),
    (dict(spheres=[[0, 0, 0, 1]], color="red-ish"), kb.SceneError, ["color"]),
    (dict(spheres=[[0, 0, 0, 1]], color=[[2, 0, 0]]), ValueError, ["color", "row 0"]),
    (dict(spheres=[[0, 0, 0, 1]], color=[[1, 0, 0]] * 2), ValueError, ["color", "2", "1"]),
    (dict(planes={"point": [0, 0, 0]}), TypeError, ["planes", "list"]),
    (dict(planes=[{"point": [0, 0, 0]}]), kb.SceneError, ["planes[0]", "normal"]),
    (dict(planes=[{"point": [0, 0, 0], "normal": [0, 0, 0], "color": "#ffffff"}]), kb.SceneError, ["planes[0]", "normal"]),
    (dict(lights=[{"position": "eye"}, {"positoin": [0, 0, 0]}]), kb.SceneError, ["lights[1]", "position"]),
    (dict(sky={"intensity": -1}), kb.SceneError, ["sky"]),
    (dict(ambient=object()), TypeError, ["ambient"]),
    (dict(background=[0, 0]), kb.SceneError, ["background"]),
]


@pytest.mark.parametrize("given, error, words", WRONG)
def test_what_is_wrong_is_named(given, error, words):
    with pytest.raises(error) as raised:
        kb.Scene(**given)
    assert all(word in str(raised.value) for word in words), raised.value


def test_a_saved_or_pickled_scene_is_the_same(tmp_path, camera):
    rng = np.random.default_rng(5)
    scene = kb.Scene(
        rng.random((500, 3)),
        radius=0.02,
        color=rng.random((500, 3)),
        planes=[dict(point=[0, 0, 0], normal=[0, 1, 0], color="#8c8c8c", name="floor")],
        lights=[dict(position=[4, 6, 3], intensity=0.9), dict(position="eye", shadows=False)],
        sky=dict(intensity=0.3, directions=8),
        ambient=0.1,
        background="#20242c",
    )
    digest = scene.render(camera, (64, 48)).digest()
    scene.save(tmp_path / "scene.toml")
    for other in [kb.Scene.open(tmp_path / "scene.toml"), pickle.loads(pickle.dumps(scene))]:
        assert other.render(camera, (64, 48)).digest() == digest
        assert (other.spheres == scene.spheres).all() and (other.colors == scene.colors).all()
        assert other.name(501) == "floor"
    assert pickle.loads(pickle.dumps(camera)) == camera


def test_a_file_that_is_wrong(tmp_path):
    with pytest.raises((OSError, kb.SceneError), match="no.toml"):
        kb.Scene.open(tmp_path / "no.toml")
    (tmp_path / "too--bad.toml").write_text("[camera]\nposition = [0, 0, 0]\n")
    with pytest.raises(kb.SceneError, match="too--bad.toml:1:1.*look_at"):
        kb.Scene.open(tmp_path / "too--bad.toml")
    with pytest.raises(ValueError, match=".toml"):
        kb.Scene().save(tmp_path / "scene.png")


def test_cameras():
    camera = kb.Camera([0, 1, 6], np.zeros(3), height=4)
    assert camera.height == 4 and camera.fov is None
    assert repr(camera) == "Camera(position=[0.0, 1.0, 6.0], look_at=[0.0, 0.0, 0.0], up=[0.0, 1.0, 0.0], height=4.0)"
    assert kb.Camera((0, 0, 5), (0, 0, 0)).fov == 45
    refuses(
        kb.Camera, kb.SceneError,
        (dict(position=(0, 0, 0), look_at=(0, 0, 0)), "same point"),
        (dict(position=(0, 1, 0), look_at=(0, 0, 0)), "parallel"),
        (dict(position=(0, 0, 5), look_at=(0, 0, 0), fov=180), "180"),
        (dict(position=(0, 0, 5), look_at=(0, 0, 0), fov=40, height=2), "both"),
        (dict(position=(0, 0, float("nan")), look_at=(0, 0, 0)), "finite"),
        (dict(position=(0, 0), look_at=(0, 0, 0)), "found 2 values in `position`"),
        (dict(position=(0, 0, 5), look_at=(0, 0, 0), fov="wide"), "found a string in `fov`"),
    )


def test_a_frame_is_counted_from_0(tmp_path):
    (tmp_path / "steps.xyz").write_text("1\n\nC 1 0 0\n1\n\nC 2 0 0\n")
    for frame, x in [(0, 1), (1, 2)]:
        assert kb.Scene.open(tmp_path / "steps.xyz", frame=frame).spheres[0, 0] == x
    with pytest.raises(kb.SceneError, match="no frame 2"):
        kb.Scene.open(tmp_path / "steps.xyz", frame=2)


def test_what_is_masked_has_no_value():
    rows, mask = np.array([[0.0, 0, 0], [2, 0, 0], [4, 0, 0]]), np.eye(3, dtype=bool)
    numbers = np.ma.masked_array([1.0, 5.0, 3.0], mask=mask[1])
    colored = partial(kb.Scene, rows, radius=1, missing_color="#ff0000")
    for masked, same in [
        (numbers, [1, np.nan, 3]), (numbers.astype(int), [1, np.nan, 3]), (np.ma.masked_array([1.0, 5.0, 3.0]), [1, 5, 3]),
    ]:
        assert (colored(color_by=masked).colors == colored(color_by=same).colors).all()
    assert (colored(color_by=numbers).colors[1] == [1, 0, 0]).all()
    refuses(
        partial(kb.Scene, spheres=rows, radius=1), ValueError,
        (dict(spheres=np.ma.masked_array(rows, mask=mask)), "masked"), (dict(radius=np.ma.masked_array([1.0, 1, 1], mask=mask[0])), "masked"),
        (dict(color=np.ma.masked_array(np.zeros((3, 3)), mask=mask)), "masked"),
    )


def test_errors_speak_of_arguments(tmp_path, camera, ball):
    for call, name in [(kb.Scene.open, "no.toml"), (camera.path, "no.csv"), (kb.read, "no.png")]:
        with pytest.raises(FileNotFoundError) as caught:
            call(tmp_path / name)
        assert caught.value.errno == errno.ENOENT and name in caught.value.filename
    refuses(partial(ball.render, camera), TypeError, (dict(size="big"), "^size: "), (dict(size=(8, 8), crop=b"abcd"), "^crop: "))
    refuses(ball.explain, TypeError, (dict(camera=camera, pixel="p"), "^pixel: "))
    with pytest.raises(ValueError, match="position and look_at") as caught:
        kb.Camera.frame(kb.Scene([[1e300, 0, 0, 1e299]]))
    assert "--" not in str(caught.value)


def test_a_scene_with_some_things_changed(ball):
    camera = kb.Camera((0, 0, 5), (0, 0, 0))
    lit = ball.replace(camera=camera, size=(20, 10), lights=[{"position": "eye"}], samples=2)
    assert lit.camera == camera and lit.size == (20, 10) and lit.samples == 2 and lit.is_lit and not ball.is_lit
    assert lit.render().digest() != ball.render(camera, (20, 10)).digest()
    for background, seen in [(None, [0, 0, 0]), (np.array([1, 2, 3], np.uint8), [1, 2, 3])]:
        assert ball.replace(background=background).render(camera, (4, 2)).rgb8[0, 0].tolist() == seen
    with pytest.raises(TypeError, match="radius"):
        ball.replace(radius=3)
