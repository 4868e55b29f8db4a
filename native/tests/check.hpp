// Tests of kernels without Python: a registry, and checks that go on after what failed.
//
//     TEST(a_sentence_that_is_true) { CHECK(1 + 1 == 2); }
//
// in any file test_*.cpp of this folder is a test, and self_test.cpp runs them all.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace geodesic::testing {

struct Test {
  const char* name;
  void (*run)();
};

inline std::vector<Test>& all_tests() {
  static std::vector<Test> the_tests;
  return the_tests;
}

inline int& n_failed_checks() {
  static int the_number = 0;
  return the_number;
}

struct Registration {
  Registration(const char* name, void (*run)()) { all_tests().push_back({name, run}); }
};

// Not for threads: they hand their results to the test.
inline void check(bool holds, const char* what, const char* file, int line,
                  const std::string& where = {}) {
  if (holds) return;
  ++n_failed_checks();
  std::printf("  %s:%d: not so: %s%s%s\n", file, line, what, where.empty() ? "" : ", with ",
              where.c_str());
}

// True if `work` throws an `Error`, and what it says.
template <class Error, class Work>
std::string message_of(Work work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

}  // namespace geodesic::testing

#define TEST(name)                                                              \
  static void name();                                                           \
  static const geodesic::testing::Registration name##_registered(#name, &name); \
  static void name()
// CHECK(what holds), or CHECK(what holds, of which case, as a string).
#define CHECK(condition, ...) \
  geodesic::testing::check((condition), #condition, __FILE__, __LINE__ __VA_OPT__(, ) __VA_ARGS__)
