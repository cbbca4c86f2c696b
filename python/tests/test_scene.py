"""Scenes from arrays, and what is wrong with arrays."""

import copy
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
    for color, expected in [
        (None, [[1, 1, 1]] * 3), (np.array([[0, 255, 0]] * 3, np.uint8), [[0, 1, 0]] * 3),
        (np.array([0, 255, 0], np.uint8), [[0, 1, 0]] * 3), ("#00ff00", [[0, 1, 0]] * 3),
    ]:
        assert kb.Scene(centers, radius=1, color=color).colors.tolist() == expected


#: Bytes of three colours.
BYTES = np.array([[214, 39, 40], [0, 128, 255], [10, 11, 1]], np.uint8)


def test_floats_of_all_colours_are_srgb():
    """A float is the same colour as its byte, to the last bit; with color_space="linear" it is itself."""
    centers, camera = np.zeros((3, 3)), kb.Camera((0, 0, 5), (0, 0, 0))
    floats = BYTES / 255

    def colored(**given):
        return kb.Scene(centers, radius=1, **given).colors

    right = colored(color=BYTES)
    assert (colored(color=floats) == right).all() and (colored(color=floats.tolist()) == right).all()
    assert (colored(color=floats, color_space="linear") == floats).all()
    assert (colored(color=BYTES, color_space="linear") == floats).all()
    single = np.float32([0.5, 0.25, 0]).astype(float)
    assert (colored(color=np.float32([single] * 3)) == colored(color=single)).all()
    for byte, number, of_byte in zip(BYTES, floats, right):
        named = "#" + byte.tobytes().hex()
        for color in [byte, number, tuple(number), named]:
            assert (colored(color=color) == of_byte).all()
            assert (colored(color_by=[np.nan] * 3, range=(0, 1), missing_color=color) == of_byte).all()
        for space, expected in [("srgb", of_byte), ("linear", number)]:
            assert (colored(color=number, color_space=space) == expected).all()
            given = dict(missing_color=number, color_space=space)
            assert (colored(color_by=[np.nan] * 3, range=(0, 1), **given) == expected).all()
            for color in [number, byte]:
                background = kb.Scene(background=color, color_space=space)
                seen = background.render(camera, (1, 1)).rgb[0, 0]
                assert (seen == expected.astype("f4")).all()
                changed = kb.Scene().replace(background=color, color_space=space)
                assert (changed.render(camera, (1, 1)).rgb == seen).all()
        assert (colored(color=named, color_space="linear") == of_byte).all()


def test_colours_of_planes_and_lights_are_srgb():
    ball = kb.Scene([[0, 0, 0, 1]])
    for byte, number in zip(BYTES, BYTES / 255):
        plane = dict(point=(0, 0, 0), normal=(0, 1, 0))
        for key, of in [
            ("planes", lambda color: [{**plane, "color": color}]), ("lights", lambda color: ({"position": "eye", "color": color},)),
            ("ambient", lambda color: color), ("background", lambda color: color),
        ]:
            hashes = {kb.Scene(**{key: of(color)}).hash() for color in [byte, number, list(number), "#" + byte.tobytes().hex()]}
            linear = {kb.Scene(**{key: of(color)}, color_space="linear").hash() for color in [byte, number]}
            assert len(hashes) == len(linear) == 1 and hashes != linear, key
            srgb, linear = ball.replace(**{key: of(number)}), ball.replace(**{key: of(number)}, color_space="linear")
            assert srgb.hash() != linear.hash(), key
    # A number is an intensity.
    assert kb.Scene(ambient=0.5).hash() == kb.Scene(ambient=(0.5,) * 3, color_space="linear").hash()
    assert kb.Scene(ambient=0.5).hash() == kb.Scene(ambient=np.array(0.5), color_space="linear").hash()
    # Scene files are linear as before.
    assert kb.Scene(background=(0.5, 0, 0), color_space="linear").hash() == kb.Scene.parse("background = [0.5, 0.0, 0.0]").hash()


