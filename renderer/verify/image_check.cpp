#include "renderer/verify/image_check.h"

#include <algorithm>
#include <utility>

#include "base/plural.h"
#include "renderer/sinks/file_sink.h"
#include "renderer/sinks/png.h"
#include "renderer/verify/file_difference.h"

namespace fire3dv::verify {
namespace {

bool shows_same_frames(const sinks::FrameImage& a, const sinks::FrameImage& b) {
  return std::equal(a.shown.begin(), a.shown.end(), b.shown.begin(), b.shown.end(),
                    [](const state::FrameTag& x, const state::FrameTag& y) {
                      return x.stream == y.stream && x.epoch == y.epoch && x.sequence == y.sequence;
                    });
}

}  // namespace

std::optional<std::string> run_difference(const sinks::RunProvenance& stored,
                                          const sinks::RunProvenance& here, bool is_live) {
  sinks::RunProvenance::Values inputs = here.inputs;
  if (is_live)
    std::erase_if(inputs,
                  [](const auto& input) { return input.first == "recording" || input.first == "clock"; });
  if (auto difference = sinks::first_difference(stored.inputs, inputs)) return difference;
  auto difference = sinks::first_difference(stored.options, here.options);
  return difference ? std::optional("setting --" + *difference) : std::nullopt;
}

ImageCheck::ImageCheck(std::string name, sinks::FrameImage stored, sinks::RunProvenance provenance,
                       std::optional<uint64_t> image, std::optional<StoredArray> array)
    : name_(std::move(name)),
      stored_(std::move(stored)),
      provenance_(std::move(provenance)),
      image_(image),
      array_(std::move(array)) {}

Result<bool> ImageCheck::begin(const offline::Manifest& manifest, const sinks::RunProvenance& provenance,
                               std::shared_ptr<offline::FrameFormat> format) {
  format_ = std::move(format);
  if (const auto difference = run_difference(provenance_, provenance, provenance_.command == "fire3dv")) {
    outcome_.differences.push_back(name_ + ": " + *difference);
    return false;
  }
  if (image_ && *image_ >= manifest.images()) {
    outcome_.unchecked = name_ + ": it is image " + std::to_string(*image_) + ", and the run has " +
                         counted(manifest.images(), "image");
    return false;
  }
  return true;
}

// The colours as a data set stores them, with its noise.
Result<std::optional<std::string>> ImageCheck::find_difference(const sinks::FrameImage& drawn) {
  for (const sinks::FramePlane& plane : drawn.planes) {
    if (array_ && plane.output == array_->output)
      return file_difference(".npy", array_->bytes, sinks::encode_npy(plane, drawn.width, drawn.height));
  }
  if (!format_) return pixel_difference(stored_, drawn);
  const auto encoded = format_->encode(drawn);
  if (!encoded) return encoded.error();
  const auto colors = sinks::decode_png(encoded->files.front().bytes);
  if (!colors) return colors.error();
  return pixel_difference(stored_, colors->image);
}

bool ImageCheck::is_wanted(uint64_t image) const {
  return !image_ || *image_ == image;
}

Result<void> ImageCheck::consume(sinks::FrameImage&& image) {
  if (drawn_provenance_ || (!image_ && !shows_same_frames(stored_, image))) return {};
  drawn_provenance_ = image.run_provenance;
  const auto difference = find_difference(image);
  if (!difference) return difference.error();
  if (*difference)
    outcome_.differences.push_back(name_ + ": " + **difference);
  else
    ++outcome_.identical;
  return {};
}

}  // namespace fire3dv::verify
