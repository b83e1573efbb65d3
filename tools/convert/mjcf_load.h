// MJCF compiled by libmujoco and posed, and calls into libmujoco that do not end the process.
#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::convert {

using MjcfModel = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using MjcfData = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

// libmujoco ends the process on a fault unless a handler does not return: so it is left by a long jump, and
// what the call had begun stays as it is. Hence the call must not hold anything with a destructor. Calls of
// several threads wait for each other, since the handlers stand for the whole process.
// warnings: gets what libmujoco warns of, 100 sentences at most; may be null.
Result<void> call_mujoco(void (*call)(void*), void* context, std::vector<std::string>* warnings);

template <typename Call>
Result<void> call_mujoco(Call&& call, std::vector<std::string>* warnings = nullptr) {
  return call_mujoco([](void* given) { (*static_cast<std::remove_reference_t<Call>*>(given))(); }, &call,
                     warnings);
}

// The caller has seen that the files are there and are files (mjcf_files.h).
Result<MjcfModel> compile_mjcf(const std::filesystem::path& file, std::vector<std::string>* warnings);

// In the first keyframe's pose, where there is one, with all that is drawn computed.
Result<MjcfData> pose_mjcf(const mjModel& model, std::vector<std::string>* warnings);

}  // namespace fire3dv::convert
