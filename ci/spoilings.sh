#!/usr/bin/env bash
# Which tests see mistakes: applies each line of tests/device/matrix/spoilings.toml to a scratch copy of the commit,
# builds it, runs tests, and prints a table.
#
#   ci/spoilings.sh                        all, with the tests matrix, certified, light, lemmas and lib
#   ci/spoilings.sh --match 'bound|sky'    those whose name has a match
#   ci/spoilings.sh --tests 'matrix lib'   these tests; `lib` are the library's own
#
# The build folder is CARGO_TARGET_DIR, else target/spoilings. A test that takes ten minutes has seen it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

match=. tests="matrix certified light lemmas lib"
while [ $# -gt 0 ]; do
    case $1 in
    --match) match=$2 ;;
    --tests) tests=$2 ;;
    *) sed -n '2,10s/^# \?//p' "$0" >&2; exit 2 ;;
    esac
    shift 2
done
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target/spoilings}
scratch=$(mktemp -d)
trap 'git worktree remove --force "$scratch/tree"; rm -rf "$scratch"' EXIT
git worktree add --quiet --detach "$scratch/tree" HEAD
python3 - "$scratch/tree" "$match" "$tests" <<'PYTHON'
import pathlib, re, subprocess, sys, tomllib

tree, match, tests = pathlib.Path(sys.argv[1]), re.compile(sys.argv[2]), sys.argv[3].split()
spoilings = tomllib.loads((tree / "tests/device/matrix/spoilings.toml").read_text())["spoiling"]


def cargo(test, *words):
    folder = "library" if (tree / f"tests/library/{test}.rs").exists() else "device"
    which = ["-p", "kugelblitz", "--lib"] if test == "lib" else ["-p", "kugelblitz-tests", "--test", folder]
    command = ["timeout", "600", "cargo", "test", "--profile", "ci", "--locked", *which, *words]
    return subprocess.run(command, cwd=tree, capture_output=True, text=True)


def says(test):
    """What a test says of the spoilt program, and of how many of its functions failed."""
    if cargo(test, "--no-run").returncode:
        return "does not build"
    done = cargo(test, *([] if test == "lib" else ["--", f"{test}::"]))
    failed = len(re.findall(r"^test .* FAILED$", done.stdout, re.M))
    return {0: "no", 124: "seen (too long)"}.get(done.returncode, f"seen ({failed})")


print("| spoiling | " + " | ".join(tests) + " |")
print("| --- " * (len(tests) + 1) + "|")
unseen = []
for spoiling in spoilings:
    name = spoiling["name"]
    if not match.search(name):
        continue
    file = tree / spoiling["file"]
    text = file.read_text()
    if text.count(spoiling["find"]) != 1:
        sys.exit(f"{name}: `{spoiling['find']}` does not stand in {spoiling['file']} once")
    file.write_text(text.replace(spoiling["find"], spoiling["replace"]))
    answers = [says(test) for test in tests]
    file.write_text(text)
    print(f"| {name} | " + " | ".join(answers) + " |", flush=True)
    if all(answer == "no" for answer in answers):
        unseen.append(name)
print()
print(f"Unseen: {', '.join(unseen) or 'none'}.")
PYTHON
