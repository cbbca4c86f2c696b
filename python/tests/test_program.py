"""The package against the program: the same words, numbers and files."""

import re
from functools import partial

import kugelblitz as kb
import numpy as np
import pytest
from conftest import ROOT, cloud, refuses

SCENES = ROOT / "scenes"
SIZE = (96, 54)
DIGESTS = {
    name: digest
    for digest, name in re.findall(r"^(\S+)  .*  scenes/(.+)\.toml$", (ROOT / "tests/digests.txt").read_text(), re.M)
}


def scene(name):
    return kb.Scene.open(SCENES / f"{name}.toml", size=SIZE)


def options(**given):
    """Arguments as the program takes them."""
    return [f"--{key}={','.join(map(str, np.ravel(value)))}" for key, value in given.items()]


def is_in(ours, theirs):
    """Whether what a dictionary holds is under the same keys of the program's."""
    return ours == theirs or isinstance(ours, dict) and all(key in theirs and is_in(ours[key], theirs[key]) for key in ours)


@pytest.fixture
def alike(run, tmp_path):
    """Whether a call saves the file that a command writes; the first lines of an export name its path."""

    def alike(name, save, *command, first_line=0):
        run(*command, "-o", tmp_path / f"theirs-{name}")
        save(tmp_path / f"ours-{name}")
        ours, theirs = ((tmp_path / f"{whose}-{name}").read_bytes().split(b"\n")[first_line:] for whose in ["ours", "theirs"])
        return ours and ours == theirs

    return alike


@pytest.fixture(scope="module")
def other(tmp_path_factory):
    """A picture in plain f32, as another renderer's."""
    path = tmp_path_factory.mktemp("other") / "other.npy"
    scene("hard/distant_1e4").render(kernel="lecture").save(path)
    return path


@pytest.mark.parametrize("name", DIGESTS)
def test_digests_are_those_of_the_repository(name):
    for device in ["cpu", "auto"]:
        assert scene(name).render(device=device).digest() == DIGESTS[name], device


def test_digests_tell_pictures_apart(ball, camera):
    digests = [
        scene.render(view, size, samples=samples).digest()
        for scene in [ball, cloud(5)]
        for view in [camera, kb.Camera((1, 1, 3), (0, 0, 0))]
        for size in [(30, 20), (20, 30)]
        for samples in [1, 2]
    ]
    assert len(set(digests)) == 16


@pytest.mark.parametrize("ending", ["png", "ppm", "npy", "exr"])
def test_pictures(run, alike, tmp_path, camera, ending):
    made = cloud(300, planes=[dict(point=[0, 0, 0], normal=[0, 1, 0], color="#8c8c8c")], sky=dict(intensity=1), camera=camera)
    made.save(path := tmp_path / "scene.toml")
    made = kb.Scene.open(path)
    command = [path, "--size=80x60", "--samples=2"]
    picture = made.render(size=(80, 60), samples=2)
    assert alike(f"p.{ending}", picture.save, "render", *command)
    assert picture.digest() == made.digest(size=(80, 60), samples=2) == run("digest", *command).split()[0]


@pytest.mark.parametrize("what", ["depth", "normal", "id", "stage"])
def test_shown(run, tmp_path, what):
    shown = scene("figure1").show(what, device="cpu")
    shown.save(ours := tmp_path / "ours.png")
    theirs = tmp_path / "theirs.png"
    run("render", SCENES / "figure1.toml", "--size=96x54", f"--show={what}", "--device=cpu", "-o", theirs)
    assert kb.compare(ours, theirs) and shown.rgb8.shape == (54, 96, 3) and (what == "id") == (not shown.legend)


@pytest.mark.parametrize("number", [2, 3, 4, 5])
@pytest.mark.parametrize("lang", ["en", "de"])
def test_figures(alike, number, lang):
    figure = kb.figure(number, lang=lang)
    assert alike("f.svg", figure.save, "figure", number, f"--lang={lang}") and figure._repr_svg_() == str(figure)
    with pytest.raises(ValueError, match="number"):
        kb.figure(6)


@pytest.mark.parametrize("language", ["pov", "tachyon"])
def test_exports(alike, language):
    export = partial(scene("figure1").export, language=language)
    assert alike("scene", export, "export", language, SCENES / "figure1.toml", "--size=96x54", first_line=3)


def test_hits(run, tmp_path):
    made = cloud(2000)
    made.save(path := tmp_path / "scene.toml")
    rng = np.random.default_rng(8)
    rays = np.hstack([rng.normal(0.5, 1, (3000, 3)), rng.normal(0, 1, (3000, 3))])
    np.save(tmp_path / "rays.npy", rays)
    run("trace", path, "--rays", tmp_path / "rays.npy", "-o", tmp_path / "hits.npy")
    theirs = np.load(tmp_path / "hits.npy")
    for given in [made, kb.Scene.open(path)]:
        ours = given.trace(rays[:, :3], rays[:, 3:])
        assert 0 < (ours.id > 0).sum() < 3000
        for field in ["id", "t", "normal"]:
            assert ours[field].tobytes() == theirs[field].tobytes()


