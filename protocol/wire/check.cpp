#include "protocol/wire/check.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <initializer_list>
#include <numeric>

#include "base/text.h"

namespace fire3dv::wire {
namespace {

constexpr size_t kBlock = 16;  // poses per branch-free block

std::string describe(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "infinity" : "-infinity";
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

std::string indexed(std::string_view field, size_t index) {
  return std::string(field) + "[" + std::to_string(index) + "]";
}

Result<void> check_number(std::string_view field, double value, double limit) {
  if (std::fabs(value) <= limit) return {};
  return Error{std::string(field) + " is " + describe(value) + "; finite numbers of magnitude up to " +
               describe(limit) + " are allowed"};
}

Result<void> check_not_negative(std::string_view field, double value, double limit) {
  if (value < 0) return Error{std::string(field) + " is negative (" + describe(value) + ")"};
  return check_number(field, value, limit);
}

Result<void> check_matrix(std::string_view field, const Affine3x4d& matrix, double limit) {
  for (size_t i = 0; i < 12; ++i) {
    if (!(std::fabs(matrix.m[i]) <= limit)) return check_number(indexed(field, i), matrix.m[i], limit);
  }
  return {};
}

Result<void> check_names(std::string_view field, const std::vector<std::string>& names,
                         const DecodeLimits& limits) {
  if (names.size() > limits.max_nodes) {
    return Error{std::string(field) + " holds " + std::to_string(names.size()) + " names; at most " +
                 std::to_string(limits.max_nodes) + " are allowed"};
  }
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i].empty()) return Error{indexed(field, i) + " is empty; a node is found by its name"};
    if (!check_text({}, names[i], limits.max_name_bytes).ok()) {
      return check_text(indexed(field, i), names[i], limits.max_name_bytes);
    }
  }
  return {};
}

Result<void> first_error(std::initializer_list<Result<void>> results) {
  for (const Result<void>& result : results) {
    if (!result.ok()) return result;
  }
  return {};
}

// Indices must rise strictly (no node twice) and lie within the frame.
Result<void> check_indices(const PoseFrameView& frame) {
  const std::span<const uint32_t> indices = frame.node_indices;
  if (frame.first_node != 0)
    return Error{"PoseFrame.first_node is " + std::to_string(frame.first_node) +
                 " beside PoseFrame.node_indices; a partial frame is not cut"};
  if (indices.size() != frame.poses.size())
    return Error{"PoseFrame.node_indices names " + std::to_string(indices.size()) + " nodes for " +
                 std::to_string(frame.poses.size()) + " poses"};
  for (size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] >= frame.node_count)
      return Error{indexed("PoseFrame.node_indices", i) + " is " + std::to_string(indices[i]) +
                   ", but PoseFrame.node_count is " + std::to_string(frame.node_count)};
    if (i != 0 && indices[i] <= indices[i - 1])
      return Error{indexed("PoseFrame.node_indices", i) + " is " + std::to_string(indices[i]) + " after " +
                   std::to_string(indices[i - 1]) + "; indices must rise"};
  }
  return {};
}

constexpr const char* kEpochIsZero = "epoch is 0; an epoch is a random number that is not 0";

}  // namespace

// Sorts instead of hashing: names are untrusted, and no choice of names makes sorting slow.
Result<void> check_unique(std::string_view field, const std::vector<std::string>& names) {
  std::vector<uint32_t> order(names.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    const int way = names[a].compare(names[b]);
    return way < 0 || (way == 0 && a < b);
  });
  for (size_t i = 1; i < order.size(); ++i) {
    if (names[order[i - 1]] != names[order[i]]) continue;
    return Error{indexed(field, order[i]) + " repeats " + indexed(field, order[i - 1]) + " (\"" +
                 printable(names[order[i]]) + "\"); names must differ"};
  }
  return {};
}

Result<void> check(const StreamDescription& description, const DecodeLimits& limits) {
  if (description.epoch == 0) return Error{std::string("StreamDescription.") + kEpochIsZero};
  const size_t matrices = description.body_from_node.size();
  if (matrices > 1 && matrices != description.node_names.size()) {
    return Error{"StreamDescription.body_from_node has " + std::to_string(matrices) + " matrices for " +
                 std::to_string(description.node_names.size()) +
                 " nodes; none, one for all, or one per node are allowed"};
  }
  const double limit = static_cast<double>(limits.max_abs_value);
  const ClockInfo& clock = description.clock;
  return first_error(
      {check_text("StreamDescription.adapter_name", description.adapter_name, limits.max_name_bytes),
       check_names("StreamDescription.node_names", description.node_names, limits),
       check_unique("StreamDescription.node_names", description.node_names),
       check_matrix("StreamDescription.world_from_stream", description.world_from_stream, limit),
       check_poses("StreamDescription.body_from_node", description.body_from_node, limits.max_abs_value),
       check_not_negative("StreamDescription.nominal_rate_hz", description.nominal_rate_hz, limit),
       check_text("StreamDescription.scene_uri", description.scene_uri, limits.max_text_bytes),
       check_text("StreamDescription.clock.boot_id", clock.boot_id, limits.max_name_bytes),
       check_not_negative("StreamDescription.clock.sim_seconds_per_second", clock.sim_seconds_per_second,
                          limit)});
}

