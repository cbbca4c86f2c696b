#!/usr/bin/env python3
"""How wrong POV-Ray and Tachyon are on the report's scenes, as a table in Markdown.

    ci/peers.py KUGELBLITZ [WxH [RUNS]] >peers.md

Each scene gets a colour of its own for every object, and is exported. The picture that each renderer
draws is then compared with the one of the kernel `certified`, which shows the exact object in every
pixel. Needs Debian's packages povray and tachyon; one that is missing is said on standard error and
left out, none at all is a failure.
"""

import random
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SCENES = {"lecture's scenes": "scenes/*.toml", "hard scenes": "scenes/hard/*.toml"}

# Seconds after which a run is ended.
LIMIT = 120

# A scene that every renderer draws right if it means the same camera, and the pixels that rounding
# to f32 may cost in it. A picture that is off by half a pixel has ten times as many wrong ones.
PLAIN = """
[camera]
position = [1.7, 1.3, 6.1]
look_at = [0.1, 0.2, 0.0]
up = [0.2, 1.0, 0.1]
fov = 41.0
""" + "".join(
    f'[[sphere]]\ncenter = {center}\nradius = {radius}\ncolor = "#000000"\n'
    for center, radius in [
        ([-1.3, 0.9, 0.1], 0.83), ([1.1, 0.4, 0.7], 0.71), ([0.2, -0.3, -1.2], 1.07),
    ]
) + '[[plane]]\npoint = [0.0, -1.1, 0.0]\nnormal = [0.1, 1.0, 0.0]\ncolor = "#000000"\n'
PLAIN_SIZE = (64, 48)
PLAIN_WRONG = 5


class Failure(Exception):
    """Why there is no result of a renderer."""


class PovRay:
    """Calculates in f64, but its boxes around objects are in f32."""

    program, language = "povray", "pov"
    trace_time = re.compile(r"Trace Time:.*\(([\d.]+) seconds\)")

    def command(self, scene, picture, size):
        # One ray a pixel, and whatever the user's own settings may change.
        return [
            "povray", f"Input_File_Name={scene}", f"Output_File_Name={picture}",
            "Output_File_Type=P8", f"Width={size[0]}", f"Height={size[1]}", "Antialias=off",
            "Display=off", "Pause_When_Done=off", "Output_Alpha=off", "Dither=off",
            "Grayscale_Output=off", "File_Gamma=sRGB", "Quality=9",
        ]


class Tachyon:
    """Calculates in f64, but reads the numbers of a scene as f32."""

    program, language = "tachyon", "tachyon"
    trace_time = re.compile(r"Ray Tracing Time:\s*([\d.]+) seconds")

    def command(self, scene, picture, size):
        return ["tachyon", scene, "-format", "PPM", "-o", picture]


def recoloured(text):
    """The scene with a colour of its own for the background and for each object."""
    colours = random.Random(1)
    taken = {0}

    def colour():
        while (code := colours.randrange(1 << 24)) in taken:
            pass
        taken.add(code)
        return f'"#{code:06x}"'

    background = colour()
    text = re.sub(r"(?m)^background *=.*$", "", text)
    text, n = re.subn(r"(?m)^color *=.*$", lambda _: f"color = {colour()}", text)
    text = f"background = {background}\n{text}"
    scene = tomllib.loads(text)
    n_objects = len(scene.get("sphere", [])) + len(scene.get("plane", []))
    if n != n_objects:
        raise SystemExit(f"ci/peers.py: {n} lines of colour for {n_objects} objects")
    return text, bytes.fromhex(background.strip('"#'))


def pixels(path, size):
    """The pixels of a PPM file."""
    header = re.match(rb"P6\s+(?:#.*\s+)*(\d+)\s+(\d+)\s+255\s", data := Path(path).read_bytes())
    if not header or (int(header[1]), int(header[2])) != size:
        raise Failure("its picture is not a PPM of the right size")
    rgb = data[header.end():]
    if len(rgb) != 3 * size[0] * size[1]:
        raise Failure("its picture is cut off")
    return [rgb[i:i + 3] for i in range(0, len(rgb), 3)]


def compare(found, exact, background):
    """Counts of false hits, false misses and other wrong objects."""
    wrong = [(f, e) for f, e in zip(found, exact, strict=True) if f != e]
    hits = sum(e == background for _, e in wrong)
    misses = sum(f == background for f, _ in wrong)
    return hits, misses, len(wrong) - hits - misses