@pytest.mark.parametrize("name, given", [
    ("figure5", dict(pixel=(640, 360))), ("figure1", dict(pixel=(700, 300))), ("lit/figure1", dict(pixel=(400, 500))),
    ("figure2", dict(ray=((0, 0, 0), np.array([0, 0, -1])))),
])
@pytest.mark.parametrize("lang", ["en", "de"])
def test_explanations(run, told, name, given, lang):
    path = SCENES / f"{name}.toml"
    explain = partial(kb.Scene.open(path).explain, **given, lang=lang)
    command = ["explain", path, *options(**given, lang=lang, device="cpu")]
    explanation, many = explain(), explain(digits=12, all=True)
    assert str(explanation).strip() == run(*command).strip()
    assert str(many).strip() == run(*command, "--digits", 12, "--all").strip()
    assert explanation.latex().strip() == run(*command, "--latex").strip()
    assert explanation.to_dict() == told(*command)["explanation"]
    assert explanation._repr_latex_().startswith("\\begin{align*}")


def test_what_is_no_ray():
    refuses(
        kb.Scene.open(SCENES / "figure2.toml").explain, (ValueError, TypeError),
        (dict(), "pixel"), (dict(pixel=(5000, 2)), "5000"), (dict(pixel=(-1, 2)), "pixel"),
        (dict(ray=((0, 0, 0), (0, 0, 0))), "ray"), (dict(ray=((0, 0, 0), (0, np.nan, 0))), "ray"),
        (dict(pixel=(1, 1), lang="fr"), "lang"), (dict(pixel=(1, 1), digits=0), "digits"),
    )


def test_compare_with_a_scene(told, other):
    path = SCENES / "hard/distant_1e4.toml"
    exact_scene = kb.Scene.open(path)
    comparison = kb.compare(other, exact_scene)
    theirs = told("compare", other, path, code=6)
    hits, ours = comparison.hits, comparison.to_dict()["hits"]
    keys = ["size", "rays", "compared", "allowed", "away", "silhouettes", "by_object", "broken"]
    assert is_in({key: ours[key] for key in keys}, theirs["hits"])
    # The program prints the command that explains a ray.
    assert ours["worst"] == [{k: v for k, v in case.items() if k != "explain"} for case in theirs["hits"]["worst"]]
    assert not comparison and not hits.kept and hits.broken and comparison.colors is not None
    array = np.load(other)
    same = kb.compare({"id": array["id"], "t": array["t"], "normal": array["normal"]}, exact_scene)
    assert same.colors is None
    assert same.hits.counts == hits.counts == kb.compare(exact_scene, array).hits.counts
    exact = exact_scene.render(size=SIZE)
    wrong_ids = set(np.flatnonzero(array["id"] != exact.id))
    assert hits.counts["wrong_ids"] == len(wrong_ids) and wrong_ids <= set(hits.wrong)
    row, column = divmod(first := min(wrong_ids), SIZE[0])
    for at in [(column, row), np.array([column, row]), np.int64(first)]:
        assert hits.at(at) == hits.at(first) != []
    refuses(hits.at, ValueError, *((dict(at=at), "at: ") for at in [(SIZE[0], 0), -1, (-1, 0)]))
    refuses(hits.at, TypeError, *((dict(at=at), "at: ") for at in ["p", (1, 2, 3)]))
    assert hits.explain((column, row)).id == exact.id[row, column]
    assert comparison.picture.rgb8.shape == (SIZE[1], SIZE[0], 3)
    assert kb.compare(exact, exact_scene) and not kb.compare(exact, exact_scene).broken
    assert kb.compare(exact_scene, exact_scene, size=(32, 18))


def test_compare_finds_what_is_planted(camera):
    made = cloud(500)
    exact = made.render(camera, SIZE)
    ids, t = exact.id.copy(), exact.t.copy()
    missed, other, deep = np.split(np.random.default_rng(9).choice(np.flatnonzero(ids), 30, replace=False), 3)
    ids.flat[missed], ids.flat[other] = 0, ids.flat[other] % 500 + 1
    t.flat[deep] *= np.float32(1.5)
    hits = kb.compare({"id": ids, "t": t}, made, camera=camera).hits
    assert hits.counts["false_misses"] == 10 and hits.counts["wrong_object"] == 10
    assert set(hits.wrong) == {*missed, *other, *deep} and hits.explained_by is None


