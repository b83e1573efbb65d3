// PNG encoder and decoder on libpng. libpng reports errors by longjmp, which must not skip destructors:
// functions that call setjmp have trivial locals only, and callers own all outputs. Callbacks catch
// exceptions, which must not unwind through C frames.

#include "renderer/sinks/png.h"

#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string_view>

#include "base/numbers.h"
#include "base/text.h"
#include "renderer/sinks/run_provenance.h"

namespace fire3dv::sinks {

namespace {

constexpr size_t kMaxTextBytes = 4096;     // per written chunk
constexpr uint32_t kMaxReadChunks = 1000;  // per file
constexpr size_t kMaxReadChunkBytes = 1 << 20;

struct Fault {
  char text[160] = "out of memory";  // default until libpng reports an error
};

[[noreturn]] void on_error(png_structp png, png_const_charp text) {
  auto* fault = static_cast<Fault*>(png_get_error_ptr(png));
  std::snprintf(fault->text, sizeof fault->text, "%s", text);
  png_longjmp(png, 1);
}
void on_warning(png_structp, png_const_charp) {}  // warnings concern readable files and are ignored

void append_bytes(png_structp png, png_bytep data, size_t size) {
  bool out_of_memory = false;
  try {
    auto* out = static_cast<std::vector<uint8_t>*>(png_get_io_ptr(png));
    out->insert(out->end(), data, data + size);
  } catch (...) {
    out_of_memory = true;
  }
  if (out_of_memory) png_error(png, "out of memory");
}
void flush_nothing(png_structp) {}

void take_bytes(png_structp png, png_bytep data, size_t size) {
  auto* in = static_cast<std::span<const uint8_t>*>(png_get_io_ptr(png));
  if (in->size() < size) png_error(png, "the file is cut short");
  std::memcpy(data, in->data(), size);
  *in = in->subspan(size);
}

struct Encoding {
  const uint8_t* rgba8;
  uint32_t width, height;
  bool opaque;
  png_text* text;
  int text_count;
  uint8_t* row;  // width * 3 bytes, for opaque images
  std::vector<uint8_t>* out;
};

bool encode(const Encoding& job, Fault& fault) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &fault, on_error, on_warning);
  if (!png) return false;
  png_infop info = png_create_info_struct(png);
  if (!info || setjmp(png_jmpbuf(png))) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, job.out, append_bytes, flush_nothing);
  png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
  // Rendered images: one cheap filter and a low compression level are within a few percent of the best size
  // at a fraction of the time. The encoder shares its cores with the renderer.
  png_set_compression_level(png, 2);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB | PNG_FILTER_UP);
  png_set_IHDR(png, info, job.width, job.height, 8, job.opaque ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGBA,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_set_text(png, info, job.text, job.text_count);
  png_write_info(png, info);
  for (uint32_t y = 0; y < job.height; ++y) {
    const uint8_t* source = job.rgba8 + size_t{4} * job.width * y;
    if (job.opaque) {
      for (uint32_t x = 0; x < job.width; ++x)
        std::memcpy(job.row + size_t{3} * x, source + size_t{4} * x, 3);
      source = job.row;
    }
    png_write_row(png, source);
  }
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return true;
}

struct Decoding {
  std::span<const uint8_t> bytes;
  PngLimits limits;
  PngFile* file;
  std::vector<uint8_t*>* rows;
};

// Throwing calls are in functions of their own, so that the setjmp function sees a plain bool.
bool make_room(const Decoding& job, uint32_t width, uint32_t height) {
  try {
    FrameImage& image = job.file->image;
    image.width = width;
    image.height = height;
    image.rgba8.resize(size_t{4} * width * height);
    job.rows->resize(height);
    for (uint32_t y = 0; y < height; ++y) (*job.rows)[y] = image.rgba8.data() + size_t{4} * width * y;
    return true;
  } catch (...) {
    return false;
  }
}

bool keep_text(const Decoding& job, const png_text* text, int count) {
  try {
    for (int i = 0; i < count; ++i) {
      const bool international = text[i].compression >= PNG_ITXT_COMPRESSION_NONE;
      const size_t length = international ? text[i].itxt_length : text[i].text_length;
      job.file->text.emplace_back(text[i].key,
                                  std::string(text[i].text ? text[i].text : "", text[i].text ? length : 0));
    }
    return true;
  } catch (...) {
    return false;
  }
}

