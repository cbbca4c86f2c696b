"""The package against the program: the same bytes and digests."""

import re

import kugelblitz as kb
import numpy as np
import pytest
from conftest import ROOT, cloud

DIGESTS = dict(re.findall(r'^"(.+)" = "(.+)"$', (ROOT / "tests/digests.toml").read_text(), re.M))


@pytest.mark.parametrize("name", DIGESTS)
def test_digests_are_those_of_the_repository(name):
    scene = kb.Scene.open(ROOT / f"scenes/{name}.toml")
    for device in ["cpu", "auto"]:
        assert scene.render(size=(96, 54), device=device).digest() == DIGESTS[name], device


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
def test_files_are_those_of_the_program(run, tmp_path, ending):
    scene = cloud(300, planes=[dict(point=[0, 0, 0], normal=[0, 1, 0], color="#8c8c8c")], sky=dict(intensity=1))
    scene.save(tmp_path / "scene.toml")
    scene = kb.Scene.open(tmp_path / "scene.toml")
    text = (tmp_path / "scene.toml").read_text()
    camera = "camera = { position = [1.9, 1.4, 2.2], look_at = [0.5, 0.5, 0.5], fov = 40 }\n"
    (tmp_path / "scene.toml").write_text(camera + text)
    scene = kb.Scene.open(tmp_path / "scene.toml")
    theirs = tmp_path / f"theirs.{ending}"
    run("render", tmp_path / "scene.toml", "--size", "80x60", "--samples", 2, "-o", theirs)
    picture = scene.render(size=(80, 60), samples=2)
    picture.save(tmp_path / f"ours.{ending}")
    if ending == "npy":
        ours, array = np.load(tmp_path / "ours.npy"), np.load(theirs)
        assert ours.dtype == array.dtype and ours.tobytes() == array.tobytes()
    else:
        assert (tmp_path / f"ours.{ending}").read_bytes() == theirs.read_bytes()
    run("compare", tmp_path / f"ours.{ending}", theirs)
    digest = run("digest", tmp_path / "scene.toml", "--size", "80x60", "--samples", 2)
    assert picture.digest() in digest


def test_hits_are_those_of_the_program(run, tmp_path):
    scene = cloud(2000)
    scene.save(tmp_path / "scene.toml")
    rng = np.random.default_rng(8)
    rays = np.hstack([rng.normal(0.5, 1, (3000, 3)), rng.normal(0, 1, (3000, 3))])
    np.save(tmp_path / "rays.npy", rays)
    run("trace", tmp_path / "scene.toml", "--rays", tmp_path / "rays.npy", "-o", tmp_path / "hits.npy")
    theirs = np.load(tmp_path / "hits.npy")
    for scene in [scene, kb.Scene.open(tmp_path / "scene.toml")]:
        ours = scene.trace(rays[:, :3], rays[:, 3:])
        assert 0 < (ours.id > 0).sum() < 3000
        for field in ["id", "t", "normal"]:
            assert np.ascontiguousarray(ours[field]).tobytes() == np.ascontiguousarray(theirs[field]).tobytes()
