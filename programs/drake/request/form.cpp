#include "programs/drake/request/form.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "base/digest.h"
#include "base/numbers.h"
#include "base/text.h"
#include "programs/drake/http/multipart.h"
#include "programs/drake/request/sha256.h"

namespace fire3dv::drake {
namespace {

constexpr double kMaxNumber = 1e9;  // of any field; far beyond every camera

constexpr std::array<std::string_view, 16> kFields{
    "scene",   "scene_sha256", "image_type", "width",    "height",   "near",      "far",       "focal_x",
    "focal_y", "fov_x",        "fov_y",      "center_x", "center_y", "min_depth", "max_depth", "submit"};

// The fields of a form. The first fault is kept; later reads return 0.
class Fields {
 public:
  explicit Fields(std::span<const FormPart> parts) : parts_(parts) {
    for (size_t i = 0; i < parts.size(); ++i) {
      const std::string name = printable_text(parts[i].name, 80);
      if (std::ranges::find(kFields, parts[i].name) == kFields.end())
        fail("the form has a field \"" + name + "\", which Drake's render protocol does not know");
      for (size_t k = 0; k < i; ++k)
        if (parts[k].name == parts[i].name) fail("the form has the field \"" + name + "\" twice");
    }
  }

  std::string_view text(std::string_view name) {
    const auto part = std::ranges::find(parts_, name, &FormPart::name);
    if (part != parts_.end()) return part->data;
    fail("the form lacks the field \"" + std::string(name) + "\"");
    return {};
  }
  double positive_number(const char* name) {
    const std::string_view digits = text(name);
    const std::optional<double> value = parse_number<double>(digits);
    if (value && *value > 0 && *value <= kMaxNumber) return *value;
    fail("the field \"" + std::string(name) + "\" is \"" + printable_text(digits, 40) +
         "\": it must be a number above 0 and at most 1e9");
    return 0;
  }
  uint32_t pixels(const char* name, uint32_t most) {
    const std::string_view digits = text(name);
    const std::optional<uint32_t> value = parse_number<uint32_t>(digits);
    if (value && *value >= 1 && *value <= most) return *value;
    fail("the field \"" + std::string(name) + "\" is \"" + printable_text(digits, 40) +
         "\": it must be a whole number of pixels from 1 to " + std::to_string(most));
    return 0;
  }
  void require(bool holds, const char* text) {
    if (!holds) fail(text);
  }
  void fail(std::string text) {
    if (fault_.message.empty()) fault_.message = std::move(text);
  }
  const Error& fault() const { return fault_; }

 private:
  std::span<const FormPart> parts_;
  Error fault_;
};

ImageType read_type(Fields& fields) {
  const std::string_view name = fields.text("image_type");
  if (name == "depth") return ImageType::depth;
  if (name == "label") return ImageType::label;
  if (name != "color")
    fields.fail("the field \"image_type\" is \"" + printable_text(name, 40) +
                "\": it must be color, depth or label");
  return ImageType::color;
}

}  // namespace

Result<RenderRequest> read_form(std::string_view body, std::string_view content_type,
                                const FormLimits& limits) {
  const Result<std::vector<FormPart>> parts = parse_multipart(body, content_type);
  if (!parts) return parts.error();
  Fields fields(*parts);
  RenderRequest request;
  request.type = read_type(fields);
  request.width = fields.pixels("width", limits.max_side_px);
  request.height = fields.pixels("height", limits.max_side_px);
  if (uint64_t{request.width} * request.height > limits.max_pixels)
    fields.fail("an image of " + std::to_string(request.width) + " x " + std::to_string(request.height) +
                " is too large: at most " + std::to_string(limits.max_pixels) + " pixels");
  request.near_m = fields.positive_number("near");
  request.far_m = fields.positive_number("far");
  fields.require(request.near_m < request.far_m, "\"near\" must be less than \"far\"");
  request.focal_x_px = fields.positive_number("focal_x");
  request.focal_y_px = fields.positive_number("focal_y");
  request.center_x_px = fields.positive_number("center_x");
  request.center_y_px = fields.positive_number("center_y");
  fields.require(request.center_x_px < request.width && request.center_y_px < request.height,
                 "\"center_x\" and \"center_y\" must lie in the image");
  // The focal lengths say the same; these are only checked.
  fields.positive_number("fov_x");
  fields.positive_number("fov_y");
  if (request.type == ImageType::depth) {
    request.min_depth_m = fields.positive_number("min_depth");
    request.max_depth_m = fields.positive_number("max_depth");
    fields.require(request.min_depth_m < request.max_depth_m,
                   "\"min_depth\" must be less than \"max_depth\"");
  }
  request.scene = fields.text("scene");
  const std::string_view digest = fields.text("scene_sha256");
  if (!fields.fault().message.empty()) return fields.fault();
  if (digest != hex(sha256_of(request.scene)))
    return Error{"\"scene_sha256\" is not the SHA-256 of the scene: the file was damaged on its way"};
  return request;
}

}  // namespace fire3dv::drake
