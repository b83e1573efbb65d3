#include "renderer/app/loop/path_checkpoint.h"

#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <system_error>
#include <type_traits>
#include <vector>

#include "base/log.h"
#include "renderer/scene/cache/scene_digest.h"
#include "shaders/shared/types.h"

namespace fire3dv::app {
namespace {

constexpr std::array<char, 8> kMagic{'F', '3', 'D', 'V', 'P', 'A', 'T', 'H'};
constexpr uint32_t kVersion = 1;

// Little-endian, like the sums behind it.
struct CheckpointHead {
  std::array<char, 8> magic = kMagic;
  uint32_t version = kVersion;
  uint32_t width = 0, height = 0;
  uint32_t samples = 0;
  uint64_t frame = 0;
  Digest digest{};        // of the inputs
  uint64_t checksum = 0;  // of the sums
};
static_assert(std::has_unique_object_representations_v<CheckpointHead>);

class Inputs {
 public:
  template <typename T>
  void add(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    add_bytes(std::as_bytes(std::span(&value, 1)));
  }
  void add(const glm::vec2& v) { add_all({v.x, v.y}); }
  void add(const glm::vec3& v) { add_all({v.x, v.y, v.z}); }
  void add(const glm::mat4& m) {
    for (int column = 0; column < 4; ++column) add_all({m[column].x, m[column].y, m[column].z, m[column].w});
  }
  void add(const std::string& text) { add_sized(std::as_bytes(std::span(text))); }
  void add_sized(std::span<const std::byte> bytes) {
    add(uint64_t{bytes.size()});
    add_bytes(bytes);
  }
  std::string text() const { return {reinterpret_cast<const char*>(bytes_.data()), bytes_.size()}; }
  Digest digest() const { return digest_of(bytes_); }

