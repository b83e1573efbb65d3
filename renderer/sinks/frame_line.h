// JSON record of one image: its files, camera, outputs and pose frames. It is one line of frames.jsonl beside
// images, or of VIDEO.jsonl.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/sinks/frame.h"

namespace fire3dv::sinks {

// Paths relative to the folder of the list.
struct FrameFiles {
  std::filesystem::path color;                // empty: colour was not requested
  std::vector<std::filesystem::path> planes;  // parallel to FrameImage::planes
};

// Includes the trailing line feed.
std::string frame_line(const FrameFiles& files, const FrameImage& image);

}  // namespace fire3dv::sinks
