#include "programs/inspect/observer.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/clock.h"
#include "base/log.h"
#include "base/plural.h"
#include "programs/inspect/recorded_edits.h"
#include "protocol/wire/check.h"

namespace fire3dv::inspect {
namespace {

using transport::LinkEvent;
using transport::LinkStats;

constexpr size_t kMaxStreams = 4096;  // includes ended streams

std::string local_boot_id() {
  std::string id;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> id;
  return id;
}

}  // namespace

double StreamSeen::rate_hz() const {
  if (frames < 2 || last_frame_ns <= first_frame_ns) return 0;
  return static_cast<double>(frames - 1) * 1e9 / static_cast<double>(last_frame_ns - first_frame_ns);
}

uint64_t StreamSeen::age_us(double quantile) const {
  uint64_t total = 0, sum = 0;
  for (const uint64_t count : ages) total += count;
  for (size_t i = 0; i < ages.size() && total != 0; ++i) {
    sum += ages[i];
    if (static_cast<double>(sum) >= quantile * static_cast<double>(total)) return uint64_t{1} << i;
  }
  return 0;
}

void Observer::poll(transport::ListenerLink& link) {
  link.poll([&](const LinkEvent& event) {
    if (event.kind == LinkEvent::Kind::note) print_log_line("fire3dv-inspect", event.text);
    if (event.kind == LinkEvent::Kind::disconnected)
      if (const auto stream = streams_.find(event.peer); stream != streams_.end())
        stream->second.ended = true;
    if (event.kind != LinkEvent::Kind::pose && event.kind != LinkEvent::Kind::control) return;
    const int64_t received_ns = event.received_ns != 0 ? event.received_ns : fire3dv::monotonic_ns();
    if (take(event.peer, event.message, received_ns)) link.accept(event.peer);
  });
}

bool Observer::take(transport::PeerId peer, std::span<const std::byte> message, int64_t received_ns) {
  const auto decoded = decoder_.decode(message);
  if (!decoded) {
    ++refused_;
    return false;
  }
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
    if (streams_.size() == kMaxStreams && streams_.find(peer) == streams_.end()) return false;
    static const std::string local_boot = local_boot_id();
    StreamSeen& stream = streams_[peer];
    if (stream.epoch == description->epoch) return true;
    stream = {};
    stream.scalars =
        fire3dv::stream::ScalarHistory(scalar_budget_, fire3dv::stream::ScalarHistory::Keep::statistics);
    stream.name = description->adapter_name;
    stream.epoch = description->epoch;
    stream.nodes = static_cast<uint32_t>(description->node_names.size());
    stream.nominal_rate_hz = description->nominal_rate_hz;
    stream.same_clock = !local_boot.empty() && description->clock.boot_id == local_boot;
    return true;
  }
  const auto found = streams_.find(peer);
  if (const auto* edit = std::get_if<wire::SceneEdit>(&*decoded)) {
    if (found == streams_.end() || edit->epoch != found->second.epoch) return false;
    ++found->second.edits;
    if (edit->property == wire::Property::marker) ++found->second.marker_edits;
    if (wire::is_scalar(edit->property)) {
      ++found->second.scalar_edits;
      // Links may repeat the newest edit of each group.
      if (edit->version <= found->second.scalar_version) return false;
      found->second.scalar_version = edit->version;
      (void)found->second.scalars.apply(*edit);
    }
    return false;
  }
  const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded);
  if (frame == nullptr || found == streams_.end() || frame->header.epoch != found->second.epoch) return false;
  StreamSeen& stream = found->second;
  ++stream.messages;
  stream.bytes += message.size();
  if (frame->header.sequence <= stream.sequence) return false;
  if (stream.sequence != 0) stream.missing += frame->header.sequence - stream.sequence - 1;
  if (stream.frames++ == 0) stream.first_frame_ns = received_ns;
  stream.sequence = frame->header.sequence;
  stream.last_frame_ns = received_ns;
  if (!stream.same_clock) return false;
  const auto age_ns = static_cast<uint64_t>(received_ns) - frame->header.publish_time_ns;
  if (static_cast<int64_t>(age_ns) < 0)
    return false;  // publish time in the future: the clocks are not the
                   // same
  ++stream.ages[std::min<size_t>(static_cast<size_t>(std::bit_width(age_ns / 1000)), kAgeBuckets - 1)];
  return false;
}