def test_alpha_is_1():
    opaque = np.column_stack([BYTES / 255, np.ones(3)])
    rows, right = [[0, 0, 0, 1]] * 3, kb.Scene([[0, 0, 0, 1]] * 3, color=BYTES).colors
    for color in [opaque, np.column_stack([BYTES, np.full(3, 255, np.uint8)]), opaque.astype(object).tolist()]:
        assert (kb.Scene(rows, color=color).colors == right).all()
    for color in [opaque[0], tuple(opaque[0]), np.append(BYTES[0], np.uint8(255))]:
        assert (kb.Scene(rows, color=color).colors == right[0]).all()
        assert kb.Scene(background=color).hash() == kb.Scene(background=BYTES[0]).hash()
    clear = opaque.copy()
    clear[2, 3] = 0.5
    refuses(
        partial(kb.Scene, rows), ValueError,
        (dict(color=clear), r"^color: row 2 .*alpha of 1,.*found 0.5"),
        (dict(color=np.column_stack([BYTES, [255, 0, 255]]).astype("u1")), r"^color: row 1 .*alpha of 255"),
        (dict(color=(1, 0, 0, 0.25)), "^color: .*alpha"), (dict(background=(1, 0, 0, 0.25)), "^background: .*alpha"),
        (dict(planes=[dict(point=(0, 0, 0), normal=(0, 1, 0), color=(1, 0, 0, 0))]), r"^planes\[0\], color: .*alpha"),
    )


def test_names_of_colours():
    rows = [[0, 0, 0, 1]] * 3
    right = kb.Scene(rows, color=np.array([[255, 0, 0], [214, 39, 40], [255, 0, 0]], "u1")).colors
    names = ["red", "#d62728", "Red"]
    for color in [names, tuple(names), np.array(names), np.array(names, object)]:
        assert (kb.Scene(rows, color=color).colors == right).all()
    assert (kb.Scene(rows, color=np.array("red")).colors == right[0]).all()
    refuses(
        partial(kb.Scene, rows), ValueError,
        (dict(color=["red", "#d62728", "redd"]), "^color: row 2 .*redd.*red"), (dict(color=["red"] * 2), "^color: 2 colours for 3"),
    )


@pytest.mark.parametrize("given, words", [
    (dict(color=(2, 0, 0)), "^color: 2.0 in a colour; expected .*from 0 to 1"),
    (dict(color=(2, 0, 0), color_space="linear"), "^color: 2.0 in a linear colour"),
    (dict(color=[[0, 0, 0], [0.5, 1.5, 0]]), r"^color: row 1 .*from 0 to 1, found \(0.5, 1.5, 0.0\)"),
    (dict(color=[[214, 39, 40]] * 2), "^color: row 0 .*uint8"),
    (dict(color=[[0, 0, 0], [0, -0.5, 0]], color_space="linear"), "^color: row 1 .*-0.5"),
    (dict(color=[0.5] * 5), "^color: .*color_by"),
    (dict(background=(0, 0, 7)), "^background: 7.0 in a colour"),
    (dict(background="grean"), "did you mean \"green\""),
    (dict(lights=[dict(position="eye"), dict(position="eye", color=(0, 0, 7))]), r"^lights\[1\], color: 7.0"),
    (dict(color_space="sRGB"), "^color_space: .*srgb.*linear"),
])
def test_wrong_colours_are_named(given, words):
    refuses(partial(kb.Scene, [[0, 0, 0, 1]] * 2), ValueError, (given, words))


class Map:
    """A colour map as matplotlib has it."""

    def __init__(self, name, of):
        self.name, self.of = name, of

    def __call__(self, number):
        assert type(number) is float
        return (*self.of(number), 1.0)


