#!/usr/bin/env python3
"""How wrong POV-Ray and Tachyon are on the report's scenes, as two tables in Markdown.

    ci/peers.py KUGELBLITZ [WxH [RUNS]] >peers.md

Each scene gets a colour of its own for every object, and is exported. The picture that each renderer
draws is then compared with the one of the kernel `certified`, which shows the exact object in every
pixel. Lit scenes are exported as they are, and once more all white with a channel of its own for each
light, so bright that a pixel shows whether the light counts there. Needs Debian's packages povray and
tachyon; one that is missing is said on standard error and left out, none at all is a failure.
"""

import json
import random
import re
import shutil
import statistics
import struct
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SCENES = {"lecture's scenes": "scenes/*.toml", "hard scenes": "scenes/hard/*.toml"}

# Lit scenes of ordinary numbers, with at most three lights and no sky. The other hard ones have numbers that a renderer
# refuses, or parts that it lacks.
LIT_SCENES = [
    "contacts", "contacts_1e-3", "contacts_1e-6", "contacts_1e3", "contacts_moved", "contacts_on_ball", "low_sun", "shells",
    "terminator",
]
LIT_SIZE = (640, 360)

# A light of this brightness fills its channel wherever it counts, and can still be a whole number of
# 32 bits when it is 255 times as large.
BRIGHT = 1000.0

# Where a surface gets less of a light than this share, Tachyon leaves the light out (below 1/512): what
# is no shadow can't be a wrong one.
FAINT = 1 / 256

# A byte that is farther off is seen at a glance.
FAR_LEVELS = 8

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

# The same in the light of a lamp and of a sun.
PLAIN_LIT = PLAIN.replace("#000000", "#c0a080") + """
[[light]]
position = [4.0, 5.0, 3.0]
intensity = 0.5
[[light]]
direction = [1.0, -2.0, -1.5]
intensity = 0.3
"""


class Failure(Exception):
    """Why there is no result of a renderer."""


class PovRay:
    """Calculates in f64, but its boxes around objects are in f32."""

    program, language, is_linear = "povray", "pov", False
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
    """Calculates in f64, but reads the numbers of a scene as f32. The bytes of a lit picture are linear
    light, cut down."""

    program, language, is_linear = "tachyon", "tachyon", True
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


