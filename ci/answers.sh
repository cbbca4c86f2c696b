#!/usr/bin/env bash
# What the program answers, in words: help, errors, JSON, SVG, LaTeX, German; and what of that has changed.
#
#   ci/answers.sh PROGRAM            compares with tests/answers, prints the differences, and fails where there are any
#   ci/answers.sh PROGRAM --renew    writes tests/answers anew
#
# Times, versions, devices and memory are left out. Needs Python 3.
set -euo pipefail
program=$(realpath "$1")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cp -r scenes "$scratch/scenes"
cp -r tests/answers/scenes "$scratch/small"
python3 - "$program" "$scratch" tests/answers <<'PYTHON'
import pathlib, re, subprocess, sys

program, scratch, kept = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
found = scratch / "answers"
found.mkdir()
volatile = re.compile(r'"(version|ms|ms_runs|bytes|bytes_device|free|memory|seconds|adapter|machine|rays_per_second)": ?'
                      r'(\{[^{}]*\}|\[[^][]*\]|"[^"]*"|[-+.e0-9]+|null)')


def run(*words):
    """Output, errors and the exit code of a command, without what differs from run to run."""
    done = subprocess.run([program, *words], cwd=scratch, capture_output=True, text=True, errors="replace",
                          stdin=subprocess.DEVNULL, timeout=120, env={"PATH": "/usr/bin", "NO_COLOR": "1", "COLUMNS": "100"})
    text = f"$ kugelblitz {' '.join(words)}\n{done.stdout}"
    text += f"--- stderr\n{done.stderr}" if done.stderr else ""
    text = text.replace(pathlib.Path(program).name, "kugelblitz").replace(str(scratch), "")
    text = re.sub(r"\d[\d.]* (µs|ms|s|MB|GB|KB|kB|MiB|GiB)\b", r"N \1", volatile.sub(r'"\1": …', text))
    text = re.sub(r"\bthere (is|are) `.*", "there is …", text)
    return f"{text}--- exit {done.returncode}\n\n"


def keep(name, *commands):
    (found / f"{name}.txt").write_text("".join(run(*words) for words in commands))


commands = re.findall(r"^  (\w+) ", run("--help").split("Options:")[0], re.M)
keep("help", ["--help"], ["-h"], ["nosuch"], [], *([name, how] for name in commands if name != "help" for how in ("-h", "--help")),
     ["generate", "cloud", "--help"])
lit, flat = "scenes/lit/figure1.toml", "scenes/figure1.toml"
small = ["--size", "48x27", "--device", "cpu"]
keep("explain", *([*at, "--device", "cpu", *more] for at in (
    ["explain", flat, "--pixel", "640,360"], ["explain", lit, "--pixel", "700,400"], ["explain", "scenes/figure5.toml", "--pixel", "640,360"],
    ["explain", "small/spheres.toml", "--ray", "0,0,0,0,0,-1"], ["explain", "small/planes.toml", "--ray", "1,0,0,0,-2,0"],
    ["explain", "small/tie.toml", "--ray", "0,0,0,0,0,-1"], ["explain", "small/far.toml", "--ray", "0,0,0,0,-1,0"], ["explain", "small/lights.toml", "--ray", "0,5,0,0,-1,0"],
    ["explain", "scenes/orthographic.toml", "--pixel", "640,360"], ["explain", flat, "--ray", "0,0,0,0,0,-1"])
    for more in ([], ["--lang", "de"], ["--latex"])), ["explain", flat, "--pixel", "640,360", "--device", "cpu", "--json"])
keep("json", ["render", flat, "-o", "a.png", "--json", *small], ["render", lit, "-o", "b.exr", "--json", *small],
     ["verify", flat, "--json", *small], ["verify", lit, "--json", *small], ["digest", lit, "--json", *small],
     ["check", lit, "--json"], ["compare", "a.png", "b.exr", "--json"], ["compare", "a.png", "a.png", "--json"],
     ["info", "b.exr", "--json"], ["judge", flat, "--against", "b.exr", "--json", *small])
