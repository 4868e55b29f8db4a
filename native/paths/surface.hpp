// Triangles around vertices and at edges, of a mesh or of a soup: any number may meet at an edge.
#pragma once

#include <complex>
#include <span>
#include <utility>
#include <vector>

#include "core/array.hpp"

namespace geodesic {

using Planar = std::complex<double>;

inline double cross(Planar p, Planar q) { return p.real() * q.imag() - p.imag() * q.real(); }

class Surface {
 public:
  // Positions, (N, 3), and faces, (F, 3), each with three different vertices.
  Surface(std::span<const double> places, std::span<const Index> faces);

  Index n_vertices() const { return starts_.size() - 1; }
  Index n_faces() const { return count(faces_) / 3; }
  std::span<const Index> faces() const { return faces_; }
  const Index* corners(Index face) const { return &faces_[3 * face]; }
  std::span<const Index> around(Index vertex) const {
    return {around_.data() + starts_[vertex], around_.data() + starts_[vertex + 1]};
  }
  bool has(Index face, Index vertex) const {
    const Index* const c = corners(face);
    return c[0] == vertex || c[1] == vertex || c[2] == vertex;
  }
  std::vector<Index> at_edge(Index a, Index b) const;
  // The corner of a face beside two others.
  Index third(Index face, Index a, Index b) const;
  // The two corners of a face beside one.
  std::pair<Index, Index> others(Index face, Index vertex) const;

  const double* place(Index vertex) const { return &places_[3 * vertex]; }
  double length(Index a, Index b) const;
  // Where c lies, on the left, in the plane in which a is at 0 and b at 1.
  Planar shape(Index a, Index b, Index c) const;
  double angle(Index face, Index vertex) const;
  // Of all faces there together; kept, by threads that may share the surface.
  double total_angle(Index vertex) const;

  // Faces around a vertex from one to another, each sharing an edge with the next; none where they
  // do not hang together there.
  std::vector<Index> chain(Index first, Index last, Index vertex) const;
  // The faces around a vertex in order; none where they make no single ring.
  std::vector<Index> ring(Index vertex, Index first) const;
  // How weights on the corners change along minus the gradient of a linear function of them; false
  // where it has none.
  bool descent(const Index (&corners)[3], std::span<const double> height, double (&rates)[3]) const;

 private:
  std::span<const double> places_;
  std::span<const Index> faces_;
  Array<Index> starts_, around_;
  mutable Array<double> total_angles_;  // less than 0 where it has not been computed
};

}  // namespace geodesic
