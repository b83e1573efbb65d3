// What the command line says of recordings: one that is shown, and one that is made.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace fire3dv::app {

struct RecordingOptions {
  std::string replay;                // MCAP file; empty: none
  std::vector<std::string> streams;  // of it; empty: all
  double speed = 1, start_s = 0, end_s = 0;
  bool loop = false;
  bool step = false;  // one image for each recorded frame

  std::string record;  // MCAP file; empty: none
  double record_sync_s = 1;  // 0: flushed to the disk at the end only
  bool attach_scene = false;
  bool foxglove = false;
};

void add_recording_options(CLI::App& app, RecordingOptions& options);
// What is wrong with them together, in words for people.
std::optional<std::string> check_recording_options(const RecordingOptions& options);

}  // namespace fire3dv::app
