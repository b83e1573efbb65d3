#include "renderer/dataset/command.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/digest.h"
#include "base/log.h"
#include "base/plural.h"
#include "base/text.h"
#include "protocol/robot/robot_file.h"
#include "renderer/dataset/dataset_format.h"
#include "renderer/dataset/labels/keypoints.h"
#include "renderer/dataset/labels/objects.h"
#include "renderer/dataset/labels/recorded_state.h"
#include "renderer/dataset/randomize/randomizer.h"
#include "renderer/dataset/randomize/scene_additions.h"
#include "renderer/offline/image_set.h"
#include "renderer/passes/outputs/silhouettes.h"

namespace fire3dv::dataset {
namespace {

class LabelledImages final : public offline::ImageSet {
 public:
  // plan: borrowed; null: nothing is randomised.
  LabelledImages(const DatasetOptions& options, std::unique_ptr<Layout> layout, const Plan* plan)
      : options_(options), plan_(plan), layout_(std::move(layout)) {
    has_flow_forward_ = layout_->has_flow_forward();
    outputs_ = layout_->further_outputs();
    for (const auto output : {wire::kColorSrgb8, wire::kDepthF32, wire::kInstanceU32}) outputs_.add(output);
  }

  wire::ImageOutputs outputs() const override { return outputs_; }
  const std::vector<std::string>& cameras() const override { return options_.cameras; }
  uint32_t flow_frames() const override { return options_.flow_frames; }
  offline::ImageChanges* changes() override { return randomizer_ ? &*randomizer_ : nullptr; }
  bool has_flow_forward() const override { return has_flow_forward_; }
  std::optional<size_t> other_of_pair(size_t camera) const override {
    return options_.is_stereo ? std::optional(camera ^ 1) : std::nullopt;
  }
  Result<std::unique_ptr<const scene::LoadedScene>> prepare_scene(const scene::LoadedScene& loaded) override {
    if (!plan_) return std::unique_ptr<const scene::LoadedScene>();
    return add_to_scene(*plan_, loaded);
  }
  Result<std::shared_ptr<offline::FrameFormat>> open_format(const scene::Scene& scene,
                                                            const std::filesystem::path& gltf_file,
                                                            Settings& settings) override;
  Result<void> check_camera(size_t index, const app::CameraRig::Placed& camera) const override;
  // Of inputs before the recording is there: another run follows, which has the warnings.
  void set_is_check() { is_check_ = true; }
  void add_poses(uint64_t image, const app::CameraRig::Placed& camera, const app::CameraRig::Placed* other,
                 const state::PoseState& poses) override;

 private:
  Result<void> randomize(const scene::Scene& scene, Description& description, Settings& settings);
  Result<void> describe_episode(const scene::Scene& scene, const std::filesystem::path& gltf_file,
                                Description& description);
  void warn(const std::string& text) const {
    if (!is_check_) log_message(warning(text));
  }

