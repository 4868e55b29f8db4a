"""
An operator of one's own
========================

The heat method needs nothing of a shape but its Laplacian. This page writes one, checks it
against the contract, and computes distances with it.
"""

from dataclasses import dataclass
from typing import ClassVar

import matplotlib.pyplot as plt
import numpy as np

import geodesic_toolkit as gt

# %%
# An operator is a recipe with one method. This is the Laplacian of linear finite elements on a
# mesh: from the gradient on each face follows everything else. The stiffness L = -Δ is positive
# semidefinite, and the mass of a vertex is a third of its faces.


@dataclass(frozen=True, kw_only=True)
class LinearElements(gt.LaplaceOperator):
    """Linear finite elements on the triangles of a mesh, as they are."""

    domains: ClassVar = (gt.TriangleMesh,)
    references: ClassVar = ("10.1080/10586458.1993.10504266",)

    def assemble(self, domain):
        """Return mass, stiffness and gradient, and where the boundary is."""
        self.check_domain(domain)
        corners = domain.vertices[domain.faces]
        side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        normal = np.cross(side, other)
        proper = np.linalg.norm(normal, axis=1) > 0
        faces, corners = domain.faces[proper], corners[proper]
        side, normal = side[proper], normal[proper]

        frame = np.stack([side, np.cross(normal, side)], axis=1)
        frame /= np.linalg.norm(frame, axis=2, keepdims=True)
        flat = np.ones((len(faces), 3, 3))  # u = a x + b y + c at the corners
        flat[:, :, :2] = np.einsum("fkd,fcd->fck", frame, corners - corners[:, :1])
        area = np.linalg.norm(normal, axis=1) / 2
        count = domain.n_vertices
        gradient = gt.ElementGradient(faces, np.linalg.inv(flat)[:, :2], area, count)

        edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        edges, faces_of_edge = np.unique(edges, axis=0, return_counts=True)
        lengths = np.linalg.norm(np.diff(domain.vertices[edges], axis=1), axis=2)
        boundary = np.zeros(count, dtype=bool)
        boundary[edges[faces_of_edge == 1]] = True
        return gt.Discretization(
            mass=np.bincount(faces.ravel(), np.repeat(area / 3, 3), count),
            stiffness=gradient.stiffness(),
            gradient=gradient,
            spacing=float(lengths.mean()),
            boundary=boundary,
        )


# %%
# The contract is checked law by law: symmetry, constants in the kernel, a gradient that fits the
# stiffness, distances that are accurate, and so on.

operator = LinearElements()
report = gt.testing.run_checks(operator, gt.testing.laplace_operator_checks(operator))
print(f"{len(report.outcomes)} laws, {len(report.broken)} broken")
for outcome in report.broken:
    print(outcome)
assert report.ok

# %%
# Everything else is shared by all operators: sources, masks, the far field, refined distances,
# matrices, pictures.

torus = gt.testing.shapes.torus(60, 30)
solver = gt.GeodesicSolver(torus, operator=operator)
distance = solver.distance(0)
exact = gt.exact_distance(torus, 0)
print(f"mean error {np.abs(distance - exact).mean() / exact.mean():.3%}")

picture = gt.viz.plot(torus, distance, size=(1400, 700))
fig = plt.figure(figsize=(7, 3.5))
fig.add_axes((0, 0, 1, 1)).imshow(picture)
plt.axis("off")