def toml(value):
    """A value of a scene, in a line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(part)}" for key, part in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


def separated(text):
    """The scene in white, and each light bright in a channel of its own; and their number."""
    scene = tomllib.loads(text)
    lights = scene["light"]
    if len(lights) > 3 or "sky" in scene:
        raise SystemExit("ci/peers.py: a lit scene has a sky, or more lights than a picture channels")
    scene.pop("ambient", None)
    scene["background"] = "#000000"
    for item in scene.get("sphere", []) + scene.get("plane", []):
        item["color"] = "#ffffff"
    for index, light in enumerate(lights):
        light["color"] = [float(channel == index) for channel in range(3)]
        light["intensity"] = BRIGHT
    return "".join(f"{key} = {toml(value)}\n" for key, value in scene.items()), len(lights)


def linear_pixels(path, size):
    """The linear colours of a picture in NPY."""
    data = Path(path).read_bytes()
    (length,) = struct.unpack("<H", data[8:10])
    fields = re.findall(rb"'(\w+)', '<(\w+)'", data[10:10 + length])
    if fields != [(b"id", b"u4"), (b"t", b"f4"), (b"normal", b"f4"), (b"rgb", b"f4")]:
        raise SystemExit(f"ci/peers.py: {path} has other fields: {fields}")
    found = [record[5:] for record in struct.iter_unpack("<I7f", data[10 + length:])]
    if len(found) != size[0] * size[1]:
        raise SystemExit(f"ci/peers.py: {path} has {len(found)} pixels")
    return found


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


def compare_lights(found, exact, n_lights):
    """Counts of lights that are left out and count, and of those that are let in and don't count. `found`
    has bytes, `exact` the light."""
    false_shadows = leaks = 0
    for channels, light in zip(found, exact, strict=True):
        for k in range(n_lights):
            if 0 < light[k] < FAINT * BRIGHT:
                continue
            is_lit, counts = channels[k] > 127, light[k] > 0
            false_shadows += counts and not is_lit
            leaks += is_lit and not counts
    return false_shadows, leaks


def compare_bytes(found, exact):
    """Counts of pixels with a wrong byte, and of those with one that is far off."""
    off = [max(abs(a - b) for a, b in zip(*pair)) for pair in zip(found, exact, strict=True)]
    return sum(levels > 0 for levels in off), sum(levels > FAR_LEVELS for levels in off)


def check_comparisons():
    """Feeds each comparison a wrong picture."""
    dark, lit, faint = (0.0, 0.0, 0.0), (BRIGHT, 0.5 * BRIGHT, 0.0), (FAINT * BRIGHT / 2, 0.0, 0.0)
    for found, counts in [
        ([b"\0\0\0", b"\xff\xff\0", b"\0\0\0"], (0, 0)),
        ([b"\0\0\0", b"\xff\xff\0", b"\xff\0\0"], (0, 0)),
        ([b"\0\0\0", b"\xff\0\0", b"\0\0\0"], (1, 0)),
        ([b"\xff\0\0", b"\xff\xff\0", b"\0\xff\0"], (0, 2)),
        ([b"\0\0\xff", b"\xff\xff\xff", b"\0\0\0"], (0, 0)),
    ]:
        if compare_lights(found, [dark, lit, faint], 2) != counts:
            raise SystemExit(f"ci/peers.py: lights are not compared: {found}")
    for found, counts in [(b"abc", (0, 0)), (b"abd", (1, 0)), (b"abk", (1, 0)), (b"abl", (1, 1))]:
        if compare_bytes([found, b"abc"], [b"abc", b"abc"]) != counts:
            raise SystemExit(f"ci/peers.py: bytes are not compared: {found}")
    background = b"xyz"
    for found, counts in [(b"abc", (0, 0, 0)), (background, (0, 1, 0)), (b"abd", (0, 0, 1))]:
        if compare([found], [b"abc"], background) != counts:
            raise SystemExit(f"ci/peers.py: objects are not compared: {found}")
    if compare([b"abc"], [background], background) != (1, 0, 0):
        raise SystemExit("ci/peers.py: false hits are not counted")


class Scene:
    """A scene file, and its pictures by both sides."""

    def __init__(self, kugelblitz, folder, text, size):
        self.kugelblitz, self.folder, self.size = kugelblitz, folder, size
        self.path = folder / "scene.toml"
        self.path.write_text(text)

    def run(self, *arguments):
        size = "x".join(map(str, self.size))
        subprocess.run([self.kugelblitz, *arguments, "--size", size, "-q"], check=True)

    def exact(self, ending):
        """The exact picture: bytes, or with `npy` the light."""
        path = self.folder / f"exact.{ending}"
        self.run("render", self.path, "-o", path, "--kernel", "certified")
        return (linear_pixels if ending == "npy" else pixels)(path, self.size)

    def draw(self, peer, n_runs):
        """The peer's pixels, its seconds of tracing and of the whole process, and its talk."""
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
        traced = traced if len(traced) == n_runs else None
        return pixels(picture, self.size), traced, whole, ran.stdout


def version(talk):
    found = re.search(r"Ray Tracer\s+Version (\S+)", talk)
    return found[1] if found else "of an unknown version"


def figure(x):
    return f"{x:.0f}" if x >= 100 else f"{x:.3g}"


def share(wrong, of):
    if wrong == 0:
        return f"0 of {of}"
    percent = 100 * wrong / of
    return f"{percent:.0f} %" if percent >= 10 else f"{percent:.2g} %"


def objects(peer, scene_of, text, size, n_runs):
    """Counts of wrong objects, seconds of tracing and of the whole process, and the peer's talk."""
    text, background = recoloured(text)
    scene = scene_of(text, size)
    exact = scene.exact("ppm")
    found, traced, whole, talk = scene.draw(peer, n_runs)
    return compare(found, exact, background), traced, whole, talk


