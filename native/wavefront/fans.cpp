#include "wavefront/fans.hpp"

#include <cmath>
#include <limits>

namespace geodesic {
namespace {

// Share of a length by which two triangles may differ about it and have the edge as one spoke: much
// more than rounding, and less than any two stars of a cloud.
constexpr double kLengthTolerance = 1e-12;

// Writes the fans of one vertex after the other; or only counts them, where there is no workspace.
class Writer {
 public:
  explicit Writer(Fan* fans) : fans_(fans) {}

  Row count() const { return count_; }

  void begin(std::uint32_t vertex) {
    vertex_ = vertex;
    used_ = 0;
  }

  void add(const Corner& corner) {
    if (used_ == 0 || corner.a != last_ ||
        std::abs(corner.to_a - to_last_) > kLengthTolerance * to_last_) {
      if (used_ == 0 || used_ > kSpokes - 2) open();
      put(corner.a, corner.to_a);
      if (used_ == 1) {
        first_ = corner.a;
        to_first_ = corner.to_a;
      }
    } else if (used_ == kSpokes && !closes(corner)) {
      open();
      put(corner.a, corner.to_a);
      first_ = corner.a;
      to_first_ = corner.to_a;
    }
    if (fans_) fans_[count_ - 1].edge[used_ - 1] = corner.edge;
    if (used_ == kSpokes) {
      used_ = 0;  // full, and closed
      return;
    }
    put(corner.b, corner.to_b);
  }

 private:
  bool closes(const Corner& corner) const {
    return corner.b == first_ && std::abs(corner.to_b - to_first_) <= kLengthTolerance * to_first_;
  }

  void open() {
    ++count_;
    used_ = 0;
    if (!fans_) return;
    Fan& fan = fans_[count_ - 1];
    std::fill_n(fan.to, kSpokes, std::numeric_limits<double>::infinity());
    std::fill_n(fan.edge, kSpokes, std::numeric_limits<double>::quiet_NaN());
    std::fill_n(fan.neighbour, kSpokes, vertex_);
  }

  void put(std::uint32_t neighbour, double length) {
    last_ = neighbour;
    to_last_ = length;
    if (fans_) {
      fans_[count_ - 1].neighbour[used_] = neighbour;
      fans_[count_ - 1].to[used_] = length;
    }
    ++used_;
  }

  Fan* fans_;
  Row count_ = 0;
  int used_ = 0;  // spokes of the last fan
  std::uint32_t vertex_ = 0, first_ = 0, last_ = 0;
  double to_first_ = 0.0, to_last_ = 0.0;
};

}  // namespace

Fans fans_of(const Corners& corners) {
  const Index n = corners.n_vertices();
  Fans result{Array<Row>(n + 1), Array<Row>(n), {}};
  const auto write = [&](Fan* fans) {
    Writer writer(fans);
    for (Index v = 0; v < n; ++v) {
      result.starts[v] = writer.count();
      writer.begin(static_cast<std::uint32_t>(v));
      for (Row c = corners.starts[v]; c < corners.ends[v]; ++c) writer.add(corners.around[c]);
      result.ends[v] = writer.count();
      writer.begin(static_cast<std::uint32_t>(v));
      for (Row c = corners.ends[v]; c < corners.starts[v + 1]; ++c) writer.add(corners.around[c]);
    }
    result.starts[n] = writer.count();
  };
  write(nullptr);
  result.fans = Array<Fan>(result.starts[n] + 1);
  result.fans[result.starts[n]] = Fan{};
  write(result.fans.data());
  return result;
}

}  // namespace geodesic
