// The base of all kernels: threads, halves, registers, workspace.
#include <cmath>
#include <stdexcept>
#include <system_error>

#include "core/threads.hpp"
#include "core/vectors.hpp"
#include "core/workspace.hpp"
#include "tests/check.hpp"
#include "tests/examples.hpp"

using namespace geodesic;
using namespace geodesic::testing;

namespace {

// Threads of which the system has two, and no more.
struct Scarce : std::thread {
  static inline int started = 0;
  template <class Work>
  explicit Scarce(Work work) : std::thread(more_or_throw(work)) {}

 private:
  template <class Work>
  static Work more_or_throw(Work work) {
    if (started == 2)
      throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
    ++started;
    return work;
  }
};

}  // namespace

TEST(every_piece_is_worked_on_once) {
  for (const Index count : {0, 1, 5, 64, 1000}) {
    for (const Index piece : {1, 3, 64, 2000}) {
      for (const int n_threads : {0, 1, 2, 7}) {
        std::vector<int> visits(count, 0);
        in_pieces(count, piece, n_threads, [&](Index begin, Index end) {
          for (Index i = begin; i < end; ++i) ++visits[i];
        });
        CHECK(std::all_of(visits.begin(), visits.end(), [](int times) { return times == 1; }));
      }
    }
  }
}

TEST(an_exception_in_a_piece_comes_out) {
  for (const int n_threads : {1, 2, 5}) {
    std::atomic<Index> done = 0;
    const std::string message = message_of<std::runtime_error>([&] {
      in_pieces(1000, 1, n_threads, [&](Index begin, Index) {
        if (begin == 10) throw std::runtime_error("the tenth piece");
        ++done;
      });
    });
    CHECK(message == "the tenth piece");
    CHECK(done < 1000);
  }
}

TEST(work_is_done_when_threads_cannot_be_started) {
  Scarce::started = 0;
  std::atomic<Index> done = 0;
  in_pieces<Scarce>(100, 1, 8, [&](Index begin, Index end) { done += end - begin; });
  CHECK(done == 100);
  CHECK(Scarce::started == 2);
}

TEST(halves_round_to_twenty_bits) {
  for (const double value : {0.0, 1.0, -1.0, 0.1, 1e-290, -3e290}) {
    const double half = Half(value);
    CHECK(std::abs(half - value) <= std::ldexp(std::abs(value), -21), std::to_string(value));
  }
}

TEST(registers_do_not_touch_what_lies_behind) {
  for (int count = 1; count <= kLanes; ++count) {
    const std::vector<double> from = random_numbers(count, 1);
    std::vector<double> to(count, -1.0);
    const First first(count);
    first.store(to.data(), first.load(from.data()) + first.load(from.data()));
    for (int i = 0; i < count; ++i) CHECK(to[i] == 2 * from[i]);
  }
}

TEST(packs_of_every_width_load_add_and_sum) {
  const auto check_width = []<int N>(std::integral_constant<int, N>) {
    const std::vector<double> numbers = random_numbers(N, 2);
    std::vector<Half> halves;
    for (const double number : numbers) halves.emplace_back(number);
    std::vector<double> stored(N);
    const auto whole = Pack<N>::load(numbers.data()), half = Pack<N>::load(halves.data());
    const auto spread = Pack<N>::spread_from(halves.data());
    (whole * spread - half).store(stored.data());
    double sum = 0.0;
    for (int i = 0; i < N; ++i) {
      sum += numbers[i];
      CHECK(std::abs(stored[i] - (numbers[i] * halves[0] - halves[i])) < 1e-15);
      CHECK(half[i] == double(halves[i]) && spread[i] == double(halves[0]));
      CHECK(choose(spread, whole, whole, half)[i] ==
            (numbers[i] > double(halves[0]) ? numbers[i] : double(halves[i])));
    }
    CHECK(std::abs(whole.sum() - sum) < 1e-14);
  };
  check_width(std::integral_constant<int, 2>{});
  check_width(std::integral_constant<int, 4>{});
  check_width(std::integral_constant<int, 8>{});
  check_width(std::integral_constant<int, 16>{});
}

TEST(workspace_is_kept_and_belongs_to_one_at_a_time) {
  for (const Index size : {0, 10, 100000, 20}) {
    Workspace one(size), other(size);
    CHECK(size == 0 || one.data() != other.data());
    std::fill_n(one.data(), size, 1.0);
    std::fill_n(other.data(), size, 2.0);
  }
}
