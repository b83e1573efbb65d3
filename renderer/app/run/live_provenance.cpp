#include "renderer/app/run/live_provenance.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>

#include "base/digest.h"
#include "base/log.h"
#include "renderer/app/options/appearance_options.h"
#include "renderer/app/stop_signals.h"
#include "renderer/editing/asset_digest.h"
#include "renderer/scene/cache/scene_digest.h"
#include "renderer/sinks/run_provenance.h"

namespace fire3dv::app {
namespace {

// Nothing without a file.
Result<void> add_digest(const char* name, const std::filesystem::path& file,
                        sinks::RunProvenance::Values& inputs) {
  constexpr uint64_t kMaxBytes = uint64_t{1} << 50;
  if (file.empty()) return {};
  const auto digest = digest_of_file(file, kMaxBytes);
  if (!digest) return digest.error();
  inputs.emplace_back(name, hex(*digest).substr(0, 32));
  return {};
}

}  // namespace

Result<std::shared_ptr<const std::string>> describe_live_run(const Options& options,
                                                             const scene::Scene& scene,
                                                             const state::EditDocument& edits,
                                                             const gpu::DeviceReport& device) {
  sinks::RunProvenance run;
  run.command = "fire3dv";
  run.build = sinks::this_build();
  run.machine = {{"device", device.name}, {"driver", device.driver}, {"cpu", sinks::cpu_name()}};
  if (!options.scene.empty()) run.files.emplace_back("scene", options.scene.filename().string());
  run.inputs.emplace_back("scene", scene::content_digest(scene));
  if (auto added = add_digest("environment", options.environment, run.inputs); !added) return added.error();
  if (auto added = add_digest("overlay", options.overlay, run.inputs); !added) return added.error();
  if (!options.overlay.empty()) {
    std::string assets = digest_of_assets(edits, {options.assets, options.overlay}, stop_was_requested);
    if (!assets.empty()) run.inputs.emplace_back("digest of added assets", std::move(assets));
  }
  Options drawn = options;
  if (options.outputs.has_planes() && !options.markers_in_data_sets) drawn.markers = false;
  run.options = appearance_options(drawn);
  std::optional<std::string> text = sinks::encode_provenance(run);
  if (!text) {
    log_message("warning: the options take more than 64 KiB: images carry no provenance");
    return std::shared_ptr<const std::string>();
  }
  return std::make_shared<const std::string>(std::move(*text));
}

}  // namespace fire3dv::app
