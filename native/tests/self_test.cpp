// Runs the tests of this folder: for sanitizers and for processors without Python.
//
// An argument chooses the tests that have it in their names. The exit status is 1 where one fails.
#include <cstring>
#include <exception>

#include "core/vectors.hpp"
#include "tests/check.hpp"

namespace {

using namespace geodesic::testing;

bool passes(const Test& test) {
  const int before = n_failed_checks();
  try {
    test.run();
  } catch (const std::exception& error) {
    check(false, error.what(), test.name, 0);
  }
  return n_failed_checks() == before;
}

}  // namespace

int main(int n_arguments, char** arguments) {
  int n_run = 0, n_failed = 0;
  for (const Test& test : all_tests()) {
    if (n_arguments > 1 && !std::strstr(test.name, arguments[1])) continue;
    ++n_run;
    if (passes(test)) continue;
    ++n_failed;
    std::printf("FAILED: %s\n", test.name);
  }
  std::printf("%d numbers in a register: %d tests, %d failed\n", geodesic::kLanes, n_run, n_failed);
  return n_failed > 0 || n_run == 0;
}
