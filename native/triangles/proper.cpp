#include "triangles/proper.hpp"

#include <array>
#include <vector>

namespace geodesic {
namespace {

// Comparing faces in pairs is faster than sorting up to this number of faces.
constexpr Index kMaxFacesComparedInPairs = 16;

// A face as its vertex of lowest index has it.
struct Rest {
  Index middle, highest, face;
  auto vertices() const { return std::pair(middle, highest); }
};

std::array<Index, 3> in_order(const Index* face) {
  const auto [least, most] = std::minmax({face[0], face[1], face[2]});
  return {least, face[0] + face[1] + face[2] - least - most, most};
}

// Strike out the faces that have the vertices of one before them.
void strike_repeats(std::span<Rest> rests, Array<bool>& proper) {
  if (count(rests) > kMaxFacesComparedInPairs) {
    std::sort(rests.begin(), rests.end(), [](const Rest& one, const Rest& other) {
      return std::pair(one.vertices(), one.face) < std::pair(other.vertices(), other.face);
    });
    for (std::size_t k = 1; k < rests.size(); ++k)
      if (rests[k].vertices() == rests[k - 1].vertices()) proper[rests[k].face] = false;
    return;
  }
  for (std::size_t k = 1; k < rests.size(); ++k)
    for (std::size_t before = 0; before < k; ++before)
      if (rests[k].vertices() == rests[before].vertices()) proper[rests[k].face] = false;
}

}  // namespace

Array<bool> proper_faces(std::span<const Index> faces, Index n_vertices) {
  const Index n_faces = count(faces) / 3;
  Array<bool> proper(n_faces, true);
  Array<Index> starts(n_vertices + 1, 0);
  for (Index f = 0; f < n_faces; ++f)
    ++starts[std::min({faces[3 * f], faces[3 * f + 1], faces[3 * f + 2]}) + 1];
  for (Index v = 0; v < n_vertices; ++v) starts[v + 1] += starts[v];
  Array<Index> free(n_vertices);
  std::copy_n(starts.begin(), n_vertices, free.begin());
  Array<Index> at_lowest(n_faces);
  for (Index f = 0; f < n_faces; ++f)
    at_lowest[free[std::min({faces[3 * f], faces[3 * f + 1], faces[3 * f + 2]})]++] = f;
  std::vector<Rest> rests;
  for (Index v = 0; v < n_vertices; ++v) {
    rests.clear();
    for (Index k = starts[v]; k < starts[v + 1]; ++k) {
      const Index face = at_lowest[k];
      const auto [least, middle, most] = in_order(&faces[3 * face]);
      if (least == middle || middle == most)
        proper[face] = false;
      else
        rests.push_back({middle, most, face});
    }
    strike_repeats(rests, proper);
  }
  return proper;
}

Array<Index> faces_at(std::span<const Index> faces, std::span<const bool> marked) {
  Array<Index> found(count(faces) / 3);
  Index n_found = 0;
  for (Index f = 0; f < found.size(); ++f) {
    const Index* const face = &faces[3 * f];
    found[n_found] = f;
    n_found += marked[face[0]] | marked[face[1]] | marked[face[2]];
  }
  found.shorten(n_found);
  return found;
}

}  // namespace geodesic