bool decode(Decoding& job, Fault& fault) {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &fault, on_error, on_warning);
  if (!png) return false;
  png_infop info = png_create_info_struct(png);
  png_infop end_info = png_create_info_struct(png);
  if (!info || !end_info || setjmp(png_jmpbuf(png))) {
    png_destroy_read_struct(&png, &info, &end_info);
    return false;
  }
  png_set_read_fn(png, &job.bytes, take_bytes);
  png_set_user_limits(png, job.limits.max_side, job.limits.max_side);
  png_set_chunk_cache_max(png, kMaxReadChunks);
  png_set_chunk_malloc_max(png, kMaxReadChunkBytes);
  png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
  png_read_info(png, info);
  const uint32_t width = png_get_image_width(png, info);
  const uint32_t height = png_get_image_height(png, info);
  if (uint64_t{width} * height > job.limits.max_pixels) png_error(png, "it has more pixels than the limit");
  png_set_expand(png);
  png_set_gray_to_rgb(png);
  png_set_strip_16(png);
  png_set_filler(png, 0xff, PNG_FILLER_AFTER);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  if (png_get_rowbytes(png, info) != size_t{4} * width) png_error(png, "its colour type is not known");
  if (!make_room(job, width, height)) png_error(png, "out of memory");
  png_read_image(png, job.rows->data());
  png_read_end(png, end_info);
  job.file->srgb = png_get_valid(png, info, PNG_INFO_sRGB) != 0;
  for (png_infop part : {info, end_info}) {
    png_textp text = nullptr;
    const int count = png_get_text(png, part, &text, nullptr);
    if (!keep_text(job, text, count)) png_error(png, "out of memory");
  }
  png_destroy_read_struct(&png, &info, &end_info);
  return true;
}

// Checks chunk lengths against the file size. libpng allocates and clears the claimed length before it reads,
// so a few hostile bytes could cost gigabytes and seconds.
const char* chunk_fault(std::span<const uint8_t> bytes) {
  if (bytes.size() < 8 || png_sig_cmp(bytes.data(), 0, 8) != 0) return "it does not begin as a PNG";
  bytes = bytes.subspan(8);
  while (bytes.size() >= 12) {  // length, type, body, CRC
    const uint32_t length = png_get_uint_32(bytes.data());
    const bool pixels = std::memcmp(bytes.data() + 4, "IDAT", 4) == 0;
    const bool last = std::memcmp(bytes.data() + 4, "IEND", 4) == 0;
    if (length > bytes.size() - 12) return "the file is cut short";
    if (!pixels && length > kMaxReadChunkBytes) return "a chunk is larger than the limit";
    if (last) return nullptr;
    bytes = bytes.subspan(size_t{12} + length);
  }
  return "the file is cut short";
}

Error with_path(const char* what, const std::filesystem::path& path, const Error& error) {
  return Error{std::string(what) + " " + path.string() + ": " + error.message};
}

}  // namespace

Result<std::vector<uint8_t>> encode_png(const FrameImage& image) {
  if (!is_consistent(image) || image.width == 0 || image.height == 0) {
    return Error{"an image of " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                 " pixels with " + std::to_string(image.rgba8.size()) + " bytes cannot be a PNG"};
  }
  TextChunks chunks = text_of(image);
  std::vector<png_text> text(chunks.size());
  char no_language[] = "";
  for (size_t i = 0; i < chunks.size(); ++i) {
    const bool is_provenance = chunks[i].first == kProvenanceKeyword;
    chunks[i].second = printable_text(chunks[i].second, is_provenance ? kMaxProvenanceBytes : kMaxTextBytes);
    std::string& value = chunks[i].second;
    const bool ascii =
        std::all_of(value.begin(), value.end(), [](char c) { return static_cast<uint8_t>(c) < 0x80; });
    text[i].compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
    text[i].key = chunks[i].first.data();
    text[i].text = value.data();
    text[i].text_length = value.size();
    text[i].itxt_length = ascii ? 0 : value.size();
    text[i].lang = no_language;
    text[i].lang_key = no_language;
  }
  bool opaque = true;
  for (size_t i = 3; i < image.rgba8.size() && opaque; i += 4) opaque = image.rgba8[i] == 0xff;
  std::vector<uint8_t> row(size_t{3} * image.width);
  std::vector<uint8_t> out;
  out.reserve(image.rgba8.size() / 4);
  Fault fault;
  const Encoding job{
      image.rgba8.data(), image.width, image.height, opaque, text.data(), static_cast<int>(text.size()),
      row.data(),         &out};
  if (!encode(job, fault)) return Error{std::string("the PNG encoder failed: ") + fault.text};
  return out;
}

Result<PngFile> decode_png(std::span<const uint8_t> bytes, const PngLimits& limits) {
  if (const char* fault = chunk_fault(bytes))
    return Error{std::string("not a PNG that can be read: ") + fault};
  PngFile file;
  std::vector<uint8_t*> rows;
  Fault fault;
  Decoding job{bytes, limits, &file, &rows};
  if (!decode(job, fault)) return Error{std::string("not a PNG that can be read: ") + fault.text};
  apply_text(file.text, file.image);
  return file;
}

