// Benchmark of udp:// with a key (DTLS 1.2) and without: bytes, round trips and memory of a handshake, time
// to publish.
#pragma once

namespace fire3dv::bench {

struct DtlsOptions {
  int rounds = 301;
  double rate_hz = 1000;  // frames per second; 0: unlimited
};

// Prints three tables in Markdown. Returns the exit status.
int dtls_cost(const DtlsOptions& options);

}  // namespace fire3dv::bench
