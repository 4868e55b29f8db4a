#include "core/pool.hpp"

#include <algorithm>
#include <bit>

#if defined(__linux__)
#include <pthread.h>
#include <sys/mman.h>
#endif

namespace geodesic {
namespace {

constexpr std::size_t kMaxIdleBytes =
    std::size_t{1} << 24;  // of the shared pool; times are the same from 8 to 64 MB

constexpr std::size_t kUnits = Pool::kArena / Pool::kUnit, kPages = Pool::kArena / Pool::kPage;
constexpr std::size_t kWord = 64;  // units of a word of the bit set
constexpr std::size_t kWordsOfPage = Pool::kPage / Pool::kUnit / kWord;

std::size_t units_of(std::size_t bytes) { return (bytes + Pool::kUnit - 1) / Pool::kUnit; }

}  // namespace

// A bit for each unit marks it as taken, and a bit for each large page marks it as touched since
// the system gave it.
struct Pool::Arena {
  char *begin, *mapped;
  std::size_t n_free = kUnits;
  std::uint64_t taken[kUnits / kWord] = {};
  std::bitset<kPages> touched;

  // The first unit from `unit` on that is taken, or is not.
  std::size_t next(std::size_t unit, bool is_taken) const {
    while (unit < kUnits) {
      const std::uint64_t word = taken[unit / kWord] ^ (is_taken ? 0 : ~std::uint64_t{0});
      const std::uint64_t rest = word >> unit % kWord;
      if (rest) return unit + static_cast<std::size_t>(std::countr_zero(rest));
      unit = (unit / kWord + 1) * kWord;
    }
    return kUnits;
  }

  // The first of so many units that are free, or none: kUnits.
  std::size_t find(std::size_t count) const {
    for (std::size_t unit = next(0, false); unit + count <= kUnits;) {
      const std::size_t end = next(unit, true);
      if (end - unit >= count) return unit;
      unit = next(end, false);
    }
    return kUnits;
  }

  void mark(std::size_t unit, std::size_t count, bool is_taken) {
    for (const std::size_t end = unit + count; unit < end;) {
      const std::size_t until = std::min(end, (unit / kWord + 1) * kWord);
      const std::uint64_t bits = ~std::uint64_t{0} >> (kWord - (until - unit)) << unit % kWord;
      if (is_taken)
        taken[unit / kWord] |= bits;
      else
        taken[unit / kWord] &= ~bits;
      unit = until;
    }
    n_free = is_taken ? n_free - count : n_free + count;
  }

  bool is_empty(std::size_t page) const {
    const std::uint64_t* const first = taken + page * kWordsOfPage;
    return std::all_of(first, first + kWordsOfPage, [](std::uint64_t word) { return word == 0; });
  }

  // Large pages that are touched and have nothing in them, of those that some units lie in.
  std::size_t count_idle(std::size_t unit, std::size_t count) const {
    std::size_t idle = 0;
    for (std::size_t page = unit / (kPage / kUnit); page * (kPage / kUnit) < unit + count; ++page)
      idle += touched[page] && is_empty(page);
    return idle;
  }
};

Pool::Pool(std::size_t most_idle) : most_idle_(most_idle) {}

#if defined(__linux__)

Pool& Pool::shared() {
  static Pool* const the_one = [] {
    static Pool* pool = new Pool(kMaxIdleBytes);
    // A child that is forked while another thread is here must find the lock open.
    pthread_atfork([] { pool->mutex_.lock(); }, [] { pool->mutex_.unlock(); },
                   [] { pool->mutex_.unlock(); });
    return pool;
  }();
  return *the_one;
}

Pool::~Pool() {
  for (const auto& arena : arenas_) munmap(arena->mapped, kArena + kPage);
}

bool Pool::add_arena() {
  void* const memory = mmap(nullptr, kArena + kPage, PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) return false;
  auto arena = std::make_unique<Arena>();
  arena->mapped = static_cast<char*>(memory);
  arena->begin = arena->mapped + (kPage - reinterpret_cast<std::uintptr_t>(memory) % kPage) % kPage;
  madvise(arena->begin, kArena,
          MADV_HUGEPAGE);  // refused by some systems: small pages serve as well
  arenas_.push_back(std::move(arena));
  return true;
}

// The last ones first: blocks are looked for from the beginning.
void Pool::release(Arena& arena, std::size_t most_idle) noexcept {
  for (std::size_t page = kPages; page-- > 0 && idle_ > most_idle;) {
    if (!arena.touched[page] || !arena.is_empty(page)) continue;
    madvise(arena.begin + page * kPage, kPage, MADV_DONTNEED);
    arena.touched[page] = false;
    idle_ -= kPage;
    held_ -= kPage;
  }
}

#else

Pool& Pool::shared() {
  static Pool* const the_one = new Pool(kMaxIdleBytes);
  return *the_one;
}
Pool::~Pool() = default;
bool Pool::add_arena() { return false; }
void Pool::release(Arena&, std::size_t) noexcept {}

#endif

void* Pool::take(std::size_t bytes) {
  if (bytes < kMinBlock || bytes > kMaxBlock) return nullptr;
  const std::size_t count = units_of(bytes);
  const std::lock_guard lock(mutex_);
  for (std::size_t a = 0; a < arenas_.size() || add_arena(); ++a) {
    Arena& arena = *arenas_[a];
    const std::size_t unit = arena.n_free < count ? kUnits : arena.find(count);
    if (unit == kUnits) continue;
    idle_ -= kPage * arena.count_idle(unit, count);
    arena.mark(unit, count, true);
    for (std::size_t page = unit * kUnit / kPage; page * kPage < (unit + count) * kUnit; ++page) {
      held_ += arena.touched[page] ? 0 : kPage;
      arena.touched[page] = true;
    }
    return arena.begin + unit * kUnit;
  }
  return nullptr;
}

bool Pool::give_back(void* block, std::size_t bytes) noexcept {
  const std::lock_guard lock(mutex_);
  const auto place = reinterpret_cast<std::uintptr_t>(block);
  for (const auto& arena : arenas_) {
    const std::uintptr_t from = place - reinterpret_cast<std::uintptr_t>(arena->begin);
    if (from >= kArena) continue;
    const std::size_t unit = units_of(from), end = units_of(from + bytes);
    arena->mark(unit, end - unit, false);
    idle_ += kPage * arena->count_idle(unit, end - unit);
    if (idle_ > most_idle_) release(*arena, most_idle_);
    return true;
  }
  return false;
}

void Pool::trim() noexcept {
  const std::lock_guard lock(mutex_);
  for (const auto& arena : arenas_) release(*arena, 0);
}

std::size_t Pool::held() const {
  const std::lock_guard lock(mutex_);
  return held_;
}

std::size_t Pool::idle() const {
  const std::lock_guard lock(mutex_);
  return idle_;
}

}  // namespace geodesic
