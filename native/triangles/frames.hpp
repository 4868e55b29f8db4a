// Tangent frames at vertices, and the turns that connect them with the planes of elements.
//
// A tangent vector is a complex number in the frame of its vertex. The turn of a corner, a number
// of length 1, takes it into the frame of the corner's element, in which gradients are given.
//
// N. Sharp, Y. Soliman, K. Crane, The Vector Heat Method, ACM Transactions on Graphics 38, 2019,
// https://doi.org/10.1145/3243651; Navigating Intrinsic Triangulations, ACM Transactions on
// Graphics 38, 2019, https://doi.org/10.1145/3306346.3322979
#pragma once

#include "core/array.hpp"

namespace geodesic {

// A unit vector at a right angle to each normal, (N, 3).
//
// T. Duff and others, Building an Orthonormal Basis, Revisited, Journal of Computer Graphics
// Techniques 6, 2017, https://jcgt.org/published/0006/01/01/
Array<double> tangent_axes(std::span<const double> normals);

// The cosines and sines of angles of up to 1e5, (N, 2); NaN of what is not a number.
Array<double> unit_vectors(std::span<const double> angles);

// Vectors in space, (N, 3), from their coordinates, (N, 2), along two axes of each vertex.
Array<double> to_space(std::span<const double> pairs, std::span<const double> x_axes,
                       std::span<const double> y_axes);

// The direction of each half-edge 3 f + c, which leaves corner c + 1, as an angle in the frame of
// that vertex, and the factor of angles between half-edges there.
struct Directions {
  Array<double> angles, scales;
};

// Directions from the angles of triangles. They fill 2 pi about a vertex inside the surface, and
// are what they are where it ends, for a boundary knows no holonomy. Each fan is turned so that it
// fits its edges in space best, so that nothing depends on numbering.
//
// `lengths` has the edge opposite each corner, `twin` is that of `twins`, coherent. Where a face is
// `mirrored` it runs clockwise, seen from where its normals point, and scales are negative.
Directions polar_directions(std::span<const double> vertices, std::span<const Index> faces,
                            std::span<const double> lengths, std::span<const Index> twin,
                            std::span<const bool> mirrored, std::span<const double> normals,
                            std::span<const double> axes);

// The direction of the bisector of each corner in the frame of its vertex, (F, 3).
Array<double> bisectors(std::span<const double> lengths, std::span<const double> angles,
                        std::span<const double> scales);

// Turns (F, 3), complex, as pairs of numbers: bisectors of corners in vertex frames become those in
// the frame of the element, mirrored where the element is.
Array<double> triangle_turns(std::span<const double> lengths, std::span<const double> bisectors,
                             std::span<const bool> mirrored);

// Turns (E, m), complex, by the least rotation of the normal at each vertex to that of the element,
// for elements in space of two or three vertices: edges, triangles, and segments (i, j, j).
//
// The first axis of an element leads from its first vertex to the second. The normal of a segment
// is the mean of those at its ends; that of a triangle its own, or, of stars, that at its first
// vertex.
struct SpaceTurns {
  Array<double> turns;
  Array<bool> mirrored;  // triangles that run clockwise, seen from where the normals point
};
SpaceTurns space_turns(std::span<const double> places, std::span<const Index> elements, int size,
                       std::span<const double> normals, std::span<const double> axes, bool stars);

}  // namespace geodesic
