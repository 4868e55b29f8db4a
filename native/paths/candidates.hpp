// The best of the paths down from a vertex, straightened.
#pragma once

#include "paths/strips.hpp"

namespace geodesic {

// The points of a geodesic from a vertex to one of several; none where no triangle connects them.
//
// Near a place where paths of equal length meet, steepest descent may take the wrong one. So it
// also sets out to every neighbour of the start that is lower, back from the ends, and to both from
// vertices over which a path is only slightly longer than over any other and shorter than over
// their neighbours. The shortest of these paths is returned.
//
// `height` is the distance from the ends and `back` that from the start, 0 there.
std::vector<Crossing> best_path(const Surface& surface, std::span<const double> height,
                                std::span<const double> back, Index start,
                                std::span<const Index> ends);

// The triangles of elements, (E, 3), each once with its corners sorted, (T, 3), and how often each
// is there. Elements (i, j, j) are none.
struct Distinct {
  std::vector<Index> triangles, stars;
};
Distinct distinct_triangles(std::span<const Index> elements);

}  // namespace geodesic
