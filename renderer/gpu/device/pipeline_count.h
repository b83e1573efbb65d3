// Count of pipelines that were used for the first time, by all devices. Drivers of CPU devices compile most
// of a pipeline in the first submission that uses it.
#pragma once

#include <cstdint>

namespace fire3dv::gpu {

uint64_t pipelines_begun();

}  // namespace fire3dv::gpu
