#include "workspace.hpp"

#include <mutex>

namespace geodesic {
namespace {

// The largest workspace, in numbers, that is kept for the next solve.
constexpr Index kMaxKeptNumbers = Index{1} << 24;

struct Kept {
  std::mutex mutex;
  Array<double> memory;
};
Kept& kept() {
  static Kept the_one;
  return the_one;
}

}  // namespace

Workspace::Workspace(Index size) {
  {
    const std::lock_guard lock(kept().mutex);
    memory_ = std::exchange(kept().memory, {});
  }
  if (memory_.size() < size) memory_ = Array<double>(size);
}

Workspace::~Workspace() {
  const std::lock_guard lock(kept().mutex);
  if (memory_.size() <= kMaxKeptNumbers && memory_.size() > kept().memory.size())
    kept().memory = std::move(memory_);
}

}  // namespace geodesic
