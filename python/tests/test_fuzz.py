"""Arguments of all kinds: a documented exception or a right result, never a crash."""

import subprocess
import sys
from pathlib import Path

import pytest
from fuzz import CALLS, SAME, line, result

N = 2000


@pytest.mark.parametrize("change", SAME)
def test_the_layout_of_an_array_changes_nothing(change):
    for name, given in CALLS.items():
        right = result(name, line(name, given))
        for key in [key for key, value in given.items() if value.startswith("np.array(")]:
            changed = {**given, key: change.replace("{}", given[key])}
            assert result(name, line(name, changed)) == right, (name, key)


@pytest.mark.parametrize("seed", [20261122])
def test_mutated_arguments_raise_or_work(seed, tmp_path):
    log = tmp_path / "cases.log"
    fuzz = Path(__file__).with_name("fuzz.py")
    # From elsewhere, so that the package under test is the one that is installed.
    done = subprocess.run(
        [sys.executable, "-X", "faulthandler", str(fuzz), str(seed), str(N), str(log)],
        capture_output=True, text=True, timeout=300, cwd=tmp_path,
    )
    cases = log.read_text().splitlines() if log.exists() else []
    assert done.returncode in (0, 1), f"died of {done.returncode} at: {cases[-1:]}\n{done.stderr}"
    assert done.returncode == 0, done.stdout + done.stderr
    worked, raised = _counts(done.stdout)
    assert len(cases) == N == worked + raised and worked > N / 5 and raised > N / 5, done.stdout


def _counts(text):
    words = text.splitlines()[-1].split()
    return int(words[0]), int(words[2])
