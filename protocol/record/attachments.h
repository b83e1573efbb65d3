// MCAP attachments of recordings: scene and other files.
#pragma once

#include <string>
#include <vector>

#include "protocol/record/foxglove.h"
#include "protocol/record/mcap/writer.h"

namespace fire3dv::record {

inline const std::string kGlbType = "model/gltf-binary";

// A file to attach, and its name in the recording, whose extension is the media type.
struct AttachedFile {
  std::string path, name;
};
// Files by their own names.
std::vector<AttachedFile> named_files(const std::vector<std::string>& paths);

std::string media_type_of(const std::string& name);
// Attaches the files to the writer. Reads each file again for every file of a split recording.
Result<void> attach_files(const std::vector<AttachedFile>& files, Writer& writer, uint64_t log_time_ns);
// Loads the .glb files that Foxglove viewers can display and that fit a message. Adds one sentence to
// `left_out` for each file that is too long.
Result<std::vector<FoxgloveModel>> load_models(const std::vector<AttachedFile>& files,
                                               std::vector<std::string>& left_out);

}  // namespace fire3dv::record
