// Files that travel in recordings.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "protocol/record/foxglove.h"
#include "protocol/record/writer.h"

namespace fire3dv::record {

inline const std::string kGlbType = "model/gltf-binary";

std::string media_type_of(const std::string& path);
// They are read anew for each file of a series.
Result<void> attach_files(const std::vector<std::string>& paths, Writer& writer, uint64_t log_time_ns);
// Those of them that viewers of Foxglove's schemas can show: .glb files, of a length that fits a message.
// `left_out` gets a sentence for each that is too long.
Result<std::vector<FoxgloveModel>> load_models(const std::vector<std::string>& paths,
                                               std::vector<std::string>& left_out);

}  // namespace fire3dv::record
