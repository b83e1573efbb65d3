#include "renderer/offline/frame_format.h"

#include <array>
#include <fstream>
#include <system_error>
#include <utility>

#include "base/files.h"
#include "renderer/sinks/output_text.h"
#include "renderer/sinks/png.h"

namespace fire3dv::offline {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxFrameBytes = uint64_t{2} << 30;

}  // namespace

Result<std::vector<uint8_t>> FrameFormat::read_file(const fs::path& folder, uint64_t,
                                                    const std::string& name) const {
  return read_whole_file(folder / name, kMaxFrameBytes);
}

Result<std::vector<uint8_t>> FrameFormat::read_run_file(const fs::path& folder,
                                                        const std::string& name) const {
  return read_whole_file(folder / name, kMaxFrameBytes);
}

Result<EncodedFrame> PngFrames::encode(const sinks::FrameImage& image) {
  EncodedFrame frame;
  const std::string name = frame_file_name(image.frame_index);
  auto bytes = sinks::encode_png(image);
  if (!bytes) return Error{"cannot encode " + name + ": " + bytes.error().message};
  frame.files.push_back({name, std::move(*bytes)});
  frame.line = sinks::frame_line({name, {}}, image);
  frame.line.pop_back();  // line feed
  return frame;
}

// Checks signature and end of a PNG. Files are renamed when complete, so only a power cut leaves a partial
// one.
bool PngFrames::is_complete(const fs::path& folder, uint64_t frame, const nlohmann::json&, bool) const {
  const fs::path path = folder / frame_file_name(frame);
  constexpr std::array<unsigned char, 8> kBegin{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  constexpr std::array<unsigned char, 8> kEnd{'I', 'E', 'N', 'D', 0xae, 0x42, 0x60, 0x82};
  std::array<unsigned char, 8> begin{}, end{};
  std::error_code fault;
  if (!fs::is_regular_file(fs::symlink_status(path, fault)) || fault) return false;
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(begin.data()), begin.size());
  file.seekg(-static_cast<std::streamoff>(end.size()), std::ios::end);
  file.read(reinterpret_cast<char*>(end.data()), end.size());
  return file && begin == kBegin && end == kEnd;
}

Result<EncodedFrame> PngFrames::load(const fs::path& folder, uint64_t frame, const std::string& line,
                                     const Manifest& manifest) const {
  auto stored = read_frame(folder, frame, manifest);
  if (!stored) return stored.error();
  EncodedFrame loaded;
  loaded.files.push_back({frame_file_name(frame), std::move(stored->bytes)});
  loaded.line = line;
  return loaded;
}

Result<StoredFrame> read_frame(const fs::path& folder, uint64_t frame, const Manifest& manifest) {
  const fs::path path = folder / frame_file_name(frame);
  StoredFrame stored;
  auto bytes = read_whole_file(path, kMaxFrameBytes);
  if (!bytes) return bytes.error();
  auto png = sinks::decode_png(*bytes);
  if (!png) return Error{"cannot read " + path.string() + ": " + png.error().message};
  stored.bytes = std::move(*bytes);
  stored.image = std::move(png->image);
  if (stored.image.frame_index != frame || stored.image.width != manifest.width ||
      stored.image.height != manifest.height)
    return Error{path.string() +
                 " is not the frame that its name says: remove it and render its shard again"};
  return stored;
}

}  // namespace fire3dv::offline