def light(peer, scene_of, text, size):
    """Counts of wrong lights and of pixels with wrong bytes, and the number of lights."""
    own = scene_of(text, size)
    exact = own.exact("npy" if peer.is_linear else "ppm")
    if peer.is_linear:
        exact = [bytes(int(255 * min(part, 1.0)) for part in pixel) for pixel in exact]
    found, _, _, _ = own.draw(peer, 1)
    wrong_bytes = compare_bytes(found, exact)
    text, n_lights = separated(text)
    white = scene_of(text, size)
    exact = white.exact("npy")
    found, _, _, _ = white.draw(peer, 1)
    return compare_lights(found, exact, n_lights), wrong_bytes, n_lights


def refuse_other_versions(peer, scene_of):
    """The version, if it draws a plain scene right."""
    counts, _, _, talk = objects(peer, scene_of, PLAIN, PLAIN_SIZE, 1)
    lights, (_, far_bytes), _ = light(peer, scene_of, PLAIN_LIT, PLAIN_SIZE)
    if max(sum(counts), sum(lights), far_bytes) > PLAIN_WRONG:
        raise Failure(f"{sum(counts)} pixels, {sum(lights)} shadows and {far_bytes} colours of a plain "
                      f"scene are wrong: version {version(talk)} draws other pictures than the export "
                      "was made for")
    return version(talk)


def measure(peer, kugelblitz, size, n_runs):
    """Rows of the tables of objects and of light."""
    if not shutil.which(peer.program):
        raise Failure(f"not installed: install the package {peer.program}")
    rows, light_rows = [], []
    with tempfile.TemporaryDirectory() as folder:
        def scene_of(text, size):
            return Scene(kugelblitz, Path(folder), text, size)

        name = f"{peer.program} {refuse_other_versions(peer, scene_of)}"
        for kind, pattern in SCENES.items():
            for path in sorted(ROOT.glob(pattern)):
                counts, traced, whole, _ = objects(peer, scene_of, path.read_text(), size, n_runs)
                n_rays = size[0] * size[1]
                ns = figure(statistics.median(traced) * 1e9 / n_rays) if traced else "–"
                ms = figure(statistics.median(whole) * 1e3)
                wrong = [share(sum(counts), n_rays), *map(str, counts)]
                rows.append([name, kind, path.stem, *wrong, ns, ms])
        for scene in LIT_SCENES:
            path = ROOT / "scenes/lit/hard" / f"{scene}.toml"
            lights, wrong_bytes, n_lights = light(peer, scene_of, path.read_text(), LIT_SIZE)
            n_pixels = LIT_SIZE[0] * LIT_SIZE[1]
            light_rows.append([
                name, path.stem, share(sum(lights), n_pixels * n_lights), *map(str, lights),
                *(share(wrong, n_pixels) for wrong in wrong_bytes),
            ])
    return rows, light_rows


def table(head, n_names, rows):
    for row in [head, ["---"] * n_names + ["---:"] * (len(head) - n_names), *rows]:
        print("| " + " | ".join(row) + " |")


def main():
    kugelblitz = str(Path(sys.argv[1]).resolve())
    size = tuple(map(int, (sys.argv[2] if len(sys.argv) > 2 else "1280x720").split("x")))
    n_runs = int(sys.argv[3]) if len(sys.argv) > 3 else 3
    check_comparisons()
    rows, light_rows = [], []
    for peer in [PovRay(), Tachyon()]:
        try:
            measured = measure(peer, kugelblitz, size, n_runs)
            rows += measured[0]
            light_rows += measured[1]
        except Failure as failure:
            print(f"ci/peers.py: {peer.program}: {failure}", file=sys.stderr)
    if not rows:
        raise SystemExit(1)
    print(f"Other renderers at {size[0]} × {size[1]} against the exact objects, on all cores: "
          "tracing by the renderer's own clock, and the whole process.\n")
    table(["renderer", "scenes", "scene", "rays with a wrong object", "false hits", "false misses",
           "another object", "tracing, ns a ray", "process, ms"], 3, rows)
    print(f"\nTheir light at {LIT_SIZE[0]} × {LIT_SIZE[1]}, of pixels times lights: lights that count and "
          "are left out (false shadows), and the other way round (leaks), but for light that is fainter than "
          "1/256, which Tachyon leaves out; and pixels with a wrong byte.\n")
    table(["renderer", "lit scene", "wrong shadows", "false shadows", "leaks", "wrong bytes",
           f"by more than {FAR_LEVELS} levels"], 2, light_rows)


main()
