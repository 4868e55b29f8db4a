"""
Loops, isolines and discs
=========================

Closed geodesics around the handle of a torus, the circles at equal distance from one of them, and
the disc about a point.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# A loop is laid along edges through three vertices or more, and pulled taut: around the tube it
# becomes a small circle, and along the tube it slips to the inner equator.

torus = gt.testing.shapes.torus(96, 48)
solver = gt.GeodesicSolver(torus)
around = gt.geodesic_loop(solver, [0, 16, 32])
along = gt.geodesic_loop(solver, [0, 32 * 48, 64 * 48])
print(f"around the tube: {around.length:.3f}, a circle has {2 * np.pi * 0.5:.3f}")
print(f"along the tube: {along.length:.3f}, a circle has {2 * np.pi * 1.5:.3f}")
assert abs(around.length / np.pi - 1) < 0.01

# %%
# Not every loop goes around something. One that does not shrinks to a point, and is an error.

try:
    gt.geodesic_loop(solver, [0, 3, 3 * 48])
except gt.errors.ContractibleLoopError as error:
    print(error)

# %%
# A loop is a source as well, and isolines of the distance from it are curves again.

distance = solver.distance(along.curve)
lines = gt.isolines(torus, distance, [0.4, 0.8, 1.2])
for line in lines:
    print(f"closed: {line.closed}, length {gt.curve_length(torus, line):.3f}")

picture = gt.viz.plot(
    torus, distance, curves=[around, along, *lines], isolines=0, sources=[], size=(1600, 700)
)
fig = plt.figure(figsize=(8, 3.5))
fig.add_axes((0, 0, 1, 1)).imshow(picture)
plt.axis("off")

# %%
# The vertices within a radius of a point form a mesh of their own. It is not a topological disc
# once it reaches around the tube.

for radius in (1.0, 2.0):
    disc = gt.geodesic_disc(solver, 0, radius)
    print(f"{disc}: a disc: {disc.is_disc}")
