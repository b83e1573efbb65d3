#include "tools/lab/bench/record_bench.h"

#include <sys/resource.h>
#include <time.h>

#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include "base/clock.h"
#include "protocol/record/channels.h"
#include "protocol/record/playback.h"
#include "protocol/record/stream_log.h"
#include "protocol/wire/encode.h"
#include "tools/lab/bench/report/statistics.h"

namespace fire3dv::bench {
namespace {

constexpr uint64_t kBegun_ns = 1'700'000'000'000'000'000;

int fail(const std::string& text) {
  std::fprintf(stderr, "fire3dv-bench: %s\n", text.c_str());
  return 1;
}

// CPU time of this thread, independent of other load.
double cpu_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double peak_rss_mb() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

// Joint motion with the frequencies of a robot arm, chained from node to node: smooth, without repeated
// values.
class Motion {
 public:
  Motion(const RecordWriteOptions& options) : options_(options), poses_(options.nodes) { move(0); }

  std::span<const wire::Affine3x4> at(uint64_t frame) {
    const double time_s = static_cast<double>(frame) / options_.rate_hz;
    if (options_.motion == "arm" || std::fmod(time_s, 60) < 0.5) move(time_s);
    return poses_;
  }

 private:
  void move(double time_s) {
    double angle = 0, x = 0, y = 0;
    for (size_t i = 0; i < poses_.size(); ++i) {
      const double hz = 0.1 + 0.07 * static_cast<double>(i % 11);
      angle += 0.3 * std::sin(6.283185307 * hz * time_s + static_cast<double>(i));
      const double c = std::cos(angle), s = std::sin(angle);
      x += 0.2 * c;
      y += 0.2 * s;
      const double z = 0.01 * static_cast<double>(i) + 0.05 * std::sin(time_s * hz);
      const double rows[] = {c, -s, 0, x, s, c, 0, y, 0, 0, 1, z};
      for (size_t k = 0; k < 12; ++k) poses_[i].m[k] = static_cast<float>(rows[k]);
    }
  }

  const RecordWriteOptions& options_;
  std::vector<wire::Affine3x4> poses_;
};

wire::StreamDescription description_of(const RecordWriteOptions& options) {
  wire::StreamDescription description;
  description.epoch = 7;
  description.adapter_name = "arm";
  for (uint32_t i = 0; i < options.nodes; ++i)
    description.node_names.push_back("a_body_of_the_scene_" + std::to_string(i));
  description.nominal_rate_hz = options.rate_hz;
  return description;
}

record::WriterOptions writer_options(const RecordWriteOptions& options) {
  record::WriterOptions result;
  result.compression = options.compression == "none"
                           ? record::Compression::none
                           : record::compression_of(options.compression).value_or(record::Compression::zstd);
  return result;
}

struct Frame {
  wire::PoseFrameView view;
  uint64_t log_time_ns;
  wire::Bytes message;  // the encoded view
};

// Writer of one file layout.
class Way {
 public:
  virtual ~Way() = default;
  virtual Result<void> take(const Frame& frame) = 0;
  virtual Result<uint64_t> finish() = 0;  // size of the file in bytes
};

class FramesWay final : public Way {
 public:
  FramesWay(std::unique_ptr<record::Sink> sink, const RecordWriteOptions& options)
      : log_([this](uint32_t) -> Result<std::unique_ptr<record::Sink>> { return std::move(sink_); }, {},
             log_options(options)),
        sink_(std::move(sink)) {
    good_ = log_.take(1, wire::encode(description_of(options)), kBegun_ns);
  }
  Result<void> take(const Frame& frame) override {
    return good_ ? log_.take(1, frame.message, frame.log_time_ns) : good_;
  }
  Result<uint64_t> finish() override {
    if (auto good = log_.finish(); !good) return good.error();
    return log_.file_bytes();
  }

