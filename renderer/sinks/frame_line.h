// What an image shows, as one line of JSON: a line of frames.jsonl beside images, or beside a video.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/sinks/frame.h"

namespace fire3dv::sinks {

// Relative to the list's folder.
struct FrameFiles {
  std::filesystem::path color;                // empty: none was wanted
  std::vector<std::filesystem::path> planes;  // as the image's
};

// With the line's end.
std::string frame_line(const FrameFiles& files, const FrameImage& image);

}  // namespace fire3dv::sinks
