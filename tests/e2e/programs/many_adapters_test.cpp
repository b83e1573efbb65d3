// Load test of the links: 64 adapter processes publish poses of 100 nodes at 1 kHz to one reader. Memory
// stays bounded, dropped frames are counted, and no stream starves. An overloaded machine drops evenly across
// streams.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <map>

#include "base/clock.h"
#include "protocol/transport/open.h"
#include "protocol/wire/decode.h"
#include "tests/e2e/programs/self_identifying_frames.h"
#include "tests/unit/protocol/transport/child.h"

namespace fire3dv::test {
namespace {

using fire3dv::monotonic_ns;

constexpr size_t kAdapters = 64;
constexpr size_t kNodes = 100;
constexpr int64_t kEveryNs = 1'000'000;
constexpr int64_t kForNs = 2'000'000'000;
constexpr uint64_t kPosesForAMean = 20'000;  // minimum of each stream: with fewer, chance decides the shares
constexpr int64_t kHangNs = int64_t{120} * 1'000'000'000;
// Each of the 64 streams may hold a few frames of 5 kB; unbounded queues would take far more.
constexpr size_t kMaxGrowthBytes = size_t{64} << 20;

// Shared memory between the test and the adapter processes.
struct Board {
  struct Adapter {
    std::atomic<bool> connected, done;
    std::atomic<uint64_t> published, dropped;
  };
  std::atomic<bool> go, stop, leave;
  Adapter adapters[kAdapters];
};

void adapt(Board& board, const std::string& uri, uint64_t index) {
  Board::Adapter& here = board.adapters[index];
  // On a machine with few cores the reader competes with 64 processes: the test is about the reader, not the
  // scheduler.
  (void)!::nice(10);
  SelfIdentifyingPublisher simulator(uri, index, kNodes);
  if (!simulator.good()) ::_exit(1);
  while (simulator.poll().renderers == 0) ::usleep(1000);
  here.connected = true;
  while (!board.go) ::usleep(1000);
  for (int64_t next_ns = monotonic_ns(); !board.stop;) {
    if (!simulator.publish(0)) ::_exit(1);
    simulator.poll();
    // Missed deadlines are not made up for: a burst of frames counts as one for a reader of the newest.
    const int64_t now_ns = monotonic_ns();
    next_ns = std::max(next_ns + kEveryNs, now_ns + kEveryNs / 2);
    ::usleep(static_cast<useconds_t>((next_ns - now_ns) / 1000));
  }
  here.published = simulator.published();
  here.done = true;
  while (!board.leave) {
    here.dropped = simulator.poll().frames_dropped;
    ::usleep(1000);
  }
}

size_t resident_bytes() {
  size_t total = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  return resident * static_cast<size_t>(::sysconf(_SC_PAGESIZE));
}

// Complete frames of one stream.
struct Stream {
  uint64_t run = 0, sequence = 0, frames = 0;
  size_t poses = 0;        // received poses of the current frame
  uint64_t all_poses = 0;  // over udp poses of incomplete frames count, too
};

class Reader {
 public:
  explicit Reader(const std::string& scheme) {
    const size_t links = scheme == "shm" ? kAdapters : 1;  // a segment has one publisher
    for (size_t i = 0; i < links; ++i) {
      std::string uri = scheme + "://127.0.0.1:0";
      if (scheme == "shm") uri = "shm://test-many-" + std::to_string(::getpid()) + "-" + std::to_string(i);
      auto opened = transport::open_listener(uri);
      EXPECT_TRUE(opened.ok()) << opened.error().message;
      links_.push_back(std::move(*opened));
    }
  }

  std::string uri_of(size_t adapter) const { return links_[links_.size() == 1 ? 0 : adapter]->uri(); }

  void poll() {
    links_[0]->wait(links_.size() == 1 ? std::chrono::microseconds(1000) : std::chrono::microseconds(100));
    for (size_t i = 0; i < links_.size(); ++i) {
      links_[i]->poll([&](const transport::LinkEvent& event) {
        using Kind = transport::LinkEvent::Kind;
        if (event.kind == Kind::note) ADD_FAILURE() << event.text;
        if (event.kind == Kind::control || event.kind == Kind::pose)
          take(streams_[{i, event.peer}], event.message);
      });
    }
  }

  std::map<uint64_t, Stream> by_run() const {
    std::map<uint64_t, Stream> streams;
    for (const auto& [peer, stream] : streams_) streams[stream.run] = stream;
    return streams;
  }
  uint64_t poses() const { return poses_; }
  transport::LinkStats stats() const {
    transport::LinkStats sum;
    for (const auto& link : links_) {
      sum.poses_dropped += link->stats().poses_dropped;
      sum.frames_dropped += link->stats().frames_dropped;
      sum.rejected += link->stats().rejected;
    }
    return sum;
  }

 private:
  void take(Stream& stream, std::span<const std::byte> bytes) {
    const auto message = decoder_.decode(bytes);
    ASSERT_TRUE(message.ok()) << message.error().message;
    if (const auto* description = std::get_if<wire::StreamDescription>(&*message)) {
      stream.run = std::stoull(description->adapter_name.substr(4));
    } else if (const auto* frame = std::get_if<wire::PoseFrameView>(&*message)) {
      ASSERT_TRUE(tells(stream.run, frame->header.sequence, frame->first_node, frame->poses));
      if (frame->header.sequence < stream.sequence) return;  // a late part of a superseded frame
      if (frame->header.sequence > stream.sequence) stream.poses = 0;
      stream.sequence = frame->header.sequence;
      stream.poses += frame->poses.size();
      stream.all_poses += frame->poses.size();
      poses_ += frame->poses.size();
      if (stream.poses == kNodes) ++stream.frames;
    }
  }

