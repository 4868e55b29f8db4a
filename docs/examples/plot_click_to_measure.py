"""
Click to measure
================

A page in the browser where a click sets the source, reads a distance or draws a path; here the
clicks are made by a script.
"""

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# ``gt.viz.view(mesh)`` opens the page in the browser and waits until Ctrl-C; on the command line it
# is ``geodesic-toolkit view bunny.off``. Both need ``pip install "geodesic-toolkit[view]"``. Drag
# to turn the shape, click to set the source, and shift-click to add one; the panel chooses the
# effect of a click. With ``block=False`` the call returns at once, with the page open, and with
# ``browser=False`` it opens no browser: ``page.url`` is the address to open later.

sphere = gt.testing.shapes.icosphere(5)
page = gt.viz.view(sphere, block=False, browser=False)

# %%
# A click is a ray from the camera through the pixel. The session, which is the state of the page,
# finds the place that the ray meets first, and moves the source there, inside a face. The
# distances follow.

session = page.session
camera = np.array([2.0, 3.0, 6.0])
source = session.pick(camera, -camera)
session.click(source)
print(f"in the face of vertices {source.vertices}, with weights {source.weights.round(3)}")

# %%
# The second effect of a click is to read the distance. On the other side of the sphere, at the
# antipode, it is π. Distances are linear in a face, and less accurate there than elsewhere: the
# antipode is where fronts from all sides meet.

session.set_mode("measure")
session.click(session.pick(-camera, camera))
place, distance = session.measured
print(f"at the antipode: {distance:.4f}, π is {np.pi:.4f}")
edge = gt.GeodesicSolver(sphere).method.metric.spacing
assert abs(distance - np.pi) < edge

# %%
# The third draws the shortest path between two clicks. A quarter of a great circle:

session.set_mode("path")
session.click(source)
aside = np.cross(camera, [0.0, 1.0, 0.0])
session.click(session.pick(aside, -aside))
path, distances = session.path, session.distances
print(f"a path of length {path.length:.4f}, π/2 is {np.pi / 2:.4f}")
assert abs(path.length / (np.pi / 2) - 1) < 2e-3

# %%
# This is what the page shows, drawn as a picture: the page itself turns, and has sharp isolines
# however close the camera is.

places = gt.Located([source.vertices], [source.weights])
picture = gt.viz.plot(
    sphere, distances, sources=places, curves=path.curve, views=(camera, aside), size=(1400, 700)
)
fig = plt.figure(figsize=(7, 3.5))
fig.add_axes((0, 0, 1, 1)).imshow(picture)
plt.axis("off")

# %%
# The page ends with ``stop``, or at the end of a ``with`` block. What was clicked is still there.

page.stop()
assert len(session.sources) == 1
