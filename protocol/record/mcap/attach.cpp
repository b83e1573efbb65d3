#include "protocol/record/mcap/attach.h"

#include <filesystem>
#include <memory>

#include "protocol/record/mcap/file.h"
#include "protocol/wire/check.h"

namespace fire3dv::record {

std::string media_type_of(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  return extension == ".glb"    ? kGlbType
         : extension == ".gltf" ? "model/gltf+json"
                                : "application/octet-stream";
}

Result<void> attach_files(const std::vector<std::string>& paths, Writer& writer, uint64_t log_time_ns) {
  for (const std::string& path : paths) {
    auto source = open_source(path);
    if (!source) return source.error();
    AttachmentIndex about;
    about.log_time_ns = log_time_ns;
    about.name = std::filesystem::path(path).filename().string();
    about.media_type = media_type_of(path);
    if (auto good = writer.attach(about, **source); !good) return good;
  }
  return {};
}

Result<std::vector<FoxgloveModel>> load_models(const std::vector<std::string>& paths,
                                               std::vector<std::string>& left_out) {
  std::vector<FoxgloveModel> models;
  uint64_t bytes = 0;
  for (const std::string& path : paths) {
    if (media_type_of(path) != kGlbType) continue;
    auto source = open_source(path);
    if (!source) return source.error();
    if ((*source)->size() > kMostModelBytes - bytes) {
      left_out.push_back(wire::printable(path, 4096) +
                         " is attached, but no model for Foxglove: all of them together may have " +
                         std::to_string(kMostModelBytes >> 20) + " MiB");
      continue;
    }
    bytes += (*source)->size();
    FoxgloveModel model{std::filesystem::path(path).filename().string(), kGlbType, Bytes((*source)->size())};
    if (auto good = (*source)->read(0, model.data); !good) return good.error();
    models.push_back(std::move(model));
  }
  return models;
}

}  // namespace fire3dv::record
