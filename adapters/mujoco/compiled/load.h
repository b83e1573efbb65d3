// MJCF through libmujoco: compilation and forward kinematics without process termination on faults.
#pragma once

#include <mujoco/mujoco.h>
#include <filesystem>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "base/error.h"

namespace fire3dv::convert {

using MjcfModel = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using MjcfData = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

// Calls libmujoco and converts a fault to an error. libmujoco exits on a fault unless its handler does not
// return, so the handler uses longjmp; objects of the call stay half-built.
// call: must not own objects with destructors. Calls of several threads are serialised, since handlers are
// per process.
// warnings: receives at most 100 messages; may be null.
Result<void> call_mujoco(void (*call)(void*), void* context, std::vector<std::string>* warnings);

template <typename Call>
Result<void> call_mujoco(Call&& call, std::vector<std::string>* warnings = nullptr) {
  return call_mujoco([](void* given) { (*static_cast<std::remove_reference_t<Call>*>(given))(); }, &call,
                     warnings);
}

// The caller has validated the files with model_files.h.
Result<MjcfModel> compile_mjcf(const std::filesystem::path& file, std::vector<std::string>* warnings);

// Poses the model in its first keyframe, if any, and computes everything that is drawn.
Result<MjcfData> pose_mjcf(const mjModel& model, std::vector<std::string>* warnings);

}  // namespace fire3dv::convert
