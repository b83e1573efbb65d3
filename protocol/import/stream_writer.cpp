#include "protocol/import/stream_writer.h"

#include <utility>

#include "protocol/wire/encode.h"

namespace fire3dv::imported {
namespace {

constexpr uint64_t kPeer = 1;
constexpr uint64_t kEpoch = 1;  // equal inputs give equal bytes

}  // namespace

Result<StreamWriter> StreamWriter::open(std::unique_ptr<record::Sink> sink,
                                        wire::StreamDescription description, int64_t time_ns) {
  StreamWriter writer;
  record::LogOptions options;
  options.flush_ns = 0;
  // std::function copies what it holds.
  auto holder = std::make_shared<std::unique_ptr<record::Sink>>(std::move(sink));
  writer.log_ = std::make_unique<record::StreamLog>(
      [holder](uint32_t) -> Result<std::unique_ptr<record::Sink>> { return std::move(*holder); },
      [](record::Writer&, uint64_t) -> Result<void> { return {}; }, options);
  description.adapter_name = "states";
  description.epoch = kEpoch;
  Result<void> taken = writer.log_->take(kPeer, wire::encode(description), static_cast<uint64_t>(time_ns));
  if (!taken) return taken.error();
  return writer;
}

Result<void> StreamWriter::write(int64_t time_ns, std::span<const wire::Affine3x4> poses) {
  const auto log_time_ns = static_cast<uint64_t>(time_ns);
  wire::PoseFrameView frame;
  frame.header = {
      .epoch = kEpoch, .sequence = ++sequence_, .sim_time_ns = time_ns, .publish_time_ns = log_time_ns};
  frame.node_count = static_cast<uint32_t>(poses.size());
  frame.poses = poses;
  if (sequence_ == 1) first_ns_ = time_ns;
  last_ns_ = time_ns;
  return log_->take(kPeer, wire::encode(frame), log_time_ns);
}

Result<void> StreamWriter::finish() {
  Result<void> taken =
      log_->take(kPeer, wire::encode(wire::Goodbye{kEpoch}), static_cast<uint64_t>(last_ns_));
  if (!taken) return taken;
  return log_->finish();
}

}  // namespace fire3dv::imported
