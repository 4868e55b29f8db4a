// What is asked of the processor by name.
#pragma once

#include "half.hpp"  // says whether there is SSE

namespace geodesic {

// Ask for the memory around a place, which is to be read soon, without waiting for it. The place
// may lie behind the end of an array.
inline void prefetch(const void* place) {
#if defined(GT_SSE)
  _mm_prefetch(static_cast<const char*>(place), _MM_HINT_T0);
#elif defined(__GNUC__) || defined(__clang__)
  __builtin_prefetch(place);
#else
  (void)place;
#endif
}

// Takes numbers below the smallest normal one for zero while it lives, in this thread.
//
// Heat, and the entries of its factor, leave the range of normal numbers between the ends of a
// large shape, and x86 processors take a hundred times as long for what is smaller.
class FlushSubnormals {
 public:
#if defined(GT_SSE)
  FlushSubnormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | kZeros); }
  ~FlushSubnormals() { _mm_setcsr(before_); }

 private:
  static constexpr unsigned kZeros = 1u << 15 | 1u << 6;  // results, and what is read
  unsigned before_;
#else
  FlushSubnormals() {}
#endif
 public:
  FlushSubnormals(const FlushSubnormals&) = delete;
  FlushSubnormals& operator=(const FlushSubnormals&) = delete;
};

}  // namespace geodesic
