// Simulator for tests of recordings: record_source URI NAME FRAMES RATE_HZ NODES [wait]. Publishes verifiable
// frames (node i of frame s is at x = s + i / 1000) and an edit every 16 frames. Prints their number, and
// ends the stream with a goodbye. wait: begins when a reader is connected.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "fire3dv/client.hpp"

int main(int argc, char** argv) try {
  if (argc < 6) return 2;
  const uint64_t frames = std::strtoull(argv[3], nullptr, 10);
  const double rate_hz = std::atof(argv[4]);
  const auto nodes = static_cast<uint32_t>(std::atoi(argv[5]));
  fire3dv::Stream stream(argv[1], argv[2]);
  fire3dv::Description description;
  for (uint32_t i = 0; i < nodes; ++i) description.node_names.push_back("link_" + std::to_string(i));
  description.nominal_rate_hz = rate_hz;
  stream.describe(description);
  const bool waits = argc > 6 && std::strcmp(argv[6], "wait") == 0;
  while (waits && stream.poll().renderers == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  std::vector<fire3dv::Pose> poses(nodes);
  const auto begun = std::chrono::steady_clock::now();
  for (uint64_t s = 1; s <= frames; ++s) {
    std::this_thread::sleep_until(begun + std::chrono::duration<double>(static_cast<double>(s) / rate_hz));
    for (uint32_t i = 0; i < nodes; ++i)
      poses[i] = {1, 0, 0, static_cast<float>(s) + static_cast<float>(i) / 1000, 0, 1, 0, 0, 0, 0, 1, 0};
    if (s % 16 == 1) stream.set_visible("link_" + std::to_string(s / 16 % nodes), s / 16 % 2 == 0);
    stream.publish(std::chrono::milliseconds(s), poses);
    stream.poll();
  }
  std::printf("%llu\n", static_cast<unsigned long long>(frames));
  return 0;
} catch (const fire3dv::ClientError& error) {
  std::fprintf(stderr, "record_source: %s\n", error.what());
  return 1;
}
