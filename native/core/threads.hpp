// Work that several threads share.
#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

#include "array.hpp"

namespace geodesic {

// Do work(begin, end) for pieces of [0, count) on up to `n_threads`, each piece once.
//
// A piece may not depend on the others, so that results are the same for any number of threads. The
// first exception of a piece is thrown again when all threads have ended. Where the system has no
// more threads, those that it has do all of the work.
template <class Thread = std::thread, class Work>
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
  const Index others = std::max<Index>(std::min<Index>(n_threads, pieces) - 1, 0);
  std::vector<Thread> helpers;
  helpers.reserve(static_cast<std::size_t>(others));  // so that nothing but a start can fail below
  try {
    while (static_cast<Index>(helpers.size()) < others) helpers.emplace_back(take);
  } catch (const std::system_error&) {
    // A thread that has begun must be waited for: the exception may not leave here.
  } catch (const std::bad_alloc&) {
    // As above: a thread needs a little memory to begin.
  }
  take();
  for (Thread& helper : helpers) helper.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace geodesic
