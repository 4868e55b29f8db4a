#include "core/array.hpp"

#include <algorithm>
#include <cstdint>
#include <new>

#include "core/pool.hpp"

#if defined(__linux__)
#include <sys/mman.h>
#endif

#if defined(__has_feature)
#define GT_HAS_FEATURE(name) __has_feature(name)
#else
#define GT_HAS_FEATURE(name) 0
#endif

namespace geodesic {
namespace {

// Sanitizers see the ends of what they allocate themselves.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || \
    GT_HAS_FEATURE(address_sanitizer) || GT_HAS_FEATURE(thread_sanitizer)
constexpr bool kPooled = false;
#else
constexpr bool kPooled = true;
#endif

constexpr std::size_t kLine = 64;  // a cache's; kernels load registers from the beginning of one

void ask_for_large_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__)
  constexpr std::uintptr_t kPage = Pool::kUnit;
  if (bytes < 2 * Pool::kPage) return;
  const auto first = reinterpret_cast<std::uintptr_t>(memory);
  const auto begin = (first + kPage - 1) / kPage * kPage, end = (first + bytes) / kPage * kPage;
  madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
#endif
}

// Whole pages pay for what is read often: a solve takes 0.75 to 0.9 of the time. In pools all are.
std::size_t unit_of(std::size_t bytes) { return bytes > Pool::kMaxBlock ? Pool::kPage : kLine; }

}  // namespace

void* allocate(std::size_t bytes) {
  if constexpr (kPooled)
    if (void* const memory = Pool::shared().take(bytes)) return memory;
  const std::size_t unit = unit_of(bytes), whole = (bytes / unit + 1) * unit;
  void* const memory = ::operator new(whole, std::align_val_t{unit});
  ask_for_large_pages(memory, whole);
  return memory;
}

void release(void* memory, std::size_t bytes) noexcept {
  if constexpr (kPooled)
    if (bytes >= Pool::kMinBlock && Pool::shared().give_back(memory, bytes)) return;
  ::operator delete(memory, std::align_val_t{unit_of(bytes)});
}

std::size_t release_rest(void* memory, std::size_t bytes, std::size_t needed) noexcept {
  if (!kPooled || bytes < Pool::kMinBlock) return bytes;
  const std::size_t kept =
      (std::max(needed, Pool::kMinBlock) + Pool::kUnit - 1) / Pool::kUnit * Pool::kUnit;
  if (kept >= bytes || !Pool::shared().give_back(static_cast<char*>(memory) + kept, bytes - kept))
    return bytes;
  return kept;
}

}  // namespace geodesic