 private:
  static record::LogOptions log_options(const RecordWriteOptions& options) {
    record::LogOptions result;
    result.writer = writer_options(options);
    result.foxglove = options.foxglove;
    return result;
  }
  record::StreamLog log_;
  std::unique_ptr<record::Sink> sink_;
  Result<void> good_;
};

// Layout with a channel per node and one pose per message, in this project's schema.
class PosesWay final : public Way {
 public:
  PosesWay(record::Writer writer, const RecordWriteOptions& options) : writer_(std::move(writer)) {
    const auto schema =
        writer_.add_schema("fire3dv.wire.fbs.Message", "flatbuffer", record::message_schema());
    for (uint32_t i = 0; schema && i < options.nodes; ++i)
      if (const auto added = writer_.add_channel(*schema, "/node_" + std::to_string(i), "flatbuffer", {}))
        channels_.push_back(*added);
  }
  Result<void> take(const Frame& frame) override {
    wire::PoseFrameView one = frame.view;
    one.node_count = 1;
    for (size_t i = 0; i < channels_.size(); ++i) {
      one.poses = frame.view.poses.subspan(i, 1);
      const wire::MessagePieces pieces = encoder_.encode(one);
      message_.assign(pieces.head.begin(), pieces.head.end());
      message_.insert(message_.end(), pieces.body.begin(), pieces.body.end());
      if (auto good = writer_.write({channels_[i], static_cast<uint32_t>(one.header.sequence),
                                     frame.log_time_ns, frame.log_time_ns, message_});
          !good)
        return good;
    }
    return {};
  }
  Result<uint64_t> finish() override {
    if (auto good = writer_.finish(); !good) return good.error();
    return writer_.file_bytes();
  }

 private:
  record::Writer writer_;
  std::vector<uint16_t> channels_;
  wire::PoseFrameEncoder encoder_;
  record::Bytes message_;
};

class RawWay final : public Way {
 public:
  explicit RawWay(std::unique_ptr<record::Sink> sink) : sink_(std::move(sink)) {}
  Result<void> take(const Frame& frame) override {
    bytes_ += frame.message.size();
    return sink_->append(frame.message);
  }
  Result<uint64_t> finish() override { return bytes_; }

