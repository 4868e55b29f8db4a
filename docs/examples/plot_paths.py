"""
Shortest paths
==============

Paths between two places, through way points, and on one side of a handle.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# A path on a mesh is a polyline that crosses its faces, and is as long as the distance.

torus = gt.testing.shapes.torus(60, 30)
solver = gt.GeodesicSolver(torus)
start, end = 0, 45 * 30 // 2 + 15
path = gt.geodesic_path(solver, start, end)
print(f"{len(path.points)} points, length {path.length:.4f}")
assert abs(path.length / gt.exact_distance(torus, start)[end] - 1) < 1e-9

# %%
# With `via` a path passes holes and hills on the side of given places, and is pulled taut; with
# ``through=True`` it stays at the places. A loop is pulled taut like a rubber band: this one
# cannot leave the hole of the torus.

way = 12 * 30
visiting = gt.geodesic_path(solver, start, end, via=[way], through=True)
loop = gt.geodesic_loop(solver, list(range(0, torus.n_vertices, 30)))
print(f"by vertex {way}: {visiting.length:.4f}; around the hole: {loop.length:.4f}")
assert visiting.length >= path.length

curves = [path.curve, visiting.curve, loop.curve]
picture = gt.viz.plot(torus, solver.distance(start), curves=curves, isolines=0, size=(1400, 700))
fig = plt.figure(figsize=(7, 3.5))
fig.add_axes((0, 0, 1, 1)).imshow(picture)
plt.axis("off")

# %%
# A path is a curve, which may be a source in its turn: the set of all places near a path.

near = solver.distance(path.curve) < 0.1
print(f"{np.count_nonzero(near)} vertices are within 0.1 of the path")
