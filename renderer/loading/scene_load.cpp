#include "renderer/loading/scene_load.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <new>
#include <optional>
#include <stdexcept>
#include <vector>

#include "base/files.h"
#include "base/log.h"
#include "base/plural.h"
#include "base/process/failure.h"
#include "base/process/progress.h"
#include "base/process/start_thread.h"
#include "renderer/scene/derived/key_light.h"
#include "renderer/scene/derived/variants.h"
#include "renderer/scene/gltf/load_gltf.h"

namespace fire3dv::app {

namespace {

constexpr size_t kWarningsShown = 20;

void tell(const std::vector<std::string>& warnings, std::vector<std::string>& notes) {
  for (size_t i = 0; i < std::min(warnings.size(), kWarningsShown); ++i)
    notes.push_back("warning: " + warnings[i]);
  if (warnings.size() > kWarningsShown)
    notes.push_back("warning: and " + std::to_string(warnings.size() - kWarningsShown) + " more");
}

// Names the user's file in messages instead of the intermediate one.
std::string loaded_from(std::string message, const std::filesystem::path& made,
                        const std::filesystem::path& description) {
  if (message.starts_with(made.string())) message.replace(0, made.string().size(), description.string());
  return message;
}

}  // namespace

SceneLoad::SceneLoad(const std::filesystem::path& path, const ConvertOptions& convert,
                     scene::SceneCacheSettings cache, scene::Levels levels, LoadedLook look,
                     std::function<bool()> should_stop)
    : path_(path),
      stamp_(scene::stamp_of(path)),
      convert_(convert),
      should_stop_(std::move(should_stop)),
      gltf_(path),
      cache_settings_(std::move(cache)),
      cache_(cache_settings_),
      levels_(levels),
      look_(std::move(look)),
      thread_(start_thread<std::jthread>("scene loading", [this] {
        Result<scene::LoadedScene> loaded = Error{};
        try {
          loaded = load();
        } catch (const std::exception& failure) {
          loaded = Error{path_.string() + ": cannot be loaded: " + describe_failure(failure)};
        }
        const std::lock_guard lock(mutex_);
        result_.emplace(std::move(loaded));
        changed_.notify_all();
      })) {}

Result<scene::LoadedScene> SceneLoad::load() {
  if (!needs_conversion(path_)) return load_gltf_file();
  note("converting", 0, 0);
  Result<ConvertedScene> converted = ConvertedScene::open(path_, convert_, cache_settings_, should_stop_);
  if (!converted) return converted.error();
  tell(converted->warnings(), notes_);
  converted_.emplace(std::move(*converted));
  gltf_ = converted_->file();
  if (!converted_->is_on_disk()) cache_ = scene::SceneCache({});
  Result<scene::LoadedScene> loaded = load_gltf_file();
  if (!loaded) return Error{"the conversion of " + loaded_from(loaded.error().message, gltf_, path_)};
  loaded->scene.source = path_;
  return loaded;
}

Result<scene::LoadedScene> SceneLoad::load_gltf_file() {
  Result<scene::LoadedScene> loaded = read_or_find();
  if (!loaded) return loaded;
  uint32_t variant = scene::kNone;
  if (!look_.variant.empty()) {
    Result<uint32_t> found = scene::find_variant(loaded->scene, look_.variant);
    if (!found) return Error{gltf_.string() + ": " + found.error().message};
    variant = *found;
  } else if (!loaded->scene.variants.empty()) {
    notes_.push_back("material variants: " + scene::variant_names(loaded->scene));
  }
  // An entry of the cache has the variant of the run that wrote it.
  scene::select_variant(*loaded, variant);
  return loaded;
}

Result<scene::LoadedScene> SceneLoad::read_or_find() {
  const scene::LoadLimits limits;
  const scene::LoadProgress progress = [this](const char* stage, size_t done, size_t total) {
    if (should_stop_ && should_stop_()) throw std::runtime_error("it was interrupted");
    note(stage, done, total);
  };
  try {
    std::optional<scene::LoadedScene> cached = cache_.find(gltf_, limits.max_file_bytes);
    for (std::string& said : cache_.take_log_messages()) notes_.push_back(std::move(said));
    // A run with --lod off may have written the cache entry without levels of detail.
    is_cached_ = cached && (cached->derived.has_levels || !scene::needs_levels(cached->scene, levels_));
    if (is_cached_) sources_ = cache_.sources();
    if (is_cached_) {  // written by a run with or without a key light
      if (!look_.has_key_light) scene::remove_key_light(cached->scene);
      if (look_.has_key_light) scene::add_key_light(cached->scene);
      return std::move(*cached);
    }
    Result<scene::Scene> scene = scene::load_gltf(gltf_, limits, progress, &sources_, cache_.known());
    if (!scene) return scene.error();
    if (look_.has_key_light) scene::add_key_light(*scene);
    scene::Derived derived = scene::derive(*scene, levels_, progress);
    return scene::LoadedScene{std::move(*scene), std::move(derived)};
  } catch (const std::bad_alloc&) {
    return Error{path_.string() + ": it does not fit into memory"};
  } catch (const std::exception& fault) {
    return Error{path_.string() + ": it cannot be loaded: " + fault.what()};
  }
}

std::vector<WatchedFile> SceneLoad::watched_files() const {
  constexpr size_t kMaxWatched = 1000;  // they are looked at twice a second
  std::vector<WatchedFile> files{{path_, stamp_}};
  const auto add = [&files](const std::filesystem::path& file) {
    if (files.size() < kMaxWatched) files.push_back({file, scene::stamp_of(file)});
  };
  if (converted_) {
    for (const std::filesystem::path& file : converted_->sources()) add(file);
  } else {
    const scene::AssetFolder folder(path_);
    for (const scene::SourceFile& source : sources_) {
      if (source.uri.empty()) continue;
      if (const Result<std::filesystem::path> file = folder.resolve(source.uri); file) add(*file);
    }
  }
  return files;
}

void SceneLoad::note(const char* stage, size_t done, size_t total) {
  const std::lock_guard lock(mutex_);
  stage_ = stage;
  done_ = done;
  total_ = total;
}

bool SceneLoad::has_failed() const {
  const std::lock_guard lock(mutex_);
  return result_ && !result_->ok();
}

bool SceneLoad::is_done() const {
  const std::lock_guard lock(mutex_);
  return result_.has_value();
}

Result<const scene::LoadedScene*> SceneLoad::wait(const std::function<void()>& meanwhile) {
  Progress progress("fire3dv", "loading " + path_.filename().string() + ":");
  std::unique_lock lock(mutex_);
  while (!changed_.wait_for(lock, std::chrono::milliseconds(100), [this] { return result_.has_value(); })) {
    progress.update(stage_, done_, total_);
    if (!meanwhile) continue;
    lock.unlock();
    meanwhile();
    lock.lock();
  }
  if (!result_->ok()) return result_->error();
  return &**result_;
}

void SceneLoad::begin_caching() {
  if (is_cached_ || std::exchange(has_stored_, true)) return;
  thread_ = std::jthread([this] {
    try {
      if (Result<void> done = cache_.store(gltf_, **result_, sources_); !done) store_error_ = done.error();
    } catch (const std::exception& fault) {
      store_error_ = Error{std::string("the scene could not be cached: ") + fault.what()};
    }
  });
}

std::optional<Error> SceneLoad::finish_caching() {
  if (thread_.joinable()) thread_.join();
  return store_error_;
}

namespace {

// Size of the meshes of a scene: half of them are smaller. Floors do not count so.
double median_mesh_size_m(const scene::Scene& scene) {
  std::vector<double> sizes;
  for (const scene::Node& node : scene.nodes) {
    if (node.mesh == scene::kNone) continue;
    const scene::Mesh& mesh = scene.meshes[node.mesh];
    double largest = 0;
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      const glm::vec3 extent = scene.primitives[p].bounds_max - scene.primitives[p].bounds_min;
      const glm::mat3 turn(node.world_from_node);
      largest = std::max(largest, double{glm::length(turn * extent)});
    }
    sizes.push_back(largest);
  }
  if (sizes.empty()) return 0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle;
}

// Of files without a unit, or whose meshes may have another one.
std::optional<std::string> find_strange_size(const std::filesystem::path& path, const scene::Scene& scene) {
  constexpr double kStrange_m = 20;
  if (!needs_conversion(path)) return std::nullopt;
  const double size_m = median_mesh_size_m(scene);
  if (!(size_m > kStrange_m)) return std::nullopt;
  char size[32];
  std::snprintf(size, sizeof size, "%.3g", size_m);
  const std::string extension = lower_extension(path);
  const bool is_mesh = extension == ".obj" || extension == ".stl" || extension == ".ply";
  return path.string() + ": its meshes are " + size + " m large: if these are millimetres, " +
         (is_mesh ? "set --unit mm" : "set scale=\"0.001 0.001 0.001\" where the description names them");
}

}  // namespace

void log_scene_summary(const std::filesystem::path& path, const scene::Scene& scene) {
  if (const auto strange = find_strange_size(path, scene)) log_message(warning(*strange));
  constexpr size_t kWarningsShown = 20;
  for (size_t i = 0; i < std::min(scene.warnings.size(), kWarningsShown); ++i)
    log_message(warning(scene.warnings[i]));
  if (scene.warnings.size() > kWarningsShown) {
    log_message(warning("and " + std::to_string(scene.warnings.size() - kWarningsShown) + " more"));
  }
  size_t triangles = 0;
  for (const scene::Primitive& primitive : scene.primitives) triangles += primitive.index_count / 3;
  const bool has_key_light = !scene.lights.empty() && scene.lights.front().is_default;
  const size_t added = has_key_light ? 1 : 0;
  log_message(path.string() + ": " + counted(scene.nodes.size() - added, "node") + ", " +
              counted(triangles, "triangle") + ", " + counted(scene.lights.size() - added, "light") +
              (has_key_light ? " (a key light is added), " : ", ") + counted(scene.cameras.size(), "camera") +
              ", " + counted(scene.textures.size(), "texture"));
}

}  // namespace fire3dv::app
