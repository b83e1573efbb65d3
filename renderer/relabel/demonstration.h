// Demonstrations of robomimic and LIBERO: HDF5 files with states of MuJoCo, imported by the joints of a
// scene.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "base/error.h"
#include "protocol/import/import.h"
#include "protocol/record/mcap/file.h"
#include "protocol/robot/robot.h"

namespace fire3dv::relabel {

// Rows of /data/DEMO/states are time, qpos and qvel. demo empty: the only one. robot: of the model, without
// mimic. Fails for rows of another length than the model's.
Result<imported::ImportReport> import_demonstration(const std::filesystem::path& file,
                                                    const std::string& demo, robot::Robot& robot,
                                                    const std::function<bool(double)>& on_progress,
                                                    std::unique_ptr<record::Sink> sink);

}  // namespace fire3dv::relabel
