#include "protocol/import/positions.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/import/stream_writer.h"

namespace fire3dv::imported {
namespace {

wire::StreamDescription describe(const robot::Robot& robot) {
  wire::StreamDescription description;
  description.node_names = robot.node_names();
  description.world_from_stream.m = robot.world_from_model().m;
  const std::vector<float>& numbers = robot.body_from_node();
  description.body_from_node.resize(numbers.size() / 12);
  for (size_t i = 0; i < description.body_from_node.size(); ++i)
    std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(12 * i), 12,
                description.body_from_node[i].m.begin());
  return description;
}

}  // namespace

Result<ImportReport> import_positions(robot::Robot& robot, robot::PositionRules rules,
                                      const NextRow& next_row, std::unique_ptr<record::Sink> sink) {
  constexpr int64_t kMaxTimeNs = int64_t{1} << 62;
  std::optional<StreamWriter> writer;
  std::vector<float> numbers(12 * robot.node_names().size());
  std::vector<wire::Affine3x4> poses(robot.node_names().size());
  for (uint64_t index = 0;; ++index) {
    PositionRow row;
    const auto fault = [&](const std::string& what) {
      return Error{"row " + std::to_string(index) + ": " + what};
    };
    const Result<bool> is_there = next_row(row);
    if (!is_there) return is_there.error();
    if (!*is_there) break;
    if (row.time_ns < 0 || row.time_ns >= kMaxTimeNs) return fault("its time is negative or too large");
    if (writer && row.time_ns <= writer->last_ns())
      return fault("its time is not after that of the row before");
    if (Result<void> set = robot.set_positions(row.positions, rules); !set) return fault(set.error().message);
    robot.write_poses(numbers);
    for (size_t i = 0; i < poses.size(); ++i)
      std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(12 * i), 12, poses[i].m.begin());
    if (!writer) {
      Result<StreamWriter> opened = StreamWriter::open(std::move(sink), describe(robot), row.time_ns);
      if (!opened) return opened.error();
      writer.emplace(std::move(*opened));
    }
    if (Result<void> written = writer->write(row.time_ns, poses); !written) return written.error();
  }
  if (!writer) return Error{"there is no row"};
  if (Result<void> finished = writer->finish(); !finished) return finished.error();
  ImportReport report;
  report.frames = writer->frames();
  report.first_ns = writer->first_ns();
  report.last_ns = writer->last_ns();
  return report;
}

}  // namespace fire3dv::imported
