// Options of recordings: replay and record.
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
  std::vector<std::string> streams;  // stream names; empty: all
  double speed = 1, start_s = 0, end_s = 0;
  bool loop = false;
  bool step = false;  // one image per recorded frame

  std::string record;        // MCAP file; empty: none
  double record_sync_s = 1;  // flush interval; 0: only at the end
  bool attach_scene = false;
  bool foxglove = false;
};

void add_recording_options(CLI::App& app, RecordingOptions& options);
// Returns an error message for contradictory options.
std::optional<std::string> check_recording_options(const RecordingOptions& options);

}  // namespace fire3dv::app
