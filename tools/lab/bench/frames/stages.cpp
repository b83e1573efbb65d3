#include "tools/lab/bench/frames/stages.h"

#include <string>

namespace fire3dv::bench {
namespace {

struct PassStage {
  std::string_view pass;
  Stage stage;
};

// Shadow maps are culled and drawn in the same dispatches as the camera view, so with shadows on "cull" and
// "raster" include them. The main pass is therefore measured with shadows off.
constexpr PassStage kTable[] = {
    {"drives", Stage::poses},      {"poses", Stage::poses},         {"transforms", Stage::poses},
    {"draws", Stage::poses},       {"morph weights", Stage::poses}, {"deform", Stage::poses},
    {"tlas", Stage::tlas},         {"deformed blas", Stage::tlas},  {"tlas wait", Stage::tlas_wait},
    {"surfaces", Stage::shading},  {"cull", Stage::cull},           {"draw commands", Stage::cull},
    {"clear", Stage::raster},      {"raster", Stage::raster},       {"expand", Stage::raster},
    {"tiles", Stage::raster},      {"depth", Stage::raster},        {"farthest depth", Stage::cull},
    {"late cull", Stage::cull},    {"late raster", Stage::raster},  {"late expand", Stage::raster},
    {"late tiles", Stage::raster}, {"light views", Stage::shadow},  {"classify", Stage::shadow},
    {"trace", Stage::shadow},      {"shade", Stage::shading},       {"shade again", Stage::shading},
    {"forward", Stage::shading},   {"post", Stage::post},           {"fxaa", Stage::post},
    {"gui", Stage::gui},           {"read-back", Stage::readback},  {"held mark", Stage::gui},
    {"counts", Stage::post},  // readback of counters
};

}  // namespace

const char* stage_name(Stage stage) {
  constexpr const char* kNames[] = {"poses",  "TLAS",    "TLAS wait", "cull", "raster",
                                    "shadow", "shading", "post",      "GUI",  "read-back"};
  static_assert(std::size(kNames) == kStages);
  return kNames[static_cast<size_t>(stage)];
}

std::optional<Stage> stage_of(std::string_view pass) {
  for (const PassStage& row : kTable) {
    if (row.pass == pass) return row.stage;
  }
  return std::nullopt;
}

double StageTimes::main_pass_ms() const {
  double sum = 0;
  for (const Stage stage : {Stage::cull, Stage::raster, Stage::shading})
    sum += ms[static_cast<size_t>(stage)];
  return sum;
}

Result<StageTimes> stage_times(const gpu::FrameTimes& times) {
  StageTimes result;
  result.frame_ms = result.between_ms = times.total_ms;
  for (const gpu::PassTime& pass : times.passes) {
    const std::optional<Stage> stage = stage_of(pass.name);
    if (!stage) {
      return Error{std::string("the pass \"") + pass.name +
                   "\" belongs to no stage of the report; give it one in tools/lab/bench/frames/stages.cpp"};
    }
    result.ms[static_cast<size_t>(*stage)] += pass.milliseconds;
    if (pass.async_compute) {
      result.aside_ms += pass.milliseconds;
    } else {
      result.between_ms -= pass.milliseconds;
    }
  }
  return result;
}

}  // namespace fire3dv::bench
