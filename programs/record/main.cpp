// Recorder program: fire3dv-record --from URI --out FILE.mcap records all frames of all streams. Over shared
// memory it reads in parallel with renderers; on other links it is the listener that simulators connect to.
// fire3dv-record recover CUT.mcap -o WHOLE.mcap copies what is intact of a damaged recording.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/command_line.h"
#include "base/log.h"
#include "base/plural.h"
#include "base/process/failure.h"
#include "base/process/progress.h"
#include "base/process/stop_signals.h"
#include "base/text.h"
#include "programs/listener_options.h"
#include "protocol/record/attachments.h"
#include "protocol/record/damage.h"
#include "protocol/record/log_thread.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/encode.h"

namespace fire3dv::record {
namespace {

using RecorderStatus = LogStatus;
using transport::LinkEvent;

// Receiver that hands messages to the recording thread. The thread decouples the link from the disk: a
// shared-memory ring holds few frames, and a disk may stall for longer.
class Recorder {
 public:
  explicit Recorder(StreamLog log) : log_(std::move(log)) {}

  // Processes pending messages of the link. Never waits for the disk. answers: the publisher has no other
  // peer.
  void poll(transport::ListenerLink& link, uint32_t link_number, bool answers);
  // Writes pending messages and finishes the file.
  void finish() { log_.finish(); }
  RecorderStatus status() const { return log_.status(); }

 private:
  void answer(transport::ListenerLink& link, transport::PeerId peer, std::span<const std::byte> message);

  wire::Decoder decoder_;
  LogThread log_;
};

void Recorder::poll(transport::ListenerLink& link, uint32_t link_number, bool answers) {
  link.poll([&](const LinkEvent& event) {
    const uint64_t peer = uint64_t{link_number} << 48 | event.peer;
    const int64_t at_ns = event.received_ns != 0 ? event.received_ns : fire3dv::monotonic_ns();
    switch (event.kind) {
      case LinkEvent::Kind::note:
        fire3dv::print_log_line("fire3dv-record", event.text);
        break;
      case LinkEvent::Kind::disconnected:
        log_.end_peer(peer, at_ns);
        break;
      case LinkEvent::Kind::pose:
      case LinkEvent::Kind::control:
        if (answers && event.kind == LinkEvent::Kind::control) answer(link, event.peer, event.message);
        log_.take(peer, event.message, at_ns, event.kind == LinkEvent::Kind::pose);
        break;
      case LinkEvent::Kind::connected:
        break;
    }
  });
}

// Answers a publisher that has no other peer, so that it knows its stream is recorded. No frame is
// acknowledged, since none is shown.
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
    else
      link.accept(peer);
    link.send(peer, wire::encode(welcome));
  } else if (const auto* ping = std::get_if<wire::Ping>(&*decoded)) {
    link.send(peer, wire::encode(wire::Pong{ping->id, ping->sender_time_ns,
                                            static_cast<uint64_t>(fire3dv::monotonic_ns())}));
  }
}

// Recovery command: copies all intact chunks and attachments of a damaged recording.
struct RecoverOptions {
  std::string from, to;
  uint64_t memory_mb = 64;
};

int fail(const Error& error) {
  print_log_line("fire3dv-record", error_line(error.message));
  return 1;
}

// Returns the exit code.
int recover_file(const RecoverOptions& options) {
  auto source = open_source(options.from);
  if (!source) return fail(source.error());
  auto reader = Reader::open(std::move(*source), {options.memory_mb << 20});
  if (!reader) return fail(reader.error());
  auto sink = create_atomic_sink(options.to);
  if (!sink) return fail(sink.error());
  Progress progress("fire3dv-record", "recovering:");
  const auto result = recover(*reader, std::move(*sink), {},
                              [&](size_t chunk, size_t chunks) { progress.update("chunks", chunk, chunks); });
  if (!result) return fail(result.error());
  std::printf("recovered %s of %s and %s; damaged: %s and %s\n", counted(result->messages, "message").c_str(),
              counted(result->chunks, "complete chunk").c_str(),
              counted(result->attachments, "attachment").c_str(),
              counted(result->damaged_chunks, "chunk").c_str(),
              counted(result->damaged_attachments, "attachment").c_str());
  if (!result->first_damage.empty())
    std::printf("first damage: %s\n", terminal_text(result->first_damage).c_str());
  if (result->messages == 0 && result->attachments == 0) return fail(Error{"nothing could be saved"});
  return 0;
}

}  // namespace
}  // namespace fire3dv::record

