#!/usr/bin/env python3
"""Compares Kugelblitz with Embree, OVITO, Tachyon and POV-Ray. `run.sh` prepares its folder and calls it.

    measure.py speed FOLDER KUGELBLITZ ROUNDS WxH COUNT...     times, as a table in Markdown
    measure.py accuracy FOLDER KUGELBLITZ ROUNDS WxH           wrong pixels of Embree, as a table in Markdown

The programs run alternately; a time is the median of all rounds. A program that is missing gets a dash in its row.
"""

import datetime
import json
import os
import re
import shutil
import statistics
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent

# How Embree is used: its name in the table, and the options of `embree_spheres`.
EMBREE = {
    "Embree, its spheres, packets of 16": ["--mode", "packet16"],
    "Embree, its spheres, single rays": ["--mode", "single"],
    "Embree, own callbacks, packets of 16": ["--mode", "packet16", "--geometry", "user"],
}
PACKETS = next(iter(EMBREE))

# Scenes of spheres only, with a perspective camera: Embree has no planes, and the driver only that camera.
ACCURACY_SCENES = [
    "figure2", "figure4", "figure5", "hard/distant_1e2", "hard/distant_1e4", "hard/distant_1e6", "hard/far_1e4",
    "hard/far_1e6", "hard/far_1e8", "hard/grazing", "hard/huge_ground", "hard/inside_nested", "hard/tiny", "hard/touching",
]

# Drum: a sun and ambient occlusion with 12 directions, 3 × 3 samples per pixel.
DRUM = """
background = "#ffffff"
[camera]
position = [0.16715, -0.29964, 0.14301]
look_at = [-0.01672, 0.0681, -0.04086]
up = [0.0, 0.0, 1.0]
fov = 30.0
[image]
width = {}
height = {}
samples = {}
[[light]]
direction = [1.0, 2.0, -2.0]
intensity = 0.5
[sky]
intensity = 0.5
directions = 12
[[spheres]]
file = "grains.csv"
color = "#8fb4d9"
"""

# Clocks of the renderers that `kugelblitz export` writes for.
CLOCKS = {
    "povray": re.compile(r"Trace Time:.*\(([\d.]+) seconds\)"),
    "tachyon": re.compile(r"Ray Tracing Time:\s*([\d.]+) seconds"),
}


def run(*command, cwd=None, may_fail=False):
    """Returns what a command prints."""
    ran = subprocess.run(
        list(map(str, command)), cwd=cwd, text=True, errors="replace", stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )
    if ran.returncode != 0 and not may_fail:
        raise SystemExit(f"{command[0]}: exit status {ran.returncode}\n{ran.stdout[-500:]}{ran.stderr[-2000:]}")
    return ran.stdout + (ran.stderr if may_fail else "")


def table(head, rows, n_names):
    for row in [head, ["---"] * n_names + ["---:"] * (len(head) - n_names), *rows]:
        print("| " + " | ".join(row) + " |")


def milliseconds(x):
    """A time with three digits."""
    return f"{x:.0f}" if x >= 100 else f"{x:.3g}"


def number(count):
    """A count as a power of ten if it is one."""
    digits = str(count)
    is_power = digits == "1" + "0" * (len(digits) - 1)
    return "10" + "".join("⁰¹²³⁴⁵⁶⁷⁸⁹"[int(digit)] for digit in str(len(digits) - 1)) if is_power else f"{count}"


def machine():
    """The processor in words, without its exact model."""
    text = Path("/proc/cpuinfo").read_text()
    model = re.search(r"model name\s*: (.*)", text)[1]
    family = next((f for f in ["Xeon", "EPYC", "Core", "Ryzen"] if f in model), model)
    article = "an" if family[0] in "AEIOU" else "a"
    return f"{os.cpu_count()} cores of {article} {family}" + (" with AVX-512" if "avx512f" in text else "")


def provenance(kugelblitz, extra):
    version = run(kugelblitz, "--version")
    commit = re.search(r"commit (\S+)", version)
    commit = f"commit {commit[1]}" if commit else "a build without a commit"
    return f"Measured on {datetime.date.today()} at {commit}, on {machine()}{extra}."