 private:
  std::unique_ptr<record::Sink> sink_;
  uint64_t bytes_ = 0;
};

Result<std::unique_ptr<Way>> open_way(const RecordWriteOptions& options) {
  auto sink = record::create_sink(options.file);
  if (!sink) return sink.error();
  if (options.layout == "raw") return std::unique_ptr<Way>(std::make_unique<RawWay>(std::move(*sink)));
  if (options.layout == "frames")
    return std::unique_ptr<Way>(std::make_unique<FramesWay>(std::move(*sink), options));
  auto writer = record::Writer::open(std::move(*sink), writer_options(options));
  if (!writer) return writer.error();
  return std::unique_ptr<Way>(std::make_unique<PosesWay>(std::move(*writer), options));
}

}  // namespace

// Frames are generated in batches; only writing is timed.
int record_write(const RecordWriteOptions& options) {
  auto way = open_way(options);
  if (!way) return fail(way.error().message);
  const auto frames = static_cast<uint64_t>(options.seconds * options.rate_hz);
  const size_t batch_frames =
      std::max<size_t>(1, (size_t{16} << 20) / (options.nodes * sizeof(wire::Affine3x4) + 256));
  Motion motion(options);
  std::vector<Frame> batch(batch_frames);
  std::vector<std::vector<wire::Affine3x4>> poses(batch_frames);
  double wall_s = 0, cpu_s = 0;
  for (uint64_t done = 0; done < frames;) {
    const size_t count = static_cast<size_t>(std::min<uint64_t>(batch_frames, frames - done));
    for (size_t i = 0; i < count; ++i) {
      const uint64_t sequence = done + i + 1;
      const auto now = motion.at(sequence);
      poses[i].assign(now.begin(), now.end());
      Frame& frame = batch[i];
      const auto since_ns = static_cast<uint64_t>(1e9 * static_cast<double>(sequence) / options.rate_hz);
      frame.log_time_ns = kBegun_ns + since_ns;
      frame.view.header = {7, sequence, static_cast<int64_t>(since_ns), since_ns, 0, 0};
      frame.view.node_count = options.nodes;
      frame.view.poses = poses[i];
      frame.message = wire::encode(frame.view);
    }
    const int64_t begun_ns = fire3dv::monotonic_ns();
    const double begun_s = cpu_seconds();
    for (size_t i = 0; i < count; ++i)
      if (auto good = (*way)->take(batch[i]); !good) return fail(good.error().message);
    wall_s += static_cast<double>(fire3dv::monotonic_ns() - begun_ns) * 1e-9;
    cpu_s += cpu_seconds() - begun_s;
    done += count;
  }
  const auto bytes = (*way)->finish();
  if (!bytes) return fail(bytes.error().message);
  const double all = static_cast<double>(frames) * options.nodes;
  std::printf(
      "{\"frames\":%llu,\"poses_per_s\":%.0f,\"poses_per_cpu_s\":%.0f,\"bytes\":%llu,\"bytes_per_pose\":%.3f}"
      "\n",
      static_cast<unsigned long long>(frames), all / wall_s, all / cpu_s,
      static_cast<unsigned long long>(*bytes), static_cast<double>(*bytes) / all);
  return 0;
}

int record_read(const RecordReadOptions& options) {
  const int64_t opened_at_ns = fire3dv::monotonic_ns();
  auto source = record::open_source(options.file);
  if (!source) return fail(source.error().message);
  auto playback = record::Playback::open(std::move(*source), {options.memory_mb << 20});
  if (!playback) return fail(playback.error().message);
  const double open_ms = static_cast<double>(fire3dv::monotonic_ns() - opened_at_ns) * 1e-6;
  record::Played played;
  std::vector<double> seek_ms, seek_cpu_ms;
  const uint64_t length_ns = playback->end_ns() - playback->start_ns();
  for (uint32_t i = 0; i < options.seeks; ++i) {
    const uint64_t at_ns = playback->start_ns() + length_ns / 1000 * (uint64_t{i} * 7919 % 1000);
    const int64_t begun_ns = fire3dv::monotonic_ns();
    const double begun_s = cpu_seconds();
    playback->seek(at_ns);
    // Plays the stream state at that time, up to the next pose.
    while (playback->next(played) == record::Playback::Step::played &&
           played.kind != record::Played::Kind::pose) {
    }
    seek_ms.push_back(static_cast<double>(fire3dv::monotonic_ns() - begun_ns) * 1e-6);
    seek_cpu_ms.push_back((cpu_seconds() - begun_s) * 1e3);
    if (played.kind != record::Played::Kind::pose || played.log_time_ns < at_ns)
      return fail("a seek gave another moment");
  }
  const Summary seeks = summarise(seek_ms);
  uint64_t messages = 0, bytes = 0;
  const int64_t begun_ns = fire3dv::monotonic_ns();
  if (options.reads_all) {
    playback->rewind();
    for (;;) {
      const auto step = playback->next(played);
      if (step == record::Playback::Step::end) break;
      if (step == record::Playback::Step::damaged) return fail(playback->problem());
      ++messages;
      bytes += played.message.size();
    }
  }
  const double read_s = static_cast<double>(fire3dv::monotonic_ns() - begun_ns) * 1e-9;
  std::printf(
      "{\"open_ms\":%.3f,\"seek_median_ms\":%.3f,\"seek_longest_ms\":%.3f,\"seek_longest_cpu_ms\":%.3f,"
      "\"messages\":%llu,\"messages_per_"
      "s\":%.0f,"
      "\"mb_per_s\":%.1f,\"read_s\":%.3f,\"peak_rss_mb\":%.1f,\"chunks\":%zu}\n",
      open_ms, seeks.median, seeks.most, summarise(seek_cpu_ms).most,
      static_cast<unsigned long long>(messages), static_cast<double>(messages) / read_s,
      static_cast<double>(bytes) / 1e6 / read_s, read_s, peak_rss_mb(),
      playback->reader().index().chunks.size());
  return 0;
}

}  // namespace fire3dv::bench
