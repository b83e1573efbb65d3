#include "renderer/relabel/demonstration.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/plural.h"
#include "base/text.h"
#include "protocol/import/positions.h"
#include "renderer/relabel/hdf5/hdf5_table.h"

namespace fire3dv::relabel {
namespace {

// Numbers of MuJoCo's qvel: quaternions have three velocities.
size_t count_velocities(const robot::Robot& robot) {
  size_t count = robot.positions().size();
  for (const robot::RobotJoint& joint : robot.joints())
    if (joint.type == robot::JointType::ball || joint.type == robot::JointType::floating) --count;
  return count;
}

Result<std::string> choose(const std::filesystem::path& file, const std::string& wanted) {
  const auto demos = list_hdf5_group(file, "/data");
  if (!demos) return demos.error();
  if (demos->empty()) return Error{quote(file.string()) + " has no demonstration in /data"};
  const std::string some = demos->front() + (demos->size() == 1 ? "" : " to " + demos->back());
  if (wanted.empty() && demos->size() == 1) return demos->front();
  if (wanted.empty())
    return Error{quote(file.string()) + " has " + counted(demos->size(), "demonstration") + ", " + some +
                 ": choose one by --demo"};
  if (std::find(demos->begin(), demos->end(), wanted) != demos->end()) return wanted;
  return Error{"--demo: " + quote(file.string()) + " has no demonstration " + quote(wanted) + ", but " +
               some};
}

}  // namespace

Result<imported::ImportReport> import_demonstration(const std::filesystem::path& file,
                                                    const std::string& demo, robot::Robot& robot,
                                                    const std::function<bool(double)>& on_progress,
                                                    std::unique_ptr<record::Sink> sink) {
  const Result<std::string> chosen = choose(file, demo);
  if (!chosen) return chosen.error();
  const std::string path = "/data/" + *chosen + "/states";
  Result<Hdf5Table> table = Hdf5Table::open(file, path);
  if (!table) return table.error();
  const size_t positions = robot.positions().size(), velocities = count_velocities(robot);
  if (table->columns() != 1 + positions + velocities)
    return Error{quote(file.string()) + ": rows of " + path + " have " + std::to_string(table->columns()) +
                 " numbers; the scene's joints need " + std::to_string(1 + positions + velocities) +
                 " (time, " + std::to_string(positions) + " of qpos, " + std::to_string(velocities) +
                 " of qvel): name the model of these states as the scene"};
  uint64_t next = 0;
  const auto next_row = [&](imported::PositionRow& row) -> Result<bool> {
    if (next == table->rows()) return false;
    if (!on_progress(static_cast<double>(next) / static_cast<double>(table->rows()))) return Error{"stopped"};
    const auto numbers = table->row(next++);
    if (!numbers) return numbers.error();
    const double time_ns = (*numbers)[0] * 1e9;
    row.time_ns = std::abs(time_ns) < 4e18 ? static_cast<int64_t>(std::llround(time_ns)) : -1;
    row.positions = numbers->subspan(1, positions);
    return true;
  };
  auto report = imported::import_positions(robot, {.is_wxyz = true}, next_row, std::move(sink));
  if (!report) return Error{quote(file.string()) + ": " + path + ": " + report.error().message};
  report->notes.push_back("states of " + *chosen);
  return report;
}

}  // namespace fire3dv::relabel