def test_colour_maps_are_objects_too():
    rows, numbers = [[0, 0, 0, 1]] * 256, np.arange(256)

    def colored(colormap, **given):
        return kb.Scene(rows, color_by=numbers, colormap=colormap, **given)

    # The library's own map of this name.
    assert (colored(Map("Viridis_r", None)).colors == colored("viridis_r").colors).all()
    bytes_of = lambda number: (number, 1 - number, 40 / 255)
    right = kb.Scene(rows, color=np.column_stack([numbers, 255 - numbers, np.full(256, 40)]).astype("u1")).colors
    for colormap in [Map("mine", bytes_of), bytes_of, lambda number: np.uint8(np.round(255 * np.array(bytes_of(number))))]:
        scene = colored(colormap)
        assert (scene.colors == right).all()
        assert "#00ff28" in str(scene.legend()) and "#ff0028" in str(scene.legend())
    for again in [pickle.loads(pickle.dumps(scene)), scene.replace(ambient=1)]:
        assert (again.colors == right).all() and str(again.legend()) == str(scene.legend())
    assert (colored(lambda number: "#d62728").colors == kb.Scene(rows, color="#d62728").colors).all()
    linear = colored(lambda number: (0.5, 0, 0), color_space="linear").colors
    assert abs(linear[0, 0] - 0.5) < 0.005
    for colormap, words in [
        (lambda number: (2, 0, 0), "colormap: .*2.0"), (lambda number: None, "colormap"), (lambda: 0, "colormap: called with 0.0, it raised"),
        ("virids", "did you mean \"viridis\""), (lambda number: (0, 0, 0, number), "colormap: .*alpha"),
    ]:
        with pytest.raises((ValueError, TypeError), match=words):
            colored(colormap)


def test_linear_colours_come_back_exactly(tmp_path):
    """What a scene gives back is linear, and is kept to the last bit."""
    rng = np.random.default_rng(6)
    for n in [1, 3, 5000]:
        rows = np.column_stack([rng.random((n, 3)), np.full(n, 0.1)])
        for color in [rng.random((n, 3)), rng.random(3), "#123456"]:
            scene = kb.Scene(rows, color=color, background=(0.3, 0.2, 0.1), ambient=(0.7, 0.6, 0.5))
            scene.save(tmp_path / "scene.toml")
            for other in [pickle.loads(pickle.dumps(scene)), kb.Scene.open(tmp_path / "scene.toml"), scene.replace(size=(3, 2)),
                          copy.copy(scene), copy.deepcopy(scene)]:
                assert (other.colors == scene.colors).all() and other.hash() == scene.hash()
            assert (kb.Scene(rows, color=scene.colors, color_space="linear").colors == scene.colors).all()


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
    for frame, x in [(-1, 2), (-2, 1)]:
        assert kb.Scene.open(tmp_path / "steps.xyz", frame=frame).spheres[0, 0] == x
    for frame in [2, -3]:
        with pytest.raises(kb.SceneError, match=f"no frame {frame}.*`frame=1`"):
            kb.Scene.open(tmp_path / "steps.xyz", frame=frame)


