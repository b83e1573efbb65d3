/* libcuda of the doctor's tests, with as many GPUs as FIRE3DV_FAKE_CUDA_DEVICES says; 0: it is installed
 * alone. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))

enum { kNoDevice = 100 };

static int device_count(void) {
  const char* const text = getenv("FIRE3DV_FAKE_CUDA_DEVICES");
  return text ? atoi(text) : 0;
}

EXPORT int cuInit(unsigned flags);
int cuInit(unsigned flags) {
  (void)flags;
  return device_count() ? 0 : kNoDevice;
}
EXPORT int cuDeviceGetCount(int* count);
int cuDeviceGetCount(int* count) {
  *count = device_count();
  return 0;
}
EXPORT int cuDeviceGet(int* device, int index);
int cuDeviceGet(int* device, int index) {
  *device = index;
  return 0;
}
EXPORT int cuDeviceGetName(char* name, int bytes, int device);
int cuDeviceGetName(char* name, int bytes, int device) {
  snprintf(name, (size_t)bytes, "fake CUDA %d", device);
  return 0;
}
EXPORT int cuDeviceGetUuid(unsigned char* uuid, int device);
int cuDeviceGetUuid(unsigned char* uuid, int device) {
  memset(uuid, 0x11 + device, 16);
  return 0;
}
EXPORT int cuGetErrorName(int error, const char** name);
int cuGetErrorName(int error, const char** name) {
  (void)error;
  *name = "CUDA_ERROR";
  return 0;
}
