#include "renderer/relabel/command.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "base/log.h"
#include "base/plural.h"
#include "base/process/progress.h"
#include "protocol/import/import.h"
#include "protocol/import/lerobot/lerobot_states.h"
#include "protocol/record/mcap/file.h"
#include "protocol/record/playback.h"
#include "protocol/robot/robot_file.h"
#include "renderer/app/stop_signals.h"
#include "renderer/dataset/command.h"
#include "renderer/dataset/labels/description.h"
#include "renderer/loading/disk_caches.h"
#include "renderer/offline/manifest.h"
#include "renderer/offline/offline_loop.h"
#include "renderer/relabel/demonstration.h"
#include "renderer/relabel/hdf5/hdf5_table.h"
#include "renderer/relabel/scene_nodes.h"

namespace fire3dv::relabel {
namespace {

// Streams of this program need no import.
bool is_own_recording(const std::filesystem::path& file) {
  std::error_code fault;
  if (!std::filesystem::is_regular_file(file, fault)) return false;
  auto source = record::open_source(file.string());
  return source && record::Playback::open(std::move(*source));
}

std::string seconds(int64_t ns) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f s", static_cast<double>(ns) * 1e-9);
  return text;
}

void log_report(const RelabelOptions& options, const scene::Scene& scene,
                const imported::ImportReport& report) {
  const std::string file = options.states.filename().string();
  for (const std::string& text : report.notes) log_message(text);
  for (const std::string& text : report.warnings) log_message(warning(file + ": " + text));
  const std::vector<std::string> resting = resting_nodes(scene, report.nodes);
  if (!resting.empty())
    log_message(counted(resting.size(), "node") + " without states " +
                (resting.size() == 1 ? "stays" : "stay") + " where the scene has " +
                (resting.size() == 1 ? "it: " : "them: ") + dataset::list_names(resting));
  const std::string origin = report.fixed_frame.empty()
                                 ? ""
                                 : "; frame " + quote(report.fixed_frame) + " is the scene's origin, " +
                                       (options.is_z_up ? "Z up" : "Y up");
  log_message(counted(report.frames, "frame") + " of " + counted(report.nodes.size(), "node") + ", from " +
              seconds(report.first_ns) + " to " + seconds(report.last_ns) + origin);
}

// Compares what is written with a file.
class ComparingSink final : public record::Sink {
 public:
  // is_equal: becomes false at the first difference; borrowed.
  ComparingSink(std::unique_ptr<record::Source> wanted, bool& is_equal)
      : wanted_(std::move(wanted)), is_equal_(is_equal) {}

  Result<void> append(std::span<const std::byte> bytes) override {
    is_equal_ = is_equal_ && bytes.size() <= wanted_->size() - at_;
    if (!is_equal_) return Error{quote(name()) + " is shorter"};
    buffer_.resize(bytes.size());
    if (Result<void> read = wanted_->read(at_, buffer_); !read) return read;
    is_equal_ = std::equal(bytes.begin(), bytes.end(), buffer_.begin());
    if (!is_equal_) return Error{quote(name()) + " differs"};
    at_ += bytes.size();
    return {};
  }
  Result<void> truncate(uint64_t length) override {
    at_ = length;
    return {};
  }
  Result<void> finish() override {
    is_equal_ = is_equal_ && at_ == wanted_->size();
    return {};
  }
  const std::string& name() const override { return wanted_->name(); }

 private:
  std::unique_ptr<record::Source> wanted_;
  bool& is_equal_;
  std::vector<std::byte> buffer_;
  uint64_t at_ = 0;
};

class Relabel {
 public:
  explicit Relabel(const RelabelOptions& options) : options_(options) {}

  // Writes options.recording, or finds it there with the same contents.
  Result<void> import_states();

 private:
  Result<void> write(std::unique_ptr<record::Sink> sink);
  // For a run that continues: the recording must be that of the images that are there.
  Result<void> compare();