def test_data_are_opened_as_arguments_say(tmp_path):
    path = tmp_path / "grains.txt"
    path.write_text("of a program\nx,y,paint,r\n1,2,0.5,1\n3,,0.25,1\n5,6,0.75,2\n")
    given = dict(header=2, missing="skip", columns=dict(z=0.0))
    assert kb.Scene.open(path, **given).spheres.tolist() == [[1, 2, 0, 1], [5, 6, 0, 2]]
    given["columns"] = dict(z=7.5, radius=False)
    assert kb.Scene.open(path, radius=0.25, **given).spheres.tolist() == [[1, 2, 7.5, 0.25], [5, 6, 7.5, 0.25]]
    del given["missing"]
    with pytest.raises(kb.SceneError, match='`missing="skip"`'):
        kb.Scene.open(path, **given)
    (tmp_path / "c.csv").write_text("x,y,z,radius,red,green,blue,n\n0,0,0,1,0.5,0.25,0,1\n9,0,0,1,0.5,0.25,0,\n")
    for space, expected in [(None, kb.Scene([[0, 0, 0, 1]], color=(0.5, 0.25, 0)).colors[0]), ("linear", [0.5, 0.25, 0])]:
        opened = partial(kb.Scene.open, tmp_path / "c.csv", color_space=space)
        assert (opened().colors == expected).all()
        without = dict(columns=dict(red=False, green=False, blue=False))
        assert (opened(color=(0.5, 0.25, 0), **without).colors == expected).all()
        by = opened(color_by="n", missing_color=np.array([0.5, 0.25, 0]), range=(0, 2), **without).colors
        assert (by[1] == expected).all() and (by[0] != by[1]).any()
    by = opened(color_by="n", colormap=Map("magma", None), **without).colors
    assert (by == opened(color_by="n", colormap="magma", **without).colors).all()
    refuses(
        opened, ValueError, (dict(color_by="n", colormap=Map("mine", lambda x: (0, 0, 0))), "^colormap: "),
        (dict(missing="drop"), "^missing: .*skip"), (dict(header=0), "^header: "), (dict(color_space="rgb"), "^color_space: "),
    )


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
    for call, name in [(kb.Scene.open, "no.toml"), (kb.read, "no.png")]:
        with pytest.raises(FileNotFoundError) as caught:
            call(tmp_path / name)
        assert caught.value.errno == errno.ENOENT and name in caught.value.filename
    refuses(partial(ball.render, camera), TypeError, (dict(size="big"), "^size: "), (dict(size=(8, 8), crop=b"abcd"), "^crop: "))
    refuses(ball.explain, TypeError, (dict(camera=camera, pixel="p"), "^pixel: "))
    with pytest.raises(ValueError, match="`position` and `look_at`") as caught:
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


def test_a_scene_without_a_camera_is_framed(tmp_path):
    """As the program frames it: for the picture's size."""
    rows = np.column_stack([np.random.default_rng(8).random((50, 3)) * [4, 1, 1], np.full(50, 0.1)])
    scene, size = kb.Scene(rows), (40, 30)
    camera = kb.Camera.frame(scene, size=size)
    assert scene.camera is None and camera != kb.Camera.frame(scene, size=(30, 40))
    picture = scene.render(size=size)
    assert picture.digest() == scene.render(camera, size).digest() == scene.digest(size=size)
    assert scene.camera is None and (picture.t == scene.render(camera, size).t).all()
    assert scene.explain(pixel=(20, 15), size=size).to_dict() == scene.explain(camera, (20, 15), size=size).to_dict()
    ours, theirs = scene.check(size=size), scene.check(camera, size)
    assert {**ours, "hierarchy": 0} == {**theirs, "hierarchy": 0}
    assert kb.compare({"id": picture.id}, scene) and scene.verify(size=size, device="cpu", samples=20)
    assert (scene.show("depth", size=size).rgb8 == scene.show("depth", camera, size).rgb8).all()
    assert scene.export(tmp_path / "a.pov", size=size).replace("a.pov", "b.pov") == scene.export(tmp_path / "b.pov", camera=camera, size=size)
    assert (tmp_path / "a.pov").read_bytes() == (tmp_path / "b.pov").read_bytes()
    sized = scene.replace(size=size)
    assert sized.render().digest() == picture.digest()
    floor = kb.Scene(planes=[dict(point=(0, 0, 0), normal=(0, 1, 0), color="red")])
    assert floor.check()["objects"]["planes"] == 1
    for call, given in [(floor.render, {}), (floor.digest, {}), (floor.explain, dict(pixel=(0, 0))), (floor.show, dict(what="depth"))]:
        refuses(call, ValueError, (given, r"^camera: .*no spheres.*Camera\("))