class Scene:
    """A recoloured scene and what is exact of it."""

    def __init__(self, kugelblitz, folder, text, size):
        self.kugelblitz, self.folder, self.size = kugelblitz, folder, size
        self.path = folder / "scene.toml"
        text, self.background = recoloured(text)
        self.path.write_text(text)
        self.run("render", self.path, "-o", folder / "exact.ppm", "--kernel", "certified")
        self.exact = pixels(folder / "exact.ppm", size)

    def run(self, *arguments):
        size = "x".join(map(str, self.size))
        subprocess.run([self.kugelblitz, *arguments, "--size", size, "-q"], check=True)

    def draw(self, peer, n_runs):
        """Counts of wrong pixels, and seconds of tracing and of the whole process."""
        source, picture = self.folder / "exported", self.folder / "picture.ppm"
        self.run("export", peer.language, self.path, "-o", source)
        traced, whole = [], []
        for _ in range(n_runs):
            picture.unlink(missing_ok=True)
            start = time.monotonic()
            try:
                ran = subprocess.run(
                    peer.command(source.name, picture.name, self.size), cwd=self.folder,
                    stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                    timeout=LIMIT, text=True, errors="replace",
                )
            except subprocess.TimeoutExpired:
                raise Failure(f"it was ended after {LIMIT} s")
            whole.append(time.monotonic() - start)
            if ran.returncode != 0 or not picture.exists():
                raise Failure(f"exit status {ran.returncode}: {ran.stdout.strip()[-200:]}")
            traced += [float(seconds) for seconds in peer.trace_time.findall(ran.stdout)]
        counts = compare(pixels(picture, self.size), self.exact, self.background)
        return counts, traced if len(traced) == n_runs else None, whole, ran.stdout


def version(talk):
    found = re.search(r"Ray Tracer\s+Version (\S+)", talk)
    return found[1] if found else "of an unknown version"


def figure(x):
    return f"{x:.0f}" if x >= 100 else f"{x:.3g}"


def measure(peer, kugelblitz, size, n_runs):
    """Rows of the table."""
    if not shutil.which(peer.program):
        raise Failure(f"not installed: install the package {peer.program}")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        plain = Scene(kugelblitz, Path(folder), PLAIN, PLAIN_SIZE)
        counts, _, _, talk = plain.draw(peer, 1)
        if sum(counts) > PLAIN_WRONG:
            raise Failure(f"{sum(counts)} pixels of a plain scene are wrong: version "
                          f"{version(talk)} draws other pictures than the export was made for")
        for kind, pattern in SCENES.items():
            for path in sorted(ROOT.glob(pattern)):
                scene = Scene(kugelblitz, Path(folder), path.read_text(), size)
                counts, traced, whole, talk = scene.draw(peer, n_runs)
                n_rays = size[0] * size[1]
                share = f"{100 * sum(counts) / n_rays:.2g} %" if any(counts) else f"0 of {n_rays}"
                ns = figure(statistics.median(traced) * 1e9 / n_rays) if traced else "–"
                ms = figure(statistics.median(whole) * 1e3)
                name = f"{peer.program} {version(talk)}"
                rows.append([name, kind, path.stem, share, *map(str, counts), ns, ms])
    return rows


def main():
    kugelblitz = str(Path(sys.argv[1]).resolve())
    size = tuple(map(int, (sys.argv[2] if len(sys.argv) > 2 else "1280x720").split("x")))
    n_runs = int(sys.argv[3]) if len(sys.argv) > 3 else 3
    rows = []
    for peer in [PovRay(), Tachyon()]:
        try:
            rows += measure(peer, kugelblitz, size, n_runs)
        except Failure as failure:
            print(f"ci/peers.py: {peer.program}: {failure}", file=sys.stderr)
    if not rows:
        raise SystemExit(1)
    head = ["renderer", "scenes", "scene", "rays with a wrong object", "false hits",
            "false misses", "another object", "tracing, ns a ray", "process, ms"]
    print(f"Other renderers at {size[0]} × {size[1]} against the exact objects, on all cores: "
          "tracing by the renderer's own clock, and the whole process.\n")
    for row in [head, ["---"] * 3 + ["---:"] * 6, *rows]:
        print("| " + " | ".join(row) + " |")


main()
