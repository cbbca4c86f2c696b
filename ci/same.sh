#!/usr/bin/env bash
# Whether two builds of the program make the same bytes, and how long each computes for them.
#
#   ci/same.sh OLD NEW            pictures, digests and lists on the CPU, in turns
#   SAME=lit ci/same.sh OLD NEW   only those whose name has a match of this expression
#   SIZE=1920x1080 CLOUDS="1000 1000000" TURNS=3 ci/same.sh OLD NEW
#                                 other pictures and clouds; of each the best of three turns
#
# Builds of `--release`: without the optimisation across units, which the profile `ci` leaves out, a walk through the tree takes up
# to 1.4 times as long.
#
# Prints the user seconds of each, and the sums. Ends with 1 where bytes differ: of PNG and EXR those that
# are not the version's and others' words about the picture. The clouds are OLD's.
#
# A program before `color_space` reads colours of floats as linear, so OLD gets scenes without that key, and NEW gets them with
# `color_space = "linear"`.
set -euo pipefail
[ $# -eq 2 ] || { sed -n '2,17s/^# \?//p' "$0" >&2; exit 2; }
scenes=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)/scenes
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 - "$1" "$2" "$scenes" "$folder" <<'PYTHON'
import os, pathlib, random, re, resource, shutil, struct, subprocess, sys, zlib

programs = [os.path.abspath(path) for path in sys.argv[1:3]]
scenes, folder = map(pathlib.Path, sys.argv[3:5])
size = os.environ.get("SIZE", "640x360")
turns = int(os.environ.get("TURNS", "1"))
counts = os.environ.get("CLOUDS", "10000 100000 1000000").split()
wanted = re.compile(os.environ.get("SAME", ""))


def png(data):
    """Size, kind and pixels, without the words."""
    place, kept, pixels = 8, b"", b""
    while place < len(data):
        length, kind = struct.unpack(">I4s", data[place : place + 8])
        chunk = data[place + 8 : place + 8 + length]
        if kind == b"IDAT":
            pixels += chunk
        elif kind not in (b"tEXt", b"iTXt", b"zTXt"):
            kept += kind + chunk
        place += 12 + length
    return kept + zlib.decompress(pixels)


def exr(data):
    """All but attributes that are text, and places counted from the first chunk."""
    place, kept = 8, b""
    text = lambda: data[place : data.index(b"\0", place)]
    while name := text():
        place += len(name) + 1
        kind = text()
        place += len(kind) + 1
        (length,) = struct.unpack("<I", data[place : place + 4])
        if kind != b"string":
            kept += name + kind + data[place + 4 : place + 4 + length]
        place += 4 + length
    place += 1
    (first,) = struct.unpack("<Q", data[place : place + 8])
    table = struct.unpack(f"<{(first - place) // 8}Q", data[place:first])
    return kept + repr([chunk - first for chunk in table]).encode() + data[first:]


def content(path):
    data = path.read_bytes()
    return {".png": png, ".exr": exr}.get(path.suffix, bytes)(data)


def used():
    """User seconds of processes that have ended."""
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime


def run(program, words, out):
    before = used()
    done = subprocess.run([program, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    if done.returncode:
        sys.exit(f"{program} {' '.join(words)}: {done.stderr.decode()}")
    return used() - before, content(out) if out else done.stdout


SPACE = 'color_space = "linear"\n'


def knows_color_space(program):
    """Whether a program knows the key."""
    probe = folder / "probe.toml"
    probe.write_text(f'[[spheres]]\nfile = "none.npy"\n{SPACE}')
    said = subprocess.run([program, "check", f"{probe}"], capture_output=True, text=True).stderr
    return "unknown key" not in said


def given(name):
    """A scene of the repository, for each program."""
    return lambda which: own_scenes[which] / f"{name}.toml"


def cloud(kind, count, which):
    """A scene of a cloud, for each program."""
    data = folder / f"{kind}-{count}.npy"
    file = folder / f"{which}-{kind}-{count}.toml"
    if not file.exists():
        words = ["--distribution", kind, "--count", count, "-o", f"{data}"]
        # A program before `compare A SCENE` has one more word.
        has_word = subprocess.run([programs[0], "generate", "cloud", "--help"], capture_output=True).returncode == 0
        command = ["generate", "cloud"] if has_word else ["generate"]
        run(programs[0], [*command, "-q", *words, "--scene", f"{file}"], None)
        # The clouds of a program that knows the key are in bytes.
        if has_space[which] and not has_space[0]:
            file.write_text(file.read_text() + SPACE)
    return file


def rays(count, spread):
    """So many rays from a place each, through a cube about the origin."""
    file = folder / f"rays-{count}-{spread}.npy"
    if not file.exists():
        draw = random.Random(1)
        head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({count}, 6), }}"
        rows = bytearray(b"\x93NUMPY\x01\x00" + struct.pack("<H", 118) + f"{head:<117}\n".encode())
        for _ in range(count):
            start = [draw.gauss(0, 4 * spread) for _ in range(3)]
            end = [draw.uniform(-spread, spread) for _ in range(3)]
            rows += struct.pack("<6d", *start, *(b - a for a, b in zip(start, end)))
        file.write_bytes(rows)
    return f"{file}"


