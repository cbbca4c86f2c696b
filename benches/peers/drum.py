#!/usr/bin/env python3
"""Writes a packing of 50 000 grains in a rotating drum, as float64 of shape (N, 4): x, y, z, radius in metres.

    drum.py DRUM.npy

Random grains below an inclined surface are pushed apart until they barely overlap. Needs numpy and scipy.
"""

import sys

import numpy as np
from scipy.spatial import cKDTree

COUNT = 50_000
LENGTH = 0.15  # of the drum, along y
DENSITY = 0.60  # share of the volume that grains fill
FILLING = 0.45  # share of the drum that the packing fills
SLOPE = np.radians(28)
STEPS = 120


def drum():
    random = np.random.default_rng(7)
    radii = random.uniform(1.5e-3, 2.5e-3, COUNT)
    area = (4 / 3 * np.pi * radii**3).sum() / DENSITY / LENGTH
    drum_radius = np.sqrt(area / FILLING / np.pi)
    surface = np.array([np.sin(SLOPE), np.cos(SLOPE)])

    parts, count = [], 0
    while count < COUNT:
        corner = [drum_radius, LENGTH, drum_radius]
        points = random.uniform([-drum_radius, 0, -drum_radius], corner, (400_000, 3))
        is_inside = (points[:, [0, 2]] ** 2).sum(axis=1) < (drum_radius - 2e-3) ** 2
        is_below = points[:, [0, 2]] @ surface < -0.06 * drum_radius
        parts.append(points[is_inside & is_below])
        count += len(parts[-1])
    centers = np.concatenate(parts)[:COUNT]

    for _ in range(STEPS):
        pairs = cKDTree(centers).query_pairs(2 * radii.max(), output_type="ndarray")
        offsets = centers[pairs[:, 1]] - centers[pairs[:, 0]]
        distances = np.linalg.norm(offsets, axis=1) + 1e-12
        overlaps = radii[pairs].sum(axis=1) - distances
        touching = overlaps > 0
        pushes = (0.3 * overlaps / distances)[touching, None] * offsets[touching]
        np.add.at(centers, pairs[touching, 0], -pushes)
        np.add.at(centers, pairs[touching, 1], pushes)
        from_axis = np.hypot(centers[:, 0], centers[:, 2])
        pull = np.minimum(1, (drum_radius - radii) / from_axis)[:, None]
        centers[:, [0, 2]] *= pull
        centers[:, 1] = np.clip(centers[:, 1], radii, LENGTH - radii)
        centers[:, 2] -= 2e-5
    return np.column_stack([centers, radii])


if len(sys.argv) != 2:
    raise SystemExit(__doc__)
np.save(sys.argv[1], drum())
