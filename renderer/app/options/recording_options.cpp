#include "renderer/app/options/recording_options.h"

#include <CLI/CLI.hpp>

#include "base/command_line.h"

namespace fire3dv::app {
namespace {

constexpr double kMaxNumber = 1e6;  // eleven days of a recording, or the speed of it

}  // namespace

void add_recording_options(CLI::App& app, RecordingOptions& options) {
  OptionGroup group(app, "Recordings");
  const auto number = number_between(0, kMaxNumber);
  group.add("--replay", options.replay, "FILE",
            "replay a recording (.mcap); without a scene, the one inside");
  group.add_repeatable("--stream", options.streams, "NAME", "replay this stream only; repeatable");
  group.add("--speed", options.speed, "X", "factor on the recorded speed; 0: unpaced")->check(number);
  group.add("--start", options.start_s, "SECONDS", "begin SECONDS into the recording")->check(number);
  group.add("--end", options.end_s, "SECONDS", "end SECONDS into the recording; 0: at its end")
      ->check(number);
  group.add_flag("--loop", options.loop, "replay again and again");
  group.add_flag("--step", options.step, "draw each recorded frame exactly once, unpaced");
  group.add("--record", options.record, "FILE", "record the received streams (.mcap)");
  group
      .add("--record-sync", options.record_sync_s, "SECONDS", "interval of disk flushes; 0: only at the end")
      ->check(number);
  group.add_flag("--record-scene", options.attach_scene, "attach the scene to the recording (.glb)");
  group.add_flag("--foxglove", options.foxglove, "add Foxglove's scene and transform messages");
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
