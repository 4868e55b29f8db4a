// Arrays of a size that does not change, and the integers that count and index.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>

namespace geodesic {

using Index = std::int64_t;  // of a face, a corner, a number in an array of any length
using Row = std::int32_t;    // of a row or an entry of a sparse matrix: half of the memory

inline constexpr Row kNone = -1;

// Memory for an array: from the pool if it is of a size for that, or else from the system, which is
// asked for large pages.
void* allocate(std::size_t bytes);
void release(void* memory, std::size_t bytes) noexcept;
// Release what lies behind, as far as that is possible; return the bytes to release in the end.
std::size_t release_rest(void* memory, std::size_t bytes, std::size_t needed) noexcept;

// An array that owns its memory, with undefined initial values.
template <class T>
class Array {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Array() = default;
  explicit Array(Index size) : size_(size) {
    const std::size_t bytes = bytes_of(size);
    data_ = Owner(static_cast<T*>(allocate(bytes)), Free{bytes});
  }
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

  // Forget what lies behind.
  void shorten(Index size) {
    size_ = size;
    std::size_t& bytes = data_.get_deleter().bytes;
    bytes = release_rest(data_.get(), bytes, bytes_of(size));
  }

 private:
  struct Free {
    std::size_t bytes = 0;
    void operator()(T* memory) const { release(memory, bytes); }
  };
  using Owner = std::unique_ptr<T, Free>;

  static std::size_t bytes_of(Index size) { return static_cast<std::size_t>(size) * sizeof(T); }

  Index size_ = 0;
  Owner data_;
};

// The size of a span as a signed number.
template <class T>
Index count(std::span<T> values) {
  return static_cast<Index>(values.size());
}

}  // namespace geodesic
