// Inspection program: fire3dv-inspect URI... shows statistics of live streams, FILE.mcap those of recordings.
// Over shared memory it reads in parallel with renderers; on other links it is the listener that simulators
// connect to.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <exception>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/command_line.h"
#include "base/error.h"
#include "base/log.h"
#include "base/plural.h"
#include "base/process/failure.h"
#include "base/process/progress.h"
#include "base/text.h"
#include "programs/inspect/observer.h"
#include "programs/inspect/recorded_edits.h"
#include "programs/inspect/renderer_page.h"
#include "programs/listener_options.h"
#include "protocol/record/channels.h"
#include "protocol/record/damage.h"
#include "protocol/record/frame_counter.h"
#include "protocol/record/mcap/summary.h"
#include "protocol/transport/open.h"
#include "protocol/wire/check.h"
#include "protocol/wire/decode.h"

namespace fire3dv::inspect {
namespace {

// Summary of a recording: streams, counts, times, rates, gaps and checksum validation.
struct RecordingText {
  std::string text, json;
  bool good = false;  // undamaged, and with frames
};

using nlohmann::json;

struct Topic {
  uint64_t messages = 0, bytes = 0;
  uint64_t first_ns = 0, last_ns = 0;
  // Statistics of pose topics only.
  record::FrameCounter tally;
  uint64_t runs = 0, refused = 0;
  uint64_t longest_gap_ns = 0;
  uint64_t epoch = 0, frame_at_ns = 0;
  int64_t first_sim_ns = 0, last_sim_ns = 0;

  const record::FrameCounts& seen() const { return tally.counts(); }
  double rate_hz() const {
    const uint64_t frames = seen().frames;
    const uint64_t count = frames != 0 ? frames : messages;
    return count < 2 || last_ns <= first_ns
               ? 0
               : static_cast<double>(count - 1) * 1e9 / static_cast<double>(last_ns - first_ns);
  }
};

// Properties of a stream from its newest description.
struct StreamInfo {
  uint32_t nodes = 0;
  std::string scene_uri;
};

class Look {
 public:
  explicit Look(record::Reader& reader) : reader_(reader) {}

  void take(const record::Message& message) {
    Topic& topic = topics_[message.channel_id];
    if (topic.messages++ == 0) topic.first_ns = message.log_time_ns;
    topic.last_ns = message.log_time_ns;
    topic.bytes += message.data.size();
    const record::Channel& channel = reader_.index().channels.at(message.channel_id);
    const auto role = channel.metadata.find(record::kRoleKey);
    if (role == channel.metadata.end()) return;
    const auto decoded = decoder_.decode(message.data);
    if (!decoded) {
      ++topic.refused;
      return;
    }
    const auto stream = channel.metadata.find(record::kStreamKey);
    const std::string& name = stream == channel.metadata.end() ? kUnnamed : stream->second;
    if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded))
      infos_[name] = {static_cast<uint32_t>(description->node_names.size()), description->scene_uri};
    if (const auto* edit = std::get_if<wire::SceneEdit>(&*decoded))
      if (infos_.contains(name)) edits_.take(name, *edit);
    if (const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded)) take_frame(topic, *frame, message);
  }

  std::string text(const record::Report& report) const;
  json as_json(const record::Report& report) const;
  uint64_t frames() const {
    uint64_t frames = 0;
    for (const auto& [id, topic] : topics_) frames += topic.seen().frames;
    return frames;
  }

 private:
  static void take_frame(Topic& topic, const wire::PoseFrameView& frame, const record::Message& message) {
    if (frame.header.epoch != topic.epoch) {
      topic.tally.begin();
      ++topic.runs;
      topic.epoch = frame.header.epoch;
    }
    if (!topic.tally.take(frame)) return;  // a further part of the frame, or a late frame
    if (topic.seen().frames == 1) topic.first_sim_ns = frame.header.sim_time_ns;
    if (topic.frame_at_ns != 0 && message.log_time_ns > topic.frame_at_ns)
      topic.longest_gap_ns = std::max(topic.longest_gap_ns, message.log_time_ns - topic.frame_at_ns);
    topic.frame_at_ns = message.log_time_ns;
    topic.last_sim_ns = frame.header.sim_time_ns;
  }
  uint64_t start_ns() const {
    uint64_t start = UINT64_MAX;
    for (const auto& [id, topic] : topics_) start = std::min(start, topic.first_ns);
    return topics_.empty() ? 0 : start;
  }
  uint64_t end_ns() const {
    uint64_t end = 0;
    for (const auto& [id, topic] : topics_) end = std::max(end, topic.last_ns);
    return end;
  }

  inline static const std::string kUnnamed;
  record::Reader& reader_;
  wire::Decoder decoder_;
  std::map<uint16_t, Topic> topics_;
  std::map<std::string, StreamInfo> infos_;
  RecordedEdits edits_;
};

