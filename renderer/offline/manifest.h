// Manifest of a frame folder (manifest.json): all settings that determine the bytes of frames, the shard, and
// the machine. A resumed run and a join compare manifests. A folder of assets is recorded by its path only,
// since the assets that streams will add are not known in advance.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "renderer/offline/timeline.h"

namespace fire3dv::offline {

// Machine that rendered the frames. Frames of other machines may differ in the last digits of a pixel.
struct Machine {
  std::string device, driver, cpu;
  bool operator==(const Machine&) const = default;
};

struct Manifest {
  // Names (for messages) and values; frames belong together only if all are equal.
  std::vector<std::pair<std::string, std::string>> settings;
  FrameTimes times;      // of all shards together
  uint32_t cameras = 1;  // images of each frame; image k is of frame k / cameras and camera k % cameras
  uint32_t width = 0, height = 0;
  uint32_t shard = 1, shards = 1;
  Machine machine;
  std::string provenance;  // JSON of sinks::encode_provenance(); empty: none, of earlier versions

  uint64_t images() const { return times.frames * cameras; }
  Part part() const { return part_of(images(), shard, shards); }  // of the images
};

// Encodes a setting's value as valid UTF-8 of bounded length. A shortened value includes its digest, so that
// different values stay different.
std::string setting_text(const std::string& value);

// Describes the first difference, for example "fps is 30 there and 60 here"; nullopt: frames of both belong
// together. with_part: the shard is compared, too.
std::optional<std::string> difference(const Manifest& there, const Manifest& here, bool with_part);

constexpr const char* kManifestName = "manifest.json";
constexpr const char* kFrameListName = "frames.jsonl";
std::string frame_file_name(uint64_t frame);  // frame_000123.png

// Returns nullopt if the folder has no manifest. The error names the file.
Result<std::optional<Manifest>> read_manifest(const std::filesystem::path& folder);
Result<void> write_manifest(const std::filesystem::path& folder, const Manifest& manifest);

}  // namespace fire3dv::offline
