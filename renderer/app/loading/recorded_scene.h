// Scene attached to a recording, extracted to a temporary file for loaders, caches and converters.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "protocol/record/mcap/reader.h"

namespace fire3dv::app {

class RecordedScene {
 public:
  // Extracts the first attached .glb file to a private temporary folder, which is removed with this object.
  // Fails if there is none or it is damaged.
  static Result<std::unique_ptr<RecordedScene>> extract(record::Reader& reader);
  ~RecordedScene();
  RecordedScene(const RecordedScene&) = delete;
  RecordedScene& operator=(const RecordedScene&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const std::string& name() const { return name_; }  // name of the attachment; for messages

 private:
  RecordedScene() = default;

  std::filesystem::path folder_, path_;
  std::string name_;
};

}  // namespace fire3dv::app