Result<void> check(const PoseFrameView& frame, const DecodeLimits& limits) {
  if (frame.header.epoch == 0) return Error{std::string("PoseFrame.") + kEpochIsZero};
  if (frame.header.sequence == 0) return Error{"PoseFrame.sequence is 0; sequences start at 1"};
  if (frame.node_count > limits.max_nodes) {
    return Error{"PoseFrame.node_count is " + std::to_string(frame.node_count) + "; at most " +
                 std::to_string(limits.max_nodes) + " nodes are allowed"};
  }
  if (!frame.node_indices.empty()) {
    if (auto good = check_indices(frame); !good) return good;
    return check_poses("PoseFrame.poses", frame.poses, limits.max_abs_value);
  }
  if (frame.first_node + uint64_t{frame.poses.size()} > frame.node_count) {
    return Error{"PoseFrame.first_node is " + std::to_string(frame.first_node) + " and " +
                 std::to_string(frame.poses.size()) + " poses follow, but PoseFrame.node_count is " +
                 std::to_string(frame.node_count)};
  }
  return check_poses("PoseFrame.poses", frame.poses, limits.max_abs_value);
}

Result<void> check(const Welcome& welcome, const DecodeLimits& limits) {
  return first_error({check_text("Welcome.renderer_name", welcome.renderer_name, limits.max_name_bytes),
                      check_text("Welcome.message", welcome.message, limits.max_text_bytes),
                      check_names("Welcome.unmatched_names", welcome.unmatched_names, limits),
                      check_names("Welcome.conflicting_names", welcome.conflicting_names, limits)});
}

Result<void> check(const Status& status, const DecodeLimits& limits) {
  if (status.epoch == 0) return Error{std::string("Status.") + kEpochIsZero};
  return first_error({check_text("Status.message", status.message, limits.max_text_bytes),
                      check_names("Status.contested_names", status.contested_names, limits)});
}

Result<void> check_text(std::string_view field, std::string_view text, size_t max_bytes) {
  if (text.size() > max_bytes) {
    return Error{std::string(field) + " has " + std::to_string(text.size()) + " bytes; at most " +
                 std::to_string(max_bytes) + " are allowed"};
  }
  for (size_t at = 0; at < text.size();) {
    const size_t start = at;
    const uint32_t character = next_character(text, at);
    if (character == kInvalidCharacter) {
      return Error{std::string(field) + " is not valid UTF-8 at byte " + std::to_string(start) + " (\"" +
                   printable(text) + "\")"};
    }
    if (is_control(character)) {
      return Error{std::string(field) + " holds a control character at byte " + std::to_string(start) +
                   " (\"" + printable(text) + "\")"};
    }
  }
  return {};
}

namespace {

// Magnitudes of floats order like the integers of their bit patterns; NaN is above all of them.
__attribute__((always_inline)) inline size_t count_good_blocks(std::span<const Affine3x4> poses,
                                                               float limit) {
  const int32_t most = std::bit_cast<int32_t>(limit);
  size_t blocks = 0;
  for (; (blocks + 1) * kBlock <= poses.size(); ++blocks) {
    const float* elements = poses[blocks * kBlock].m.data();
    int32_t bad = 0;
    for (size_t e = 0; e < 12 * kBlock; ++e)
      bad |= (std::bit_cast<int32_t>(elements[e]) & INT32_MAX) > most ? -1 : 0;
    if (bad != 0) break;
  }
  return blocks;
}

#if defined(__x86_64__)
// Publishing over shared memory is one copy of the poses: this second pass must not cost more than the copy.
__attribute__((target("avx2"))) size_t count_good_blocks_avx2(std::span<const Affine3x4> poses, float limit) {
  return count_good_blocks(poses, limit);
}
#endif

size_t good_blocks(std::span<const Affine3x4> poses, float limit) {
#if defined(__x86_64__)
  static const bool has_avx2 = __builtin_cpu_supports("avx2");
  if (has_avx2) return count_good_blocks_avx2(poses, limit);
#endif
  return count_good_blocks(poses, limit);
}

}  // namespace

Result<void> check_poses(std::string_view field, std::span<const Affine3x4> poses, float limit) {
  // Fast path: one vectorised pass over blocks. Only a bad frame is searched for its first bad element.
  const size_t checked = kBlock * good_blocks(poses, limit);
  for (size_t i = checked; i < poses.size(); ++i) {
    uint32_t good = 0;
    for (const float element : poses[i].m) good += std::fabs(element) <= limit;
    if (good == 12) continue;
    for (size_t e = 0; e < 12; ++e) {
      if (std::fabs(poses[i].m[e]) <= limit) continue;
      return Error{indexed(field, i) + " row " + std::to_string(e / 4) + " column " + std::to_string(e % 4) +
                   " is " + describe(poses[i].m[e]) + "; finite numbers of magnitude up to " +
                   describe(limit) + " are allowed"};
    }
  }
  return {};
}

std::string printable(std::string_view text, size_t max_bytes) {
  return printable_text(text, max_bytes);
}

}  // namespace fire3dv::wire
