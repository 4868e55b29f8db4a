"""
Refinement and its order
========================

How the error of a distance falls with the size of the edges: on a sphere, whose distances are
known.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# The vertices are moved at random, so that the triangles are not all alike. Refined distances,
# which are the default, are second order: edges of half the length have a quarter of the error.
# Plain heat, the paper's own result, improves much more slowly.

rng = np.random.default_rng(0)
sizes, errors = [], {"refined": [], "plain heat": []}
for level in (3, 4, 5):
    ball = gt.testing.shapes.icosphere(level)
    edge = np.sqrt(4 * np.pi / ball.n_vertices)
    moved = ball.vertices + 0.15 * edge * rng.normal(size=ball.vertices.shape)
    moved /= np.linalg.norm(moved, axis=1, keepdims=True)
    sphere = gt.TriangleMesh(moved, ball.faces)
    exact = np.arccos(np.clip(moved @ moved[0], -1, 1))
    sizes.append(edge)
    for name, refine in (("refined", "auto"), ("plain heat", False)):
        found = gt.geodesic_distance(sphere, 0, refine=refine)
        errors[name].append(np.abs(found - exact).mean() / exact.mean())

order = {name: np.polyfit(np.log(sizes), np.log(some), 1)[0] for name, some in errors.items()}
print({name: f"order {value:.2f}" for name, value in order.items()})
assert order["refined"] > 1.6

fig, axes = plt.subplots(figsize=(5.5, 4), layout="constrained")
for name, some in errors.items():
    axes.loglog(sizes, some, "o-", label=f"{name}: order {order[name]:.1f}")
axes.set(xlabel="length of an edge", ylabel="mean error, relative to the mean distance")
axes.legend()