  std::vector<std::unique_ptr<transport::ListenerLink>> links_;
  std::map<std::pair<size_t, transport::PeerId>, Stream> streams_;
  wire::Decoder decoder_;
  uint64_t poses_ = 0;
};

class ManyAdapters : public testing::TestWithParam<const char*> {};

TEST_P(ManyAdapters, BacklogAndStarvationAreBounded) {
  auto* const board =
      new (::mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) Board{};
  Reader reader(GetParam());
  std::vector<std::unique_ptr<transport::test::Child>> adapters;
  for (size_t i = 0; i < kAdapters; ++i)
    adapters.push_back(std::make_unique<transport::test::Child>([&] { adapt(*board, reader.uri_of(i), i); }));
  const auto all = [&](auto&& holds) {
    return std::all_of(std::begin(board->adapters), std::end(board->adapters), holds);
  };
  const auto poll_until = [&](auto&& holds) {
    for (const int64_t until = monotonic_ns() + kHangNs; !holds() && monotonic_ns() < until;) reader.poll();
    return holds();
  };
  ASSERT_TRUE(
      poll_until([&] { return all([](const Board::Adapter& one) { return one.connected.load(); }); }));

  const size_t resident_before = resident_bytes();
  const int64_t begin_ns = monotonic_ns();
  board->go = true;
  EXPECT_TRUE(poll_until(
      [&] { return monotonic_ns() - begin_ns >= kForNs && reader.poses() >= kAdapters * kPosesForAMean; }));
  board->stop = true;
  ASSERT_TRUE(poll_until([&] { return all([](const Board::Adapter& one) { return one.done.load(); }); }));
  const double seconds = static_cast<double>(monotonic_ns() - begin_ns) / 1e9;
  // The newest frame always arrives. Once it is here, each frame of a stream has arrived or was dropped.
  const auto all_here = [&] {
    const auto streams = reader.by_run();
    for (size_t i = 0; i < kAdapters; ++i) {
      const auto stream = streams.find(i);
      if (stream == streams.end() || stream->second.sequence != board->adapters[i].published ||
          stream->second.poses < kNodes)
        return false;
    }
    return true;
  };
  EXPECT_TRUE(poll_until(all_here));
  const size_t resident_after = resident_bytes();
  for (const int64_t until = monotonic_ns() + 50'000'000; monotonic_ns() < until;) reader.poll();
  board->leave = true;

  uint64_t published = 0, dropped = 0, frames = 0;
  double mean_share = 0, least_share = 2;  // fraction of a stream's poses that arrived
  uint64_t least_run = 0;
  for (const auto& [run, stream] : reader.by_run()) {
    published += board->adapters[run].published;
    dropped += board->adapters[run].dropped;
    frames += stream.frames;
    const double share =
        static_cast<double>(stream.all_poses) / static_cast<double>(board->adapters[run].published * kNodes);
    mean_share += share / kAdapters;
    if (share < least_share) least_run = run;
    least_share = std::min(least_share, share);
  }
  EXPECT_GE(least_share, mean_share / 2) << "stream " << least_run << " starves: it published "
                                         << board->adapters[least_run].published << " frames";
  EXPECT_LT(resident_after, resident_before + kMaxGrowthBytes) << "frames pile up";
  EXPECT_EQ(reader.stats().rejected, 0u);
  // Received frames that were superseded before the read: udp counts their parts, the other links the frames.
  const transport::LinkStats stats = reader.stats();
  const uint64_t counted = frames + dropped + stats.poses_dropped + stats.frames_dropped;
  if (std::string_view(GetParam()) == "udp") {
    EXPECT_GE(counted, published) << "a frame is lost without a count";
    EXPECT_LE(frames + stats.frames_dropped, published);
  } else {
    EXPECT_EQ(counted, published) << "a frame is lost without a count";
  }
  std::printf(
      "| %s | %.0f | %.0f | %.2f M | %.0f %% | %.1f MiB | %llu by the adapters, %llu messages and %llu "
      "frames by the reader |\n",
      GetParam(), static_cast<double>(published) / seconds / kAdapters, static_cast<double>(frames) / seconds,
      static_cast<double>(reader.poses()) / seconds / 1e6, 100 * least_share / mean_share,
      (static_cast<double>(resident_after) - static_cast<double>(resident_before)) / (1 << 20),
      static_cast<unsigned long long>(dropped), static_cast<unsigned long long>(stats.poses_dropped),
      static_cast<unsigned long long>(stats.frames_dropped));
  for (const auto& adapter : adapters) adapter->join();  // each removes its segment
  ::munmap(board, sizeof(Board));
}

INSTANTIATE_TEST_SUITE_P(Transports, ManyAdapters, testing::Values("shm", "tcp", "udp"),
                         [](const auto& transport) { return transport.param; });

}  // namespace
}  // namespace fire3dv::test
