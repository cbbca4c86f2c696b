"""What the program has besides `render` and `trace`: the package gives the same words, numbers and files."""

from functools import partial

import kugelblitz as kb
import numpy as np
import pytest
from conftest import ROOT, cloud, refuses

SCENES = ROOT / "scenes"
SIZE = (96, 54)


def assert_in(ours, theirs, name=""):
    """What a dictionary holds is under the same keys of the program's."""
    assert ours
    for key, value in ours.items():
        assert key in theirs, f"{name}.{key}"
        if isinstance(value, dict) and isinstance(theirs[key], dict):
            assert_in(value, theirs[key], f"{name}.{key}")
        else:
            assert value == theirs[key], f"{name}.{key}"


@pytest.fixture(scope="module")
def other(tmp_path_factory):
    """A picture in plain f32, as another renderer's."""
    path = tmp_path_factory.mktemp("other") / "other.npy"
    kb.Scene.open(SCENES / "hard/distant_1e4.toml").render(size=SIZE, kernel="lecture").save(path)
    return path


@pytest.mark.parametrize("name, pixel", [("figure5", (640, 360)), ("figure1", (700, 300)), ("lit/figure1", (400, 500))])
@pytest.mark.parametrize("lang", ["en", "de"])
def test_explain(run, told, name, pixel, lang):
    path = SCENES / f"{name}.toml"
    scene = kb.Scene.open(path)
    given = ["explain", path, "--pixel", f"{pixel[0]},{pixel[1]}", "--device", "cpu", "--lang", lang]
    explanation = scene.explain(pixel=pixel, lang=lang)
    assert str(explanation).strip() == run(*given).strip()
    assert explanation.latex().strip() == run(*given, "--latex").strip()
    assert explanation.to_dict() == told(*given)["explanation"]
    assert explanation.id == scene.render(crop=(*pixel, 1, 1)).id[0, 0]
    assert explanation._repr_latex_().startswith("\\begin{align*}")
    many = scene.explain(pixel=pixel, lang=lang, digits=12, all=True)
    assert str(many).strip() == run(*given, "--digits", 12, "--all").strip()


def test_explain_a_ray(run):
    path = SCENES / "figure2.toml"
    scene = kb.Scene.open(path)
    explanation = scene.explain(ray=((0, 0, 0), np.array([0, 0, -1])))
    theirs = run("explain", path, "--ray", "0,0,0,0,0,-1", "--device", "cpu")
    assert str(explanation).strip() == theirs.strip()
    refuses(
        scene.explain, (ValueError, TypeError),
        (dict(), "pixel"), (dict(pixel=(5000, 2)), "5000"), (dict(pixel=(-1, 2)), "pixel"),
        (dict(ray=((0, 0, 0), (0, 0, 0))), "ray"), (dict(ray=((0, 0, 0), (0, np.nan, 0))), "ray"),
        (dict(pixel=(1, 1), lang="fr"), "lang"), (dict(pixel=(1, 1), digits=0), "digits"),
    )


def test_judge(told, other):
    path = SCENES / "hard/distant_1e4.toml"
    scene = kb.Scene.open(path)
    judgement = scene.judge(against=other)
    theirs = told("judge", path, "--against", other, code=6)
    ours = judgement.to_dict()
    for key in ["size", "rays", "judged", "allowed", "away", "silhouettes", "broken"]:
        assert ours[key] == theirs[key], key
    # The program says besides by which command one sees why.
    assert ours["worst"] == [{k: v for k, v in case.items() if k != "explain"} for case in theirs["worst"]]
    assert not judgement and not judgement.kept and judgement.broken
    array = np.load(other)
    same = scene.judge(id=array["id"], t=array["t"], normal=array["normal"])
    assert same.counts == judgement.counts == scene.judge(against=array).counts
    exact = scene.render(size=SIZE)
    wrong_ids = set(np.flatnonzero(array["id"] != exact.id))
    assert judgement.counts["wrong_ids"] == len(wrong_ids) and wrong_ids <= set(judgement.wrong)
    row, column = divmod(min(wrong_ids), SIZE[0])
    for at in [(column, row), np.array([column, row]), np.int64(min(wrong_ids))]:
        assert judgement.at(at) == judgement.at(min(wrong_ids)) != []
    for at, error in [((SIZE[0], 0), ValueError), (-1, ValueError), ((-1, 0), ValueError), ("p", TypeError), ((1, 2, 3), TypeError)]:
        with pytest.raises(error, match="at: "):
            judgement.at(at)
    assert judgement.explain((column, row)).id == exact.id[row, column]
    assert judgement.picture.rgb8.shape == (SIZE[1], SIZE[0], 3)
    assert scene.judge(against=exact) and not scene.judge(against=exact).broken


