#!/usr/bin/env bash
# What the program answers: help, errors, words, JSON, SVG, LaTeX, German, files; and what of that has changed.
#
#   ci/answers.sh PROGRAM [NAME]...            runs the commands in tests/answers/NAME.txt again, prints where the answers
#                                              differ, and fails where they do; without a name, those in all files
#   ci/answers.sh PROGRAM --renew [NAME]...    writes the answers anew, to be read before they are committed
#
# A line of a file that begins with `$ ` is a command of bash, and lines after it with `> ` continue it; what follows is its
# answer. Lines of the answer that begin with `→ ` are the input of the command, which repeats each before its own answer. A
# new command or row is such a line, and --renew. The commands of a file run one after the other in a folder of their own,
# with links `scenes` and `small` to the scenes and to `tests/answers/scenes`, and know the functions of
# `tests/answers/functions.sh`. Times, versions, devices and memory are left out. Needs Python 3.
set -euo pipefail
program=$(realpath "$1")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
python3 - "$program" "${@:2}" <<'PYTHON'
import concurrent.futures, difflib, os, pathlib, re, subprocess, sys, tempfile

program, renew = sys.argv[1], "--renew" in sys.argv
kept = pathlib.Path("tests/answers").resolve()
names = [name for name in sys.argv[2:] if name != "--renew"]
files = [kept / f"{name}.txt" for name in names] or sorted(kept.glob("*.txt"))
volatile = re.compile(r'"(version|ms|ms_runs|bytes|bytes_device|free|memory|seconds|adapter|machine|rays_per_second)": ?'
                      r'(\{[^{}]*\}|\[[^][]*\]|"[^"]*"|[-+.e0-9]+|null)')


def answer(command, rows, folder, environment):
    """Output, errors and the exit code of a command, without what differs from run to run."""
    done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, capture_output=True, text=True,
                          errors="replace", input=rows, timeout=600)
    text = done.stdout + (f"--- stderr\n{done.stderr}" if done.stderr else "")
    text = volatile.sub(r'"\1": …', text.replace(folder, ""))
    # A failure shows what may be a picture.
    text = re.sub(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]", lambda found: f"\\x{ord(found[0]):02x}", text)
    text = re.sub(r"\b\d[\d.]* (µs|ms|s)\b", "N s", text)
    text = re.sub(r"(?<!at most )(?<!than )\b\d[\d.]* (MB|GB|KB|kB|MiB|GiB)\b", "N MiB", text)
    text = re.sub(r"\bthere (is|are) `.*", "there is …", text)
    text = re.sub(r"\bare available [^:]*:", "are available …:", text)
    if not text.endswith("\n") and text:
        text += "(no line break)\n"
    return f"{text}--- exit {done.returncode}\n"


def answers(file):
    """The file's text as it was, and as it is now."""
    before, after = file.read_text(), []
    with tempfile.TemporaryDirectory() as folder:
        programs = pathlib.Path(folder, "bin")
        programs.mkdir()
        (programs / "kugelblitz").symlink_to(program)
        here = pathlib.Path(folder, "here")
        here.mkdir()
        (here / "scenes").symlink_to(kept.parents[1] / "scenes")
        (here / "small").symlink_to(kept / "scenes")
        environment = {"PATH": f"{programs}:/usr/bin:/bin", "NO_COLOR": "1", "COLUMNS": "100", "LC_ALL": "C.UTF-8",
                       "BASH_ENV": str(kept / "functions.sh")}
        for block in re.split(r"^(?=\$ )", before, flags=re.M)[1:]:
            shown = re.match(r"\$ .*\n(?:>.*\n)*", block)[0]
            command = re.sub(r"^(\$ |> ?)", "", shown, flags=re.M)
            rows = "".join(re.findall(r"^→ (.*\n)", block, re.M))
            after.append(shown + answer(command, rows, str(here), environment))
    return before, "\n".join(after)


with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
    found = dict(zip(files, pool.map(answers, files)))
for file, (before, after) in found.items():
    if renew:
        file.write_text(after)
    elif before != after:
        name = str(file.relative_to(kept.parents[1]))
        sys.stdout.writelines(difflib.unified_diff(before.splitlines(True), after.splitlines(True), name, "now", n=1))
sys.exit(not renew and any(before != after for before, after in found.values()))
PYTHON
