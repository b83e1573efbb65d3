/* Vulkan layer of the doctor's tests: it hangs when the loader loads it. */
#include <unistd.h>

__attribute__((constructor)) static void on_load(void) {
  for (;;) pause();
}
