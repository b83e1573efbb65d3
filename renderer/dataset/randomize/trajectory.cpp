#include "renderer/dataset/randomize/trajectory.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>

#include "base/digest.h"
#include "base/files.h"
#include "base/numbers.h"
#include "base/text.h"
#include "base/words.h"

namespace fire3dv::dataset {
namespace {

constexpr uint64_t kMaxTrajectoryBytes = 64 << 20;
constexpr double kMaxNumber = 1e12;

}  // namespace

glm::dmat4 Trajectory::at(double share) const {
  const double time_s = poses.front().time_s + share * (poses.back().time_s - poses.front().time_s);
  const auto next = std::lower_bound(poses.begin(), poses.end(), time_s,
                                     [](const Pose& pose, double time) { return pose.time_s < time; });
  const Pose& to = next == poses.end() ? poses.back() : *next;
  const Pose& from = next == poses.begin() ? to : *(next - 1);
  const double length_s = to.time_s - from.time_s;
  const double way = length_s > 0 ? (time_s - from.time_s) / length_s : 0;
  glm::dmat4 pose = glm::mat4_cast(glm::slerp(from.world_from_camera, to.world_from_camera, way));
  pose[1] = -pose[1];
  pose[2] = -pose[2];
  pose[3] = glm::dvec4(glm::mix(from.position_m, to.position_m, way), 1);
  return pose;
}

Result<Trajectory> read_trajectory(const std::filesystem::path& file) {
  auto bytes = read_whole_file(file, kMaxTrajectoryBytes);
  if (!bytes) return bytes.error();
  Trajectory trajectory;
  trajectory.digest = hex(digest_of(std::as_bytes(std::span(*bytes)))).substr(0, 32);
  std::string_view left(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  for (size_t number = 1; !left.empty(); ++number) {
    const size_t end = std::min(left.find('\n'), left.size());
    std::string_view line = left.substr(0, end);
    left.remove_prefix(std::min(end + 1, left.size()));
    line = line.substr(0, line.find('#'));
    if (trimmed(line).empty()) continue;
    const auto wrong = [&](const std::string& text) {
      return Error{quote(file.string()) + ", line " + std::to_string(number) + ": " + text};
    };
    std::array<double, 8> values{};
    for (double& value : values) {
      const std::optional<double> parsed = parse_number<double>(next_word(line));
      if (!parsed || !(std::abs(*parsed) <= kMaxNumber))
        return wrong("a pose is TIME X Y Z QX QY QZ QW, eight numbers");
      value = *parsed;
    }
    if (!trimmed(line).empty()) return wrong("a pose is TIME X Y Z QX QY QZ QW, eight numbers");
    Trajectory::Pose pose;
    pose.time_s = values[0];
    pose.position_m = {values[1], values[2], values[3]};
    pose.world_from_camera = glm::dquat(values[7], values[4], values[5], values[6]);
    if (std::abs(glm::length(pose.world_from_camera) - 1) > 1e-2)
      return wrong("the quaternion has not the length 1");
    pose.world_from_camera = glm::normalize(pose.world_from_camera);
    if (!trajectory.poses.empty() && !(pose.time_s > trajectory.poses.back().time_s))
      return wrong("times must ascend");
    trajectory.poses.push_back(pose);
  }
  if (trajectory.poses.empty()) return Error{quote(file.string()) + " has no poses"};
  return trajectory;
}

}  // namespace fire3dv::dataset
