// What a folder of frames is of: everything that decides about a frame's bytes, which part of all frames it
// holds, and what drew them. Written as manifest.json beside the frames, so that a run that was interrupted
// knows whether it may go on, and a join whether parts belong together. Of a folder of assets it has the path
// alone, since what streams will add from it is not known before.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/error.h"
#include "renderer/offline/frame_times.h"

namespace fire3dv::offline {

// What drew the frames. On others of its kind a frame may differ in a pixel's last digits.
struct Machine {
  std::string device, driver, cpu;
  bool operator==(const Machine&) const = default;
};

struct Manifest {
  // Each with a name for people; all have to be equal for frames to belong together.
  std::vector<std::pair<std::string, std::string>> settings;
  FrameTimes times;  // of all parts together
  uint32_t width = 0, height = 0;
  uint32_t shard = 1, shards = 1;
  Machine machine;

  Part part() const { return part_of(times.frames, shard, shards); }
};

// A setting's value as a manifest can hold it: valid UTF-8 of bounded length. What is changed by that has its
// digest with it, so that two that differ still do.
std::string setting_text(const std::string& value);

// "fps is 30 there and 60 here", of the first difference that decides about bytes; nothing: frames of both
// belong together. with_part: they are even of the same part.
std::optional<std::string> difference(const Manifest& there, const Manifest& here, bool with_part);

constexpr const char* kManifestName = "manifest.json";
constexpr const char* kFrameListName = "frames.jsonl";
std::string frame_file_name(uint64_t frame);  // frame_000123.png

// Nothing where the folder has none. The error names the file.
Result<std::optional<Manifest>> read_manifest(const std::filesystem::path& folder);
Result<void> write_manifest(const std::filesystem::path& folder, const Manifest& manifest);

std::string cpu_name();  // of this machine

}  // namespace fire3dv::offline
