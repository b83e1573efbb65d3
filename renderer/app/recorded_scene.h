// The scene that travels in a recording, as a file: loaders, caches and converters take files.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "protocol/record/reader.h"

namespace fire3dv::app {

class RecordedScene {
 public:
  // The first .glb file that is attached, in a folder of its own, closed to others, that goes with this
  // object. An error for a recording without one, or one that is damaged.
  static Result<std::unique_ptr<RecordedScene>> extract(record::Reader& reader);
  ~RecordedScene();
  RecordedScene(const RecordedScene&) = delete;
  RecordedScene& operator=(const RecordedScene&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const std::string& name() const { return name_; }  // as it was attached; for people

 private:
  RecordedScene() = default;

  std::filesystem::path folder_, path_;
  std::string name_;
};

}  // namespace fire3dv::app
