// Key map from GLFW to sinks::Key.
#pragma once

#include "renderer/sinks/window_input.h"

namespace fire3dv::sinks {

Key key_of(int glfw_key);

}  // namespace fire3dv::sinks
