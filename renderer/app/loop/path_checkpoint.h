// Checkpoint file of a path-traced image: the sums of its samples so far, beside the images of a run. After
// an interruption the same run goes on there, to the same bytes.
//
// The file `paths.checkpoint` belongs to one image: it holds its number, size, samples and a digest of
// everything else that decides the sums. It is replaced atomically and checked like any file from outside.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "base/digest.h"
#include "base/files.h"
#include "renderer/app/options/options.h"
#include "renderer/gpu/device/device.h"
#include "renderer/passes/path/path_pass.h"
#include "renderer/passes/view/view.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

class PathCheckpoint {
 public:
  // folder: of the images. run: text of inputs that are neither options of drawing nor in the arguments of
  // attach(), such as scene edits. environment: digest of its file; empty: the studio environment.
  PathCheckpoint(std::filesystem::path folder, const Options& options, const gpu::DeviceReport& device,
                 std::string environment, std::string run = {});

  // Parts of an image.
  struct Image {
    uint64_t frame = 0;
    VkExtent2D extent{};
    const state::PoseState& poses;
    const passes::View& view;
    const scene::Scene& scene;
    uint64_t scene_number = 0;  // another one for each scene
  };
  // Sets `resume` and `save` of the hooks for one image; *this must outlive their use. A file that does not
  // fit is reported and not used.
  void attach(const Image& image, passes::PathHooks& hooks);
  // Removes the file: all images are written.
  void remove();

 private:
  Digest digest_of_image(const Image& image);
  std::optional<passes::PathSamples> load(const Image& image, const Digest& digest);
  void save(uint64_t frame, VkExtent2D extent, const Digest& digest, const passes::PathSamples& sums);

  const std::filesystem::path file_;
  const settings::PathSettings settings_;
  const std::chrono::steady_clock::duration interval_;
  const std::string inputs_;                               // of all images
  std::optional<std::pair<uint64_t, std::string>> scene_;  // number and digest of the last scene
  FileBytes loaded_;
  bool reported_error_ = false;
};

}  // namespace fire3dv::app
