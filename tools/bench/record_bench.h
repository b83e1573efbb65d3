// What recordings cost: making them, their size, reading them, and seeking in them. Each call is one
// measurement, in a process of its own, and says one JSON line.
#pragma once

#include <cstdint>
#include <string>

namespace fire3dv::bench {

// Layouts: frames, as our recorder writes them; poses, one message for each pose in a channel for each node,
// as logs of single topics have it; raw, bare frames one behind the other, without any format.
struct RecordWriteOptions {
  std::string file;
  double seconds = 60;
  uint32_t nodes = 100;
  double rate_hz = 1000;
  std::string compression = "zstd";  // zstd, lz4, none
  std::string layout = "frames";     // frames, poses, raw
  // arm: every pose changes in every frame; rest: all stand still but for half a second of each minute.
  std::string motion = "arm";
  bool foxglove = false;
};
int record_write(const RecordWriteOptions& options);

struct RecordReadOptions {
  std::string file;
  uint32_t seeks = 200;
  bool reads_all = true;
  uint64_t memory_mb = 64;
};
int record_read(const RecordReadOptions& options);

}  // namespace fire3dv::bench
