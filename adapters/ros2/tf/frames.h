// Coordinate frames (protocol/frames) under the names of this adapter.
#pragma once

#include "protocol/frames/frame_buffer.h"
#include "protocol/frames/frame_tree.h"
#include "protocol/frames/transform.h"

namespace fire3dv::ros2 {

using namespace frames;

}  // namespace fire3dv::ros2
