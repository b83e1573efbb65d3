#include "protocol/import/lerobot/lerobot_states.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <system_error>
#include <utility>
#include <vector>

#include "base/plural.h"
#include "base/text.h"
#include "protocol/import/lerobot/lerobot_set.h"
#include "protocol/import/positions.h"
#include "protocol/robot/joint_reader.h"

namespace fire3dv::imported {
namespace {

namespace fs = std::filesystem;

std::string some_of(const std::vector<std::string>& names) {
  constexpr size_t kMaxNames = 8;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kMaxNames); ++i) text += (i ? ", " : "") + quote(names[i]);
  return text + (names.size() > kMaxNames ? ", ..." : "");
}

// Position of each number of a row; SIZE_MAX: none.
using Targets = std::vector<size_t>;

Result<Targets> find_targets(const LerobotInfo& info, size_t numbers, const std::string& prefix,
                             const std::vector<std::string>& positions, ImportReport& report) {
  Targets targets(numbers, SIZE_MAX);
  if (info.state_names.empty()) {
    if (numbers != positions.size())
      return Error{"its numbers have no names, and rows have " + std::to_string(numbers) +
                   " of them; the scene's joints have " + std::to_string(positions.size()) + ": " +
                   some_of(positions)};
    for (size_t i = 0; i < numbers; ++i) targets[i] = i;
    report.notes.push_back("numbers without names are the robot's positions in order: " + some_of(positions));
    return targets;
  }
  if (info.state_names.size() != numbers)
    return Error{"rows have " + std::to_string(numbers) + " numbers, and meta/info.json has " +
                 counted(info.state_names.size(), "name")};
  std::map<std::string_view, size_t> index_of;
  for (size_t i = 0; i < positions.size(); ++i) index_of.emplace(positions[i], i);
  std::vector<std::string> unknown, silent;
  std::vector<bool> is_set(positions.size());
  for (size_t i = 0; i < numbers; ++i) {
    std::string_view name = info.state_names[i];
    auto found = index_of.end();
    if (name.starts_with(prefix)) {
      name.remove_prefix(prefix.size());
      found = index_of.find(name);
      constexpr std::string_view kEnding = ".pos";
      if (found == index_of.end() && name.ends_with(kEnding))
        found = index_of.find(name.substr(0, name.size() - kEnding.size()));
    }
    if (found == index_of.end()) {
      unknown.push_back(info.state_names[i]);
      continue;
    }
    if (is_set[found->second]) return Error{"two of its numbers are of " + quote(std::string(found->first))};
    is_set[found->second] = true;
    targets[i] = found->second;
  }
  for (size_t i = 0; i < positions.size(); ++i) {
    if (!is_set[i]) silent.push_back(positions[i]);
  }
  if (unknown.size() == numbers)
    return Error{"no number of it is a joint of the scene: " + some_of(unknown) +
                 "; the scene's joints are " + some_of(positions)};
  if (!unknown.empty())
    report.warnings.push_back("numbers that are no joints of the scene: " + some_of(unknown));
  if (!silent.empty())
    report.warnings.push_back("joints without positions stay as in the scene: " + some_of(silent));
  return targets;
}

// Factors of positions: degrees to radians for angles.
std::vector<double> factors_of(const robot::Robot& robot, bool in_degrees) {
  std::vector<double> factors(robot.positions().size(), 1);
  constexpr double kDegree = std::numbers::pi / 180;
  for (const robot::RobotJoint& joint : robot.joints()) {
    if (!in_degrees || joint.position_count == 0) continue;
    if (joint.type == robot::JointType::revolute) factors[joint.position_index] = kDegree;
    if (joint.type == robot::JointType::planar) factors[joint.position_index + 2] = kDegree;
  }
  return factors;
}

Result<uint64_t> choose_episode(const LerobotInfo& info, const std::optional<uint64_t>& wanted) {
  if (wanted && *wanted < info.episodes) return *wanted;
  if (!wanted && info.episodes == 1) return uint64_t{0};
  const std::string some =
      info.episodes == 0
          ? "no episode"
          : counted(info.episodes, "episode") + ", 0" +
                (info.episodes > 1 ? " to " + std::to_string(info.episodes - 1) : std::string());
  return Error{"it has " + some + (wanted ? ", and not " + std::to_string(*wanted) : std::string()) +
               (info.episodes > 1 ? ": choose one by --episode" : "")};
}

}  // namespace

bool is_lerobot_set(const fs::path& folder) {
  std::error_code fault;
  return fs::is_directory(folder, fault) && fs::is_regular_file(folder / "meta/info.json", fault);
}

Result<ImportReport> import_lerobot(const fs::path& folder, const LerobotChoices& choices,
                                    robot::Robot& robot, const std::function<bool(double)>& on_progress,
                                    std::unique_ptr<record::Sink> sink) {
  const auto fault = [&](const std::string& what) { return Error{quote(folder.string()) + ": " + what}; };
  const auto info = read_lerobot_info(folder);
  if (!info) return info.error();
  const auto episode = choose_episode(*info, choices.episode);
  if (!episode) return fault(episode.error().message);
  const auto rows = read_episode(folder, *info, *episode);
  if (!rows) return rows.error();
  ImportReport found;
  const std::vector<std::string> names = robot::position_names(robot);
  const auto targets = find_targets(*info, rows->state.width, choices.prefix, names, found);
  if (!targets) return fault(std::string(kStateColumn) + ": " + targets.error().message);
  const std::vector<double> factors = factors_of(robot, choices.in_degrees);

  std::vector<double> positions = robot.positions();
  size_t next = 0;
  const auto next_row = [&](PositionRow& row) -> Result<bool> {
    const size_t count = rows->frame_index.size();
    if (next == count) return false;
    if (!on_progress(static_cast<double>(next) / static_cast<double>(count))) return Error{"stopped"};
    for (size_t i = 0; i < targets->size(); ++i) {
      if (const size_t target = (*targets)[i]; target != SIZE_MAX)
        positions[target] = rows->state.values[next * targets->size() + i] * factors[target];
    }
    const double time_ns = rows->frame_index[next++] / info->fps * 1e9;
    row.time_ns = std::abs(time_ns) < 4e18 ? static_cast<int64_t>(std::llround(time_ns)) : -1;
    row.positions = positions;
    return true;
  };
  auto report = import_positions(robot, {}, next_row, std::move(sink));
  if (!report) return fault("episode " + std::to_string(*episode) + ": " + report.error().message);
  report->notes = std::move(found.notes);
  report->warnings = std::move(found.warnings);
  report->notes.push_back("states of episode " + std::to_string(*episode) + " of " +
                          std::to_string(info->episodes));
  return report;
}

}  // namespace fire3dv::imported