def test_judge_finds_what_is_planted():
    scene = cloud(500)
    camera = kb.Camera((1.9, 1.4, 2.2), (0.5, 0.5, 0.5), fov=40)
    exact = scene.render(camera, SIZE)
    rng = np.random.default_rng(9)
    ids, t = exact.id.copy(), exact.t.copy()
    hit = np.flatnonzero(ids)
    missed, other, deep = np.split(rng.choice(hit, 30, replace=False), 3)
    ids.flat[missed], ids.flat[other] = 0, ids.flat[other] % 500 + 1
    t.flat[deep] *= np.float32(1.5)
    judgement = scene.judge(camera, id=ids, t=t)
    assert judgement.counts["false_misses"] == 10 and judgement.counts["wrong_object"] == 10
    assert set(judgement.wrong) == {*missed, *other, *deep}


def test_judge_takes_the_conventions_of_others(camera):
    scene = cloud(500)
    exact = scene.render(camera, SIZE)
    judge = partial(scene.judge, camera, id=exact.id)
    from_0 = exact.id.astype(int) - 1
    with np.errstate(divide="ignore"):
        zbuffer = np.where(exact.id, (2 - 1 / exact.t) / (2 - 1 / 50), 1)
    for there in [
        dict(id=from_0, id_offset=1), dict(id=np.where(from_0 < 0, 99999, from_0), id_offset=1, no_hit=99999),
        dict(id=exact.id[::-1], rows_from_below=True), dict(normal=-exact.normal, normals="either"),
        dict(t=exact.t * 1000.0, scale=1e-3, allow="t=1e-6"), dict(zbuffer=zbuffer, near=0.5, far=50, allow="t=1e-4"),
    ]:
        assert judge(**there), there
    assert not judge(normal=-exact.normal) and not judge(id=from_0)
    refuses(
        judge, (ValueError, TypeError),
        (dict(near=1), "near, far"), (dict(near=1, far=1), "near, far"), (dict(scale=0), "scale"),
        (dict(scale="x"), "scale"), (dict(normals="sideways"), "normals.*outward"), (dict(id_offset=1.5), "id_offset"),
        (dict(color_tolerance=256), "color_tolerance"), (dict(rows_from_below=1), "rows_from_below"),
        (dict(t=exact.t[1:]), "t: the shape"), (dict(against=exact), "against"), (dict(id=None), "nothing"),
    )


def test_compare(told, other, tmp_path):
    exact = kb.Scene.open(SCENES / "hard/distant_1e4.toml").render(size=SIZE)
    exact.save(tmp_path / "exact.npy")
    theirs = told("compare", tmp_path / "exact.npy", other, code=6)
    difference = kb.compare(tmp_path / "exact.npy", other)
    ours = difference.to_dict()
    for key in ["allowed", "pixels", "differing", "beyond", "first", "channels"]:
        assert ours[key] == theirs[key], key
    assert not difference and difference.n_differing == theirs["differing"]
    assert kb.compare(exact, exact) and kb.compare(exact.rgb8, exact)
    spoilt = exact.rgb8.copy()
    spoilt[3, 5, 1] ^= 4
    assert kb.compare(spoilt, exact.rgb8).beyond.tolist() == [3 * SIZE[0] + 5]
    assert kb.compare(spoilt, exact.rgb8, allow="levels=4")