  const RelabelOptions& options_;
};

Result<void> Relabel::write(std::unique_ptr<record::Sink> sink) {
  const bool is_demonstration = is_hdf5_file(options_.states),
             is_lerobot = imported::is_lerobot_set(options_.states),
             has_positions = is_demonstration || is_lerobot;
  if (options_.episode && !is_lerobot)
    return Error{"--episode is for a LeRobot data set: " + quote(options_.states.string()) +
                 " has no meta/info.json"};
  std::unique_ptr<imported::MessageSource> messages;
  if (!has_positions) {
    auto opened = imported::open_messages(options_.states, app::stop_was_requested);
    if (!opened) return opened.error();
    messages = std::move(*opened);
  }
  const app::CacheLocations caches =
      app::find_cache_locations(options_.drawing.cache, [](const char* name) { return std::getenv(name); });
  auto opened =
      offline::RecordingScene::open(options_.drawing, caches.scenes, nullptr, app::stop_was_requested);
  if (!opened) return opened.error();
  app::SceneLoad& load = (*opened)->load();
  auto loaded = load.wait();
  if (!loaded) return loaded.error();
  const scene::Scene& scene = (*loaded)->scene;
  // Reading may take minutes: a mistyped name ends the run before.
  if (options_.dataset) {
    if (auto good = dataset::check(*options_.dataset, scene, load.gltf_file()); !good) return good;
  }
  auto robot = robot::find_robot(load.gltf_file(), !is_demonstration);
  if (!robot) {
    log_message(warning(robot.error().message + "; joint states cannot move it"));
    robot = std::optional<robot::Robot>();
  }
  const state::NodeNames names(scene);
  imported::ImportOptions choices;
  choices.frame_prefix = options_.prefix;
  choices.fixed_frame = options_.fixed_frame;
  choices.is_z_up = options_.is_z_up;
  choices.is_in_degrees = options_.in_degrees;
  choices.find_node = [&](std::string_view name) { return find_node(scene, names, name); };
  choices.robot = *robot ? &**robot : nullptr;
  Progress progress("fire3dv", "reading " + printable_text(options_.states.string(), 200) + ":");
  choices.on_progress = [&](double done) {
    constexpr uint64_t kTotal = 1000;
    progress.update("", static_cast<uint64_t>(std::llround(done * double{kTotal})), kTotal);
    return !app::stop_was_requested();
  };
  if (is_demonstration && options_.in_degrees)
    return Error{
        "--joint-unit deg is for joint states and LeRobot data sets: MuJoCo's positions are radians"};
  if (has_positions && !choices.robot)
    return Error{
        quote(options_.drawing.scene.string()) + " has no joints: name the " +
        (is_lerobot ? "robot of the data set, such as its URDF file," : "model.xml of the demonstration") +
        " as the scene"};
  const auto import = [&] {
    if (is_demonstration)
      return import_demonstration(options_.states, options_.demo, *choices.robot, choices.on_progress,
                                  std::move(sink));
    if (is_lerobot)
      return imported::import_lerobot(options_.states,
                                      {options_.episode, options_.prefix, options_.in_degrees},
                                      *choices.robot, choices.on_progress, std::move(sink));
    return imported::import_states(*messages, choices, std::move(sink));
  };
  auto report = import();
  if (!report) return report.error();
  if (has_positions) {
    for (const std::string& name : choices.robot->node_names())
      if (auto node = choices.find_node(name)) report->nodes.push_back(std::move(*node));
  }
  log_report(options_, scene, *report);
  load.begin_caching();
  if (const auto fault = load.finish_caching()) log_message(warning(fault->message));
  return {};
}

Result<void> Relabel::import_states() {
  const std::filesystem::path& recording = options_.recording;
  std::error_code fault;
  if (std::filesystem::equivalent(options_.states, recording, fault))
    return Error{quote(options_.states.string()) +
                 " has the states, and the import would write to it: choose another " +
                 (options_.dataset ? "folder" : "file") + " with --out"};
  if (recording.has_parent_path()) std::filesystem::create_directories(recording.parent_path(), fault);
  if (!std::filesystem::exists(recording, fault)) {
    auto sink = record::create_atomic_sink(recording.string());
    return sink ? write(std::move(*sink)) : sink.error();
  }
  if (!options_.dataset)
    return Error{quote(recording.string()) + " exists: remove it, or choose another file with --out"};
  return compare();
}

Result<void> Relabel::compare() {
  auto source = record::open_source(options_.recording.string());
  if (!source) return source.error();
  bool is_equal = true;
  const Result<void> written = write(std::make_unique<ComparingSink>(std::move(*source), is_equal));
  if (is_equal) return written;
  return Error{quote(options_.recording.string()) +
               " is of other states, or of another version of this program: remove "
               "it, or choose another folder with --out"};
}

}  // namespace

int run(const RelabelOptions& options) {
  if (is_own_recording(options.states)) {
    if (!options.dataset)
      return report_failure(Error{quote(options.states.string()) +
                                  " is a recording of this program already: name a folder with --out"});
    dataset::DatasetOptions dataset = *options.dataset;
    dataset.run.recording = options.states.string();
    return dataset::run(dataset);
  }
  std::error_code fault;
  const bool is_new = !std::filesystem::exists(options.recording, fault);
  if (Result<void> done = Relabel(options).import_states(); !done) return report_failure(done.error());
  if (!options.dataset) {
    log_message("wrote " + options.recording.string());
    return 0;
  }
  const int exit_code = dataset::run(*options.dataset);
  // A recording of which no image was drawn would stand in the way of the next command.
  if (exit_code != 0 && is_new && !app::stop_was_requested() &&
      !std::filesystem::exists(options.dataset->run.out / offline::kManifestName, fault))
    std::filesystem::remove(options.recording, fault);
  return exit_code;
}

}  // namespace fire3dv::relabel
