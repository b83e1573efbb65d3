// A scene on its way: read and prepared on a thread of its own, while the device opens and its pipelines are made.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "protocol/error.h"
#include "renderer/scene/derived.h"
#include "renderer/scene/scene.h"

namespace fire3dv::app {

struct LoadedScene {
  scene::Scene scene;
  scene::Derived derived;
};

class SceneLoad {
 public:
  explicit SceneLoad(const std::filesystem::path& path);  // begins

  // Whether take() would report an error, as far as is known by now: then nothing else has to be begun.
  bool has_failed() const;
  // Waits, and says meanwhile how far it is. Once.
  Result<LoadedScene> take();

 private:
  void note(const char* stage, size_t done, size_t total);

  const std::filesystem::path path_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Result<LoadedScene>> result_;
  const char* stage_ = "reading";
  size_t done_ = 0, total_ = 0;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace fire3dv::app
