// Points of a cloud that are much closer to each other along lines, or in heaps, than elsewhere.
#pragma once

#include "clouds/cloud.hpp"

namespace geodesic {

// The radius of the crowd around each point, 0 where there is none.
//
// A ball about a point of a surface holds four times as many points if it is twice as wide. Along a
// scan line it has to be four times as wide for that, and about a heap of points wider still. The
// reach is the distance to the last neighbour by which that shows: the next line, or the next heap,
// is not nearer than that.
//
// Normals are not used. Throws std::invalid_argument if a neighbour is not a point of the cloud.
Array<double> crowd_reaches(const Cloud& cloud, int n_threads);

// Select points to keep, so that each other point has one of them within its radius.
//
// Points are visited in their order, so that the first of a heap is kept; those of radius 0 always
// are. Throws std::invalid_argument as above.
Array<bool> thinned(const Cloud& cloud, std::span<const double> radii);

}  // namespace geodesic
