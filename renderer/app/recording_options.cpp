#include "renderer/app/recording_options.h"

#include <CLI/CLI.hpp>
#include <charconv>

namespace fire3dv::app {
namespace {

constexpr double kMost = 1e6;  // eleven days of a recording, or so many times as fast

// CLI11's own check lets NaN and infinity pass.
std::string number_to_a_million(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good =
      error == std::errc() && end == text.data() + text.size() && value >= 0 && value <= kMost;  // not NaN
  return good ? "" : text + " is not a number from 0 to 1000000";
}

}  // namespace

void add_recording_options(CLI::App& app, RecordingOptions& options) {
  app.add_option(
      "--replay", options.replay,
      "show a recording (.mcap) as if its streams were published now; without SCENE the .glb file that "
      "travels in it");
  app.add_option("--stream", options.streams, "of a recording, this stream alone; may be given several times")
      ->allow_extra_args(false);
  app.add_option("--speed", options.speed, "times as fast as recorded; 0: as fast as can be")
      ->check(number_to_a_million)
      ->capture_default_str();
  app.add_option("--start", options.start_s, "seconds into the recording")->check(number_to_a_million);
  app.add_option("--end", options.end_s, "seconds into the recording; 0: its end")
      ->check(number_to_a_million);
  app.add_flag("--loop", options.loop, "play the recording again and again");
  app.add_flag("--step", options.step, "draw each recorded frame exactly once, whenever it came");
  app.add_option("--record", options.record, "record what is received into this file (.mcap)");
  app.add_option("--record-sync", options.record_sync_s,
                 "flush the recording to the disk every so many seconds; 0: only at its end")
      ->check(number_to_a_million)
      ->capture_default_str();
  app.add_flag("--record-scene", options.attach_scene, "let the scene travel in the recording: a .glb file");
  app.add_flag("--foxglove", options.foxglove, "record what Foxglove's viewers show, too");
}

std::optional<std::string> check_recording_options(const RecordingOptions& options) {
  if (options.replay.empty()) {
    const char* lonely = !options.streams.empty() ? "--stream"
                         : options.speed != 1     ? "--speed"
                         : options.start_s != 0   ? "--start"
                         : options.end_s != 0     ? "--end"
                         : options.loop           ? "--loop"
                         : options.step           ? "--step"
                                                  : nullptr;
    if (lonely) return std::string(lonely) + " needs a recording: --replay FILE.mcap";
  }
  if (options.record.empty() && options.record_sync_s != 1) return "--record-sync needs a --record file";
  if (options.record.empty() && (options.attach_scene || options.foxglove))
    return std::string(options.attach_scene ? "--record-scene" : "--foxglove") + " needs a --record file";
  return {};
}

}  // namespace fire3dv::app
