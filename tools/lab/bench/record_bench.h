// Recording benchmark: write cost, file size, read cost and seek time. Each call is one measurement in its
// own process and prints one JSON line.
#pragma once

#include <cstdint>
#include <string>

namespace fire3dv::bench {

// Layouts: `frames`, as this project's recorder writes; `poses`, one channel per node with one pose per
// message, as in logs of single topics; `raw`, bare frames without a container.
struct RecordWriteOptions {
  std::string file;
  double seconds = 60;
  uint32_t nodes = 100;
  double rate_hz = 1000;
  std::string compression = "zstd";  // zstd, lz4, none
  std::string layout = "frames";     // frames, poses, raw
  // arm: every pose changes in every frame; rest: poses change only during half a second of each minute.
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