@pytest.mark.parametrize("number", [3, 4])
@pytest.mark.parametrize("lang", ["en", "de"])
def test_figure(run, number, lang, tmp_path):
    run("figure", number, "--lang", lang, "-o", tmp_path / "theirs.svg")
    figure = kb.figure(number, lang=lang)
    figure.save(tmp_path / "ours.svg")
    assert (tmp_path / "ours.svg").read_bytes() == (tmp_path / "theirs.svg").read_bytes()
    assert figure._repr_svg_() == str(figure)
    with pytest.raises(ValueError, match="number"):
        kb.figure(5)


@pytest.mark.parametrize("language, ending", [("pov", "pov"), ("tachyon", "dat")])
def test_export(run, language, ending, tmp_path):
    path = SCENES / "figure1.toml"
    run("export", language, path, "--size", "96x54", "-o", tmp_path / "theirs")
    kb.Scene.open(path).export(tmp_path / f"ours.{ending}", language, size=SIZE)
    assert (tmp_path / f"ours.{ending}").read_text().splitlines()[3:] == (tmp_path / "theirs").read_text().splitlines()[3:]


@pytest.mark.parametrize("distribution", ["uniform", "lattice", "packing"])
def test_generate(run, distribution, tmp_path):
    path = tmp_path / "cloud.npy"
    run("generate", "cloud", "--count", 300, "--distribution", distribution, "--seed", 7, "-o", path)
    scene = kb.Scene.generate(300, distribution, seed=7)
    assert (scene.spheres == np.load(path)[:, :4]).all()
    if np.load(path).shape[1] == 7:
        assert (scene.colors == np.load(path)[:, 4:]).all()


def test_digest_info_and_check(run, told, tmp_path):
    path = SCENES / "lit/figure1.toml"
    scene = kb.Scene.open(path)
    assert scene.digest(size=SIZE) == run("digest", path, "--size", "96x54").split()[0]
    assert scene.digest(size=SIZE) == scene.render(size=SIZE).digest()
    scene.render(size=SIZE).save(tmp_path / "p.png")
    theirs = told("info", tmp_path / "p.png")
    assert_in(kb.info(tmp_path / "p.png"), theirs)
    theirs = told("check", path)
    ours = scene.check()
    assert ours["objects"] == theirs["objects"] and ours["light"] == theirs["light"]


def test_verify(told):
    path = SCENES / "hard/distant_1e4.toml"
    theirs = told("verify", path, "--size", "96x54")
    verification = kb.Scene.open(path).verify(size=SIZE, device="gpu")
    assert verification
    ours = verification.to_dict()["kernels"][0]
    assert ours["kernel"] == "certified"
    assert ours["gpu_against_cpu"] == theirs["kernels"][0]["gpu_against_cpu"]


@pytest.mark.parametrize("what", ["depth", "normal", "id", "side", "stage"])
def test_show(run, what, tmp_path):
    path = SCENES / "figure1.toml"
    run("render", path, "--size", "96x54", "--show", what, "--device", "cpu", "-o", tmp_path / "theirs.png")
    shown = kb.Scene.open(path).show(what, size=SIZE, device="cpu")
    shown.save(tmp_path / "ours.png")
    assert kb.compare(tmp_path / "ours.png", tmp_path / "theirs.png")
    assert shown.rgb8.shape == (54, 96, 3) and (what == "id") == (not shown.legend) and shown._repr_png_().startswith(b"\x89PNG")


