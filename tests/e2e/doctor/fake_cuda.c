/* libcuda of the doctor's tests: it is installed, and there is no GPU. */
#define EXPORT __attribute__((visibility("default")))

enum { kNoDevice = 100 };

EXPORT int cuInit(unsigned flags);
int cuInit(unsigned flags) {
  (void)flags;
  return kNoDevice;
}
#define UNUSED_FUNCTION(name) \
  EXPORT int name(void);      \
  int name(void) {            \
    return kNoDevice;         \
  }
UNUSED_FUNCTION(cuDeviceGetCount)
UNUSED_FUNCTION(cuDeviceGet)
UNUSED_FUNCTION(cuDeviceGetName)
UNUSED_FUNCTION(cuDeviceGetUuid)
UNUSED_FUNCTION(cuGetErrorName)
