// Benchmarks of links, one function per command of fire3dv-bench. Each prints tables in Markdown and returns
// the exit code.
#pragma once

#include <cstddef>
#include <string>

#include "tools/lab/bench/links/one_way.h"

namespace fire3dv::bench {

// Cost of a publish over shared memory, against a bare copy of the same bytes.
int publish_bench(int rounds);

struct OneWayOptions {
  int rounds = 31;
  int frames = 100;  // consecutive frames per transport and turn
  double rate_hz = 1000;
  LinkSecurity security;  // links without key files are skipped
};

// Cost of a publish and arrival time of its frame for each link, against the simplest transport of the same
// kind.
int one_way_bench(const OneWayOptions& options);

struct DtlsOptions {
  int rounds = 301;
  double rate_hz = 1000;  // frames per second; 0: unlimited
};

// udp:// with a key (DTLS 1.2) and without: bytes, round trips and memory of a handshake, time to publish.
int dtls_cost(const DtlsOptions& options);

// Cost of an image request without a wait, against publishing a frame.
int request_bench(int rounds);

struct PublishOptions {
  std::string uri;
  size_t poses = 100;
  double rate_hz = 1000;
};

// Scripted publisher at a fixed rate. Runs until end of input. For each input line it prints a JSON line
// about the calls since the last one: count, percentiles in nanoseconds, drops, readers.
int publish_command(const PublishOptions& options);

struct IngestOptions {
  double seconds = 2;  // per row
};

// Poses per second that a renderer receives, decodes, checks and binds to nodes.
int ingest_bench(const IngestOptions& options);

}  // namespace fire3dv::bench
