// Rows of a sparse table: from each of several sets of sources the vertices near it.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "core/array.hpp"

namespace geodesic {

// The vertices of row k are those from begins[k] to begins[k + 1], ascending, and their distances.
struct NearRows {
  Array<Index> begins;
  Array<Index> vertices;
  Array<double> distances;
};

// Some rows that follow each other, as they are found.
class NearPiece {
 public:
  using Entry = std::pair<Index, double>;

  void add(Index vertex, double distance) { entries_.emplace_back(vertex, distance); }
  // What was added since the last row is the next one, each vertex once.
  void end_row() {
    const auto first = entries_.begin() + (ends_.empty() ? 0 : ends_.back());
    std::sort(first, entries_.end());
    entries_.erase(std::unique(first, entries_.end()), entries_.end());
    ends_.push_back(static_cast<Index>(entries_.size()));
  }

  const std::vector<Entry>& entries() const { return entries_; }
  const std::vector<Index>& ends() const { return ends_; }

 private:
  std::vector<Entry> entries_;
  std::vector<Index> ends_;
};

inline NearRows together(const std::vector<NearPiece>& pieces) {
  std::size_t n_rows = 0, n_entries = 0;
  for (const NearPiece& piece : pieces)
    n_rows += piece.ends().size(), n_entries += piece.entries().size();
  NearRows rows{Array<Index>(static_cast<Index>(n_rows) + 1),
                Array<Index>(static_cast<Index>(n_entries)),
                Array<double>(static_cast<Index>(n_entries))};
  Index row = 0, entry = 0;
  rows.begins[0] = 0;
  for (const NearPiece& piece : pieces) {
    const Index first = entry;
    for (const Index end : piece.ends()) rows.begins[++row] = first + end;
    for (const auto& [vertex, distance] : piece.entries())
      rows.vertices[entry] = vertex, rows.distances[entry++] = distance;
  }
  return rows;
}

}  // namespace geodesic