def test_compare_takes_and_names_transforms(camera):
    made = cloud(500)
    exact = made.render(camera, SIZE)
    from_0 = exact.id.astype(int) - 1
    with np.errstate(divide="ignore"):
        zbuffer = np.where(exact.id, (2 - 1 / exact.t) / (2 - 1 / 50), 1)
    half = np.tan(np.radians(camera.fov / 2))
    x, y = ((np.arange(n) + 0.5 - n / 2) / (SIZE[1] / 2) * half for n in SIZE)
    distance = exact.t * np.sqrt(1 + x**2 + y[:, None] ** 2)
    forward = np.subtract(camera.look_at, camera.position)
    right = np.cross(forward, camera.up)
    axes = np.array([axis / np.linalg.norm(axis) for axis in [right, np.cross(right, forward), -forward]])
    loose = "t=1e-4,normal=0.1"
    for arrays, transform in [
        (dict(id=from_0), "ids+1"), (dict(id=exact.id[::-1]), "flip-rows"), (dict(id=exact.id, t=exact.t * 1000.0), "scale=0.001"),
        (dict(id=exact.id, t=zbuffer), "zbuffer=0.5:50"), (dict(id=exact.id, t=distance), "distance"),
        (dict(t=np.where(exact.id, exact.t, 7)), "background=7"), (dict(id=exact.id, normal=exact.normal @ axes.T), "camera-normals"),
        (dict(id=exact.id, normal=-exact.normal), "negate-normals"),
    ]:
        of = partial(kb.compare, arrays, made, camera=camera)
        comparison = of(allow=loose)
        assert comparison.explained_by == transform and f'transform="{transform}"' in str(comparison)
        assert of(transform=[transform], allow=loose), transform
    refuses(
        partial(kb.compare, a={"id": exact.id}, b=made, camera=camera), (ValueError, TypeError),
        (dict(transform="zbuffer=1"), "zbuffer"), (dict(transform=["scale=0"]), "scale"), (dict(transform="up"), "no transform"),
        (dict(a={"id": exact.id, "t": exact.t[1:]}), "the shape"), (dict(a={}), "nothing"), (dict(a={"ids": exact.id}), "ids"),
        (dict(allow="levels=1"), "levels"), (dict(rays=(np.zeros((1, 3)), np.ones((1, 3)))), "camera"),
    )
    refuses(kb.compare, ValueError, (dict(a=exact, b=exact, camera=camera), "Scene"), (dict(a=exact, b=exact, transform="ids+1"), "flips"))


def test_compare(told, other, tmp_path):
    exact = scene("hard/distant_1e4").render()
    exact.save(tmp_path / "exact.npy")
    difference = kb.compare(tmp_path / "exact.npy", other)
    ours, theirs = difference.to_dict(), told("compare", tmp_path / "exact.npy", other, code=6)["picture"]
    assert is_in({key: ours[key] for key in ["allowed", "pixels", "differing", "beyond", "first", "channels"]}, theirs)
    assert not difference and difference.n_differing == theirs["differing"]
    assert kb.compare(exact, exact) and kb.compare(exact.rgb8, exact)
    spoilt = exact.rgb8.copy()
    spoilt[3, 5, 1] ^= 4
    assert kb.compare(spoilt, exact.rgb8).beyond.tolist() == [3 * SIZE[0] + 5]
    assert kb.compare(spoilt, exact.rgb8, allow="levels=4")
    assert kb.compare(exact.rgb8[::-1], exact).explained_by == "flip-rows"


def test_arrays_of_any_type_and_order_are_compared(camera):
    made = cloud(50)
    exact = made.render(camera, SIZE)
    for change in [np.asfortranarray, lambda a: a.astype(a.dtype.newbyteorder(">")), lambda a: np.repeat(a, 2, 0)[::2]]:
        arrays = {"id": exact.id, "t": exact.t, "normal": exact.normal, "rgb": exact.rgb8}
        assert kb.compare({key: change(array) for key, array in arrays.items()}, made, camera=camera).colors is not None
    for dtype in ["u2", "i2", "i4", "i8", "u8", "f4", "f8", "g"]:
        assert kb.compare({"id": exact.id.astype(dtype)}, made, camera=camera), dtype
    for dtype, name in [("u1", "u8"), ("u2", "u16"), ("u4", "u32"), ("i4", "i64"), ("f2", "f16"), ("f4", "f32"), ("f8", "f64")]:
        colors = exact.rgb8.astype(dtype)
        assert [channel["types"] for channel in kb.compare(colors, colors).channels] == [[name, name]] * 3
    refuses(kb.compare, ValueError, (dict(a=exact.rgb8[:0], b=exact), "^a: the shape"), (dict(a=exact, b=exact.rgb8[0, 0]), "^b: the shape"))


