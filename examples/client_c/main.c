/* C client example: publishes a box that rotates about the vertical axis. Usage: ./client_c [URI] [FRAMES] */
#define _POSIX_C_SOURCE 199309L
#include <fire3dv/client.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

int main(int argc, char** argv) {
  const char* uri = argc > 1 ? argv[1] : "shm://demo";
  const long frames = argc > 2 ? atol(argv[2]) : 1000000;
  const char* names[] = {"box"};
  fire3dv_options options = {.struct_size = sizeof options, .adapter_name = "client_c"};
  fire3dv_description description = {
      .struct_size = sizeof description, .node_names = names, .node_count = 1, .nominal_rate_hz = 100};

  fire3dv_stream* stream = fire3dv_open(uri, &options);
  if (!stream || fire3dv_describe(stream, &description) != FIRE3DV_OK) {
    fprintf(stderr, "client_c: %s\n", fire3dv_last_error());
    return 1;
  }
  for (long i = 0; i < frames; ++i) {
    const float c = cosf(0.01f * (float)i), s = sinf(0.01f * (float)i);
    const float stream_from_box[12] = {c, 0, s, 0, 0, 1, 0, 1, -s, 0, c, 0}; /* 1 m above the floor */
    fire3dv_publish(stream, i * 10000000LL, stream_from_box, 1, 0);
    fire3dv_poll(stream, NULL);
    nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
  }
  printf("client_c: %ld frames published\n", frames);
  fire3dv_close(&stream);
  return 0;
}