std::string date_of(uint64_t unix_ns) {
  const auto seconds = static_cast<std::time_t>(unix_ns / 1'000'000'000);
  std::tm parts{};
  char text[64] = "an unknown time";
  if (::gmtime_r(&seconds, &parts) != nullptr)
    std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", &parts);
  return text;
}

std::string Look::text(const record::Report& report) const {
  char line[512];
  const double seconds = static_cast<double>(end_ns() - std::min(start_ns(), end_ns())) * 1e-9;
  std::snprintf(line, sizeof line, "%s: %s in %s, %.1f MB", wire::printable(reader_.name(), 256).c_str(),
                counted(report.messages, "message").c_str(), counted(report.chunks, "chunk").c_str(),
                static_cast<double>(reader_.source().size()) / 1e6);
  std::string text = line;
  std::snprintf(line, sizeof line, ", %.3f s from %s", seconds, date_of(start_ns()).c_str());
  if (!topics_.empty()) text += line;  // without messages the times are unknown
  text += '\n';
  for (const auto& [id, topic] : topics_) {
    const record::Channel& channel = reader_.index().channels.at(id);
    std::snprintf(line, sizeof line, "  %s: %s, %s, %.1f Hz", wire::printable(channel.topic, 128).c_str(),
                  counted(topic.messages, "message").c_str(), counted(topic.bytes, "byte").c_str(),
                  topic.rate_hz());
    text += line;
    if (topic.seen().frames != 0) {
      std::snprintf(
          line, sizeof line, ", %s of %s, %llu missing, longest gap %.1f ms, sim time %.3f s to %.3f s",
          counted(topic.seen().frames, "frame").c_str(), counted(topic.runs, "run").c_str(),
          static_cast<unsigned long long>(topic.seen().missing),
          static_cast<double>(topic.longest_gap_ns) * 1e-6, static_cast<double>(topic.first_sim_ns) * 1e-9,
          static_cast<double>(topic.last_sim_ns) * 1e-9);
      text += line;
    }
    if (topic.seen().parts != 0)
      text += ", in " + counted(topic.seen().parts, "part") + ", " +
              counted(topic.tally.incomplete(true), "frame") + " incomplete";
    if (topic.seen().late != 0) text += ", " + counted(topic.seen().late, "message") + " late";
    if (topic.refused != 0) text += ", " + std::to_string(topic.refused) + " not understood";
    text += '\n';
  }
  for (const auto& [name, info] : infos_)
    text += "  \"" + wire::printable(name) + "\": " + counted(info.nodes, "node") + ", scene " +
            (info.scene_uri.empty() ? "not named" : wire::printable(info.scene_uri, 256)) + '\n' +
            edits_.text(name);
  for (const record::AttachmentIndex& attachment : reader_.index().attachments)
    text += "  attachment \"" + wire::printable(attachment.name) +
            "\": " + counted(attachment.data_bytes, "byte") + ", " + wire::printable(attachment.media_type) +
            '\n';
  if (const std::string& remark = reader_.index().remark; !remark.empty()) text += "  note: " + remark + '\n';
  for (const std::string& problem : report.problems) text += "  problem: " + problem + '\n';
  if (report.problem_count > report.problems.size())
    text += "  and " + counted(report.problem_count - report.problems.size(), "more problem") + '\n';
  const bool has_frames = frames() != 0;
  if (!has_frames) text += "no frames: nothing to replay\n";
  if (!report.sound())
    text += counted(report.problem_count, "problem") +
            (report.damaged_chunks == 0
                 ? "; no chunk is damaged: fire3dv-record recover writes a file with a right index\n"
                 : ", " + counted(report.damaged_chunks, "damaged chunk") +
                       "; fire3dv-record recover saves the rest\n");
  else if (has_frames)
    text += report.data_crc_given ? "all checksums are right\n" : "all checksums in the file are right\n";
  return text;
}

json Look::as_json(const record::Report& report) const {
  json topics = json::array(), attachments = json::array(), streams = json::object();
  for (const auto& [id, topic] : topics_)
    topics.push_back({{"topic", wire::printable(reader_.index().channels.at(id).topic, 1024)},
                      {"messages", topic.messages},
                      {"bytes", topic.bytes},
                      {"first_ns", topic.first_ns},
                      {"last_ns", topic.last_ns},
                      {"rate_hz", topic.rate_hz()},
                      {"frames", topic.seen().frames},
                      {"parts", topic.seen().parts},
                      {"incomplete", topic.tally.incomplete(true)},
                      {"late", topic.seen().late},
                      {"runs", topic.runs},
                      {"missing", topic.seen().missing},
                      {"longest_gap_ns", topic.longest_gap_ns},
                      {"first_sim_time_ns", topic.first_sim_ns},
                      {"last_sim_time_ns", topic.last_sim_ns},
                      {"not_understood", topic.refused}});
  for (const auto& [name, info] : infos_) {
    json& stream = streams[wire::printable(name, 1024)];
    stream = {{"nodes", info.nodes}, {"scene_uri", info.scene_uri}};
    edits_.add_json(name, stream);
  }
  for (const record::AttachmentIndex& attachment : reader_.index().attachments)
    attachments.push_back({{"name", wire::printable(attachment.name, 1024)},
                           {"media_type", wire::printable(attachment.media_type, 1024)},
                           {"bytes", attachment.data_bytes}});
  json problems = json::array();
  for (const std::string& problem : report.problems) problems.push_back(problem);
  return {{"file", wire::printable(reader_.name(), 4096)},
          {"file_bytes", reader_.source().size()},
          {"sound", report.sound()},
          {"check_sum_over_all", report.data_crc_given},
          {"has_summary", reader_.index().has_summary},
          {"messages", report.messages},
          {"frames", frames()},
          {"chunks", report.chunks},
          {"damaged_chunks", report.damaged_chunks},
          {"start_ns", start_ns()},
          {"end_ns", end_ns()},
          {"topics", topics},
          {"streams", streams},
          {"attachments", attachments},
          {"problem_count", report.problem_count},
          {"problems", problems}};
}

Result<RecordingText> inspect_recording(const std::string& path, const record::ReadLimits& limits) {
  auto source = record::open_source(path);
  if (!source) return source.error();
  auto reader = record::Reader::open(std::move(*source), limits);
  if (!reader) return reader.error();
  Look look(*reader);
  Progress progress("fire3dv-inspect", wire::printable(reader->name(), 256) + ":");
  const auto report = record::verify(*reader, [&](const record::Message& message) {
    look.take(message);
    progress.update("checking", reader->chunk(), reader->index().chunks.size());
  });
  if (!report) return report.error();
  return RecordingText{look.text(*report), look.as_json(*report).dump() + '\n',
                       report->sound() && look.frames() != 0};
}

}  // namespace
}  // namespace fire3dv::inspect

