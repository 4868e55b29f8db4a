// Prints the level of x86-64 of the processor that builds.
#include "../python/level.h"

#include <stdio.h>

int main(void) {
  printf("%d", level_of_processor());
  return 0;
}
