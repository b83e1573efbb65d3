#include "convert/mjcf/assets/png_pixels.h"

#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <string_view>

namespace fire3dv::convert {
namespace {

constexpr uint64_t kMaxPixels = uint64_t{1} << 26;

struct Input {
  std::span<const std::byte> left;
};

void read_bytes(png_structp png, png_bytep to, size_t count) {
  auto* const input = static_cast<Input*>(png_get_io_ptr(png));
  if (input->left.size() < count) png_error(png, "the file is cut short");
  if (count > 0) std::memcpy(to, input->left.data(), count);
  input->left = input->left.subspan(count);
}

void ignore_warning(png_structp, png_const_charp) {}

void on_error(png_structp png, png_const_charp) {
  png_longjmp(png, 1);
}

// Plain data, so that longjmp skips no destructor.
struct Decoder {
  png_structp png = nullptr;
  png_infop info = nullptr;
  uint32_t width = 0, height = 0;
};

bool read_header(Decoder& decoder) {
  if (setjmp(png_jmpbuf(decoder.png)) != 0) return false;
  png_read_info(decoder.png, decoder.info);
  decoder.width = png_get_image_width(decoder.png, decoder.info);
  decoder.height = png_get_image_height(decoder.png, decoder.info);
  png_set_expand(decoder.png);
  png_set_strip_16(decoder.png);
  png_set_gray_to_rgb(decoder.png);
  png_set_strip_alpha(decoder.png);
  png_set_interlace_handling(decoder.png);
  png_read_update_info(decoder.png, decoder.info);
  return png_get_rowbytes(decoder.png, decoder.info) == size_t{3} * decoder.width;
}

bool read_rows(Decoder& decoder, png_bytep* rows) {
  if (setjmp(png_jmpbuf(decoder.png)) != 0) return false;
  png_read_image(decoder.png, rows);
  return true;
}

}  // namespace

bool is_png_file(std::span<const std::byte> bytes) {
  constexpr std::string_view kMagic = "\x89PNG\r\n\x1a\n";
  return bytes.size() >= kMagic.size() && std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0;
}

Result<PngPixels> decode_png(std::span<const std::byte> bytes) {
  Input input{bytes};
  Decoder decoder;
  decoder.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, on_error, ignore_warning);
  if (decoder.png) decoder.info = png_create_info_struct(decoder.png);
  PngPixels pixels;
  std::vector<png_bytep> rows;
  bool is_read = false, is_large = false;
  if (decoder.info) {
    png_set_read_fn(decoder.png, &input, read_bytes);
    is_read = read_header(decoder);
    is_large = is_read && uint64_t{decoder.width} * decoder.height > kMaxPixels;
    if (is_read && !is_large) {
      pixels.width = decoder.width;
      pixels.height = decoder.height;
      pixels.rgb.resize(size_t{3} * decoder.width * decoder.height);
      for (uint32_t row = 0; row < decoder.height; ++row)
        rows.push_back(pixels.rgb.data() + size_t{3} * decoder.width * row);
      is_read = read_rows(decoder, rows.data());
    }
  }
  png_destroy_read_struct(&decoder.png, &decoder.info, nullptr);
  if (is_large)
    return Error{"the PNG file has more than " + std::to_string(kMaxPixels) + " pixels; make it smaller"};
  if (!is_read) return Error{"the PNG file cannot be decoded"};
  return pixels;
}

}  // namespace fire3dv::convert
