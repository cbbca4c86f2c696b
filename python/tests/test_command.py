"""The command that the package installs, against the program."""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import kugelblitz as kb
import pytest

SCRIPT = Path(sysconfig.get_path("scripts")) / "kugelblitz"


def done(*command, **environment):
    return subprocess.run(
        list(map(str, command)), capture_output=True, text=True, timeout=100, env={**os.environ, **environment},
    )


@pytest.mark.parametrize("arguments", [
    ["--version"], ["render", "--help"], ["render", "nosuch.toml", "-o", "no.png"], ["rendr"],
    ["info", "figure1", "--json"], ["info", "nosuch.toml", "--json"], ["explain", "figure5", "--pixel", "3,4", "-q"],
], ids=" ".join)
def test_the_command_answers_as_the_program_does(arguments):
    ours, theirs = done(SCRIPT, *arguments), done(os.environ["KUGELBLITZ"], *arguments)
    assert (ours.returncode, ours.stdout, ours.stderr) == (theirs.returncode, theirs.stdout, theirs.stderr)


@pytest.mark.parametrize("start", [[SCRIPT], [sys.executable, "-m", "kugelblitz"]], ids=["script", "module"])
def test_the_command_draws_the_bytes_of_the_program(start, tmp_path):
    files = [tmp_path / "ours.png", tmp_path / "theirs.png"]
    for program, file in zip([start, [os.environ["KUGELBLITZ"]]], files):
        assert done(*program, "render", "lit/figure1", "--size", "96x54", "-o", file, "-q").returncode == 0
    assert files[0].read_bytes() == files[1].read_bytes()


def test_without_a_driver_the_cpu_draws(tmp_path):
    file = tmp_path / "picture.png"
    drawn = done(SCRIPT, "render", "lit/figure1", "--size", "96x54", "-o", file, VK_DRIVER_FILES="/nonexistent")
    assert drawn.returncode == 0 and "on the CPU" in drawn.stderr and file.stat().st_size > 1000


def test_the_command_starts_without_numpy():
    code = "import sys, kugelblitz; assert 'numpy' not in sys.modules; kugelblitz.Hits; assert 'numpy' in sys.modules"
    assert done(sys.executable, "-c", code).returncode == 0


def test_names_that_are_imported_late_are_there():
    assert all(getattr(kb, name) is not None for name in kb.__all__)
    with pytest.raises(AttributeError, match="has no attribute 'Nonsense'"):
        kb.Nonsense
