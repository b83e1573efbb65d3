#include <time.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "protocol/wire/check.h"
#include "stream.h"

namespace fire3dv::client {
namespace {

constexpr size_t kMaxNameBytesInAll = size_t{128} << 20;

int64_t realtime_ns() noexcept {
  timespec time{};
  ::clock_gettime(CLOCK_REALTIME, &time);
  return int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

wire::DecodeLimits outgoing_limits() {
  return {};
}

wire::DecodeLimits incoming_limits() {
  wire::DecodeLimits limits;
  limits.max_message_bytes = size_t{64} << 20;  // a Welcome may list every name of a large scene
  return limits;
}

wire::ClockInfo read_clocks() {
  wire::ClockInfo clocks;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> clocks.boot_id;  // stays empty without /proc
  if (!wire::check_text("boot_id", clocks.boot_id, 64).ok()) clocks.boot_id.clear();
  clocks.monotonic_at_open_ns = monotonic_now_ns();
  clocks.realtime_at_open_ns = realtime_ns();
  return clocks;
}

Result<wire::StreamDescription> read_description(const fire3dv_description& description) {
  const wire::DecodeLimits limits = outgoing_limits();
  if (description.node_count > limits.max_nodes) {
    return Error{"node_count is " + std::to_string(description.node_count) + "; at most " +
                 std::to_string(limits.max_nodes) + " nodes are allowed"};
  }
  if (description.node_count > 0 && !description.node_names) return Error{"node_names is NULL"};
  const size_t matrices = description.body_from_node_count;
  if (matrices > 1 && matrices != description.node_count) {
    return Error{"body_from_node_count is " + std::to_string(matrices) + "; 0, 1 or node_count (" +
                 std::to_string(description.node_count) + ") are allowed"};
  }
  if (matrices > 0 && !description.body_from_node)
    return Error{"body_from_node is NULL but its count is not 0"};

  wire::StreamDescription result;
  size_t name_bytes = 0;
  for (size_t i = 0; i < description.node_count; ++i) {
    const char* name = description.node_names[i];
    if (!name) return Error{"node_names[" + std::to_string(i) + "] is NULL"};
    // One byte above the limit suffices for the check below to refuse the name.
    result.node_names.emplace_back(name, ::strnlen(name, limits.max_name_bytes + 1));
    name_bytes += result.node_names.back().size();
  }
  if (name_bytes > kMaxNameBytesInAll)
    return Error{"node_names are longer than 128 MiB together: use shorter names"};
  if (description.world_from_stream) {
    std::copy_n(description.world_from_stream, 12, result.world_from_stream.m.begin());
  }
  result.body_from_node.resize(matrices);
  for (size_t i = 0; i < matrices; ++i) {
    std::copy_n(description.body_from_node + 12 * i, 12, result.body_from_node[i].m.begin());
  }
  result.nominal_rate_hz = description.nominal_rate_hz;
  if (description.scene_uri) {
    result.scene_uri.assign(description.scene_uri,
                            ::strnlen(description.scene_uri, limits.max_text_bytes + 1));
  }
  result.epoch = 1;  // placeholder, not 0; the stream sets its own epoch
  const Result<void> good = wire::check(result, limits);
  if (!good.ok()) return good.error();
  return result;
}

bool struct_is_known(const void* data, size_t struct_size, size_t known_size) {
  constexpr size_t kSaneSize = 4096;
  if (struct_size < known_size || struct_size > kSaneSize) return false;
  const auto* bytes = static_cast<const unsigned char*>(data);
  return std::all_of(bytes + known_size, bytes + struct_size, [](unsigned char byte) { return byte == 0; });
}

}  // namespace fire3dv::client
