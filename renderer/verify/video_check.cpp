#include "renderer/verify/video_check.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "base/files.h"

namespace fire3dv::verify {
namespace {

namespace fs = std::filesystem;

// Position of the first byte that differs; nullopt: the files are equal.
Result<std::optional<uint64_t>> first_other_byte(const fs::path& a, const fs::path& b) {
  std::ifstream first(a, std::ios::binary), second(b, std::ios::binary);
  if (!first || !second) return Error{"cannot read " + (first ? b : a).string()};
  std::array<char, 1 << 16> ours{}, theirs{};
  for (uint64_t at = 0;;) {
    first.read(ours.data(), ours.size());
    second.read(theirs.data(), theirs.size());
    const std::streamsize count = first.gcount(), other = second.gcount();
    const auto differing =
        std::mismatch(ours.begin(), ours.begin() + count, theirs.begin(), theirs.begin() + other);
    const auto same = static_cast<uint64_t>(differing.first - ours.begin());
    if (same != static_cast<uint64_t>(count) || count != other) return std::optional(at + same);
    if (count == 0) return std::optional<uint64_t>();
    at += same;
  }
}

// A joined video has the encoder options of fire3dv join, which its frames do not know.
sinks::RunProvenance without_encoder(sinks::RunProvenance run) {
  std::erase_if(run.options, [](const auto& option) {
    return option.first == "codec" || option.first == "crf" || option.first == "full-chroma";
  });
  return run;
}

}  // namespace

VideoCheck::VideoCheck(fs::path stored, std::string comment, sinks::RunProvenance provenance)
    : stored_(std::move(stored)), comment_(std::move(comment)), provenance_(std::move(provenance)) {}

VideoCheck::~VideoCheck() {
  sink_.reset();
  std::error_code fault;
  if (!folder_.empty()) fs::remove_all(folder_, fault);
}

Result<bool> VideoCheck::begin(const offline::Manifest& manifest, const sinks::RunProvenance& provenance,
                               std::shared_ptr<offline::FrameFormat>) {
  if (const auto difference =
          run_difference(without_encoder(provenance_), without_encoder(provenance), false)) {
    outcome_.differences.push_back(stored_.string() + ": " + *difference);
    return false;
  }
  std::string name = (fs::temp_directory_path() / "fire3dv-verify-XXXXXX").string();
  if (!::mkdtemp(name.data())) return Error{"cannot make the folder " + name + ": " + system_reason(errno)};
  folder_ = name;
  settings_.path = folder_ / ("again" + stored_.extension().string());
  settings_.width = manifest.width;
  settings_.height = manifest.height;
  settings_.comment = comment_;
  auto sink = sinks::VideoSink::open(settings_);
  if (!sink) return sink.error();
  sink_ = std::move(*sink);
  frames_ = manifest.images();
  return true;
}

Result<void> VideoCheck::consume(sinks::FrameImage&& image) {
  if (!drawn_provenance_) drawn_provenance_ = image.run_provenance;
  frames_ -= std::min<uint64_t>(frames_, 1);
  return sink_->consume(std::move(image));
}

Result<void> VideoCheck::finish() {
  if (frames_ != 0) return {};  // stopped
  if (auto finished = sink_->finish(); !finished) return finished;
  const auto differing = first_other_byte(stored_, settings_.path);
  if (!differing) return differing.error();
  if (*differing)
    outcome_.differences.push_back(stored_.string() + ": byte " + std::to_string(**differing) +
                                   " differs: the frames or the encoder differ; write frames into a folder "
                                   "to find the pixel");
  else
    outcome_.identical = 1;
  return {};
}

}  // namespace fire3dv::verify
