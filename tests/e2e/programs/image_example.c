/* The example of fire3dv/image.h as a program: image_example URI. Prints the sum of the first image's bytes,
 * or the error. */
#include <fire3dv/image.h>
#include <stdio.h>

static unsigned long sum;

static void use_row(const uint8_t* row, size_t bytes) {
  for (size_t i = 0; i < bytes; ++i) sum += row[i];
}

int main(int argc, char** argv) {
  const char* names[] = {"node"};
  const float pose[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  fire3dv_description description = {sizeof description};
  description.node_names = names;
  description.node_count = 1;
  fire3dv_stream* stream = argc == 2 ? fire3dv_open(argv[1], NULL) : NULL;
  if (!stream || fire3dv_describe(stream, &description) != FIRE3DV_OK) return 2;
  fire3dv_publish(stream, 1, pose, 1, 0);
  fire3dv_image_request request = {sizeof request};
  request.fx = request.fy = 300;
  request.width = 320;
  request.height = 240;
  uint64_t id;
  if (fire3dv_request_image(stream, &request, &id) != FIRE3DV_OK) return 2;
  fire3dv_image* image = NULL;
  if (fire3dv_wait_image(stream, id, 2000, &image) == FIRE3DV_OK) {
    const fire3dv_image_plane* color = fire3dv_plane_of(image, FIRE3DV_IMAGE_COLOR_SRGB8);
    for (uint32_t y = 0; color && y < color->height; ++y)
      use_row((const uint8_t*)color->data + (size_t)y * color->row_stride, 4 * color->width);
    fire3dv_release_image(&image);
    printf("sum %lu\n", sum);
  } else {
    printf("%s\n", fire3dv_last_error());
  }
  fire3dv_close(&stream);
  return 0;
}
