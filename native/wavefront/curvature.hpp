// Gaussian curvature: the angle defects of vertices over their areas.
#pragma once

#include "wavefront/corners.hpp"

namespace geodesic {

// The angle defects of vertices: 2 pi, or pi at the boundary, minus the angles about the vertex.
Array<double> angle_defects(std::span<const Index> elements, std::span<const double> frames,
                            std::span<const bool> boundary);

// Angle defect over area, averaged over one-rings; 0 where the domain ends, and where sheets meet.
// Where it comes to `coarse`, times the area of a vertex, it counts for half.
Array<double> curvatures(std::span<const Index> elements, std::span<const double> measure,
                         std::span<const double> defects, const Corners& corners,
                         std::span<const bool> boundary, double coarse);

// The same where triangles are stars, the centre of each first: from the angles about the centres.
// A segment has no area.
Array<double> star_curvatures(std::span<const Index> elements, std::span<const double> frames,
                              std::span<const bool> boundary, double coarse);

}  // namespace geodesic
