#include "renderer/offline/output_frames.h"

#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "base/files.h"
#include "renderer/sinks/file_sink.h"

namespace fire3dv::offline {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxFileBytes = uint64_t{2} << 30;

}  // namespace

// In the order of write_frame_files().
std::vector<std::string> OutputFrames::file_names(uint64_t frame) const {
  std::vector<std::string> names;
  const std::string begin = fs::path(frame_file_name(frame)).stem().string();
  if (outputs_.has(wire::kColorSrgb8)) names.push_back(frame_file_name(frame));
  for (const wire::ImageOutputInfo& info : wire::kImageOutputTable) {
    const bool has_file =
        info.output == wire::kAmodal || (!info.is_boxes && info.output != wire::kColorSrgb8);
    if (has_file && outputs_.has(info.output))
      names.push_back(begin + "." + std::string(info.cli_name) + ".npy");
  }
  return names;
}

Result<EncodedFrame> OutputFrames::encode(const sinks::FrameImage& image) {
  EncodedFrame frame;
  const fs::path begin = fs::path(frame_file_name(image.frame_index)).stem();
  const auto files = sinks::write_frame_files(
      image, begin, [&](const fs::path& name, std::vector<uint8_t> bytes) -> Result<void> {
        frame.files.push_back({name.string(), std::move(bytes)});
        return {};
      });
  if (!files) return files.error();
  auto line = nlohmann::ordered_json::parse(sinks::frame_line(*files, image));
  line["bytes"] = nlohmann::ordered_json::array();
  for (const FolderFile& file : frame.files) line["bytes"].push_back(file.bytes.size());
  frame.line = line.dump();
  return frame;
}

bool OutputFrames::is_complete(const fs::path& folder, uint64_t frame, const nlohmann::json& line,
                               bool is_packed) const {
  const std::vector<std::string> names = file_names(frame);
  const auto sizes = line.find("bytes");
  if (sizes == line.end() || !sizes->is_array() || sizes->size() != names.size()) return false;
  if (is_packed) return true;
  for (size_t i = 0; i < names.size(); ++i) {
    std::error_code fault;
    const fs::path path = folder / names[i];
    if (!(*sizes)[i].is_number_unsigned() || !fs::is_regular_file(fs::symlink_status(path, fault)) ||
        fs::file_size(path, fault) != (*sizes)[i].get<uint64_t>() || fault)
      return false;
  }
  return true;
}

Result<EncodedFrame> OutputFrames::load(const fs::path& folder, uint64_t frame, const std::string& line,
                                        const Manifest&) const {
  EncodedFrame loaded;
  loaded.line = line;
  for (const std::string& name : file_names(frame)) {
    auto bytes = read_whole_file(folder / name, kMaxFileBytes);
    if (!bytes) return bytes.error();
    loaded.files.push_back({name, std::move(*bytes)});
  }
  return loaded;
}

std::string outputs_text(wire::ImageOutputs outputs) {
  std::string text;
  for (const wire::ImageOutputInfo& info : wire::kImageOutputTable) {
    if (outputs.has(info.output)) text += (text.empty() ? "" : ",") + std::string(info.cli_name);
  }
  return text;
}

Result<wire::ImageOutputs> outputs_of(const Manifest& manifest) {
  for (const auto& [name, value] : manifest.settings) {
    if (name != kOutputsSetting) continue;
    auto outputs = wire::parse_image_outputs(value);
    if (!outputs)
      return Error{std::string(kManifestName) + ": " + kOutputsSetting + ": " + outputs.error().message};
    return outputs;
  }
  return wire::ImageOutputs();
}

}  // namespace fire3dv::offline