keep("words", ["verify", flat, *small], ["verify", lit, "--all-kernels", *small], ["check", lit], ["digest", flat, *small],
     ["compare", "a.png", "b.exr"], ["info", "b.exr"], ["judge", flat, "--against", "b.exr", *small],
     ["render", flat, "-o", "-", "--print-scene"], ["render", flat, "-o", "a.png", *small])
keep("figures", ["figure", "3", "scenes/figure3.toml"], ["figure", "4", "scenes/figure4.toml", "--lang", "de"], ["figure", "9", flat])
keep("export", *([ "export", to, scene, "-o", "-"] for to in ("pov", "tachyon") for scene in (flat, lit)))
keep("usage", ["render", flat], ["render", "none.toml", "-o", "a.png"], ["render", flat, "-o", "a.xyz"], ["render", flat, "-o", "a.png", "--size", "0x4"],
     ["render", flat, "-o", "a.png", "--kernel", "stabel"], ["render", flat, "-o", "a.png", "--device", "nosuch"], ["compare", "a.png", "none.png"],
     ["render", flat, "-o", "a.png", "--samples", "99"], ["explain", flat, "--pixel", "5000,1"], ["trace", flat, "--rays", "a.png", "-o", "h.npy"],
     ["judge", flat, "--against", flat], *(["explain", "scenes/figure5.toml", "--device", "cpu", *words.split()] for words in (
         "--pixel 1281,0", "--pixel 0,721", "--pixel -1,0", "--pixel 5,5 --crop 10,20,30,40", "--pixel 21,0 --size 21x11",
         "--pixel 1.5,0", "--pixel 1", "--ray 0,0,0,0,0,0", "--ray 0,0,0,0,0,inf", "--ray nan,0,0,0,0,1", "--ray 0,0,0,0,1",
         "--ray 0,0,0,0,0,1 --pixel 1,1", "--ray 0,0,0,0,0,1 --size 3x3", "", "--size 3x3", "--pixel 1,1 --digits 0",
         "--pixel 1,1 --digits 41", "--pixel 1,1 --lang fr")), ["generate", "cloud", "--count", "9", "--distribution", "nosuch", "-o", "c.npy"],
     *(["render", flat, "-o", *words.split()] for words in (
         "c.png --size 12", "c.png --crop 1,2,3", "c.png --size 20x20 --crop 10,10,11,5", "c.png --format exr", "c.png --certificates",
         "c.png --bits 12", "c.exr --bits 16", "c.png --repeat 2", "c.png -q -v", "-", "- --format ppm --json", "c.exr --show depth",
         "c.png --show depth --bits 16", "c.png --show depth --transparent", "c.png --show depth --samples 2",
         "c.png --show depth --kernel stable --epsilon 1e-3", "c.png --show depth --json --repeat 2", "c.png --show dept")),
     ["man", "rendr"], *(["figure", *words.split()] for words in (
         "", "5", "3 scenes/figure2.toml", "4 scenes/figure2.toml --object 9", "4 scenes/figure2.toml --object 0",
         "3 scenes/figure2.toml --object 1", "4 -o c.png", "4 --json")))
with (found / "usage.txt").open("a") as said:
    said.write(f"files: {', '.join(sorted(file.name for file in scratch.glob('?.*')))}\n")
texts = re.split(r"^=== \d+\n", (kept / "wrong_scenes.txt").read_text(), flags=re.M)[1:]
with (found / "wrong_scenes_said.txt").open("w") as said:
    for text in texts:
        (scratch / "a.toml").write_text(text)
        said.write(run("check", "a.toml"))
PYTHON
if [ "${2:-}" = --renew ]; then
    cp "$scratch"/answers/*.txt tests/answers/
else
    rm -rf "$scratch/kept"; mkdir "$scratch/kept"
    cp tests/answers/*.txt "$scratch/kept"
    rm "$scratch/kept/wrong_scenes.txt"
    diff -r -U1 "$scratch/kept" "$scratch/answers"
fi