  const DatasetOptions& options_;
  const Plan* const plan_;
  std::optional<Randomizer> randomizer_;
  std::optional<RecordedState> state_;
  std::unique_ptr<Layout> layout_;
  wire::ImageOutputs outputs_;
  bool has_flow_forward_ = false, is_check_ = false;
  std::shared_ptr<DatasetFormat> format_;
};

// Node of a camera of the file; kNone: a free camera, or one that the overlay file adds.
uint32_t find_camera(const scene::Scene& scene, const std::string& name) {
  const auto rig = app::CameraRig::create(scene, {name, false, {}, {}});
  return rig ? rig->node() : scene::kNone;
}

// name empty: that of the camera which the scene begins with.
std::string camera_title(const scene::Scene& scene, const std::string& name) {
  if (!name.empty()) return name;
  const uint32_t node = find_camera(scene, name);
  if (node == scene::kNone) return "auto";
  return scene.nodes[node].name.empty() ? "camera" : scene.nodes[node].name;
}

Error orthographic(const std::string& name) {
  return Error{"camera " + quote(name) +
               " is orthographic, so that it has no camera matrix: choose another with --camera, or auto"};
}

void warn_of_missing_labels(const scene::Scene& scene, float label_alpha, Description& description) {
  std::vector<std::string> names;
  for (const uint32_t node : passes::nodes_without_labels(scene, nullptr, label_alpha))
    names.push_back(scene.nodes[node].path);
  if (names.empty()) return;
  description.warnings.push_back(counted(names.size(), "node") +
                                 " will have no depth and no labels, being blended with alpha not above " +
                                 "--label-alpha: " + list_names(names));
}

// Names that nothing has are errors where no stream and no overlay file can add an object.
Result<void> LabelledImages::randomize(const scene::Scene& scene, Description& description,
                                       Settings& settings) {
  if (!plan_) return {};
  const bool is_whole = options_.run.recording.empty() && options_.run.drawing.overlay.empty();
  for (const auto& [text, is_pattern] : Randomizer::unmatched(*plan_, scene, description.cameras)) {
    if (is_whole && !is_pattern) return Error{text};
    warn(text + (is_whole ? "" : " in the file of the scene"));
  }
  if (options_.is_stereo && !plan_->of(Section::cameras).empty())
    return Error{plan_->file + ": cameras of --stereo-pairs keep their places: remove the section cameras"};
  if (!plan_->maps.empty() && options_.flow_frames != 0)
    return Error{plan_->file +
                 ": environment.map: each map has a renderer of its own, and flow needs one for all: "
                 "leave --flow-frames out, or set it to 0"};
  std::string_view left = plan_->text;
  while (!left.empty()) {
    const size_t end = std::min(left.find('\n'), left.size());
    description.randomization.emplace_back(left.substr(0, end));
    left.remove_prefix(std::min(end + 1, left.size()));
  }
  description.seed = plan_->seed;
  settings.emplace_back("randomization", hex(digest_of(std::as_bytes(std::span(plan_->text)))).substr(0, 32));
  settings.emplace_back("seed", std::to_string(plan_->seed));
  std::string inputs;
  for (const auto& [name, trajectory] : plan_->paths) inputs += trajectory.digest;
  for (const auto& [name, map] : plan_->maps) inputs += map.digest;
  for (const auto* const files : {&plan_->textures, &plan_->distractors}) {
    for (const auto& [name, file] : *files) inputs += name + file.digest;
  }
  inputs += plan_->given.digest;
  if (!inputs.empty()) settings.emplace_back("files of the randomization", inputs);
  randomizer_.emplace(*plan_, description.cameras);
  // Again before the first image; a mistake that is found here leaves no folder.
  return is_whole ? randomizer_->set_scene(scene, options_.run.drawing.draw) : Result<void>();
}

Result<void> LabelledImages::describe_episode(const scene::Scene& scene,
                                              const std::filesystem::path& gltf_file,
                                              Description& description) {
  Episode& episode = description.episode;
  episode.fps = static_cast<uint32_t>(options_.run.rate.value_or(offline::FrameRate{}).numerator);
  episode.task = options_.task;
  episode.has_linear_depth = options_.has_depth_scale;
  if (options_.run.recording.empty() || is_check_) return {};
  auto moved = find_moved_nodes(options_.run.recording, scene);
  if (!moved) return moved.error();
  auto robot = robot::find_robot(gltf_file, true);
  if (!robot) log_message(warning(robot.error().message + "; the state has no joint positions"));
  state_.emplace(scene, robot ? *robot : std::nullopt, *moved);
  if (!state_->note().empty())
    log_message(warning(state_->note() + ": the state is the poses of the nodes that move"));
  if (const size_t count = state_->names().size() + state_->environment_names().size();
      count > kMaxStateNumbers) {
    description.warnings.push_back("no state: " + counted(moved->size(), "node") + " and their joints have " +
                                   counted(count, "number") + ", more than " +
                                   std::to_string(kMaxStateNumbers));
    state_.reset();
    return {};
  }
  episode.state_names = state_->names();
  episode.environment_names = state_->environment_names();
  return {};
}

Result<std::shared_ptr<offline::FrameFormat>> LabelledImages::open_format(
    const scene::Scene& scene, const std::filesystem::path& gltf_file, Settings& settings) {
  Description description;
  description.format = options_.format;
  description.command = options_.command;
  description.license = options_.license;
  description.width = options_.run.drawing.width;
  description.height = options_.run.drawing.height;
  description.depth_unit_mm = options_.depth_unit_mm;
  description.flow_frames = options_.flow_frames;
  description.is_stereo = options_.is_stereo;
  description.tar_bytes = static_cast<uint64_t>(options_.tar_mb * 1e6);
  description.label_alpha = double{options_.run.drawing.draw.label_alpha};
  const std::vector<std::string>& names = options_.cameras;
  for (const std::string& name : names.empty() ? std::vector{options_.run.drawing.camera} : names) {
    description.cameras.push_back(camera_title(scene, name));
    const uint32_t node = find_camera(scene, name);
    const bool is_final = options_.run.drawing.overlay.empty();  // else check_camera() has its edits
    if (is_final && node != scene::kNone && scene.cameras[scene.nodes[node].camera].orthographic)
      return orthographic(description.cameras.back());
  }
  std::set<uint32_t> without_labels;
  if (plan_ && plan_->distractor_entry() && !plan_->distractor_entry()->has_flag("labels"))
    without_labels = distractor_nodes(*plan_, scene);
  if (auto found = find_objects(scene, options_.objects, description, without_labels); !found)
    return found.error();
  if (auto read = read_keypoints(scene, options_.keypoints, description); !read) return read.error();
  if (options_.format == kLerobot) {
    if (auto described = describe_episode(scene, gltf_file, description); !described)
      return described.error();
  }
  if (const auto depth = layout_->depth16(description);
      options_.has_depth_scale && !description.episode.has_linear_depth &&
      !(depth && depth->unit_mm == description.depth_unit_mm))
    warn("--depth-scale has no effect: the format " + options_.format + " has no depth images with a scale");
  if (auto drawn = randomize(scene, description, settings); !drawn) return drawn.error();
  warn_of_missing_labels(scene, options_.run.drawing.draw.label_alpha, description);
  auto written = as_written(description);
  if (!written) return written.error();
  description = std::move(*written);
  if (auto good = layout_->check(description); !good) return good.error();
  for (const std::string& text : description.warnings) warn(text);
  std::vector<offline::FolderFile> files;
  const std::vector<std::string> models = layout_->static_names(description);
  for (size_t i = 0; i < models.size(); ++i)
    files.push_back({models[i], encode_model(scene, description, i)});
  std::string cameras, objects, keypoints;
  for (const std::string& name : description.cameras) cameras += name + "\n";
  for (const std::string& name : options_.objects) objects += name + "\n";
  for (const Keypoint& point : description.keypoints) {
    keypoints += std::to_string(point.node) + " " + point.name;
    for (const double value : point.node_from_point_m) keypoints += " " + std::to_string(value);
    keypoints += "\n";
  }
  settings.insert(settings.end(), {{"format", options_.format},
                                   {"cameras", cameras},
                                   {"objects", objects},
                                   {"keypoints", keypoints},
                                   {"depth scale", std::to_string(options_.depth_unit_mm)},
                                   {"flow frames", std::to_string(options_.flow_frames)},
                                   {"stereo", options_.is_stereo ? "pairs" : "none"},
                                   {"license", options_.license}});
  if (options_.format == "webdataset")
    settings.emplace_back("archive size", std::to_string(description.tar_bytes));
  if (const Episode& episode = description.episode; episode.fps != 0) {
    std::string numbers;
    for (const auto* list : {&episode.state_names, &episode.environment_names}) {
      for (const std::string& name : *list) numbers += name + "\n";
    }
    settings.insert(settings.end(), {{"task", episode.task},
                                     {"depth steps", episode.has_linear_depth ? "equal" : "logarithmic"},
                                     {"state", numbers}});
  }
  format_ = std::make_shared<DatasetFormat>(std::move(description), std::move(layout_), std::move(files));
  return std::shared_ptr<offline::FrameFormat>(format_);
}

Result<void> LabelledImages::check_camera(size_t index, const app::CameraRig::Placed& camera) const {
  if (camera.camera.orthographic) return orthographic(format_->description().cameras[index]);
  return {};
}

void LabelledImages::add_poses(uint64_t image, const app::CameraRig::Placed& camera,
                               const app::CameraRig::Placed* other, const state::PoseState& poses) {
  const Description& description = format_->description();
  ImagePoses now;
  now.intrinsics = passes::intrinsics_of(camera.camera, {description.width, description.height});
  now.world_from_camera = opencv_pose(camera.world_from_camera);
  if (other) {
    const auto other_k = passes::intrinsics_of(other->camera, {description.width, description.height});
    const glm::dmat4 world_from_other = opencv_pose(other->world_from_camera);
    const bool is_left = description.index_of_camera(image) % 2 == 0;
    const auto baseline_m =
        is_left ? find_baseline(now.intrinsics, now.world_from_camera, other_k, world_from_other)
                : find_baseline(other_k, world_from_other, now.intrinsics, now.world_from_camera);
    if (baseline_m)
      now.baseline_m = *baseline_m;
    else
      now.stereo_fault = "cameras " + quote(description.cameras[description.index_of_camera(image) & ~1u]) +
                         " and " + quote(description.cameras[description.index_of_camera(image) | 1u]) +
                         " have no disparity at image " + std::to_string(image) + ": " +
                         baseline_m.error().message + "; a pair has equal cameras, displaced along x";
  }
  if (randomizer_) {
    now.drawn = randomizer_->drawn();
    now.noise = randomizer_->noise();
  }
  if (state_) {
    RecordedState::Values values = state_->read(poses);
    now.state = std::move(values.state);
    now.environment = std::move(values.environment);
  }
  for (const Instance& instance : description.instances)
    now.world_from_instance.emplace_back(poses.world_from_node(instance.number - 1));
  for (const Keypoint& point : description.keypoints)
    now.world_from_keypoint_node.emplace_back(poses.world_from_node(point.node));
  format_->add_poses(image, std::move(now));
}

}  // namespace

namespace {

// nullopt: nothing is randomised.
Result<std::optional<Plan>> read_plan_of(const DatasetOptions& options) {
  if (options.randomize.empty()) return std::optional<Plan>();
  auto plan = read_plan(options.randomize);
  if (!plan) return plan.error();
  plan->seed = options.seed;
  if (!options.draws.empty()) {
    auto draws = read_given_draws(options.draws);
    if (!draws) return draws.error();
    plan->given = std::move(*draws);
  }
  return std::optional<Plan>(std::move(*plan));
}

}  // namespace

Result<void> check(const DatasetOptions& options, const scene::Scene& scene,
                   const std::filesystem::path& gltf_file) {
  const auto plan = read_plan_of(options);
  if (!plan) return plan.error();
  const std::vector<std::string>& names = options.cameras;
  for (const std::string& name : names.empty() ? std::vector{options.run.drawing.camera} : names) {
    // A camera that the overlay file adds is checked when the scene has it.
    if (!options.run.drawing.overlay.empty()) break;
    if (auto camera = app::CameraRig::create(scene, {name, false, {}, {}}); !camera) return camera.error();
  }
  LabelledImages images(options, make_layout(options.format), *plan ? &**plan : nullptr);
  images.set_is_check();
  offline::ImageSet::Settings settings;
  const auto opened = images.open_format(scene, gltf_file, settings);
  return opened ? Result<void>() : opened.error();
}

int run(const DatasetOptions& options, offline::ImageConsumer* consumer) {
  const auto plan = read_plan_of(options);
  if (!plan) return report_failure(plan.error());
  LabelledImages images(options, make_layout(options.format), *plan ? &**plan : nullptr);
  return offline::render(options.run, &images, consumer);
}

}  // namespace fire3dv::dataset