namespace {

volatile std::sig_atomic_t stop_requested = 0;

// Returns 1 when a recording is unreadable, damaged or without frames; its readable part is still reported.
int inspect_recordings(const std::vector<std::string>& files, bool as_json, uint64_t memory_mb) {
  int result = 0;
  for (const std::string& file : files) {
    const auto recording = fire3dv::inspect::inspect_recording(file, {memory_mb << 20});
    if (!recording) {
      std::cerr << "fire3dv-inspect: error: " << fire3dv::terminal_text(recording.error().message) << '\n';
      result = 1;
      continue;
    }
    std::cout << (as_json ? recording->json : fire3dv::terminal_text(recording->text));
    if (!recording->good) result = 1;
  }
  return result;
}

// Returns 1 when a page cannot be read.
int inspect_renderers(const std::vector<std::string>& urls, bool as_json) {
  using namespace fire3dv;
  int result = 0;
  for (const std::string& url : urls) {
    const Result<std::string> page = inspect::fetch_page(url);
    if (!page) {
      print_log_line("fire3dv-inspect", error_line(page.error().message));
      result = 1;
      continue;
    }
    const std::vector<inspect::DrawnStream> streams = inspect::read_page(*page);
    std::cout << (as_json ? inspect::json_of(url, streams) : terminal_text(inspect::text_of(url, streams)));
  }
  return result;
}

}  // namespace

