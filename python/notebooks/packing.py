# %% [markdown]
# # A packing, coloured by speed
#
# Grains of a simulation, made up here: positions, radii and velocities as arrays. The colour tells how fast each one is.

# %%
import os

import kugelblitz as kb
import numpy as np

SMALL = "KUGELBLITZ_SMALL" in os.environ
N_GRAINS = 500 if SMALL else 20_000
SIZE = (96, 54) if SMALL else (1280, 720)

# %%
heap = kb.Scene.generate(N_GRAINS, "packing", seed=1)
centers, radii = heap.spheres[:, :3], heap.spheres[:, 3]
middle = centers.mean(axis=0)
# The heap turns about its middle, and its grains rattle.
rng = np.random.default_rng(2)
velocity = np.cross([0, 1, 0], centers - middle) + rng.normal(0, 0.05, centers.shape)
speed = np.linalg.norm(velocity, axis=1)

# %% [markdown]
# `color_by` takes one number for each sphere, and `range` the ones at the ends of the colour map: the least and the
# largest, unless it is given.

# %%
scene = kb.Scene(
    centers,
    radius=radii,
    color_by=speed,
    colormap="viridis",
    range=(0, np.quantile(speed, 0.99)),
    lights=[{"position": "eye", "intensity": 0.6}],
    sky={"intensity": 0.5, "directions": 16},
    background="#ffffff",
)
camera = kb.Camera.frame(scene, view="iso")
picture = scene.render(camera, size=SIZE, samples=2)
picture

# %% [markdown]
# The colours go with the speeds: of two grains, the faster one is brighter in viridis.

# %%
by_speed = np.argsort(speed)
luminance = scene.colors[by_speed] @ [0.2126, 0.7152, 0.0722]
assert luminance[: N_GRAINS // 4].mean() < luminance[-N_GRAINS // 4 :].mean()

# %% [markdown]
# Ids lead back to the data: which of the grains in sight is the fastest, and where is it?

# %%
seen, pixels = np.unique(picture.id[picture.id > 0], return_counts=True)
fastest = seen[np.argmax(speed[seen - 1])]
y, x = np.argwhere(picture.id == fastest)[0]
print(f"{len(seen)} of {N_GRAINS} grains are in sight, the largest of them on {pixels.max()} pixels")
print(f"the fastest is object {fastest} at pixel {x},{y}: {speed[fastest - 1]:.3f}")
