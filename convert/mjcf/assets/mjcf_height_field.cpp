#include "convert/mjcf/assets/mjcf_height_field.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "convert/mjcf/assets/mjcf_source.h"
#include "convert/mjcf/assets/png_pixels.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

constexpr uint64_t kMaxElevations = uint64_t{1} << 24;

Error too_large() {
  return Error{"it has more than " + std::to_string(kMaxElevations) + " elevations; make it smaller"};
}

Result<void> read_png(std::span<const std::byte> bytes, MjcfHeightField& field) {
  const Result<PngPixels> pixels = decode_png(bytes);
  if (!pixels) return pixels.error();
  field.columns = pixels->width;
  field.rows = pixels->height;
  if (uint64_t{pixels->width} * pixels->height > kMaxElevations) return too_large();
  // The lower edge of the image is at -Y.
  for (size_t row = field.rows; row-- > 0;)
    for (size_t column = 0; column < field.columns; ++column)
      field.data.push_back(pixels->rgb[3 * (row * field.columns + column)]);
  return {};
}

// MuJoCo's format: rows, columns, then elevations.
Result<void> read_binary(std::span<const std::byte> bytes, MjcfHeightField& field) {
  uint32_t counts[2] = {0, 0};
  if (bytes.size() >= sizeof counts) std::memcpy(counts, bytes.data(), sizeof counts);
  const uint64_t cells = uint64_t{counts[0]} * counts[1];
  if (cells > kMaxElevations) return too_large();
  if (bytes.size() != sizeof counts + 4 * cells)
    return Error{"the height field has counts that differ from its contents; export it again"};
  field.rows = counts[0];
  field.columns = counts[1];
  field.data.resize(cells);
  if (cells > 0) std::memcpy(field.data.data(), bytes.data() + sizeof counts, 4 * cells);
  return {};
}

Result<void> read_inline(const MjcfAttributes& from, MjcfHeightField& field) {
  const int rows = from.integer("nrow", 0), columns = from.integer("ncol", 0);
  if (rows < 1 || columns < 1) return Error{"it has neither a file nor positive nrow and ncol"};
  field.rows = static_cast<size_t>(rows);
  field.columns = static_cast<size_t>(columns);
  if (uint64_t{field.rows} * field.columns > kMaxElevations) return too_large();
  field.data.assign(field.rows * field.columns, 0);
  const std::string* const text = from.find("elevation");
  if (!text) return {};  // flat; a simulation fills it
  const std::vector<double> values = mjcf_numbers(*text, field.data.size() + 1);
  if (values.size() != field.data.size()) return Error{"elevation does not have nrow times ncol numbers"};
  for (size_t row = 0; row < field.rows; ++row)
    for (size_t column = 0; column < field.columns; ++column)
      field.data[(field.rows - 1 - row) * field.columns + column] =
          static_cast<float>(values[row * field.columns + column]);
  return {};
}

}  // namespace

Result<MjcfHeightField> read_mjcf_height_field(MjcfSource& source, const MjcfElement& element) {
  const MjcfAttributes from = source.attributes(element, MjcfDefaults::kMain);
  MjcfHeightField field;
  const auto size = from.vec4("size");
  if (!size || !(size->x > 0 && size->y > 0 && size->z > 0 && size->w > 0))
    return Error{"its size is not four positive numbers"};
  field.half = {size->x, size->y};
  field.height = size->z;
  field.base = size->w;
  const std::string name = source.file_name(from.text("file"));
  Result<void> done;
  if (name.empty()) {
    done = read_inline(from, field);
  } else {
    const auto file = source.files().find(name, source.folders(element, source.compiler().mesh_folder));
    if (!file) return file.error();
    const Result<FileBytes> bytes = source.files().read(*file);
    if (!bytes) return bytes.error();
    done = is_png_file(bytes->view()) ? read_png(bytes->view(), field) : read_binary(bytes->view(), field);
    if (!done) return Error{quote(file->string()) + ": " + done.error().message};
  }
  if (!done) return done.error();
  if (field.rows < 2 || field.columns < 2) return Error{"it has fewer than two rows or columns"};
  for (const float elevation : field.data)
    if (!std::isfinite(elevation)) return Error{"an elevation is not finite"};
  // Elevations are scaled to 0 to 1, as in MuJoCo.
  const auto [low, high] = std::minmax_element(field.data.begin(), field.data.end());
  const float lowest = *low, range = *high - *low;
  for (float& elevation : field.data) {
    elevation -= lowest;
    if (range > 1e-14f) elevation /= range;
  }
  return field;
}

}  // namespace fire3dv::convert
