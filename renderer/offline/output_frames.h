// Format of frames with other outputs than colours: the files of fire3dv --out DIR --outputs LIST, with the
// sizes of each frame's files in its line.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "protocol/wire/image_outputs.h"
#include "renderer/offline/frame_format.h"

namespace fire3dv::offline {

class OutputFrames final : public FrameFormat {
 public:
  explicit OutputFrames(wire::ImageOutputs outputs) : outputs_(outputs) {}

  Result<EncodedFrame> encode(const sinks::FrameImage& image) override;
  bool is_complete(const std::filesystem::path& folder, uint64_t frame, const nlohmann::json& line,
                   bool is_packed) const override;
  Result<EncodedFrame> load(const std::filesystem::path& folder, uint64_t frame, const std::string& line,
                            const Manifest& manifest) const override;

 private:
  std::vector<std::string> file_names(uint64_t frame) const;

  const wire::ImageOutputs outputs_;
};

// Setting of the manifest that names the outputs: "color,depth". A folder of colours alone has none.
constexpr const char* kOutputsSetting = "outputs";
std::string outputs_text(wire::ImageOutputs outputs);
// Outputs of the frames in a folder. The error names the setting.
Result<wire::ImageOutputs> outputs_of(const Manifest& manifest);

}  // namespace fire3dv::offline
