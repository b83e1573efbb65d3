// Calls on a stream, from any thread: they exclude each other, and a wait lets others in between two looks.
#pragma once

#include <time.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <utility>

#include "protocol/transport/core/fork_guard.h"
#include "stream.h"

namespace fire3dv::client {

// A call in progress. It holds the stream's lock, and fire3dv_close waits for its end.
class StreamCall {
 public:
  explicit StreamCall(fire3dv_stream& stream) : stream_(stream) {
    stream_.calls.fetch_add(1);
    stream_.mutex.lock();
  }
  ~StreamCall() {
    stream_.mutex.unlock();
    stream_.calls.fetch_sub(1);
  }
  StreamCall(const StreamCall&) = delete;
  StreamCall& operator=(const StreamCall&) = delete;

  // Repeats `look`, which returns a code or nothing, until it returns a code, the time is over (nothing), or
  // the stream is closed. Pauses are short at first: small images return within microseconds.
  template <typename Look>
  std::optional<int> wait(uint32_t timeout_ms, Look&& look) {
    constexpr long kFirstPauseNs = 20'000, kLongestPauseNs = 200'000;
    const uint64_t end_ns = monotonic_now_ns() + uint64_t{timeout_ms} * 1'000'000;
    for (long pause_ns = kFirstPauseNs;; pause_ns = std::min(pause_ns * 2, kLongestPauseNs)) {
      if (const std::optional<int> code = look()) return code;
      if (stream_.closing.load()) return fail(FIRE3DV_ERROR_STATE, "the stream is closed");
      if (monotonic_now_ns() >= end_ns) return {};
      const timespec pause{0, pause_ns};
      stream_.mutex.unlock();
      ::nanosleep(&pause, nullptr);
      stream_.mutex.lock();
    }
  }

 private:
  fire3dv_stream& stream_;
};

// guarded() for functions of a stream. The body may take the StreamCall, to wait.
template <typename Body>
int guarded(fire3dv_stream* stream, Body&& body) noexcept {
  if (!stream) return fail(FIRE3DV_ERROR_ARGUMENT, "stream is NULL");
  // The lock may be held by a thread that the child does not have.
  if (stream->is_inherited())
    return fail(FIRE3DV_ERROR_STATE,
                "the stream was opened before fork(), and is its parent's: open one in this process");
  return guarded([&] {
    StreamCall call(*stream);
    if (stream->closing.load()) return fail(FIRE3DV_ERROR_STATE, "the stream is closed");
    if constexpr (std::is_invocable_v<Body, StreamCall&>)
      return int{std::forward<Body>(body)(call)};
    else
      return int{std::forward<Body>(body)()};
  });
}

}  // namespace fire3dv::client
