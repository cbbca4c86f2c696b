"""The guide's pages and the notebooks: what they show, runs."""

import ast
import os
import re
import subprocess
import sys

import pytest
from conftest import ROOT

PAGES = ["docs/guide/src/python.md", "docs/guide/src/dask.md", "docs/guide/src/pytest.md", "README.md", "python/README.md"]
NOTEBOOKS = sorted((ROOT / "python/notebooks").glob("*.py"))


def blocks(page, language):
    """A page's blocks in a language, each on the lines that it has in the page."""
    text = (ROOT / page).read_text()
    for match in re.finditer(rf"^```{language}\n(.*?)^```$", text, re.M | re.S):
        yield "\n" * text.count("\n", 0, match.start(1)) + match[1]


def run(folder, *command, **environment):
    done = subprocess.run(
        [sys.executable, *command], cwd=folder, capture_output=True, text=True, timeout=300,
        env={**os.environ, "MPLBACKEND": "agg", **environment},
    )
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture
def folder(tmp_path):
    """An empty folder that holds a link `scenes`, as the program's pages are run in."""
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    return tmp_path


@pytest.mark.parametrize("page", PAGES)
def test_the_blocks_of_a_page_run(page, folder):
    """In order, in one namespace; where there are tests among them, pytest runs them."""
    code = "\n".join(blocks(page, "python"))
    assert code.strip()
    lines = [""] * (1 + max(code.count("\n") for code in blocks(page, "python")))
    for block in blocks(page, "python"):
        for number, line in enumerate(block.splitlines()):
            lines[number] = line or lines[number]
    tests = re.findall(r"^def (test_\w+)", code, re.M)
    name = "test_page.py" if tests else "page.py"
    # Workers of Dask import the page, too.
    body = "\n".join("    " + line if line else "" for line in lines)
    source = "\n".join(lines) if tests else f"if __name__ == '__main__':\n{body}\n"
    (folder / name).write_text(source)
    if tests:
        assert f"{len(tests)} passed" in run(folder, "-m", "pytest", "-p", "no:cacheprovider", name)
    else:
        run(folder, name)


@pytest.mark.parametrize("page", PAGES)
def test_blocks_for_a_cluster_are_python(page):
    for block in blocks(page, "python,cluster"):
        ast.parse(block)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path, folder):
    run(folder, str(path), KUGELBLITZ_SMALL="1")
    text = path.read_text()
    assert text.startswith("# %% [markdown]\n") and text.count("\n# %%") >= 4
    assert not os.path.exists(folder / "__pycache__")


def test_there_are_four_notebooks():
    assert len(NOTEBOOKS) == 4