# A name, a scene or how to make it, words, and the file's ending.
jobs = []
draw = lambda name, scene, *words, ending="png": jobs.append((name, scene, ["render", *words], ending))
trace = lambda name, scene, *of: jobs.append((name, scene, ["trace", "--rays", lambda: rays(*of)], "npy"))

has_space = [knows_color_space(program) for program in programs]
own_scenes = [scenes, scenes]
for which in (0, 1):
    if not has_space[which]:
        own_scenes[which] = folder / f"scenes-{which}"
        shutil.copytree(scenes, own_scenes[which])
        for path in own_scenes[which].rglob("*.toml"):
            path.write_text(re.sub(r'color_space *= *"linear"\n', "", path.read_text()))

for path in sorted(scenes.rglob("*.toml")):
    name = str(path.relative_to(scenes).with_suffix(""))
    draw(name, given(name))
    draw(f"{name} hits", given(name), ending="npy")
    jobs.append((f"{name} digest", given(name), ["digest"], None))
for name in ["figure1", "figure2", "orthographic", "hard/huge_ground", "hard/touching", "hard/far_1e6",
             "lit/figure1", "lit/figure2", "lit/packing", "lit/hard/contacts", "lit/hard/shells"]:
    for samples in ["2", "3"]:
        draw(f"{name} samples {samples}", given(name), "--samples", samples)
for name in ["figure1", "lit/figure1", "lit/hard/low_sun"]:
    draw(f"{name} 16 bits", given(name), "--bits", "16")
    draw(f"{name} exr", given(name), ending="exr")
    draw(f"{name} exr samples", given(name), "--samples", "2", "--transparent", ending="exr")
    draw(f"{name} ppm", given(name), ending="ppm")
    draw(f"{name} ppm 16 bits", given(name), "--bits", "16", ending="ppm")
    draw(f"{name} npy samples", given(name), "--samples", "2", ending="npy")
    draw(f"{name} orthographic", given(name), "--height", "6", ending="npy")
    draw(f"{name} part", given(name), "--crop", "11,7,61,53", ending="npy")
    trace(f"{name} list", given(name), 100_000, 3)
for count in counts:
    for kind in ["uniform", "packing", "lattice"]:
        made = lambda which, kind=kind, count=count: cloud(kind, count, which)
        name = f"{kind} {count}"
        draw(f"{name} ids", made)
        draw(f"{name} hits", made, ending="npy")
        draw(f"{name} orthographic", made, "--height", "1.5", ending="npy")
        draw(f"{name} lit", made, "--light", "3,5,4")
        trace(f"{name} list", made, 100_000, 1)
    draw(f"{name} samples", made, "--samples", "2")
    draw(f"{name} sky", made, "--sky", "0.8,16")

sums, differ, n_jobs = [0.0, 0.0], [], 0
print(f"{'what':40} {'old s':>8} {'new s':>8} {'ratio':>6}")
for name, scene, words, ending in jobs:
    if not wanted.search(name):
        continue
    n_jobs += 1
    words = [f"{word()}" if callable(word) else word for word in words]
    if words[0] == "trace":
        words += ["--device", "cpu", "-q"]
    else:
        words += ["--device", "cpu", "--size", size] + ["-q"] * (words[0] == "render")
    best, contents = [float("inf")] * 2, [None, None]
    for turn in range(turns):
        for which in (0, 1) if turn % 2 == 0 else (1, 0):
            out = folder / f"{which}.{ending}" if ending else None
            outs = ["-o", f"{out}"] if out else []
            seconds, contents[which] = run(programs[which], [*words, f"{scene(which)}", *outs], out)
            best[which] = min(best[which], seconds)
    same = contents[0] == contents[1]
    if not same:
        differ.append(name)
    sums = [total + seconds for total, seconds in zip(sums, best)]
    ratio = best[1] / max(best[0], 1e-3)
    print(f"{name:40} {best[0]:8.3f} {best[1]:8.3f} {ratio:6.2f}{'' if same else '  DIFFERENT'}", flush=True)
print(f"{f'{n_jobs} in all':40} {sums[0]:8.3f} {sums[1]:8.3f} {sums[1] / max(sums[0], 1e-3):6.2f}")
if differ:
    sys.exit(f"{len(differ)} differ: {', '.join(differ)}")
PYTHON
