"""
Means and even cells
====================

The mean of places on a surface, their median, and sites that are the centres of their own Voronoi
cells.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# The mean has the least sum of squared distances. On a sphere the mean of points at equal distance
# and angles around the pole is the pole.

sphere = gt.testing.shapes.icosphere(4)
solver = gt.GeodesicSolver(sphere)
turn = np.arange(7) * 2 * np.pi / 7
sites = np.column_stack([0.6 * np.cos(turn), 0.6 * np.sin(turn), np.full(7, 0.8)])
mean = gt.geodesic_mean(solver, sites)
print(f"the mean is at {mean.position.round(4)} after {mean.steps} steps")
assert np.linalg.norm(mean.position - [0, 0, 1]) < 0.01

# %%
# The median has the least sum of distances. With a site at the pole and one far from it, the mean
# moves towards the far one, and the median does not.

sites = np.vstack([sites, [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]])
off = [gt.geodesic_mean(solver, sites, power=power).position[1] for power in (2, 1)]
print("the mean moves by {:.3f}, the median by {:.3f}".format(*np.abs(off)))
assert abs(off[1]) < abs(off[0])

# %%
# Lloyd's iteration moves each site to the mean of its cell, and spreads the sites evenly.

torus = gt.testing.shapes.torus(96, 48)
on_torus = gt.GeodesicSolver(torus)
cells = gt.centroidal_voronoi(on_torus, 40, rng=np.random.default_rng(0))
first, last = cells.energies[[0, -1]]
print(f"energy from {first:.3f} to {last:.3f} in {len(cells.energies) - 1} steps")
assert last < 0.8 * first

picture = gt.viz.plot(
    torus, on_torus.distance(cells.sites), sources=cells.sites, isolines=6, size=(1600, 700)
)
fig = plt.figure(figsize=(8, 3.5))
fig.add_axes((0, 0, 1, 1)).imshow(picture)
plt.axis("off")
