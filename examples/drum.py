"""Writes grains.csv: 50 000 grains in a rotating drum, with velocities, for the picture in README.md.

Needs numpy and scipy. Takes about 20 seconds. Then:

    kugelblitz render grains.csv -o grains.png --color-by "vx [m/s]" --up z --background white --size 800x450
"""

import csv

import numpy as np
from scipy.spatial import cKDTree

# The drum turns around y, and z points up. All lengths in metres.
N, LENGTH, SLOPE = 50_000, 0.15, np.radians(28)
rng = np.random.default_rng(7)
radius = rng.uniform(1.5e-3, 2.5e-3, N)
drum_radius = np.sqrt((4 / 3 * np.pi * radius**3).sum() / 0.6 / LENGTH / 0.45 / np.pi)
uphill = np.array([np.sin(SLOPE), np.cos(SLOPE)])


def depth(p):
    """Depth of points (N, 3) below the free surface."""
    return -p[:, [0, 2]] @ uphill - 0.06 * drum_radius


# Random points in the filled part of the drum, pushed apart until they hardly overlap.
p = rng.uniform([-drum_radius, 0, -drum_radius], [drum_radius, LENGTH, drum_radius], (8 * N, 3))
p = p[(np.hypot(p[:, 0], p[:, 2]) < drum_radius - 2e-3) & (depth(p) > 0)][:N]
for _ in range(120):
    pairs = cKDTree(p).query_pairs(5e-3, output_type="ndarray")
    offset = p[pairs[:, 1]] - p[pairs[:, 0]]
    distance = np.linalg.norm(offset, axis=1) + 1e-12
    overlap = radius[pairs].sum(1) - distance
    touching = overlap > 0
    push = 0.3 * (overlap[touching] / distance[touching])[:, None] * offset[touching]
    np.add.at(p, pairs[touching, 0], -push)
    np.add.at(p, pairs[touching, 1], push)
    from_axis = np.hypot(p[:, 0], p[:, 2])
    outside = from_axis > drum_radius - radius
    p[np.ix_(outside, [0, 2])] *= ((drum_radius - radius[outside]) / from_axis[outside])[:, None]
    p[:, 1] = np.clip(p[:, 1], radius, LENGTH - radius)
    p[:, 2] -= 2e-5

# Grains turn with the drum, but flow down near the surface.
speed = np.pi / 2
flow = np.exp(-np.clip(depth(p), 0, None) / 0.012)
v = np.zeros((N, 3))
v[:, 0] = speed * p[:, 2] * (1 - flow) + 1.1 * flow * np.cos(SLOPE) * (1 - (p[:, 0] / drum_radius) ** 2)
v[:, 2] = -speed * p[:, 0] * (1 - flow) - 1.1 * flow * np.sin(SLOPE) * (1 - (p[:, 0] / drum_radius) ** 2)
v += rng.normal(0, 0.02, (N, 3))

with open("grains.csv", "w", newline="") as file:
    table = csv.writer(file)
    table.writerow(["x [m]", "y [m]", "z [m]", "radius [m]", "vx [m/s]", "vy [m/s]", "vz [m/s]"])
    table.writerows(np.column_stack([p, radius, v]).round(7).tolist())
