// Benchmark of sealed udp:// beside DTLS 1.2 with a pre-shared key (OpenSSL): bytes, round trips, time.
#pragma once

namespace fire3dv::bench {

struct DtlsOptions {
  int rounds = 301;
  double rate_hz = 1000;  // frames a second; 0: one after the other
};

// Prints two tables in Markdown. Returns the exit status.
int dtls_cost(const DtlsOptions& options);

}  // namespace fire3dv::bench
