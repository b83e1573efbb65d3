#include "tools/record/recorder.h"

#include <chrono>
#include <cstdio>

#include "protocol/transport/clock.h"
#include "protocol/wire/encode.h"

namespace fire3dv::record {
namespace {

using transport::LinkEvent;

// What waits for the disk. Poses beyond it are left out and counted; what is not a pose may take twice as
// much.
constexpr uint64_t kMostQueuedBytes = uint64_t{256} << 20;
constexpr auto kTickEvery = std::chrono::milliseconds(100);

}  // namespace

Recorder::Recorder(StreamLog log)
    : monotonic_at_start_ns_(transport::monotonic_ns()),
      unix_at_start_ns_(std::chrono::duration_cast<std::chrono::nanoseconds>(
                            std::chrono::system_clock::now().time_since_epoch())
                            .count()),
      log_(std::move(log)),
      thread_([this] { run(); }) {}

Recorder::~Recorder() {
  finish();
}

// Wall time that never jumps: read once, and then counted on.
uint64_t Recorder::unix_ns(int64_t monotonic_ns) const {
  const int64_t now_ns = unix_at_start_ns_ + (monotonic_ns - monotonic_at_start_ns_);
  return now_ns > 0 ? static_cast<uint64_t>(now_ns) : 0;
}

void Recorder::push(Incoming incoming, bool may_drop) {
  const uint64_t bytes = incoming.message.size() + sizeof(Incoming);
  const std::lock_guard lock(mutex_);
  if (status_.failure) return;
  // That a peer is gone is never left out: its stream would seem to live for ever.
  if (!incoming.message.empty() &&
      queued_bytes_ + bytes > (may_drop ? kMostQueuedBytes : 2 * kMostQueuedBytes)) {
    ++dropped_;
    return;
  }
  queued_bytes_ += bytes;
  queue_.push_back(std::move(incoming));
  wake_.notify_one();
}

void Recorder::poll(transport::ListenerLink& link, uint32_t link_number, bool answers) {
  link.poll([&](const LinkEvent& event) {
    const uint64_t peer = uint64_t{link_number} << 48 | event.peer;
    const int64_t at_ns = event.received_ns != 0 ? event.received_ns : transport::monotonic_ns();
    switch (event.kind) {
      case LinkEvent::Kind::note:
        std::fprintf(stderr, "fire3dv-record: %s\n", std::string(event.text).c_str());
        break;
      case LinkEvent::Kind::disconnected:
        push({peer, unix_ns(at_ns), {}}, false);
        break;
      case LinkEvent::Kind::pose:
      case LinkEvent::Kind::control:
        if (answers && event.kind == LinkEvent::Kind::control) answer(link, event.peer, event.message);
        push({peer, unix_ns(at_ns), wire::Bytes(event.message.begin(), event.message.end())},
             event.kind == LinkEvent::Kind::pose);
        break;
      case LinkEvent::Kind::connected:
        break;
    }
  });
}

// A publisher that has only us to talk to hears that its stream is taken. Images are shown nowhere: no frame
// is acknowledged.
void Recorder::answer(transport::ListenerLink& link, transport::PeerId peer,
                      std::span<const std::byte> message) {
  const auto decoded = decoder_.decode(message);
  if (!decoded) return;
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
    wire::Welcome welcome;
    welcome.renderer_name = "fire3dv-record";
    welcome.epoch = description->epoch;
    if (description->protocol_major != wire::kProtocolMajor)
      welcome.status = wire::WelcomeStatus::version_mismatch;
    link.send(peer, wire::encode(welcome));
  } else if (const auto* ping = std::get_if<wire::Ping>(&*decoded)) {
    link.send(peer, wire::encode(wire::Pong{ping->id, ping->sender_time_ns,
                                            static_cast<uint64_t>(transport::monotonic_ns())}));
  }
}

void Recorder::run() {
  std::deque<Incoming> batch;
  for (bool over = false; !over;) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, kTickEvery, [&] { return over_ || !queue_.empty(); });
      batch.swap(queue_);
      queued_bytes_ = 0;
      over = over_ && batch.empty();
    }
    Result<void> good;
    size_t taken = 0;
    for (; good && taken < batch.size(); ++taken) {
      const Incoming& incoming = batch[taken];
      if (incoming.message.empty())
        log_.end_peer(incoming.peer);
      else
        good = log_.take(incoming.peer, incoming.message, incoming.log_time_ns);
    }
    if (good) good = log_.tick(unix_ns(transport::monotonic_ns()));
    if (!good) dropped_ += batch.size() - taken;
    batch.clear();
    if (!good || over) {
      const auto finished = log_.finish();
      if (good) good = finished;
      over = true;
    }
    const std::lock_guard lock(mutex_);
    status_.streams = log_.streams();
    status_.file_bytes = log_.file_bytes();
    status_.files = log_.files();
    status_.refused = log_.refused();
    status_.unkept_edits = log_.unkept_edits();
    status_.unwritten = dropped_ + log_.lost_messages();
    if (!good) status_.failure = good.error().message;
  }
}

void Recorder::finish() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

RecorderStatus Recorder::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

}  // namespace fire3dv::record
