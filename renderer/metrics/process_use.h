// Process metrics (memory, CPU time, descriptors) with the family names of Prometheus client libraries.
#pragma once

#include <cstdint>

#include "renderer/metrics/exposition.h"

namespace fire3dv::metrics {

// Resident set size in bytes; 0 if unknown.
uint64_t resident_bytes();

void write_process_use(Exposition& exposition);

}  // namespace fire3dv::metrics
