"""The stubs name what there is, with its parameters and defaults."""

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
TYPED = ["testing", "dask", "_drawings", "_given", "_verdicts"]
PACKAGE = Path(kb.__file__).parent
STUBS = ast.parse((PACKAGE / "__init__.pyi").read_text())


def named(body):
    return {node.name: node for node in body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}


def parameters(node):
    """Names, kinds and whether there is a default, without self."""
    arguments = node.args
    positional = [*arguments.posonlyargs, *arguments.args]
    n_required = len(positional) - len(arguments.defaults)
    rows = [(a.arg, "positional", i >= n_required) for i, a in enumerate(positional)]
    rows += [(a.arg, "keyword", default is not None) for a, default in zip(arguments.kwonlyargs, arguments.kw_defaults)]
    return [row for row in rows if row[0] not in ("self", "cls")]


def found(function):
    rows = []
    for parameter in inspect.signature(function).parameters.values():
        kind = "keyword" if parameter.kind is parameter.KEYWORD_ONLY else "positional"
        rows.append((parameter.name, kind, parameter.default is not parameter.empty))
    return [row for row in rows if row[0] not in ("self", "cls")]


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
    assert sorted(node.target.id for node in named(STUBS.body)[name].body) == sorted(known(section))


def test_arguments_are_the_keys_of_a_scene_file():
    camera, cloud = known("camera = { KEY }"), known("spheres = [{ KEY }]")
    assert [name for name, *_ in found(kb.Camera)] == camera
    assert {*camera} - {"position"} <= {name for name, *_ in found(kb.Camera.frame)}
    assert {*cloud} - {"file", "missing_color"} <= {name for name, *_ in found(kb.Scene.open)}
    assert {*cloud} - {"file", "columns", "frame"} <= {name for name, *_ in found(kb.Scene)}


BALL = kb.Scene([[0, 0, 0, 1]], camera=kb.Camera((0, 0, 5), (0, 0, 0)), size=(4, 3))


@pytest.mark.parametrize("call, given", [
    (kb.Scene, {}), (kb.Scene.open, dict(path=ROOT / "scenes/figure1.toml")), (kb.Camera.frame, dict(scene=BALL)),
    (BALL.replace, {}), (BALL.judge, dict(id=BALL.render().id)),
], ids=["Scene", "open", "frame", "replace", "judge"])
def test_a_signature_has_what_the_call_takes(call, given):
    there = {key: p.default for key, p in inspect.signature(call).parameters.items() if p.default is not p.empty}
    call(**{**{key: None if default is ... else default for key, default in there.items()}, **given})
    with pytest.raises(TypeError, match="nonsense: no such argument") as raised:
        call(**given, nonsense=1)
    assert {*str(raised.value).rpartition("there are ")[2].split(", ")} <= there.keys()


def test_the_package_is_whole():
    assert (PACKAGE / "py.typed").exists()
    for name in ["dask.py", "testing.py"]:
        assert (PACKAGE / name).exists()


def test_every_public_name_is_in_the_stubs():
    of_python = {alias.asname for node in STUBS.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    stubs = {name for name in named(STUBS.body) if not name.startswith("_")} | of_python - {None}
    assert stubs | {"__version__"} == {*kb.__all__} and all(hasattr(kb, name) for name in stubs)


@pytest.mark.parametrize("name", [name for name in kb.__all__ if inspect.isclass(getattr(kb, name))
                                  and name in named(STUBS.body)])
def test_methods_have_the_parameters_of_the_stubs(name):
    kind, stub = getattr(kb, name), named(STUBS.body)[name]
    members = named(stub.body)
    if issubclass(kind, Exception) or name == "Hits":
        return
    there = {key for key in vars(kind) if not key.startswith("_")}
    assert there == {key for key in members if not key.startswith("_")}
    for key, node in members.items():
        if any(getattr(d, "id", getattr(d, "attr", "")) in ("property", "setter") for d in node.decorator_list):
            assert inspect.isdatadescriptor(vars(kind)[key]), key
        elif key == "__new__":
            assert found(kind) == parameters(node)
        elif not key.startswith("__"):
            assert found(getattr(kind, key)) == parameters(node), key


@pytest.mark.parametrize("name", [n for n in kb.__all__ if inspect.isbuiltin(getattr(kb, n))])
def test_functions_have_the_parameters_of_the_stubs(name):
    assert found(getattr(kb, name)) == parameters(named(STUBS.body)[name])


def test_everything_says_what_it_is():
    for name in kb.__all__:
        thing = getattr(kb, name)
        if inspect.isclass(thing) or inspect.isbuiltin(thing):
            assert thing.__doc__, name
        if inspect.isclass(thing) and thing.__module__.startswith("kugelblitz") and not issubclass(thing, Exception):
            for key, member in vars(thing).items():
                assert key.startswith("_") or member is None or inspect.getdoc(member), f"{name}.{key}"


def test_the_package_is_typed():
    command = [sys.executable, "-m", "mypy", "--strict", *(part for name in TYPED for part in ("-p", f"kugelblitz.{name}"))]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_licences_come_along():
    files = {file.name for file in importlib.metadata.files("kugelblitz") or []}
    assert {"LICENSE-APACHE", "LICENSE-MIT", "py.typed"} <= files, files
