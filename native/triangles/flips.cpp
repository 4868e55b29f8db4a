#include "triangles/flips.hpp"

#include <cmath>

#include "triangles/measures.hpp"

namespace geodesic {
namespace {

// Sum of two cotangents below zero, over that of 1 and their sizes, from which on an edge is
// flipped: no rounding must flip it back.
constexpr double kCotangentTolerance = 1e-10;

Index next(Index half) { return half % 3 == 2 ? half - 2 : half + 1; }
Index previous(Index half) { return half % 3 == 0 ? half + 2 : half - 1; }

// The stack of half-edges to check, each at most once.
class Waiting {
 public:
  explicit Waiting(Index n_halves) : stack_(n_halves), is_waiting_(n_halves, false) {}
  void push(Index half) {
    if (is_waiting_[half]) return;
    is_waiting_[half] = true;
    stack_[known_++] = half;
  }
  Index pop() {
    const Index half = stack_[--known_];
    is_waiting_[half] = false;
    return half;
  }
  bool empty() const { return known_ == 0; }

 private:
  Array<Index> stack_;
  Array<bool> is_waiting_;
  Index known_ = 0;
};

}  // namespace

Index flip_edges(std::span<Index> faces, std::span<double> length, std::span<Index> twin,
                 std::span<const bool> held, std::span<double> angles, std::span<double> scales) {
  const Index n_halves = count(faces);
  Waiting waiting(n_halves);
  for (Index face = 0; face < n_halves; face += 3) {  // opposite obtuse angles
    double squares[3];
    for (int c = 0; c < 3; ++c) squares[c] = length[face + c] * length[face + c];
    for (int c = 0; c < 3; ++c)
      if (squares[c] > squares[(c + 1) % 3] + squares[(c + 2) % 3] && twin[face + c] >= 0)
        waiting.push(face + c);
  }
  Index flips = 0;
  while (!waiting.empty()) {
    const Index half = waiting.pop(), mate = twin[half];
    if (mate < 0 || mate / 3 == half / 3) continue;
    const Index f = half - half % 3, g = mate - mate % 3;  // triangles abc and bad, c = apex of f
    const Index to_b = next(half), to_a = previous(half);  // opposite a and b in f: bc and ca
    const Index ad_half = next(mate), db_half = previous(mate);
    if (held[faces[to_b]] || held[faces[to_a]]) continue;
    const double ab = length[half], bc = length[to_b], ca = length[to_a];
    const double ad = length[ad_half], db = length[db_half];
    const double above = doubled_area(ab, bc, ca), below = doubled_area(ab, ad, db);
    // Twice the cotangents at c and d, times the doubled area of each triangle.
    const double at_c = (bc * bc + ca * ca - ab * ab) * below;
    const double at_d = (ad * ad + db * db - ab * ab) * above;
    if (!(at_c + at_d < -kCotangentTolerance * (above * below + std::abs(at_c) + std::abs(at_d))))
      continue;
    const double x = ((ca - bc) * (ca + bc) - (ad - db) * (ad + db)) / (2 * ab);
    const double y = (above + below) / ab;
    const double cd = std::sqrt(x * x + y * y);
    const Index a = faces[to_b], b = faces[to_a], c = faces[half], d = faces[mate];
    const Index old[4] = {ad_half, to_a, to_b, db_half};
    const Index moved[4] = {f, f + 2, g, g + 2};
    Index across[4];
    for (int side = 0; side < 4; ++side) {
      across[side] = twin[old[side]];
      for (int k = 0; k < 4; ++k)
        if (twin[old[side]] == old[k]) across[side] = moved[k];
    }
    double angle[4], scale[4];  // of the sides, if they are carried along
    if (!angles.empty())
      for (int side = 0; side < 4; ++side) {
        angle[side] = angles[old[side]];
        scale[side] = scales[old[side]];
      }
    const Index corners[6] = {c, a, d, d, b, c};
    const double lengths[6] = {ad, cd, ca, bc, cd, db};
    for (int k = 0; k < 3; ++k) {
      faces[f + k] = corners[k];
      faces[g + k] = corners[3 + k];
      length[f + k] = lengths[k];
      length[g + k] = lengths[3 + k];
    }
    for (int side = 0; side < 4; ++side) {
      twin[moved[side]] = across[side];
      if (across[side] < 0) continue;
      twin[across[side]] = moved[side];
      waiting.push(moved[side]);
    }
    twin[f + 1] = g + 1;
    twin[g + 1] = f + 1;
    if (!angles.empty()) {
      for (int side = 0; side < 4; ++side) {
        angles[moved[side]] = angle[side];
        scales[moved[side]] = scale[side];
      }
      scales[f + 1] = scales[g + 2];  // d to c, after d to b
      angles[f + 1] = angles[g + 2] + scales[g + 2] * angle_between(cd, db, bc);
      scales[g + 1] = scales[f + 2];  // c to d, after c to a
      angles[g + 1] = angles[f + 2] + scales[f + 2] * angle_between(ca, cd, ad);
    }
    ++flips;
  }
  return flips;
}

}  // namespace geodesic
