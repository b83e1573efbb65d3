// Presentation mode of the window's swapchain, as the user chooses it.
#pragma once

#include <cstdint>

namespace fire3dv::sinks {

enum class Present : uint8_t {
  vsync,      // FIFO: every image, at the display's refresh rate
  mailbox,    // the newest image, at the display's refresh rate
  immediate,  // without waiting; may tear
};

}  // namespace fire3dv::sinks