 private:
  void add_all(std::initializer_list<float> values) {
    for (const float value : values) add(value);
  }
  void add_bytes(std::span<const std::byte> bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  std::vector<std::byte> bytes_;
};

void add_poses(const state::PoseState& poses, Inputs& inputs) {
  static_assert(sizeof(state::NodeDrive) == 2 * sizeof(uint32_t) + sizeof(wire::Affine3x4));
  inputs.add_sized(std::as_bytes(std::span(poses.node_drives())));
  inputs.add_sized(std::as_bytes(std::span(poses.morph_weights())));
  for (const state::Stream& stream : poses.streams())
    inputs.add_sized(std::as_bytes(std::span(stream.poses)));
}

void add_view(const passes::View& view, Inputs& inputs) {
  inputs.add(view.clip_from_world);
  inputs.add(view.eye_world);
  inputs.add(view.look_world);
  inputs.add(view.orthographic);
  inputs.add(view.near_m);
  inputs.add(view.lens.f_number);
  inputs.add(view.lens.focus_distance_m);
  inputs.add(view.lens.of_stream);
  for (const glm::vec3& ray : {view.world_from_ndc_x, view.world_from_ndc_y, view.world_from_ndc_origin})
    inputs.add(ray);
  const scene::Ground ground = view.ground.value_or(scene::Ground());
  inputs.add(view.ground.has_value());
  inputs.add(ground.height_m);
  inputs.add(ground.radius_m);
  inputs.add(ground.center_world);
}

std::string inputs_of_run(const Options& options, const gpu::DeviceReport& device,
                          const std::string& environment, const std::string& run) {
  Inputs inputs;
  for (const std::string& text : {std::string(FIRE3DV_VERSION), device.name, device.driver, environment, run})
    inputs.add(text);
  const settings::DrawSettings& draw = options.draw;
  inputs.add(draw.environment_intensity);
  inputs.add(draw.environment_rotation_rad);
  inputs.add(draw.environment_sun);  // of ground shadows
  inputs.add(draw.background.show_environment);
  inputs.add(draw.background.show_sky);
  inputs.add(draw.background.color);
  inputs.add(draw.background.zenith.value_or(draw.background.color));
  inputs.add(draw.anisotropy);
  const settings::PathSettings& path = *draw.path;
  inputs.add(path.bounces);
  inputs.add(path.seed);
  inputs.add(path.lens.f_number);
  inputs.add(path.lens.focus_distance_m);
  inputs.add(static_cast<uint32_t>(path.back_end));
  return inputs.text();
}

}  // namespace

PathCheckpoint::PathCheckpoint(std::filesystem::path folder, const Options& options,
                               const gpu::DeviceReport& device, std::string environment, std::string run)
    : file_(std::move(folder) / "paths.checkpoint"),
      settings_(*options.draw.path),
      interval_(std::chrono::duration_cast<std::chrono::steady_clock::duration>(
          std::chrono::duration<double>(options.checkpoint_interval_s))),
      inputs_(inputs_of_run(options, device, environment, run)) {}

Digest PathCheckpoint::digest_of_image(const Image& image) {
  if (!scene_ || scene_->first != image.scene_number)
    scene_.emplace(image.scene_number, scene::content_digest(image.scene));
  Inputs inputs;
  inputs.add(inputs_);
  inputs.add(scene_->second);
  add_poses(image.poses, inputs);
  add_view(image.view, inputs);
  return inputs.digest();
}

void PathCheckpoint::attach(const Image& image, passes::PathHooks& hooks) {
  const Digest digest = digest_of_image(image);
  hooks.resume = load(image, digest);
  if (hooks.resume)
    log_message("info: going on after " + std::to_string(hooks.resume->samples) + " of " +
                std::to_string(settings_.samples_per_pixel) + " samples per pixel, from " + file_.string());
  hooks.save_interval = interval_;
  hooks.save = [this, frame = image.frame, extent = image.extent, digest](const passes::PathSamples& sums) {
    save(frame, extent, digest, sums);
  };
}

// The file may be anything: it comes from outside.
std::optional<passes::PathSamples> PathCheckpoint::load(const Image& image, const Digest& digest) {
  std::error_code fault;
  if (!std::filesystem::exists(std::filesystem::symlink_status(file_, fault))) return std::nullopt;
  const auto start_again = [&](const std::string& why) {
    log_message(warning(file_.string() + " " + why + ": the image starts again"));
    return std::nullopt;
  };
  const uint64_t sum_bytes = uint64_t{image.extent.width} * image.extent.height * sizeof(gpu_types::PathSum);
  Result<FileBytes> bytes = read_file(file_, sizeof(CheckpointHead) + sum_bytes);
  if (!bytes) return start_again("is no checkpoint of this image (" + bytes.error().message + ")");
  loaded_ = std::move(*bytes);
  CheckpointHead head;
  if (loaded_.size < sizeof(CheckpointHead)) return start_again("is no checkpoint");
  std::memcpy(&head, loaded_.data.get(), sizeof(CheckpointHead));
  if (head.magic != kMagic || head.version != kVersion)
    return start_again("is no checkpoint of this version of fire3dv");
  if (head.frame != image.frame) return std::nullopt;  // of an image that comes, or that is complete
  if (head.width != image.extent.width || head.height != image.extent.height || head.digest != digest)
    return start_again("is of another scene, camera, size, setting, seed or device");
  const std::span<const std::byte> sums = loaded_.view().subspan(sizeof(CheckpointHead));
  Checksum checksum;
  checksum.add(sums);
  if (sums.size() != sum_bytes || checksum.value() != head.checksum) return start_again("is damaged");
  if (head.samples == 0 || head.samples > settings_.samples_per_pixel)
    return start_again("has " + std::to_string(head.samples) + " samples per pixel, --spp wants " +
                       std::to_string(settings_.samples_per_pixel));
  return passes::PathSamples{head.samples, sums};
}

// A checkpoint that cannot be written does not end the run.
void PathCheckpoint::save(uint64_t frame, VkExtent2D extent, const Digest& digest,
                          const passes::PathSamples& sums) {
  CheckpointHead head;
  head.width = extent.width;
  head.height = extent.height;
  head.samples = sums.samples;
  head.frame = frame;
  head.digest = digest;
  Checksum checksum;
  checksum.add(sums.sums);
  head.checksum = checksum.value();
  const Result<void> written = base::write_atomically(file_, {std::as_bytes(std::span(&head, 1)), sums.sums});
  if (written || std::exchange(reported_error_, true)) return;
  log_message(warning(written.error().message + "; without a checkpoint an interrupted image starts again"));
}

void PathCheckpoint::remove() {
  std::error_code fault;
  std::filesystem::remove(file_, fault);
  base::remove_abandoned_temporaries(file_.parent_path(), file_.filename().string());  // of killed runs
}

}  // namespace fire3dv::app
