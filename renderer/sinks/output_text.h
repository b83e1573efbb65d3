// Text in output files: sanitisers for untrusted text (adapter and camera names), and the JSON record of one
// image.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/sinks/frame.h"

namespace fire3dv::sinks {

// Returns a quoted JSON string.
std::string json_string(std::string_view text);

// Returns a file name of letters, digits, '-', '_' and '.'. It is never empty, hidden or special; all other
// characters become '_'.
std::string safe_file_name(std::string_view text);

// Paths relative to the folder of the list.
struct FrameFiles {
  std::filesystem::path color;                // empty: colour was not requested
  std::vector<std::filesystem::path> planes;  // parallel to FrameImage::planes
  std::filesystem::path amodal;               // masks; empty: not requested
};

// JSON record of one image: its files, camera, outputs and pose frames. It is one line of frames.jsonl beside
// images, or of VIDEO.jsonl, and includes the trailing line feed.
std::string frame_line(const FrameFiles& files, const FrameImage& image);

}  // namespace fire3dv::sinks