class Times:
    """Times of several rounds, by row."""

    def __init__(self):
        self.runs = {}

    def add(self, key, value):
        self.runs.setdefault(key, []).append(value)

    def __getitem__(self, key):
        return statistics.median(self.runs[key]) if key in self.runs else None


def camera_options(camera):
    def vector(key, default=None):
        return ",".join(map(repr, camera.get(key, default)))

    return [
        "--position", vector("position"), "--look-at", vector("look_at"),
        "--up", vector("up", [0.0, 1.0, 0.0]), "--fov", camera.get("fov", 45.0),
    ]


def embree(folder, spheres, camera, size, *options):
    found = run(folder / "embree_spheres", spheres, "--size", size, *camera_options(camera), *options)
    return json.loads(found)


def trace_clouds(folder, kugelblitz, size, count, times):
    """One round of a cloud: id, t and normal of each pixel, and the build of the hierarchy."""
    scene = folder / f"cloud_{count}.toml"
    spheres, camera = scene.with_suffix(".npy"), tomllib.loads(scene.read_text())["camera"]
    for name, options in EMBREE.items():
        found = embree(folder, spheres, camera, size, *options)
        times.add((count, name), found["trace_ms"])
        if name == PACKETS:
            times.add((count, "build", name), found["build_ms"])
        own = json.loads(run(
            kugelblitz, "render", scene, "-o", folder / "own.npy", "--size", size, "--device", "cpu",
            "--repeat", 9, "--json", "-q",
        ))
        times.add((count, "own"), statistics.median(sum(ms.values()) for ms in own["ms_runs"]))
        times.add((count, "build", "own"), own["ms"]["prepare"] + own["ms"]["build"])
        hits = [own["hits"], found["hits"]]
        if abs(hits[0] - hits[1]) > 1e-4 * own["rays"]["total"]:
            raise SystemExit(f"{scene}: {hits[0]} hits of Kugelblitz, {hits[1]} of {name}: other pictures")
    return found["version"]


def draw(kugelblitz, scene, folder):
    """Times of one lit picture."""
    output = folder / "own.png"
    return json.loads(run(kugelblitz, "render", scene, "-o", output, "--device", "cpu", "--json", "-q"))["ms"]


def light_drum(folder, kugelblitz, size, times, versions):
    """One round of the drum: OVITO's Tachyon with antialiasing; POV-Ray and Tachyon with the same 13 lights."""
    smooth, plain = folder / "drum_smooth.toml", folder / "drum_plain.toml"
    smooth.write_text(DRUM.format(*size.split("x"), 3))
    plain.write_text(DRUM.format(*size.split("x"), 1))
    found = run(sys.executable, HERE / "ovito_picture.py", folder / "grains.csv", smooth, folder / "ovito.png", may_fail=True)
    if match := re.search(r'^\{"version".*\}$', found, re.MULTILINE):
        picture = json.loads(match[0])
        times.add("ovito", picture["ms"])
        versions["OVITO"] = picture["version"]
    else:
        print(f"measure.py: no OVITO: {found.strip()[-200:]}", file=sys.stderr)
    for _ in range(3):
        ms = draw(kugelblitz, smooth, folder)
        times.add("own smooth", ms["total"] - ms["read"] - ms["write"])
    for program, clock in CLOCKS.items():
        if not shutil.which(program):
            print(f"measure.py: no {program}: install the package {program}", file=sys.stderr)
            continue
        source = folder / f"drum.{program}"
        run(kugelblitz, "export", {"povray": "pov"}.get(program, program), plain, "-o", source, "-q")
        width, height = size.split("x")
        found = run(*{
            "povray": [
                "povray", f"Input_File_Name={source.name}", "Output_File_Name=povray.ppm", "Output_File_Type=P8",
                f"Width={width}", f"Height={height}", "Antialias=off", "Display=off", "Pause_When_Done=off",
            ],
            "tachyon": ["tachyon", source.name, "-format", "PPM", "-o", "tachyon.ppm"],
        }[program], cwd=folder, may_fail=True)
        if not (seconds := clock.search(found)):
            raise SystemExit(f"{program}: {found[-500:]}")
        times.add(program, 1e3 * float(seconds[1]))
        versions[{"povray": "POV-Ray", "tachyon": "Tachyon"}[program]] = re.search(r"Version (\d+(?:\.\d+)*)", found)[1]
        ms = draw(kugelblitz, plain, folder)
        times.add("own plain", sum(ms[stage] for stage in ["trace", "refine", "decide", "readback", "shade"]))