namespace {

// Histogram of frame ages as text bars, scaled to the fullest bucket.
std::string age_text(const StreamSeen& stream) {
  constexpr uint64_t kWidest = 40;
  const uint64_t fullest = *std::max_element(stream.ages.begin(), stream.ages.end());
  if (fullest == 0) return stream.same_clock ? "" : "  ages are unknown: it uses another machine's clock\n";
  char line[128];
  std::snprintf(line, sizeof line, "  age when they came: half below %llu us, 99 %% below %llu us\n",
                static_cast<unsigned long long>(stream.age_us(0.5)),
                static_cast<unsigned long long>(stream.age_us(0.99)));
  std::string text = line;
  for (size_t i = 0; i < stream.ages.size(); ++i) {
    if (stream.ages[i] == 0) continue;
    const uint64_t bar = (stream.ages[i] * kWidest + fullest - 1) / fullest;
    const bool last = i + 1 == stream.ages.size();  // the last bucket holds all older frames, too
    std::snprintf(line, sizeof line, "  %s%8llu us %8llu ", last ? ">=" : " <",
                  static_cast<unsigned long long>(uint64_t{1} << (last ? i - 1 : i)),
                  static_cast<unsigned long long>(stream.ages[i]));
    text += line + std::string(bar, '#') + '\n';
  }
  return text;
}

}  // namespace

std::string Observer::text(const transport::ListenerLink& link) const {
  std::string text;
  char line[256];
  for (const auto& [peer, stream] : streams_) {
    std::snprintf(line, sizeof line, "\"%s\"%s: %s, %.1f Hz, %s, %llu missing, %s",
                  wire::printable(stream.name, 64).c_str(), stream.ended ? " (ended)" : "",
                  counted(stream.nodes, "node").c_str(), stream.rate_hz(),
                  counted(stream.frames, "frame").c_str(), static_cast<unsigned long long>(stream.missing),
                  counted(stream.bytes, "byte").c_str());
    text += line;
    if (stream.edits > 0) text += ", " + counted(stream.edits, "scene edit");
    if (stream.marker_edits > 0) text += " (" + std::to_string(stream.marker_edits) + " of markers)";
    if (stream.scalar_edits > 0) text += " (" + std::to_string(stream.scalar_edits) + " of scalars)";
    if (stream.nominal_rate_hz > 0) {
      std::snprintf(line, sizeof line, "; nominal %.1f Hz", stream.nominal_rate_hz);
      text += line;
    }
    text += '\n' + age_text(stream) + scalar_text(stream.scalars, "  ");
  }
  if (streams_.empty()) text += "no streams\n";
  const LinkStats stats = link.stats();
  std::snprintf(line, sizeof line, "%s: %s, %s, %s overtaken, %s not understood", link.uri().c_str(),
                counted(stats.peers, "peer").c_str(), counted(stats.messages_received, "message").c_str(),
                counted(stats.poses_dropped, "pose").c_str(), counted(refused_, "message").c_str());
  text += line;
  for (size_t i = 0; i < transport::kCauseCount; ++i)
    if (stats.rejected_by_cause[i] != 0)
      text += std::string(", ") + transport::cause_name(static_cast<transport::Cause>(i)) + " " +
              std::to_string(stats.rejected_by_cause[i]);
  return text + '\n';
}

std::string Observer::json(const transport::ListenerLink& link) const {
  using nlohmann::json;
  const LinkStats stats = link.stats();
  json rejected = json::object();
  for (size_t i = 0; i < transport::kCauseCount; ++i)
    rejected[transport::cause_name(static_cast<transport::Cause>(i))] = stats.rejected_by_cause[i];
  json streams = json::array();
  for (const auto& [peer, stream] : streams_) {
    json ages = json::array();
    for (const uint64_t count : stream.ages) ages.push_back(count);
    streams.push_back({{"name", stream.name},
                       {"epoch", stream.epoch},
                       {"nodes", stream.nodes},
                       {"nominal_rate_hz", stream.nominal_rate_hz},
                       {"rate_hz", stream.rate_hz()},
                       {"ended", stream.ended},
                       {"frames", stream.frames},
                       {"messages", stream.messages},
                       {"bytes", stream.bytes},
                       {"missing", stream.missing},
                       {"edits", stream.edits},
                       {"marker_edits", stream.marker_edits},
                       {"scalar_edits", stream.scalar_edits},
                       {"scalars", scalar_json(stream.scalars)},
                       {"sequence", stream.sequence},
                       {"ages_known", stream.same_clock},
                       {"ages_below_power_of_two_us", ages}});
  }
  return json{{"uri", link.uri()},
              {"peers", stats.peers},
              {"messages", stats.messages_received},
              {"bytes", stats.bytes_received},
              {"poses_overtaken", stats.poses_dropped},
              {"not_understood", refused_},
              {"rejected", rejected},
              {"streams", streams}}
             .dump() +
         '\n';
}

}  // namespace fire3dv::inspect
