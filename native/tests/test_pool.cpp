// Memory that is used again.
#include <cstring>

#include "core/array.hpp"
#include "core/pool.hpp"
#include "core/threads.hpp"
#include "tests/check.hpp"

using namespace geodesic;

namespace {

constexpr std::size_t kPage = Pool::kPage, kLeast = Pool::kMinBlock;

// A block of a pool, filled with its own number.
struct Block {
  unsigned char* memory;
  std::size_t bytes;
  unsigned char number;

  Block(Pool& pool, std::size_t size, int its)
      : memory(static_cast<unsigned char*>(pool.take(size))),
        bytes(size),
        number(static_cast<unsigned char>(its)) {
    if (memory) std::memset(memory, number, bytes);
  }
  bool is_whole() const {
    return std::all_of(memory, memory + bytes, [&](unsigned char byte) { return byte == number; });
  }
};

bool has_pools() {
  Pool pool(0);
  void* const block = pool.take(kLeast);
  return block && pool.give_back(block, kLeast);
}

}  // namespace

TEST(sizes_that_are_not_for_a_pool_are_refused) {
  Pool pool(0);
  CHECK(pool.take(0) == nullptr && pool.take(kLeast - 1) == nullptr);
  CHECK(pool.take(Pool::kMaxBlock + 1) == nullptr);
  double elsewhere = 0;
  CHECK(!pool.give_back(&elsewhere, kLeast));
}

TEST(blocks_do_not_overlap_and_are_used_again) {
  if (!has_pools()) return;
  Pool pool(4 * kPage);
  std::vector<Block> blocks;
  std::uint64_t seed = 1;
  for (int round = 0; round < 2000; ++round) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    if (blocks.size() > 40 || (!blocks.empty() && seed >> 60 < 6)) {
      const std::size_t which = (seed >> 32) % blocks.size();
      CHECK(blocks[which].is_whole());
      CHECK(pool.give_back(blocks[which].memory, blocks[which].bytes));
      blocks.erase(blocks.begin() + static_cast<std::ptrdiff_t>(which));
    } else {
      blocks.emplace_back(pool, kLeast + (seed >> 20) % (seed >> 63 ? 5 * kPage : 9 * kLeast),
                          round);
      CHECK(reinterpret_cast<std::uintptr_t>(blocks.back().memory) % Pool::kUnit == 0);
    }
    CHECK(pool.idle() <= 4 * kPage && pool.idle() <= pool.held());
  }
  for (const Block& block : blocks) {
    CHECK(block.is_whole());
    CHECK(pool.give_back(block.memory, block.bytes));
  }
  CHECK(pool.held() == pool.idle());
  pool.trim();
  CHECK(pool.held() == 0);
}

TEST(the_lowest_place_that_fits_is_taken) {
  if (!has_pools()) return;
  Pool pool(kPage);
  void* const first = pool.take(kLeast);
  void* const second = pool.take(3 * kLeast);
  void* const third = pool.take(kLeast);
  CHECK(pool.held() == kPage);
  CHECK(pool.give_back(second, 3 * kLeast));
  CHECK(pool.take(4 * kLeast) > third);
  CHECK(pool.take(2 * kLeast) == second);
  CHECK(pool.give_back(first, kLeast) && pool.take(kLeast) == first);
}

TEST(the_end_of_a_block_can_be_given_back) {
  if (!has_pools()) return;
  Pool pool(0);
  char* const block = static_cast<char*>(pool.take(2 * kPage));
  CHECK(pool.held() == 2 * kPage);
  CHECK(pool.give_back(block + kLeast, 2 * kPage - kLeast));
  CHECK(pool.held() == kPage && pool.idle() == 0);
  CHECK(pool.take(kLeast) == block + kLeast);
}

TEST(a_full_arena_is_followed_by_another) {
  if (!has_pools()) return;
  Pool pool(0);
  std::vector<void*> blocks;
  for (int k = 0; k < 3; ++k) blocks.push_back(pool.take(Pool::kMaxBlock));
  CHECK(blocks[2] != nullptr);
  for (void* const block : blocks) CHECK(pool.give_back(block, Pool::kMaxBlock));
  CHECK(pool.held() == 0);
}

TEST(threads_share_a_pool) {
  if (!has_pools()) return;
  Pool pool(2 * kPage);
  std::atomic<Index> spoiled = 0;
  in_pieces(400, 1, 4, [&](Index k, Index) {
    const Block block(pool, kLeast + static_cast<std::size_t>(k) * 997, static_cast<int>(k));
    spoiled += !block.is_whole();
    pool.give_back(block.memory, block.bytes);
  });
  CHECK(spoiled == 0);
  CHECK(pool.held() == pool.idle());
}

TEST(arrays_that_are_shortened_keep_what_is_left) {
  for (const Index size : {100, 10'000, 3'000'000}) {
    for (const Index kept : {Index{0}, Index{7}, size / 2, size - 1, size}) {
      Array<double> array(size);
      for (Index i = 0; i < size; ++i) array[i] = static_cast<double>(i);
      array.shorten(kept);
      const Array<double> other(size, -1.0);
      CHECK(array.size() == kept);
      for (Index i = 0; i < kept; ++i) CHECK(array[i] == static_cast<double>(i));
    }
  }
}
