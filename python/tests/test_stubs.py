"""Types, signatures and texts are those of what there is."""

import ast
import importlib.metadata
import inspect
import subprocess
import sys
from pathlib import Path

import kugelblitz as kb
import pytest
from conftest import ROOT

#: Modules with types beside the stubs.
TYPED = ["testing", "dask", "_drawings", "_given", "_hits"]


def mypy(module, *arguments):
    done = subprocess.run([sys.executable, "-m", module, *map(str, arguments)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr


def known(section):
    """The keys that a table of scene files may have."""
    with pytest.raises(kb.SceneError, match="unknown key") as raised:
        kb.Scene.parse(section.replace("KEY", "nonsense = 1"))
    return str(raised.value).rpartition("known keys here: ")[2].split(", ")


@pytest.mark.parametrize("name, section", [
    ("_Plane", "plane = [{ KEY }]"), ("_Light", "light = [{ KEY }]"), ("_Sky", "sky = { KEY }"),
    ("_Columns", "spheres = [{ columns = { KEY } }]"),
])
def test_dictionaries_have_the_keys_of_a_scene_file(name, section):
    stubs = ast.parse((Path(kb.__file__).parent / "__init__.pyi").read_text())
    [stub] = [node for node in stubs.body if getattr(node, "name", "") == name]
    assert sorted(node.target.id for node in stub.body) == sorted(known(section))


def test_arguments_are_the_keys_of_a_scene_file():
    camera, cloud = known("camera = { KEY }"), known("spheres = [{ KEY }]")
    assert list(inspect.signature(kb.Camera).parameters) == camera
    for call, keys in [
        (kb.Camera.frame, {*camera} - {"position"}), (kb.Scene.open, {*cloud} - {"file", "format"}),
        (kb.Scene, {*cloud} - {"file", "format", "columns", "header", "missing", "frame"}),
    ]:
        assert keys <= inspect.signature(call).parameters.keys()


BALL = kb.Scene([[0, 0, 0, 1]], camera=kb.Camera((0, 0, 5), (0, 0, 0)), size=(4, 3))


@pytest.mark.parametrize("call, given", [
    (kb.Scene, {}), (kb.Scene.open, dict(path=ROOT / "scenes/figure1.toml")), (kb.Camera.frame, dict(scene=BALL)),
    (BALL.replace, {}),
], ids=["Scene", "open", "frame", "replace"])
def test_a_signature_has_what_the_call_takes(call, given):
    there = {key: p.default for key, p in inspect.signature(call).parameters.items() if p.default is not p.empty}
    call(**{**{key: None if default is ... else default for key, default in there.items()}, **given})
    with pytest.raises(TypeError, match="nonsense: no such argument") as raised:
        call(**given, nonsense=1)
    assert {*str(raised.value).rpartition("there are ")[2].split(", ")} <= there.keys()


def test_the_stubs_are_what_there_is(tmp_path):
    """Names, parameters, their kinds and defaults; of what the package takes of the bindings for itself, the names alone."""
    (tmp_path / "allowed").write_text(r"kugelblitz\._kugelblitz\..*" "\n" r"kugelblitz\._hits\.Hits\.__module__")
    (tmp_path / "mypy.ini").write_text("[mypy]\n[mypy-tqdm.*]\nignore_missing_imports = True\n")
    mypy("mypy.stubtest", "kugelblitz", "--allowlist", tmp_path / "allowed", "--mypy-config-file", tmp_path / "mypy.ini")


def test_everything_says_what_it_is():
    for name in kb.__all__:
        thing = getattr(kb, name)
        if inspect.isclass(thing) or inspect.isbuiltin(thing):
            assert thing.__doc__, name
        if inspect.isclass(thing) and thing.__module__.startswith("kugelblitz") and not issubclass(thing, Exception):
            for key, member in vars(thing).items():
                assert key.startswith("_") or member is None or inspect.getdoc(member), f"{name}.{key}"


def test_the_package_is_typed():
    mypy("mypy", "--strict", *(part for name in TYPED for part in ("-p", f"kugelblitz.{name}")))


def test_the_licences_come_along():
    files = {file.name for file in importlib.metadata.files("kugelblitz") or []}
    assert {"LICENSE-APACHE", "LICENSE-MIT", "py.typed"} <= files, files
