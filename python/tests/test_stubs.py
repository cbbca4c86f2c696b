"""The stubs name what there is, with its parameters and defaults."""

import ast
import importlib.metadata
import inspect
import subprocess
import sys
from pathlib import Path

import kugelblitz as kb
import pytest

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


def test_the_package_is_whole():
    assert (PACKAGE / "py.typed").exists()
    for name in ["dask.py", "testing.py"]:
        assert (PACKAGE / name).exists()


def test_every_public_name_is_in_the_stubs():
    stubs = named(STUBS.body)
    assert set(kb.__all__) - {"__version__"} <= set(stubs)
    for name, node in stubs.items():
        if not name.startswith("_"):
            assert name in kb.__all__ and hasattr(kb, name), name


@pytest.mark.parametrize("name", [name for name in kb.__all__ if inspect.isclass(getattr(kb, name))])
def test_methods_have_the_parameters_of_the_stubs(name):
    kind, stub = getattr(kb, name), named(STUBS.body)[name]
    members = named(stub.body)
    if issubclass(kind, Exception) or name == "Hits":
        return
    there = {key for key in vars(kind) if not key.startswith("_")}
    assert there == {key for key in members if not key.startswith("_")}
    for key, node in members.items():
        if any(getattr(d, "id", getattr(d, "attr", "")) in ("property", "setter") for d in node.decorator_list):
            assert inspect.isgetsetdescriptor(vars(kind)[key]), key
        elif key == "__init__":
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
    command = [sys.executable, "-m", "mypy", "--strict", "-p", "kugelblitz.testing", "-p", "kugelblitz.dask"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_licences_come_along():
    files = {file.name for file in importlib.metadata.files("kugelblitz") or []}
    assert {"LICENSE-APACHE", "LICENSE-MIT", "py.typed"} <= files, files
