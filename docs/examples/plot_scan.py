"""
Distances in a scan
===================

A depth camera records one corner of a hall. The distance is measured along the recorded surface,
from one point to all pixels, and to points between them.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# The scan is generated: rays from a camera at 1.5 m meet a floor, a wall and a box. Like a real
# camera it has noise that grows with depth, loses pixels at random and records nothing behind the
# box. ``gt.read("frame.pcd")`` would read a scan from a file, ``gt.as_domain`` takes one from
# Open3D.

rng = np.random.default_rng(0)
height, width = 90, 120
tilt = np.radians(25)
right, up = np.meshgrid(np.linspace(-0.62, 0.62, width), np.linspace(0.46, -0.46, height))
rays = np.stack(
    [
        right,
        np.cos(tilt) + up * np.sin(tilt),
        up * np.cos(tilt) - np.sin(tilt),
    ],
    axis=-1,
)
eye = np.array([0.0, 0.0, 1.5])


def depth_of_box(low, high):
    """Return the depth at which each ray enters a box; infinite where it does not."""
    with np.errstate(divide="ignore"):
        steps = np.stack([(low - eye) / rays, (high - eye) / rays])
    entry, leave = steps.min(axis=0).max(axis=-1), steps.max(axis=0).min(axis=-1)
    return np.where((entry < leave) & (entry > 0), entry, np.inf)


depth = np.minimum.reduce(
    [
        depth_of_box(np.array([-9, -9, -1.0]), np.array([9, 9, 0.0])),  # the floor
        depth_of_box(np.array([-9, 4.2, -1.0]), np.array([9, 5, 9])),  # the wall
        depth_of_box(np.array([-0.7, 2.2, -1.0]), np.array([0.3, 2.8, 0.6])),  # the box
    ]
)
depth += 0.001 * depth**2 * rng.normal(size=depth.shape)
depth[rng.random(depth.shape) < 0.03] = np.nan
points = eye + depth[..., None] * rays

# %%
# Missing pixels keep their index, and their distance is infinite, so the result has the shape of
# the camera's image. If the position of the camera is known, normals can be turned towards it, and
# oriented normals distinguish the two sides of a thin sheet. Here the normals are estimated.

cloud = gt.PointCloud(points.reshape(-1, 3))
solver = gt.GeodesicSolver(cloud)
source = [-1.2, 3.9, 0.0]  # on the floor, in the corner behind the box
distance = solver.distance(source).reshape(height, width)
print(cloud)
print("normals by", solver.method.metric.notes["normals"])

# %%
# :meth:`~geodesic_toolkit.GeodesicSolver.query` returns distances between the pixels and slightly
# off the surface, here on a fine square grid over the floor. Points farther than ``reach`` from all
# pixels, as in the shadow of the box, read infinity.

x, y = np.meshgrid(np.linspace(-2.2, 2.2, 221), np.linspace(1.0, 4.2, 161))
floor = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
on_floor = solver.query(floor, source, reach=0.05).reshape(x.shape)
print(f"{np.isfinite(on_floor).mean():.0%} of the floor's grid was seen")
print("in the air:", solver.query([0.0, 3.0, 1.5], source))

fig, (seen, above) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
look = {"cmap": "viridis", "vmin": 0, "vmax": 4.5}
lines = {"levels": np.arange(0, 4.5, 0.25), "colors": "black", "linewidths": 0.5}
seen.imshow(distance, **look)
seen.contour(np.where(np.isfinite(distance), distance, np.nan), **lines)
seen.set(title="the image of the camera: missing pixels are blank")
seen.axis("off")
answered = np.where(np.isfinite(on_floor), on_floor, np.nan)
plan = above.pcolormesh(x, y, answered, **look)
above.contour(x, y, answered, **lines)
above.plot(*source[:2], "o", color="red", markeredgecolor="white", markersize=9)
above.set(title="the floor from above, by queries", xlabel="m", ylabel="m", aspect="equal")
fig.colorbar(plan, ax=above, label="distance (m)")

# %%
# Paths do not cross areas without pixels: from the corner to the other side of the box they lead
# around the whole shadow, along the wall or in front of the box.

straight = np.linalg.norm(floor - np.array(source), axis=1).reshape(x.shape)
reached = np.isfinite(on_floor)
print(f"longest detour: {(on_floor - straight)[reached].max():.2f} m")

# %%
# On the part of the floor that the source sees, the distance is that of the straight line, in spite
# of the noise of the camera and the missing pixels.

seen_from_source = reached & (x > -2) & (x < -0.8) & (y > 3) & (straight > 0.3)
error = np.abs(on_floor - straight)[seen_from_source] / straight[seen_from_source]
print(f"error where the source sees the floor: {100 * error.mean():.2f} %")
assert error.mean() < 0.01
