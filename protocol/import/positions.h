// Import of positions of all joints of a robot, row by row, such as MuJoCo's qpos: they become a recording of
// one stream, whose nodes are the robot's bodies.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "base/error.h"
#include "protocol/import/import.h"
#include "protocol/record/mcap/file.h"
#include "protocol/robot/robot.h"

namespace fire3dv::imported {

struct PositionRow {
  int64_t time_ns = 0;
  std::span<const double> positions;  // as of Robot::positions(); valid until the next row
};
// False at the end.
using NextRow = std::function<Result<bool>(PositionRow&)>;

// robot: its positions change. Fails for times that do not rise and for positions that the robot refuses,
// with the number of the row, from 0. The sink is finished on success only.
Result<ImportReport> import_positions(robot::Robot& robot, robot::PositionRules rules,
                                      const NextRow& next_row, std::unique_ptr<record::Sink> sink);

}  // namespace fire3dv::imported
