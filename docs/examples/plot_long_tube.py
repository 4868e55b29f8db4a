"""
Beyond the range of 64-bit floats
=================================

Heat that has diffused for a short time falls by a factor of about e per edge. Some 700 edges from
the source it is smaller than the smallest 64-bit float, and has no direction. The distances are
right nevertheless.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# A tube, long and thin, with the source on its first ring. Along it the exact distance is that of
# the unrolled plane.

rings, around = 1500, 12
tube = gt.testing.shapes.tube(rings, around)
solver = gt.GeodesicSolver(tube)
line = np.arange(0, rings, 2) * around  # vertices straight along the tube, every second ring
turned = np.arange(0, rings, 2) / 2 % around  # by which the rings are twisted, in edges
exact = np.hypot(tube.vertices[line, 2], np.minimum(turned, around - turned))

# %%
# A single solve underflows to zero. Its logarithm does not: where the heat gets small,
# the solver starts again from there, scaled up, with the same factor
# (see :doc:`/mathematics`).

heat = solver.heat(0)
log_heat = solver.log_heat(0)
print(f"vertices without heat: {(heat == 0).sum()} of {tube.n_vertices}")
print(f"the smallest heat is exp({log_heat.min():.0f})")

# %%
# The distance at the far end, more than a thousand edges away, is right to a fraction of a per
# cent.

distance = solver.distance(0)
error = distance[line][-1] / exact[-1] - 1
print(f"far end: {distance[line][-1]:.1f}, exact {exact[-1]:.1f}, error {100 * error:+.2f} %")
assert (heat == 0).any()
assert np.isfinite(log_heat).all()
assert abs(error) < 0.005

fig, (above, below) = plt.subplots(2, 1, figsize=(8, 6), sharex=True, layout="constrained")
positive = heat[line] > 0
above.plot(exact, log_heat[line], color="#1f5f8b", label="with restarts")
above.plot(
    exact[positive],
    np.log(heat[line][positive]),
    color="#b3541e",
    linewidth=4,
    alpha=0.6,
    label="one solve",
    zorder=0,
)
above.axhline(np.log(5e-324), color="grey", linestyle=":", label="the smallest 64-bit float")
above.set(ylabel="log of the heat")
above.legend()
below.plot(exact[1:], 100 * (distance[line][1:] / exact[1:] - 1), color="#1f5f8b")
below.axhline(0, color="grey", linewidth=0.8)
below.set(xlabel="exact distance from the source, in edges", ylabel="error of the distance, %")
below.set_ylim(-3, 3)
