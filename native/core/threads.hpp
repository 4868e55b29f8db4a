// Work that several threads share.
#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "array.hpp"

namespace geodesic {

// Do work(begin, end) for pieces of [0, count) on up to `n_threads`, each piece once.
//
// What a piece does may not depend on the others, so that results are the same for any number of
// threads. The first exception of a piece is thrown again when all threads have ended.
template <class Work>
void in_pieces(Index count, Index piece, int n_threads, Work work) {
  const Index pieces = (count + piece - 1) / piece;
  std::atomic<Index> next = 0;
  std::exception_ptr failure;
  std::mutex mutex;
  const auto take = [&] {
    try {
      for (Index k; (k = next++) < pieces;) work(k * piece, std::min(count, (k + 1) * piece));
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
      next = pieces;
    }
  };
  std::vector<std::thread> helpers;
  const Index others = std::min<Index>(n_threads, pieces) - 1;
  for (Index t = 0; t < others; ++t) helpers.emplace_back(take);
  take();
  for (std::thread& helper : helpers) helper.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace geodesic
