# %% [markdown]
# # A first picture
#
# Arrays in, a picture out, and for every pixel a proof that it shows the right object. Open this file as a notebook
# in Jupyter (with jupytext) or in VS Code, or run it as a script.

# %%
import os

import kugelblitz as kb
import numpy as np

# Small where it is tested.
SMALL = "KUGELBLITZ_SMALL" in os.environ
N_SPHERES = 1_000 if SMALL else 100_000
SIZE = (96, 54) if SMALL else (1280, 720)

# %% [markdown]
# A hundred thousand spheres in a cube, on a floor. `spheres` is an array of centres, `radius` one number or one for
# each, and so is `color`, here floats in sRGB.

# %%
rng = np.random.default_rng(1)
centers = rng.random((N_SPHERES, 3))
scene = kb.Scene(
    centers,
    radius=0.3 * N_SPHERES ** (-1 / 3),
    color=centers,
    planes=[{"point": [0, -0.02, 0], "normal": [0, 1, 0], "color": "#8c8c8c", "name": "floor"}],
    lights=[{"position": [3, 4, 2], "intensity": 0.8}],
    sky={"intensity": 0.4, "directions": 16},
    background="#ffffff",
)
scene

# %%
camera = kb.Camera.frame(scene, view="iso")
picture = scene.render(camera, size=SIZE, progress=not SMALL)
picture

# %% [markdown]
# Next to the colours, a picture has ids, depths and normals as arrays, and says how many pixels each stage decided:
# f32 within its error bound nearly all, f64 and exact arithmetic the rest.

# %%
print("objects in sight:", len(np.unique(picture.id)) - 1)
print("depths:", picture.t[picture.id > 0].min(), "to", picture.t[picture.id > 0].max())
print("decided by:", picture.counts)

# %% [markdown]
# Another camera needs no new tree over the spheres. `crop` draws a part of the picture, which is the same as the part
# of the whole.

# %%
beside = kb.Camera((-1.4, 0.6, 0.5), (0.5, 0.4, 0.5), fov=50)
whole = scene.render(beside, size=SIZE, samples=2)
left = scene.render(beside, size=SIZE, samples=2, crop=(0, 0, SIZE[0] // 2, SIZE[1]))
assert (whole.rgb8[:, : SIZE[0] // 2] == left.rgb8).all()
whole

# %% [markdown]
# A picture's digest is the same on every device and driver: compare this line with that of anybody else.

# %%
print(picture.digest())
picture.save("cloud.png")
