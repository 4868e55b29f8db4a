"""
Distances in a graph: a maze
============================

A picture of a maze is a graph of its free pixels. Distances in it are nearly those of the floor,
not those of steps along rows and columns.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# Walls are drawn into an image. Each free pixel is a vertex, with edges of length 1 to its
# neighbours in the row and in the column.

free = np.ones((60, 60), dtype=bool)
for row in (12, 24, 36, 48):
    free[row, (row // 12) % 2 * 12 : 60 - (row // 12 + 1) % 2 * 12] = False
number = np.full(free.shape, -1)
number[free] = np.arange(free.sum())
right = (number[:, :-1], number[:, 1:])
down = (number[:-1], number[1:])
edges = np.concatenate([np.column_stack([a.ravel(), b.ravel()]) for a, b in (right, down)])
graph = gt.Graph(int(free.sum()), edges[(edges >= 0).all(axis=1)])
print(graph)

# %%
# By default, fronts cross the squares between the edges, so that a diagonal is sqrt(2) long and not
# 2. With ``refine=False`` the result is plain heat, which is smooth.

distance = gt.geodesic_distance(graph, 0)
image = np.full(free.shape, np.nan)
image[free] = distance
corner = distance[number[11, 11]]
print(f"11 rows down and 11 columns across: {corner:.3f}, of {np.hypot(11, 11):.3f}")
assert abs(corner / np.hypot(11, 11) - 1) < 0.02

fig, axes = plt.subplots(figsize=(4.6, 4), layout="constrained")
shown = axes.imshow(image, cmap="viridis")
axes.contour(image, levels=24, colors="white", linewidths=0.5)
axes.set(xticks=[], yticks=[], title=f"the exit is {distance[number[59, 59]]:.0f} pixels away")
fig.colorbar(shown, label="pixels")
