import json
import os
import shutil
import subprocess
import threading
from pathlib import Path

import numpy as np
import pytest

import kugelblitz as kb

ROOT = Path(__file__).resolve().parents[2]


def cloud(n, seed=1, **options):
    """Spheres in the unit cube, as `kugelblitz generate` scales them."""
    centers = np.random.default_rng(seed).random((n, 3))
    return kb.Scene(centers, radius=0.3 * n ** (-1 / 3), **options)


@pytest.fixture
def camera():
    return kb.Camera((1.9, 1.4, 2.2), (0.5, 0.5, 0.5), fov=40)


@pytest.fixture
def ball():
    return kb.Scene([[0, 0, 0, 1]], color="#d62728", background="#20242c")


@pytest.fixture(scope="session")
def run():
    """Calls the command line, and gives what it prints. KUGELBLITZ names it, else it is what `cargo build --release`
    built."""
    built = ROOT / "target/release/kugelblitz"
    program = os.environ.get("KUGELBLITZ") or (built if built.exists() else shutil.which("kugelblitz"))
    assert program, "build the program (cargo build --release), or name it by KUGELBLITZ=PATH"

    def run(*arguments, code=0):
        done = subprocess.run([program, *map(str, arguments), "-q"], capture_output=True, timeout=120)
        assert done.returncode == code, done.stderr.decode()
        return done.stdout.decode()

    return run


@pytest.fixture(scope="session")
def told(run):
    """The summary of a call, which the command line prints as JSON."""
    return lambda *arguments, code=0: json.loads(run(*arguments, "--json", code=code))


def refuses(call, error, *cases):
    """Each call with such arguments is refused by words."""
    for given, words in cases:
        with pytest.raises(error, match=words):
            call(**given)


def in_threads(n, work):
    """Each of `n` threads does it, given its number."""
    threads = [threading.Thread(target=work, args=(number,)) for number in range(n)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
