#!/usr/bin/env python3
"""Renders spheres with OVITO's Tachyon renderer, and prints the milliseconds of `render_image` as JSON.

    ovito_picture.py SPHERES.csv SCENE.toml [PICTURE.png]

SPHERES.csv: columns x, y, z and radius first, below a header. The scene gives camera, size, antialiasing and the number of samples
for ambient occlusion. The data are in memory before; nothing is written while the clock runs. Needs PyPI's ovito.
"""

import json
import math
import sys
import time
import tomllib

import numpy as np
import ovito
from ovito.data import DataCollection
from ovito.pipeline import Pipeline, StaticSource
from ovito.vis import TachyonRenderer, Viewport

spheres = np.loadtxt(sys.argv[1], delimiter=",", skiprows=1, usecols=range(4))
with open(sys.argv[2], "rb") as file:
    scene = tomllib.load(file)
camera, image = scene["camera"], scene["image"]

data = DataCollection()
particles = data.create_particles(count=len(spheres))
particles.create_property("Position", data=spheres[:, :3])
particles.create_property("Radius", data=spheres[:, 3])
Pipeline(source=StaticSource(data=data)).add_to_scene()
viewport = Viewport(
    type=Viewport.Type.Perspective,
    camera_pos=camera["position"],
    camera_dir=np.subtract(camera["look_at"], camera["position"]),
    camera_up=camera["up"],
    fov=math.radians(camera["fov"]),
)
# Tachyon adds its antialiasing samples to a first ray through the pixel.
renderer = TachyonRenderer(
    antialiasing_samples=image["samples"] ** 2 - 1,
    ambient_occlusion_samples=scene["sky"]["directions"],
)
viewport.render_image(size=(64, 36), renderer=renderer)  # to warm up
start = time.perf_counter()
picture = viewport.render_image(size=(image["width"], image["height"]), renderer=renderer)
elapsed = time.perf_counter() - start
if len(sys.argv) > 3:
    picture.save(sys.argv[3])
print(json.dumps({"version": ovito.version_string, "ms": 1e3 * elapsed}))
