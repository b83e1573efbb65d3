#include "base/image/jpeg_encoder.h"

#include <csetjmp>
#include <string>
#include <vector>

#include <jpeglib.h>

#ifndef JCS_EXTENSIONS
#error "libjpeg-turbo is needed: its JCS_EXT_RGBX reads the renderer's pixels in place"
#endif

namespace fire3dv {

struct JpegEncoder::State {
  jpeg_error_mgr errors{};
  jpeg_compress_struct compressor{};
  std::jmp_buf on_error{};
  char message[JMSG_LENGTH_MAX] = "";
  bool is_created = false;
  std::vector<unsigned char> buffer;
  unsigned char* bytes = nullptr;  // in `buffer`
  unsigned long size = 0;

  // libjpeg's error handler must not return; no object with a destructor lives between setjmp and here.
  [[noreturn]] static void fail(j_common_ptr common) {
    auto* const state = static_cast<State*>(common->client_data);
    common->err->format_message(common, state->message);
    std::longjmp(state->on_error, 1);
  }

  ~State() {
    if (is_created) jpeg_destroy_compress(&compressor);
  }

  bool create() {
    compressor.err = jpeg_std_error(&errors);
    errors.error_exit = fail;
    errors.output_message = [](j_common_ptr) {};
    compressor.client_data = this;
    if (setjmp(on_error) != 0) return false;
    jpeg_create_compress(&compressor);
    compressor.client_data = this;
    return is_created = true;
  }

  bool compress(const unsigned char* pixels, uint32_t width, uint32_t height, size_t row_stride, int quality,
                Chroma chroma) {
    if (setjmp(on_error) != 0) {
      jpeg_abort_compress(&compressor);
      return false;
    }
    jpeg_mem_dest(&compressor, &bytes, &size);
    compressor.image_width = width;
    compressor.image_height = height;
    compressor.input_components = 4;
    compressor.in_color_space = JCS_EXT_RGBX;
    jpeg_set_defaults(&compressor);
    jpeg_set_quality(&compressor, quality, TRUE);
    if (chroma == Chroma::full)
      compressor.comp_info[0].h_samp_factor = compressor.comp_info[0].v_samp_factor = 1;
    jpeg_start_compress(&compressor, TRUE);
    while (compressor.next_scanline < compressor.image_height) {
      // libjpeg does not write to the rows.
      JSAMPROW row = const_cast<JSAMPROW>(pixels + compressor.next_scanline * row_stride);
      jpeg_write_scanlines(&compressor, &row, 1);
    }
    jpeg_finish_compress(&compressor);
    return true;
  }
};

JpegEncoder::JpegEncoder() : state_(std::make_unique<State>()) {}

JpegEncoder::~JpegEncoder() = default;
JpegEncoder::JpegEncoder(JpegEncoder&&) noexcept = default;
JpegEncoder& JpegEncoder::operator=(JpegEncoder&&) noexcept = default;

Result<std::span<const uint8_t>> JpegEncoder::encode(const void* rgbx, uint32_t width, uint32_t height,
                                                     size_t row_stride, uint32_t quality, Chroma chroma) {
  State& state = *state_;
  // Upper bound of libjpeg-turbo (tjBufSize), so that libjpeg never replaces the buffer.
  const auto padded = [](size_t side) { return (side + 15) / 16 * 16; };
  const size_t bytes_per_pixel = chroma == Chroma::full ? 6 : 3;
  state.buffer.resize(padded(width) * padded(height) * bytes_per_pixel + 2048);
  state.bytes = state.buffer.data();
  state.size = static_cast<unsigned long>(state.buffer.size());
  if ((state.is_created || state.create()) &&
      state.compress(static_cast<const unsigned char*>(rgbx), width, height, row_stride,
                     static_cast<int>(quality), chroma) &&
      state.bytes == state.buffer.data())
    return std::span<const uint8_t>(state.bytes, state.size);
  return Error{"an image of " + std::to_string(width) + "x" + std::to_string(height) +
               " cannot be encoded as JPEG: " + state.message};
}

}  // namespace fire3dv
