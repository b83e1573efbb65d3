#include "renderer/serve/jpeg.h"

#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <cstdlib>

#include <jpeglib.h>

#include "protocol/base/error.h"

namespace fire3dv::serve {
namespace {

// libjpeg's default handler ends the program.
struct ErrorHandler {
  jpeg_error_mgr manager;
  std::jmp_buf end;
};

void on_error(j_common_ptr codec) {
  std::longjmp(reinterpret_cast<ErrorHandler*>(codec->err)->end, 1);
}

void ignore_message(j_common_ptr) {}

// Encodes into memory of malloc(). No object with a destructor may live here: errors leave by longjmp().
bool encode(const uint8_t* rgba8, uint32_t width, uint32_t height, int quality, unsigned char** bytes,
            unsigned long* size) {
  jpeg_compress_struct codec;
  ErrorHandler errors;
  codec.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = on_error;
  errors.manager.output_message = ignore_message;
  if (setjmp(errors.end) != 0) {
    jpeg_destroy_compress(&codec);
    return false;
  }
  jpeg_create_compress(&codec);
  jpeg_mem_dest(&codec, bytes, size);
  codec.image_width = width;
  codec.image_height = height;
  codec.input_components = 4;
  codec.in_color_space = JCS_EXT_RGBX;
  jpeg_set_defaults(&codec);
  jpeg_set_quality(&codec, quality, TRUE);
  if (quality >= 90) codec.comp_info[0].h_samp_factor = codec.comp_info[0].v_samp_factor = 1;
  jpeg_start_compress(&codec, TRUE);
  while (codec.next_scanline < height) {
    JSAMPROW row = const_cast<JSAMPROW>(rgba8 + size_t{4} * width * codec.next_scanline);
    jpeg_write_scanlines(&codec, &row, 1);
  }
  jpeg_finish_compress(&codec);
  jpeg_destroy_compress(&codec);
  return true;
}

}  // namespace

bool append_jpeg(std::span<const uint8_t> rgba8, uint32_t width, uint32_t height, int quality,
                 std::vector<uint8_t>& file) {
  FIRE3DV_ASSERT(rgba8.size() == size_t{4} * width * height && width > 0 && height > 0);
  // Room for any image of this size: libjpeg never replaces the buffer, which an error could not tell.
  unsigned long size = 6ul * (width + 16) * (height + 16) + 65536;
  auto* bytes = static_cast<unsigned char*>(std::malloc(size));
  if (!bytes) return false;
  const bool done = encode(rgba8.data(), width, height, quality, &bytes, &size);
  if (done) file.insert(file.end(), bytes, bytes + size);
  std::free(bytes);
  return done;
}

}  // namespace fire3dv::serve