def speed(folder, kugelblitz, n_rounds, size, counts):
    times, versions = Times(), {}
    for index in range(n_rounds):
        print(f"measure.py: round {index + 1} of {n_rounds}", file=sys.stderr)
        for count in counts:
            versions["Embree"] = trace_clouds(folder, kugelblitz, size, count, times)
        light_drum(folder, kugelblitz, size, times, versions)

    def row(picture, other, key, own):
        their, our = times[key], times[own]
        cells = ["–" if x is None else milliseconds(x) for x in [their, our]]
        return [picture, other, *cells, "–" if None in (their, our) else f"{their / our:.1f}"]

    rows = []
    for count in counts:
        picture = f"{number(count)} spheres: id, t, normal"
        rows += [row(picture, name, (count, name), (count, "own")) for name in EMBREE]
        build = row(f"{number(count)} spheres: building the BVH", "Embree, its spheres",
                    (count, "build", PACKETS), (count, "build", "own"))
        rows.append(build)
    lit = "50 000 grains, lit"
    rows += [
        row(f"{lit}, 9 samples per pixel", "Tachyon in OVITO", "ovito", "own smooth"),
        row(f"{lit}, 1 sample per pixel", "Tachyon", "tachyon", "own plain"),
        row(f"{lit}, 1 sample per pixel", "POV-Ray", "povray", "own plain"),
    ]
    table(["Picture", "Other program", "Its time, ms", "Kugelblitz, ms", "Ratio"], rows, 2)
    used = ", ".join(f"{name} {version}" for name, version in versions.items())
    print("\n" + provenance(kugelblitz, f", at {size.replace('x', ' × ')}, with {used}; medians of {n_rounds} rounds"))


def accuracy(folder, kugelblitz, _, size):
    rows, version, n_rays = [], "", int(np.prod([int(x) for x in size.split("x")]))
    hits, spheres, ids = folder / "hits.npy", folder / "spheres.npy", {}
    for name in ACCURACY_SCENES:
        path = ROOT / "scenes" / f"{name}.toml"
        scene = tomllib.loads(path.read_text())
        numbers = [[*map(float, sphere["center"]), float(sphere["radius"])] for sphere in scene["sphere"]]
        np.save(spheres, np.array(numbers, dtype="<f8"))
        cells = []
        for options in [[], ["--relative"]]:
            version = embree(folder, spheres, scene["camera"], size, "--repeat", 1, "-o", hits, *options)["version"]
            judged = json.loads(run(
                kugelblitz, "judge", path, "--against", hits, "--allow", "ids=any,silhouettes=any,t=any,normal=any",
                "--device", "cpu", "--json", "-q",
            ))
            cells.append(str(sum(judged[part]["wrong_ids"] for part in ["away", "silhouettes"])))
        verified = json.loads(run(
            kugelblitz, "verify", path, "--size", size, "--samples", n_rays, "--device", "cpu", "--json", "-q",
        ))["kernels"][0]["against_exact"]["cpu"]
        cells.append(str(sum(verified[error] for error in ["false_hits", "false_misses", "wrong_object"])))
        rows.append([path.stem, *cells])
        if path.stem == "grazing":
            for isa in ["sse2", "avx512"]:
                embree(folder, spheres, scene["camera"], size, "--repeat", 1, "-o", hits, "--isa", isa)
                ids[isa] = np.load(hits)["id"]
    table([f"Scene, wrong pixels of {n_rays}", "Embree", "Embree, relative to the camera", "Kugelblitz"], rows, 1)
    n_differ = int((ids["sse2"] != ids["avx512"]).sum())
    print(f"\nWith SSE2 and with AVX-512, Embree shows another object in {n_differ} pixels of `grazing`.")
    print("\n" + provenance(kugelblitz, f", with Embree {version}"))


def main():
    what, folder, kugelblitz, n_rounds, size, *counts = sys.argv[1:]
    kugelblitz = str(Path(kugelblitz).resolve())
    {"speed": speed, "accuracy": accuracy}[what](
        Path(folder), kugelblitz, int(n_rounds), size, *([list(map(int, counts))] if what == "speed" else [])
    )


main()
