// Memory for arrays in large pages, which are used again.
//
// The system hands out memory with a fault for every page that is touched first, and in pages of
// 4 kB these are a third of a build. A page of 2 MB costs as much as a hundred of them and holds
// five hundred. Allocators ask for none, and give large blocks back at once, so that the next array
// of the same build pays again.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace geodesic {

// Blocks of `kUnit` out of arenas of 64 MB, the lowest that fits, so that what is in use stays
// together. A large page in which nothing is left waits for the next block, up to `most_idle`
// bytes of them; the system gets the others back. Of all threads.
class Pool {
 public:
  static constexpr std::size_t kUnit = std::size_t{1} << 12;   // a page as systems have them
  static constexpr std::size_t kPage = std::size_t{1} << 21;   // and a large one
  static constexpr std::size_t kArena = std::size_t{1} << 26;  // address space; memory comes later
  // Sizes of blocks: units would waste a good part of less, and more is seldom asked for.
  static constexpr std::size_t kMinBlock = std::size_t{1} << 14, kMaxBlock = std::size_t{1} << 25;

  explicit Pool(std::size_t most_idle);
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  // The one that arrays come from. It is never destroyed: some outlive everything else.
  static Pool& shared();

  // A block at the beginning of a unit, in which anything may stand; none where the system has no
  // such memory, or the size is not one for a pool.
  void* take(std::size_t bytes);
  // Take a block back that came from here, or its end, as far as that is whole units. Return false
  // if it came from elsewhere.
  bool give_back(void* block, std::size_t bytes) noexcept;

  // Give the system everything in which nothing is left.
  void trim() noexcept;

  // Bytes of large pages that have been touched, and of those in which nothing is left.
  std::size_t held() const;
  std::size_t idle() const;

 private:
  struct Arena;

  bool add_arena();
  void release(Arena& arena, std::size_t most_idle) noexcept;

  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Arena>> arenas_;
  std::size_t most_idle_, held_ = 0, idle_ = 0;
};

}  // namespace geodesic