@pytest.mark.parametrize("options", [{}, {"view": "iso"}, {"view": "-x", "fov": 30}, {"view": "y", "height": "auto", "up": (0, 0, 1)}])
def test_frame_places_the_camera_where_the_program_does(run, tmp_path, options):
    scene = cloud(200)
    np.save(tmp_path / "cloud.npy", scene.spheres)
    given = [f"--{key}={','.join(map(str, value)) if isinstance(value, tuple) else value}" for key, value in options.items()]
    text = run("render", tmp_path / "cloud.npy", "--print-scene", "--size", "96x54", *given)
    (tmp_path / "theirs.toml").write_text(text)
    theirs = kb.Scene.open(tmp_path / "theirs.toml")
    ours = kb.Camera.frame(scene, size=SIZE, **options)
    assert ours == theirs.camera
    same = kb.Scene.open(tmp_path / "cloud.npy", size=SIZE, **options)
    assert same.render().digest() == theirs.render().digest()


def test_films(run, tmp_path):
    path = SCENES / "figure1.toml"
    scene = kb.Scene.open(path)
    run("render", path, "--size", "96x54", "--turntable", 3, "-o", tmp_path / "film.png")
    frames = [scene.render(camera, SIZE) for camera in scene.camera.turntable(3)]
    for number, frame in enumerate(frames, 1):
        assert kb.compare(frame.rgb8, tmp_path / f"film-{number:04}.png")
    (tmp_path / "path.csv").write_text("x,y,z\n0,1,6\n1,1,6\n")
    assert [c.position for c in scene.camera.path(tmp_path / "path.csv")] == [[0, 1, 6], [1, 1, 6]]


def test_colours_by_numbers(tmp_path):
    rng = np.random.default_rng(10)
    centers, speed = rng.random((100, 3)), rng.random(100)
    speed[3] = np.nan
    given = dict(color_by=speed, colormap="plasma", range=(0.25, 0.75), missing_color="#ff00ff")
    scene = kb.Scene(centers, radius=0.05, **given)
    rows = "\n".join(f"{x!r},{y!r},{z!r},{'' if np.isnan(s) else repr(float(s))}" for (x, y, z), s in zip(centers.tolist(), speed))
    (tmp_path / "grains.csv").write_text(f"x,y,z,speed\n{rows}\n")
    options = dict(colormap="plasma", range=(0.25, 0.75), radius=0.05)
    theirs = kb.Scene.open(tmp_path / "grains.csv", color_by="speed", **options)
    keep = np.arange(100) != 3
    assert (scene.colors[keep] == theirs.colors[keep]).all() and len(np.unique(scene.colors, axis=0)) > 20
    assert scene.colors[3].tolist() == [1, 0, 1]
    assert scene.legend()._repr_svg_().startswith("<svg")
    for wrong in [speed[:5], speed[:, None] * [1, 1], ["a"] * 100]:
        with pytest.raises((ValueError, TypeError), match="color_by"):
            kb.Scene(centers, radius=0.05, color_by=wrong)


def test_data_files_are_read_as_the_program_reads_them(run, tmp_path):
    (tmp_path / "water.xyz").write_text("3\nwater\nO 0 0 0\nH 0.96 0 0\nH -0.24 0.93 0\n")
    scene = kb.Scene.open(tmp_path / "water.xyz", size=SIZE)
    text = run("render", tmp_path / "water.xyz", "--print-scene", "--size", "96x54")
    (tmp_path / "theirs.toml").write_text(text)
    assert scene.digest() == kb.Scene.open(tmp_path / "theirs.toml").digest()
    assert scene.n_spheres == 3


def test_a_scene_with_some_things_changed(ball):
    camera = kb.Camera((0, 0, 5), (0, 0, 0))
    lit = ball.replace(camera=camera, size=(20, 10), lights=[{"position": "eye"}], samples=2)
    assert lit.camera == camera and lit.size == (20, 10) and lit.samples == 2 and lit.is_lit and not ball.is_lit
    assert lit.render().digest() != ball.render(camera, (20, 10)).digest()
    assert ball.replace(background=None).render(camera, (4, 2)).rgb8[0, 0].tolist() == [0, 0, 0]
    with pytest.raises(TypeError, match="radius"):
        ball.replace(radius=3)
