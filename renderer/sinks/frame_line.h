// What an image shows, as one line of JSON: a line of frames.jsonl beside images, or beside a video.
#pragma once

#include <string>

#include "renderer/sinks/frame.h"

namespace fire3dv::sinks {

// file: where the image is, relative to the list. With the line's end.
std::string frame_line(const std::string& file, const FrameImage& image);

}  // namespace fire3dv::sinks
