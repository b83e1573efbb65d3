// Check of one stored image against the same image of a run that is drawn now.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderer/offline/image_consumer.h"
#include "renderer/sinks/run_provenance.h"

namespace fire3dv::verify {

// Outcome of a check. Neither is set: it did not end.
struct Outcome {
  uint64_t identical = 0;                     // checked images without a difference
  std::vector<std::string> differences;       // the first of each image, in order
  std::vector<std::string> file_differences;  // the first of each file of the whole set
  std::vector<std::string> notes;             // on files that are compared beside the images, and others
  std::optional<std::string> unchecked;       // reason why nothing can be compared
};

// Difference of inputs and options, which is named before anything is drawn; nullopt: there is none. is_live:
// runs without a recording of their own, whose images are drawn by a recording of their streams.
std::optional<std::string> run_difference(const sinks::RunProvenance& stored,
                                          const sinks::RunProvenance& here, bool is_live);

// NumPy file of an output.
struct StoredArray {
  std::vector<uint8_t> bytes;
  wire::ImageOutput output{};
};

class ImageCheck final : public offline::ImageConsumer {
 public:
  // stored: with the pixels of the file. image: its number in the new run; nullopt: the one that shows the
  // same frames of streams.
  // array: checked in place of the colours.
  ImageCheck(std::string name, sinks::FrameImage stored, sinks::RunProvenance provenance,
             std::optional<uint64_t> image, std::optional<StoredArray> array = std::nullopt);

  Result<bool> begin(const offline::Manifest& manifest, const sinks::RunProvenance& provenance,
                     std::shared_ptr<offline::FrameFormat> format) override;
  bool is_wanted(uint64_t image) const override;
  Result<void> consume(sinks::FrameImage&& image) override;
  Result<void> finish() override { return {}; }

  const Outcome& outcome() const { return outcome_; }
  // JSON; null: nothing was drawn.
  const std::shared_ptr<const std::string>& drawn_provenance() const { return drawn_provenance_; }

 private:
  Result<std::optional<std::string>> find_difference(const sinks::FrameImage& drawn);

  const std::string name_;
  const sinks::FrameImage stored_;
  const sinks::RunProvenance provenance_;
  const std::optional<uint64_t> image_;
  const std::optional<StoredArray> array_;
  std::shared_ptr<offline::FrameFormat> format_;  // of a data set; else null
  Outcome outcome_;
  std::shared_ptr<const std::string> drawn_provenance_;
};

}  // namespace fire3dv::verify
