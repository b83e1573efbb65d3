// Format of a frame folder: the files of each image, its line of frames.jsonl, and the files of the whole
// run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/offline/manifest.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::offline {

struct FolderFile {
  std::string name;  // relative to the folder, with '/'
  std::vector<uint8_t> bytes;
};

struct EncodedFrame {
  std::vector<FolderFile> files;
  std::string line;  // a JSON object with "frame", without line feed
};

// Longest line of a list: labels of thousands of instances.
constexpr uint64_t kMaxLineBytes = 16 << 20;

// Lines of complete frames, by frame.
using FrameLines = std::map<uint64_t, std::string>;

// Methods are called by several threads at once.
class FrameFormat {
 public:
  virtual ~FrameFormat() = default;

  virtual Result<EncodedFrame> encode(const sinks::FrameImage& image) = 0;
  // True if files of the whole run hold all frames, whose own files may be gone.
  virtual bool is_packed(const std::filesystem::path&) const { return false; }
  // True if all files of a listed frame are there, and complete. Names follow from the number and never from
  // texts of the line, so that a list cannot name other files. is_packed: of the folder.
  virtual bool is_complete(const std::filesystem::path& folder, uint64_t frame, const nlohmann::json& line,
                           bool is_packed) const = 0;
  // Reads the files of a complete frame, for another folder.
  virtual Result<EncodedFrame> load(const std::filesystem::path& folder, uint64_t frame,
                                    const std::string& line, const Manifest& manifest) const = 0;
  // Reads one of the files that encode() names, also from the files of a finished run. Untrusted bytes.
  virtual Result<std::vector<uint8_t>> read_file(const std::filesystem::path& folder, uint64_t frame,
                                                 const std::string& name) const;
  // True if a new run starts in an empty folder only: its names might be those of other files.
  virtual bool needs_empty_folder() const { return false; }
  // Creates sub-folders, and files that depend on no frame. Before the first frame.
  virtual Result<void> begin(const std::filesystem::path&) { return {}; }
  // Writes files that depend on all frames. After the last frame of all shards; also when nothing was drawn.
  virtual Result<void> complete(const std::filesystem::path&, const FrameLines&) { return {}; }

  // For a check of a finished run. Files that begin() writes, before it has written them.
  virtual std::vector<FolderFile> first_files() const { return {}; }
  // Files that complete() makes of the lines, which may come from outside.
  virtual Result<std::vector<FolderFile>> last_files(const FrameLines&) const {
    return std::vector<FolderFile>();
  }
  // Names of further files and folders that complete() writes, such as pages for readers.
  virtual std::vector<std::string> page_names() const { return {}; }
  // Reads one of the first or last files, without what may differ between equal runs. Untrusted bytes.
  virtual Result<std::vector<uint8_t>> read_run_file(const std::filesystem::path& folder,
                                                     const std::string& name) const;
};

// DIR/frame_000000.png and so on: colours alone.
class PngFrames final : public FrameFormat {
 public:
  Result<EncodedFrame> encode(const sinks::FrameImage& image) override;
  bool is_complete(const std::filesystem::path& folder, uint64_t frame, const nlohmann::json& line,
                   bool is_packed) const override;
  Result<EncodedFrame> load(const std::filesystem::path& folder, uint64_t frame, const std::string& line,
                            const Manifest& manifest) const override;
};

// Reads one frame of a PngFrames folder with its file's bytes. Fails if the file holds another frame or size.
struct StoredFrame {
  std::vector<uint8_t> bytes;
  sinks::FrameImage image;
};
Result<StoredFrame> read_frame(const std::filesystem::path& folder, uint64_t frame, const Manifest& manifest);

}  // namespace fire3dv::offline
