"""
Signed distance from curves
===========================

The distance from curves, positive on their left and negative on their right, even if the curves
have gaps.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# A circle at latitude 0.5 on a sphere, eastwards: the north, on its left, is positive.

sphere = gt.testing.shapes.icosphere(4)
solver = gt.GeodesicSolver(sphere)
turn = np.linspace(0, 2 * np.pi, 73)[:-1]
radius, height = np.cos(0.5), np.sin(0.5)
places = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(72, height)])
circle = gt.Curve(places, closed=True)
distance = gt.signed_distance(solver, circle)
exact = np.arcsin(sphere.vertices[:, 2]) - 0.5
print(f"mean error: {abs(distance - exact).mean():.1e} of a radius")
assert abs(distance - exact).mean() < 0.005

# %%
# Three arcs of it, which leave out half of the circle. The sides come from normals that diffuse,
# and the gaps are bridged.

arcs = [gt.Curve(places[begin : begin + 13]) for begin in (0, 24, 48)]
broken = gt.signed_distance(solver, arcs)
print(f"wrong signs: {(np.sign(broken) != np.sign(exact))[abs(exact) > 0.1].mean():.1%}")

pictures = [
    gt.viz.plot(sphere, field, curves=curves, size=(1600, 750), views=["front", "y"],
                **gt.viz.two_sided(field))
    for field, curves in ((distance, circle), (broken, arcs))
]  # fmt: skip
fig, axes = plt.subplots(2, 1, figsize=(8, 7.5), layout="constrained")
for place, picture in zip(axes, pictures, strict=True):
    place.imshow(picture)
    place.axis("off")