namespace {

using namespace fire3dv;

constexpr int kUsageError = 2;

struct Options {
  std::vector<std::string> from;
  std::string out;
  std::vector<std::string> attach;
  std::string compression = "zstd";
  double split_mb = 0, split_s = 0, seconds = 0, sync_s = 1;
  bool until_end = false, foxglove = false;
  transport::ListenerOptions listener;
  record::RecoverOptions recover;
};

int fail(const std::string& message) {
  fire3dv::print_log_line("fire3dv-record", fire3dv::error_line(message));
  return 1;
}

void add_options(CLI::App& app, Options& options) {
  OptionGroup group(app);
  group.add("--from", options.from, "URI", "shm://NAME, or tcp, tls, udp://HOST:PORT; several into one file");
  group.add("--out", options.out, "FILE", "file to write; with --split-*: FILE_0000.mcap and so on");
  group.add("--attach", options.attach, "FILE", "files to attach, such as the scene");
  group.add_flag("--foxglove", options.foxglove, "add Foxglove's transforms and attached .glb models");
  group.add_choice("--compression", options.compression, "zstd|lz4|none", "compression of chunks");
  group.add("--split-mb", options.split_mb, "N", "start a new file after N megabytes")->check(check_number);
  group.add("--split-s", options.split_s, "N", "start a new file after N seconds")->check(check_number);
  group.add("--sync", options.sync_s, "SECONDS", "interval of disk flushes; 0: only at the end")
      ->check(check_number);
  group.add("--seconds", options.seconds, "N", "duration; 0: until interrupted")->check(check_number);
  group.add_flag("--until-end", options.until_end, "exit when all streams have ended");
  add_listener_options(app, options.listener);
}

std::string numbered(const std::string& out, uint32_t file) {
  const std::filesystem::path path(out);
  char number[16];
  std::snprintf(number, sizeof number, "_%04u", file);
  return (path.parent_path() / (path.stem().string() + number + path.extension().string())).string();
}

void print_progress(const record::RecorderStatus& status, const char* end) {
  uint64_t frames = status.reclaimed_frames, missing = 0, live = 0;
  for (const record::StreamSeen& stream : status.streams) {
    frames += stream.frames;
    missing += stream.missing;
    live += stream.live;
  }
  std::fprintf(stderr, "fire3dv-record: info: %s (%llu live), %s, %llu missing, %.1f MB in %s%s",
               counted(status.streams.size() + status.reclaimed_streams, "stream").c_str(),
               static_cast<unsigned long long>(live), counted(frames, "frame").c_str(),
               static_cast<unsigned long long>(missing), static_cast<double>(status.file_bytes) / 1e6,
               counted(status.files, "file").c_str(), end);
  std::fflush(stderr);
}

void print_result(const record::RecorderStatus& status) {
  for (const record::StreamSeen& stream : status.streams)
    std::printf("\"%s\": %s, %s, %s, %llu missing, %llu incomplete, %llu late, %s, %s\n", stream.name.c_str(),
                counted(stream.nodes, "node").c_str(), counted(stream.frames, "frame").c_str(),
                counted(stream.parts, "part").c_str(), static_cast<unsigned long long>(stream.missing),
                static_cast<unsigned long long>(stream.incomplete),
                static_cast<unsigned long long>(stream.late), counted(stream.edits, "edit").c_str(),
                counted(stream.bytes, "byte").c_str());
  std::printf("%.1f MB in %s; %s not understood, %llu missing\n",
              static_cast<double>(status.file_bytes) / 1e6, counted(status.files, "file").c_str(),
              counted(status.refused, "message").c_str(), static_cast<unsigned long long>(status.unwritten));
  if (status.reclaimed_streams != 0)
    std::printf("%s ended earlier, with %s\n", counted(status.reclaimed_streams, "more stream").c_str(),
                counted(status.reclaimed_frames, "frame").c_str());
  if (status.dropped_edits != 0)
    std::printf("%s missing from snapshots, for lack of memory: a replay with --start lacks them\n",
                counted(status.dropped_edits, "edit").c_str());
  if (status.unconverted_markers != 0)
    std::printf("%s missing in Foxglove's channels: images, longer than 12 MiB there, or too many\n",
                counted(status.unconverted_markers, "marker value").c_str());
}

std::string unrecorded_text(uint64_t streams) {
  return counted(streams, "stream") +
         " not recorded: too many are live, or were in this file; record fewer of them, or begin new files "
         "with --split-s";
}

// Returns the exit code: 0 if the files lack nothing.
int report_losses(const record::RecorderStatus& status) {
  if (status.failure)
    return fail(*status.failure +
                (status.unwritten != 0 ? " (missing: " + counted(status.unwritten, "message") + ")" : ""));
  const std::optional<std::string> gaps = record::describe_gaps(status);
  const int exit_code = gaps ? fail(*gaps) : 0;
  if (status.unwritten != 0)
    return fail(counted(status.unwritten, "message") +
                " missing: the disk is too slow for these streams; record to a faster disk");
  return status.unrecorded_streams != 0 ? fail(unrecorded_text(status.unrecorded_streams)) : exit_code;
}

bool all_ended(const record::RecorderStatus& status) {
  for (const record::StreamSeen& stream : status.streams)
    if (stream.live) return false;
  return !status.streams.empty();
}

int record_streams(const Options& options) {
  std::vector<std::unique_ptr<transport::ListenerLink>> links;
  for (const std::string& uri : options.from) {
    auto link = transport::open_listener(uri, options.listener);
    if (!link) return fail(link.error().message);
    links.push_back(std::move(*link));
  }
  record::LogOptions log;
  log.writer.compression = options.compression == "none" ? record::Compression::none
                                                         : *record::compression_of(options.compression);
  log.split_bytes = static_cast<uint64_t>(options.split_mb * 1e6);
  log.split_ns = static_cast<uint64_t>(options.split_s * 1e9);
  log.flush_ns = static_cast<uint64_t>(options.sync_s * 1e9);
  const bool splits = log.split_bytes != 0 || log.split_ns != 0;
  // Checked before the file is created, so that a mistyped name leaves no file.
  for (const std::string& path : options.attach)
    if (auto source = record::open_source(path); !source) return fail(source.error().message);
  log.foxglove = options.foxglove;
  if (options.foxglove) {
    std::vector<std::string> left_out;
    auto models = record::load_models(record::named_files(options.attach), left_out);
    if (!models) return fail(models.error().message);
    log.models = std::move(*models);
    for (const std::string& text : left_out)
      fire3dv::print_log_line("fire3dv-record", fire3dv::warning(text));
  }
  // The first file is created now, so that a bad name is reported before data is lost.
  auto first = record::create_sink(splits ? numbered(options.out, 0) : options.out);
  if (!first) return fail(first.error().message);
  auto first_sink = std::make_shared<std::unique_ptr<record::Sink>>(std::move(*first));
  record::Recorder recorder(record::StreamLog(
      [&, first_sink](uint32_t file) -> Result<std::unique_ptr<record::Sink>> {
        if (file == 0) return std::move(*first_sink);
        return record::create_sink(numbered(options.out, file));
      },
      // Attachments are read before the first frame arrives, and again for each further file.
      [&](record::Writer& writer, uint64_t now_ns) {
        return record::attach_files(record::named_files(options.attach), writer, now_ns);
      },
      log));
  for (const auto& link : links) fire3dv::print_log_line("fire3dv-record", "listening on " + link->uri());

  // Of several links none waits long for the others: a ring of shared memory has 8 slots.
  const auto turn = std::chrono::nanoseconds(std::chrono::milliseconds(links.size() == 1 ? 20 : 4));
  const auto share = turn / static_cast<int64_t>(links.size());
  const bool shows = ::isatty(STDERR_FILENO) != 0;
  const int64_t begun_ns = fire3dv::monotonic_ns();
  int64_t next_print_ns = begun_ns;
  bool unrecorded_reported = false, name_reported = false;
  for (int64_t now_ns = begun_ns; !stop_requested; now_ns = fire3dv::monotonic_ns()) {
    if (options.seconds > 0 && static_cast<double>(now_ns - begun_ns) > options.seconds * 1e9) break;
    for (uint32_t i = 0; i < links.size(); ++i) {
      links[i]->wait(share);
      recorder.poll(*links[i], i, !options.from[i].starts_with("shm:"));
    }
    if (now_ns < next_print_ns) continue;
    next_print_ns = now_ns + fire3dv::kSecondNs / 5;
    const record::RecorderStatus status = recorder.status();
    if (shows) print_progress(status, "\r");
    if (status.unrecorded_streams != 0 && !std::exchange(unrecorded_reported, true))
      (void)fail(unrecorded_text(status.unrecorded_streams));
    if (status.name_fault && !status.failure && !std::exchange(name_reported, true))
      fire3dv::print_log_line("fire3dv-record", fire3dv::warning(*status.name_fault));
    if (status.failure || (options.until_end && all_ended(status))) break;
  }
  recorder.finish();
  const record::RecorderStatus status = recorder.status();
  if (shows) print_progress(status, "\n");
  print_result(status);
  return report_losses(status);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Records the streams that are published at a URI into an MCAP file.", "fire3dv-record"};
  set_help(app, "--from URI... --out FILE.mcap [OPTIONS]");
  app.footer("Rescue a damaged recording: fire3dv-record recover --help. Details: man fire3dv-record.");
  set_program_flags(app);
  Options options;
  add_options(app, options);
  options.listener.delivery = transport::Delivery::all;
  CLI::App* const recover =
      app.add_subcommand("recover", "rescue the complete parts of a truncated or damaged recording");
  set_help(*recover, "FILE.mcap --out FILE.mcap [OPTIONS]");
  recover->add_option("file", options.recover.from, "damaged recording")->required();
  recover->add_option("-o,--out", options.recover.to, "file to write")->type_name("FILE")->required();
  recover->add_option("--memory-mb", options.recover.memory_mb, "memory for the index of the file, in MB")
      ->check(in_range(16u, 16'384u))
      ->type_name("N")
      ->capture_default_str();
  try {
    app.parse(argc, argv);
    if (!recover->parsed() && options.from.empty()) throw CLI::RequiredError("--from");
    if (!recover->parsed() && options.out.empty()) throw CLI::RequiredError("--out");
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageError;
  }
  install_stop_signals(SecondStop::ignored);  // the file is finished in any case
  try {
    return recover->parsed() ? record::recover_file(options.recover) : record_streams(options);
  } catch (const std::exception& failure) {
    return fail(describe_failure(failure));
  }
}
