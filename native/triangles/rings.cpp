#include "triangles/rings.hpp"

#include "core/processor.hpp"

namespace geodesic {
namespace {

constexpr Index kPrefetchDistance = 4;  // vertices of prefetch distance
constexpr Index kAtOnce = 8;            // neighbours that are copied at once, whether they count

// Put `other` into a list of `n` vertices unless it was met at v; return how many are in the list.
// Without a branch, which processors would guess wrong for every third neighbour.
inline Index meet(Row other, Row v, Row* met_at, Row* list, Index n) {
  list[n] = other;
  n += met_at[other] != v;
  met_at[other] = v;
  return n;
}

// The other two vertices of a face.
struct Others {
  Row a, b;
};

}  // namespace

Rings::Rings(std::span<const Index> faces, Index n)
    : starts_(n + 1), near_(2 * count(faces) + kAtOnce), is_inside_(n) {
  Array<Row> begins(n + 1, 0), met_at(n, kNone);
  Array<Others> others(count(faces));
  for (const Index v : faces) ++begins[v];
  for (Index v = 1; v < n; ++v) begins[v] += begins[v - 1];
  begins[n] = static_cast<Row>(count(faces));
  for (Index f = count(faces) - 3; f >= 0; f -= 3) {  // leaves where those of each vertex begin
    const Row a = static_cast<Row>(faces[f]), b = static_cast<Row>(faces[f + 1]),
              c = static_cast<Row>(faces[f + 2]);
    others[--begins[a]] = {b, c};
    others[--begins[b]] = {c, a};
    others[--begins[c]] = {a, b};
  }
  Row n_near = starts_[0] = 0;
  for (Index v = 0; v < n; ++v) {
    const Row own = static_cast<Row>(v);
    met_at[v] = own;
    for (Row place = begins[v]; place < begins[v + 1]; ++place)
      for (const Row other : {others[place].a, others[place].b})
        n_near = static_cast<Row>(meet(other, own, met_at.data(), near_.data(), n_near));
    starts_[v + 1] = n_near;
    is_inside_[v] = size(v) <= begins[v + 1] - begins[v];
  }
  std::fill_n(&near_[n_near], kAtOnce, 0);
}

TwoRings::TwoRings(const Rings& rings)
    : rings_(rings),
      met_at_(rings.n_vertices(), kNone),
      all_((Rings::kMostNeighbours + 1) * (Rings::kMostNeighbours + kAtOnce)),
      both_(all_.size()) {}

std::span<const Row> TwoRings::of(Index v) {
  if (v + kPrefetchDistance < rings_.n_vertices())
    for (const Row soon : rings_.of(v + kPrefetchDistance)) prefetch(rings_.of(soon).data());
  const std::span<const Row> near = rings_.of(v);
  if (!rings_.is_inside(v) || count(near) > Rings::kMostNeighbours) return {};
  Index n_all = 0;
  const auto take = [&](std::span<const Row> ring) {
    if (count(ring) > Rings::kMostNeighbours) return;
    for (Index k = 0; k < count(ring); k += kAtOnce)
      std::copy_n(ring.data() + k, kAtOnce, &all_[n_all + k]);
    n_all += count(ring);
  };
  take(near);
  for (const Row one : near) take(rings_.of(one));
  const Row own = static_cast<Row>(v);
  met_at_[v] = own;
  Index n = 0;
  for (Index k = 0; k < n_all; ++k) n = meet(all_[k], own, met_at_.data(), both_.data(), n);
  return {both_.data(), static_cast<std::size_t>(n)};
}

}  // namespace geodesic
