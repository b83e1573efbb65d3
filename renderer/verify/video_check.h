// Check of a stored video: the run is encoded again into a temporary file, and the bytes are compared.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "renderer/offline/image_consumer.h"
#include "renderer/sinks/video/video_sink.h"
#include "renderer/verify/image_check.h"

namespace fire3dv::verify {

class VideoCheck final : public offline::ImageConsumer {
 public:
  // comment: of the stored file, which the new one gets, too.
  VideoCheck(std::filesystem::path stored, std::string comment, sinks::RunProvenance provenance);
  ~VideoCheck() override;  // removes the temporary files

  // Encoder settings of the run. Before it begins.
  void set_encoder(sinks::VideoSettings settings) { settings_ = std::move(settings); }
  Result<bool> begin(const offline::Manifest& manifest, const sinks::RunProvenance& provenance,
                     std::shared_ptr<offline::FrameFormat> format) override;
  bool is_wanted(uint64_t) const override { return true; }
  Result<void> consume(sinks::FrameImage&& image) override;
  // Ends the encoding and compares.
  Result<void> finish() override;

  const Outcome& outcome() const { return outcome_; }
  const std::shared_ptr<const std::string>& drawn_provenance() const { return drawn_provenance_; }

 private:
  const std::filesystem::path stored_;
  const std::string comment_;
  const sinks::RunProvenance provenance_;
  sinks::VideoSettings settings_;
  std::filesystem::path folder_;  // temporary; empty: not made
  std::unique_ptr<sinks::VideoSink> sink_;
  uint64_t frames_ = 0;
  Outcome outcome_;
  std::shared_ptr<const std::string> drawn_provenance_;
};

}  // namespace fire3dv::verify
