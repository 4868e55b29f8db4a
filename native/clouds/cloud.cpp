#include "clouds/cloud.hpp"

#include <stdexcept>
#include <string>

#include "core/threads.hpp"

namespace geodesic {

void check_neighbours(const Cloud& cloud, int n_threads) {
  in_pieces(cloud.rows(), kPointsAtOnce, n_threads, [&](Index begin, Index end) {
    bool sound = true;  // a comparison of numbers without sign, in which a negative one is large
    for (Index i = begin * cloud.width; i < end * cloud.width; ++i)
      sound &= static_cast<std::uint64_t>(cloud.neighbours[i]) <
               static_cast<std::uint64_t>(cloud.size());
    if (!sound)
      throw std::invalid_argument("a neighbour is not a point of the cloud, which has " +
                                  std::to_string(cloud.size()));
  });
}

}  // namespace geodesic
