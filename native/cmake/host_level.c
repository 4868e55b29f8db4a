// Prints the level of x86-64 of the processor that builds.
#include <stdio.h>

#include "../python/level.h"

int main(void) {
  printf("%d", level_of_processor());
  return 0;
}
