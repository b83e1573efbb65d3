// What this process takes of the machine, in the families that Prometheus's own libraries use.
#pragma once

#include "renderer/metrics/exposition.h"

namespace fire3dv::metrics {

void write_process_use(Exposition& exposition);

}  // namespace fire3dv::metrics
