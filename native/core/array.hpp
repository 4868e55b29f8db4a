// Arrays of a size that does not change, and the integers that count and index.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace geodesic {

using Index = std::int64_t;  // of a face, a corner, a number in an array of any length
using Row = std::int32_t;    // of a row or an entry of a sparse matrix: half of the memory

inline constexpr Row kNone = -1;

// `kWhole` begins and ends with a page of 2 MB, for what is read often: it costs more to come by,
// and a solve takes 0.75 to 0.9 of the time.
enum class Pages : std::size_t { kAny = 64, kWhole = std::size_t{1} << 21 };

// Numbers in memory that it owns, in which anything may stand at first. The system is asked for
// large pages.
template <class T>
class Array {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Array() = default;
  explicit Array(Index size, Pages pages = Pages::kAny)
      : size_(size), data_(allocate(size, pages)) {}
  Array(Index size, T value) : Array(size) { std::fill(begin(), end(), value); }

  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  Index size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T& operator[](Index i) { return data_.get()[i]; }
  const T& operator[](Index i) const { return data_.get()[i]; }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }

  operator std::span<T>() { return {data(), static_cast<std::size_t>(size_)}; }
  operator std::span<const T>() const { return {data(), static_cast<std::size_t>(size_)}; }

  // Forget what lies behind; the memory stays.
  void shorten(Index size) { size_ = size; }

 private:
  struct Free {
    std::align_val_t alignment{};
    void operator()(T* memory) const { ::operator delete(memory, alignment); }
  };
  using Owner = std::unique_ptr<T, Free>;
  static constexpr std::size_t kLarge = std::size_t{1} << 22;  // bytes worth large pages

  static Owner allocate(Index size, Pages pages) {
    std::size_t bytes = static_cast<std::size_t>(size) * sizeof(T);
    const auto unit = static_cast<std::size_t>(bytes < kLarge ? Pages::kAny : pages);
    bytes = (bytes + unit) / unit * unit;
    void* const memory = ::operator new(bytes, std::align_val_t{unit});
#if defined(__linux__)
    if (bytes >= kLarge) {
      constexpr std::uintptr_t kPage = 4096;
      const auto begin = (reinterpret_cast<std::uintptr_t>(memory) + kPage - 1) / kPage * kPage;
      const auto end = (reinterpret_cast<std::uintptr_t>(memory) + bytes) / kPage * kPage;
      madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
    }
#endif
    return Owner(static_cast<T*>(memory), Free{std::align_val_t{unit}});
  }

  Index size_ = 0;
  Owner data_;
};

// The size of a span as a signed number.
template <class T>
Index count(std::span<T> values) {
  return static_cast<Index>(values.size());
}

}  // namespace geodesic
