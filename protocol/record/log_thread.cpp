#include "protocol/record/log_thread.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "base/clock.h"
#include "base/plural.h"
#include "base/process/failure.h"
#include "base/process/start_thread.h"
#include "base/text.h"

namespace fire3dv::record {
namespace {

constexpr auto kTickEvery = std::chrono::milliseconds(100);
constexpr uint64_t kBytesBetweenGivingBack = 1 << 20;
constexpr size_t kMaxNamedStreams = 8;  // in a sentence

}  // namespace

std::optional<std::string> describe_gaps(const LogStatus& status) {
  std::string text;
  size_t named = 0, unnamed = 0;
  for (const StreamSeen& stream : status.streams) {
    if (stream.missing == 0 && stream.incomplete == 0) continue;
    if (named++ >= kMaxNamedStreams) {
      ++unnamed;
      continue;
    }
    if (!text.empty()) text += "; ";
    text += "stream \"" + terminal_text(stream.name) + "\" lacks " + counted(stream.missing, "frame") +
            " of " + std::to_string(stream.frames + stream.missing);
    if (stream.incomplete != 0) text += ", and " + counted(stream.incomplete, "frame") + " in part";
  }
  if (unnamed != 0) text += "; and " + counted(unnamed, "more stream");
  if (status.reclaimed_missing != 0) {
    if (!text.empty()) text += "; ";
    text += "streams that ended earlier lack " + counted(status.reclaimed_missing, "frame");
  }
  if (text.empty()) return {};
  return text +
         ": they were lost on the way, or not read in time (use tcp or tls instead of udp, or a machine "
         "with less load)";
}

LogThread::LogThread(StreamLog log, uint64_t max_queued_bytes)
    : monotonic_at_start_ns_(monotonic_ns()),
      unix_at_start_ns_(std::chrono::system_clock::now().time_since_epoch() / std::chrono::nanoseconds(1)),
      max_queued_bytes_(max_queued_bytes),
      log_(std::move(log)),
      thread_(start_thread("recording", [this] { run(); })) {}

LogThread::~LogThread() {
  finish();
}

// Unix time without jumps: the wall clock is read once and advanced by the monotonic clock.
uint64_t LogThread::unix_ns(int64_t at_ns) const {
  const int64_t now_ns = unix_at_start_ns_ + (at_ns - monotonic_at_start_ns_);
  return now_ns > 0 ? static_cast<uint64_t>(now_ns) : 0;
}

void LogThread::push(Incoming incoming, bool may_drop) {
  const uint64_t bytes = incoming.bytes();
  bool first = false;
  {
    const std::lock_guard lock(mutex_);
    if (over_) return;
    if (status_.failure) {
      ++dropped_;
      return;
    }
    // Ends of peers are never dropped: their streams would appear to live forever.
    const uint64_t max_bytes = may_drop ? max_queued_bytes_ : 2 * max_queued_bytes_;
    if (!incoming.message.empty() && queued_bytes_ + bytes > max_bytes) {
      ++dropped_;
      trouble_ = true;
      return;
    }
    queued_bytes_ += bytes;
    first = queue_.empty();
    queue_.push_back(std::move(incoming));
  }
  if (first) wake_.notify_one();
}

void LogThread::take(uint64_t peer, std::span<const std::byte> message, int64_t at_ns, bool is_pose) {
  if (!message.empty()) push({peer, unix_ns(at_ns), Bytes(message.begin(), message.end())}, is_pose);
}

void LogThread::end_peer(uint64_t peer, int64_t at_ns) {
  push({peer, unix_ns(at_ns), {}}, false);
}

// Number of messages without the end-of-peer markers, which share the queue.
uint64_t LogThread::messages_in(const std::deque<Incoming>& queue) {
  return static_cast<uint64_t>(
      std::ranges::count_if(queue, [](const Incoming& incoming) { return !incoming.message.empty(); }));
}

void LogThread::run() {
  try {
    write_until_over();
  } catch (const std::exception& failure) {
    const std::lock_guard lock(mutex_);
    status_.failure = "the recording ended: " + describe_failure(failure);
    dropped_ += messages_in(queue_);
    queue_.clear();
    trouble_ = true;
  }
}

void LogThread::write_until_over() {
  std::deque<Incoming> batch;
  for (bool over = false; !over;) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, kTickEvery, [&] { return over_ || !queue_.empty(); });
      batch.swap(queue_);
      over = over_ && batch.empty();
    }
    Result<void> good;
    uint64_t written_bytes = 0;
    for (; good && !batch.empty(); batch.pop_front()) {
      const Incoming& incoming = batch.front();
      if (incoming.message.empty())
        log_.end_peer(incoming.peer);
      else
        good = log_.take(incoming.peer, incoming.message, incoming.log_time_ns);
      written_bytes += incoming.bytes();
      if (written_bytes >= kBytesBetweenGivingBack) give_back(std::exchange(written_bytes, 0));
    }
    give_back(written_bytes);
    if (good) good = log_.tick(unix_ns(monotonic_ns()));
    const uint64_t lost = messages_in(batch);
    batch.clear();
    if (!good || over) {
      const auto finished = log_.finish();
      if (good) good = finished;
      over = true;
    }
    LogStatus status{log_.streams(),
                     log_.file_bytes(),
                     log_.files(),
                     log_.refused(),
                     log_.dropped_edits(),
                     log_.reclaimed_streams(),
                     log_.reclaimed_frames(),
                     log_.unrecorded_streams(),
                     log_.lost_messages(),
                     {},
                     log_.unconverted_markers(),
                     log_.reclaimed_missing(),
                     log_.name_fault()};
    if (!good) status.failure = good.error().message;
    const std::lock_guard lock(mutex_);
    dropped_ += lost;
    if (status.failure) {  // messages queued in the meantime are lost as well
      dropped_ += messages_in(queue_);
      queue_.clear();
    }
    if (status.failure || status.unwritten != 0 || status.unrecorded_streams != 0 || status.name_fault)
      trouble_ = true;
    status_ = std::move(status);
  }
}

// Called after the write: messages that the thread still holds for a slow disk count as queued memory.
void LogThread::give_back(uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  queued_bytes_ -= bytes;
}

void LogThread::finish() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

LogLosses LogThread::losses() const {
  const std::lock_guard lock(mutex_);
  return {status_.unwritten + dropped_, status_.unrecorded_streams, status_.failure, status_.name_fault};
}

LogStatus LogThread::status() const {
  const std::lock_guard lock(mutex_);
  LogStatus status = status_;
  status.unwritten += dropped_;
  return status;
}

}  // namespace fire3dv::record
