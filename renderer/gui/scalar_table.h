// Table of scalars as CSV (RFC 4180): a row for each simulation time, a column for each scalar.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "renderer/state/frame_receiver.h"

namespace fire3dv::gui {

struct ScalarColumn {
  std::string name;
  const stream::ScalarGroup* group = nullptr;  // not null
  size_t scalar = 0;                           // index in the group
};

// Samples from begin_ns to end_ns, both included. A cell without a value is empty. Numbers have all digits
// that they need to be read back unchanged. Of columns with a common time, rows are merged.
std::string csv_text(std::span<const ScalarColumn> columns, int64_t begin_ns, int64_t end_ns);

}  // namespace fire3dv::gui
