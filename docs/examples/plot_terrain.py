"""
A robot on terrain
==================

Travel times and paths over a hill with a muddy plain and a road: a cost for each face.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# The terrain is 1 by 1 km, with a hill in the middle. Mud takes five times as long as grass, and
# the road half as long.

flat = gt.testing.shapes.grid(61)
x, y, _ = flat.vertices.T
height = 0.2 * np.exp(-30 * ((x - 0.5) ** 2 + (y - 0.5) ** 2))
terrain = gt.TriangleMesh(np.column_stack([x, y, height]), flat.faces)

middle_x, middle_y, _ = terrain.vertices[terrain.faces].mean(axis=1).T
cost = np.ones(terrain.n_faces)
cost[(middle_x > 0.6) & (middle_y < 0.7)] = 5.0
cost[(middle_y > 0.8) & (middle_y < 0.85)] = 0.5

# %%
# Travel times are distances on the weighted mesh.

solver = gt.GeodesicSolver(gt.MetricMesh(terrain, cost=cost))
times = solver.distance(0)
plain = gt.geodesic_distance(terrain, 0)
corner = int(np.flatnonzero((x == 1) & (y == 1))[0])
print(f"to the far corner: {times[corner]:.3f}, without costs {plain[corner]:.3f}")

# %%
# The road is worth a detour, which Fermat's principle finds: straight to the road at the critical
# angle, of sine 1/2, along it, and off again at the same angle.

tangent = 1 / np.sqrt(3)
by_road = (0.8 + 0.15) * 2 * tangent + 0.5 * (1 - (0.8 + 0.15) * tangent)
print(f"over flat ground, by the road: {by_road:.3f}")
assert abs(times[corner] / by_road - 1) < 0.05

# %%
# The fastest path takes this way: through faces, refracted at both sides of the road. Without costs
# the path leaves the road out.

fastest = gt.geodesic_path(solver, 0, corner)
shortest = gt.geodesic_path(gt.GeodesicSolver(terrain), 0, corner)
print(f"fastest: {fastest.length:.3f}, {fastest.length_in_space:.3f} km long")
print(f"shortest: {shortest.length:.3f} km long")
assert abs(fastest.length / times[corner] - 1) < 0.02

curves = [fastest, shortest]
above = {"views": ["z"], "size": (1100, 900)}
picture = gt.viz.plot(terrain, times, sources=[0], curves=curves, label="travel time", **above)
fig = plt.figure(figsize=(5.5, 4.5))
fig.add_axes((0, 0, 1, 1)).imshow(picture)
plt.axis("off")