def test_verify(told):
    theirs = told("verify", SCENES / "hard/distant_1e4.toml", "--size=96x54")["kernels"][0]
    verification = scene("hard/distant_1e4").verify(device="gpu")
    [ours] = verification.to_dict()["kernels"]
    assert verification and is_in({key: ours[key] for key in ["kernel", "gpu_against_cpu"]}, theirs)
    refuses(scene("hard/distant_1e4").verify, ValueError, (dict(samples=0), "samples: "))


def test_info_and_check(told, tmp_path):
    lit = scene("lit/figure1")
    lit.render().save(tmp_path / "p.png")
    assert (info := kb.info(tmp_path / "p.png")) and is_in(info, told("info", tmp_path / "p.png"))
    assert is_in({key: lit.check()[key] for key in ["objects", "light"]}, told("info", SCENES / "lit/figure1.toml"))


@pytest.mark.parametrize("distribution", ["uniform", "lattice", "packing"])
def test_generate(run, distribution, tmp_path):
    path = tmp_path / "cloud.npy"
    run("generate", "--count=300", f"--distribution={distribution}", "--seed=7", "-o", path)
    made, theirs = kb.Scene.generate(300, distribution, seed=7), np.load(path)
    # The file has bytes in sRGB.
    assert (made.spheres == theirs[:, :4]).all() and theirs.shape == (300, 7)
    ours = kb.Scene(made.spheres, color=made.colors, color_space="linear", camera=made.camera)
    assert ours.render(size=SIZE).digest() == made.render(size=SIZE).digest()
    theirs = kb.Scene(theirs[:, :4], color=theirs[:, 4:].astype("u1"), camera=made.camera)
    assert (theirs.render(size=SIZE).rgb8 == made.replace(lights=None, sky=None, ambient=None, background=None).render(size=SIZE).rgb8).all()


@pytest.mark.parametrize("given", [{}, {"view": "iso"}, {"view": "-x", "fov": 30}, {"view": "y", "height": "auto", "up": (0, 0, 1)}])
def test_frame_places_the_camera_where_the_program_does(run, tmp_path, given):
    np.save(tmp_path / "cloud.npy", cloud(200).spheres)
    text = run("render", tmp_path / "cloud.npy", "--print-scene", "--size=96x54", *options(**given))
    (tmp_path / "theirs.toml").write_text(text)
    theirs = kb.Scene.open(tmp_path / "theirs.toml")
    assert kb.Camera.frame(cloud(200), size=SIZE, **given) == theirs.camera
    assert kb.Scene.open(tmp_path / "cloud.npy", size=SIZE, **given).digest() == theirs.digest()


def test_data_files_are_read_as_the_program_reads_them(run, tmp_path):
    (tmp_path / "water.xyz").write_text("3\nwater\nO 0 0 0\nH 0.96 0 0\nH -0.24 0.93 0\n")
    text = run("render", tmp_path / "water.xyz", "--print-scene", "--size=96x54")
    (tmp_path / "theirs.toml").write_text(text)
    ours = kb.Scene.open(tmp_path / "water.xyz", size=SIZE)
    assert ours.digest() == kb.Scene.open(tmp_path / "theirs.toml").digest() and ours.n_spheres == 3


def test_films(run, tmp_path):
    figure = scene("figure1")
    run("render", SCENES / "figure1.toml", "--size=96x54", "--turntable=3", "-o", tmp_path / "film.png")
    for number, camera in enumerate(figure.camera.turntable(3), 1):
        assert kb.compare(figure.render(camera).rgb8, tmp_path / f"film-{number:04}.png")


def test_colours_by_numbers(tmp_path):
    rng = np.random.default_rng(10)
    centers, speed = rng.random((100, 3)), rng.random(100)
    speed[3] = np.nan
    given = dict(radius=0.05, colormap="plasma", range=(0.25, 0.75))
    ours = kb.Scene(centers, color_by=speed, missing_color="#ff0000", **given)
    rows = "\n".join(f"{x!r},{y!r},{z!r},{'' if np.isnan(s) else repr(float(s))}" for (x, y, z), s in zip(centers.tolist(), speed))
    (tmp_path / "grains.csv").write_text(f"x,y,z,speed\n{rows}\n")
    theirs = kb.Scene.open(tmp_path / "grains.csv", color_by="speed", **given)
    assert ((ours.colors == theirs.colors).all(1) == (np.arange(100) != 3)).all() and len(np.unique(ours.colors, axis=0)) > 20
    assert ours.colors[3].tolist() == [1, 0, 0] and ours.legend()._repr_svg_().startswith("<svg")
    wrong = [dict(color_by=numbers) for numbers in [speed[:5], speed[:, None] * [1, 1], ["a"] * 100]]
    refuses(partial(kb.Scene, centers, radius=0.05), (ValueError, TypeError), *((given, "color_by") for given in wrong))
