# %% [markdown]
# # The lecture's formulas, with numbers
#
# The lecture finds what a ray $\vec o + t \vec d$ sees of a sphere by the roots of a quadratic equation. Here are its
# formulas with the numbers of one ray, and what becomes of them in f32.

# %%
import os
from fractions import Fraction

import kugelblitz as kb
import numpy as np

SMALL = "KUGELBLITZ_SMALL" in os.environ
SIZE = (64, 36) if SMALL else (640, 360)

# %% [markdown]
# Three spheres as in figure 5: one is missed, one is touched, one is pierced. They are placed so that all numbers are
# whole.

# %%
spheres = np.array([[-6, 0, -16, 3], [3, 4, -24, 5], [0, -3, -40, 5]], float)
origin, direction = np.zeros(3), np.array([0, 0, -1.0])


def roots(sphere, number):
    """a, b, k, D and both t by the lecture's formulas, every step in this kind of number."""
    c, r = [number(x) for x in sphere[:3]], number(sphere[3])
    o, d = [number(x) for x in origin], [number(x) for x in direction]
    oc = [x - y for x, y in zip(o, c)]
    a = sum(x * x for x in d)
    b = number(2) * sum(x * y for x, y in zip(d, oc))
    k = sum(x * x for x in oc) - r * r
    discriminant = b * b - number(4) * a * k
    if discriminant < 0:
        return a, b, k, discriminant, None
    root = number(np.sqrt(float(discriminant)))
    return a, b, k, discriminant, sorted([(-b - root) / (number(2) * a), (-b + root) / (number(2) * a)])


for sphere in spheres:
    a, b, k, discriminant, ts = roots(sphere, float)
    print(f"c = {sphere[:3]}, r = {sphere[3]:g}:  a = {a:g}, b = {b:g}, k = {k:g}, D = {discriminant:g}, t = {ts}")

# %% [markdown]
# `scene.explain` writes them as one would on paper, for any pixel or ray, with the exact numbers and with those of f32
# beside them. A notebook shows the formulas; `print` the text.

# %%
scene = kb.Scene(spheres, color="#d62728")
explanation = scene.explain(ray=(origin, direction))
print(explanation)
explanation

# %%
hit = scene.trace([origin], [direction])[0]
assert hit.id == 2 and hit.t == 24 == roots(spheres[1], float)[-1][0]

# %% [markdown]
# ## The error of f32
#
# Now the eye goes away from a sphere of radius 1, and the ray passes its centre at 1.001: it misses. D is the difference
# of two numbers that grow with the square of the distance, but D itself does not grow: in f32 its digits get lost.

# %%
print(f"{'distance':>10} {'D in f32':>12} {'D exactly':>12}   what f32 says")
for distance in [10, 100, 1_000, 10_000, 100_000]:
    sphere = np.array([1.001, 0, -distance, 1.0])
    in_f32 = roots(sphere, np.float32)[3]
    exactly = roots(sphere, lambda x: Fraction(float(x)))[3]
    print(f"{distance:>10} {float(in_f32):>12.5f} {float(exactly):>12.5f}   {'hit' if in_f32 >= 0 else 'no hit'}")
    assert exactly < 0

# %% [markdown]
# What that does to a picture: the same nine balls, seen from farther and farther away through a longer and longer lens.
# `kernel="lecture"` is the lecture's formulas in plain f32, as they stand.

# %%
balls = np.array([[x, y, 0, 0.6] for x in (-1.5, 0, 1.5) for y in (-1.5, 0, 1.5)])
nine = kb.Scene(balls, color="#1f77b4")
shares = []
for distance in [10, 100, 1_000, 10_000, 100_000]:
    camera = kb.Camera((0, 0, distance), (0, 0, 0), fov=float(np.degrees(2 * np.arctan(2.5 / distance))))
    plain = nine.render(camera, size=SIZE, kernel="lecture")
    exact = nine.render(camera, size=SIZE)
    shares.append((plain.id != exact.id).mean())
    print(f"distance {distance:>7}: {shares[-1]:8.3%} of the pixels show a wrong object")
assert shares[0] < 0.001 < shares[-1]
plain

# %% [markdown]
# And this is right, at every distance:

# %%
exact