Result<void> write_png(const std::filesystem::path& path, const FrameImage& image,
                       base::Durability durability) {
  auto bytes = encode_png(image);
  if (!bytes) return with_path("cannot write", path, bytes.error());
  return write_whole_file(path, *bytes, durability);
}

Result<PngFile> read_png(const std::filesystem::path& path, const PngLimits& limits) {
  auto bytes = read_whole_file(path, 8 * limits.max_pixels + (1 << 20));
  if (!bytes) return bytes.error();
  auto file = decode_png(*bytes, limits);
  if (!file) return with_path("cannot read", path, file.error());
  return file;
}

// --- text chunks of an image's provenance, and their parser ---

namespace {

template <typename T>
void read_number(std::string_view text, T& value, int base = 10) {
  if (const std::optional<T> parsed = parse_number<T>(text, base)) value = *parsed;
}

void apply_stream_field(std::string_view field, std::string_view text, state::FrameTag& tag) {
  if (field == "Stream") tag.stream = text;
  if (field == "Epoch") read_number(text, tag.epoch, 16);
  if (field == "Sequence") read_number(text, tag.sequence);
  if (field == "SimTimeNs") read_number(text, tag.sim_time_ns);
  if (field == "PublishTimeNs") read_number(text, tag.publish_time_ns);
  for (const state::Condition condition :
       {state::Condition::live, state::Condition::late, state::Condition::lost})
    if (field == "State" && text == state::condition_name(condition)) tag.condition = condition;
}

}  // namespace

std::string hex64(uint64_t value) {
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(value));
  return digits;
}

TextChunks text_of(const FrameImage& image) {
  TextChunks text;
  text.emplace_back("Software", "FIRE-3DV " FIRE3DV_VERSION);
  if (!image.camera.empty()) text.emplace_back("Camera", image.camera);
  text.emplace_back("Frame", std::to_string(image.frame_index));
  if (image.run_provenance) text.emplace_back(kProvenanceKeyword, *image.run_provenance);
  if (image.path_traced) {
    text.emplace_back("Renderer", "path");
    text.emplace_back("SamplesPerPixel", std::to_string(image.path_traced->samples_per_pixel));
    text.emplace_back("Bounces", std::to_string(image.path_traced->bounces));
    text.emplace_back("Seed", std::to_string(image.path_traced->seed));
  }
  for (const std::string& name : image.hidden_streams) text.emplace_back("HiddenStream", name);
  text.emplace_back("Streams", std::to_string(image.shown.size()));
  for (size_t i = 0; i < image.shown.size(); ++i) {
    const state::FrameTag& tag = image.shown[i];
    const std::string suffix = image.shown.size() == 1 ? "" : "." + std::to_string(i);
    text.emplace_back("Stream" + suffix, tag.stream);
    text.emplace_back("Epoch" + suffix, hex64(tag.epoch));
    text.emplace_back("Sequence" + suffix, std::to_string(tag.sequence));
    text.emplace_back("SimTimeNs" + suffix, std::to_string(tag.sim_time_ns));
    text.emplace_back("PublishTimeNs" + suffix, std::to_string(tag.publish_time_ns));
    text.emplace_back("State" + suffix, state::condition_name(tag.condition));
  }
  return text;
}

void apply_text(const TextChunks& text, FrameImage& image) {
  uint64_t stream_count = 0;
  for (const auto& [keyword, value] : text) {
    if (keyword == "Camera") image.camera = value;
    if (keyword == "Frame") read_number(value, image.frame_index);
    if (keyword == kProvenanceKeyword) image.run_provenance = std::make_shared<const std::string>(value);
    if (keyword == "HiddenStream") image.hidden_streams.push_back(value);
    if (keyword == "Streams") read_number(value, stream_count);
    if (keyword == "Renderer" && value == "path") image.path_traced.emplace();
  }
  for (const auto& [keyword, value] : text) {
    if (!image.path_traced) break;
    if (keyword == "SamplesPerPixel") read_number(value, image.path_traced->samples_per_pixel);
    if (keyword == "Bounces") read_number(value, image.path_traced->bounces);
    if (keyword == "Seed") read_number(value, image.path_traced->seed);
  }
  // The count is untrusted: a file cannot show more streams than it has chunks.
  image.shown.assign(stream_count <= text.size() ? stream_count : 0, {});
  for (const auto& [keyword, value] : text) {
    const std::string_view name = keyword;
    const size_t dot = name.find('.');
    size_t index = dot == std::string_view::npos ? 0 : SIZE_MAX;
    if (dot != std::string_view::npos) read_number(name.substr(dot + 1), index);
    if (index < image.shown.size()) apply_stream_field(name.substr(0, dot), value, image.shown[index]);
  }
}

}  // namespace fire3dv::sinks
