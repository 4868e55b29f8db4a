// Local Delaunay stars: the triangles that surround each point of a cloud in its tangent plane.
//
// The neighbours are inverted about the point, p -> p / |p|^2. Circles through the point become
// lines, so that the convex hull of the images has an edge for every empty circle, which is a
// Delaunay triangle: K. Q. Brown, Voronoi diagrams from convex hulls, Information Processing
// Letters 9, 1979, https://doi.org/10.1016/0020-0190(79)90074-7. The hull is that of A. M. Andrew,
// Another efficient algorithm for convex hulls in two dimensions, the same volume,
// https://doi.org/10.1016/0020-0190(79)90072-3
#pragma once

#include "clouds/cloud.hpp"

namespace geodesic {

// Options of stars; delaunay_stars in laplacians/pointcloud/stars.py documents them.
struct StarOptions {
  Index k;        // neighbours that a star begins with
  bool oriented;  // whether the sign of a normal means something
  bool smooth;    // whether the points lie on the surface, almost without noise
};

struct Stars {
  Array<Index> triangles;  // (E, 3), the centre of the star first, in the order of centres
  Array<double> frames;    // (E, 3): (l, a, b), corners at (0, 0), (l, 0) and (a, b)
  Array<bool> is_open;     // (M,), where the star does not surround its centre
};

// The centres of the stars, one for each row of the cloud's neighbours, and the largest radius of
// each.
struct Centres {
  std::span<const Index> points;
  std::span<const double> reaches;
};

// `weights` are what squared distances are lessened by, one for each point, so that points on one
// circle are distinguished.
//
// Throws std::invalid_argument if a neighbour or a centre is not a point of the cloud.
Stars delaunay_stars(const Cloud& cloud, const Centres& centres, std::span<const double> weights,
                     const StarOptions& options, int n_threads);

}  // namespace geodesic
