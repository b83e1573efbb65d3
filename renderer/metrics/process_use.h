// What this process takes of the machine, in the families that Prometheus's own libraries use.
#pragma once

#include <cstdint>

#include "renderer/metrics/exposition.h"

namespace fire3dv::metrics {

// Of memory, in RAM; 0 where the system does not tell.
uint64_t resident_bytes();

void write_process_use(Exposition& exposition);

}  // namespace fire3dv::metrics