int main(int argc, char** argv) try {
  using namespace fire3dv;
  CLI::App app{"Prints streams of links or recordings: rates, losses and ages of frames.", "fire3dv-inspect"};
  set_help(app, "URI|FILE.mcap... [OPTIONS]");
  app.footer("Details: man fire3dv-inspect.");
  set_program_flags(app);
  std::vector<std::string> uris;
  transport::ListenerOptions options;
  options.delivery = transport::Delivery::all;
  double seconds = 2;
  bool as_json = false;
  uint64_t memory_mb = 64;
  app.add_option("uri", uris, "shm://NAME, tcp, tls, udp://HOST:PORT; recordings; or http://HOST:PORT")
      ->required();
  OptionGroup group(app);
  group.add("--seconds", seconds, "N", "duration of the measurement")->check(number_between(0.1, 86400));
  group.add_flag("--json", as_json, "print one JSON object for each URI, one a line");
  group.add("--memory-mb", memory_mb, "N", "memory for the index of a recording, in MB")
      ->check(in_range(16u, 16'384u));
  add_listener_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  std::signal(SIGINT, [](int) { stop_requested = 1; });
  std::signal(SIGTERM, [](int) { stop_requested = 1; });

  const auto is_page = [](const std::string& name) { return name.starts_with("http://"); };
  if (std::ranges::all_of(uris, is_page)) return inspect_renderers(uris, as_json);
  if (std::ranges::any_of(uris, is_page)) {
    std::cerr << "fire3dv-inspect: name renderers (http://), links or recordings, not several of them\n";
    return 2;
  }
  const auto is_link = [](const std::string& name) { return name.find("://") != std::string::npos; };
  const auto links = std::count_if(uris.begin(), uris.end(), is_link);
  if (links == 0) return inspect_recordings(uris, as_json, memory_mb);
  if (static_cast<size_t>(links) != uris.size()) {
    std::cerr << "fire3dv-inspect: name links or recordings, not both\n";
    return 2;
  }

  struct Look {
    std::unique_ptr<transport::ListenerLink> link;
    inspect::Observer observer;
  };
  std::vector<Look> looks;
  for (const std::string& uri : uris) {
    auto link = transport::open_listener(uri, options);
    if (!link) {
      std::cerr << "fire3dv-inspect: error: " << link.error().message << '\n';
      return 1;
    }
    looks.push_back({std::move(*link), {}});
  }
  const auto share =
      std::chrono::nanoseconds(std::chrono::milliseconds(20)) / static_cast<int64_t>(looks.size());
  const int64_t until_ns = fire3dv::monotonic_ns() + static_cast<int64_t>(seconds * 1e9);
  while (!stop_requested && fire3dv::monotonic_ns() < until_ns) {
    for (Look& look : looks) {
      look.link->wait(share);
      look.observer.poll(*look.link);
    }
  }
  int result = 0;
  for (const Look& look : looks) {
    std::cout << (as_json ? look.observer.json(*look.link) : look.observer.text(*look.link));
    if (!look.observer.streams().empty()) continue;
    std::cout.flush();
    char limit[32];
    std::snprintf(limit, sizeof limit, "%g s", seconds);
    print_log_line("fire3dv-inspect",
                   error_line("nothing was published at " + look.link->uri() + " within " + limit +
                              "; start a publisher there, check the name, or listen longer with --seconds"));
    result = 1;
  }
  return result;
} catch (const std::exception& failure) {
  fire3dv::print_log_line("fire3dv-inspect", fire3dv::error_line(fire3dv::describe_failure(failure)));
  return 1;
}
