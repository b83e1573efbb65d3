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
  if (Result<void> taken = writer.take(wire::encode(description), time_ns); !taken) return taken.error();
  return writer;
}

Result<void> StreamWriter::take(std::span<const std::byte> message, int64_t time_ns) {
  if (Result<void> taken = log_->take(kPeer, message, static_cast<uint64_t>(time_ns)); !taken) return taken;
  if (log_->refused() == 0) return {};
  return Error{"a pose is beyond 1e12, or a node's name is longer than 1024 bytes: recordings hold neither"};
}

Result<void> StreamWriter::write(int64_t time_ns, std::span<const wire::Affine3x4> poses) {
  wire::PoseFrameView frame;
  frame.header = {.epoch = kEpoch,
                  .sequence = ++sequence_,
                  .sim_time_ns = time_ns,
                  .publish_time_ns = static_cast<uint64_t>(time_ns)};
  frame.node_count = static_cast<uint32_t>(poses.size());
  frame.poses = poses;
  if (sequence_ == 1) first_ns_ = time_ns;
  last_ns_ = time_ns;
  return take(wire::encode(frame), time_ns);
}

Result<void> StreamWriter::finish() {
  if (Result<void> taken = take(wire::encode(wire::Goodbye{kEpoch}), last_ns_); !taken) return taken;
  return log_->finish();
}

}  // namespace fire3dv::imported
