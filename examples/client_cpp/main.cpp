// C++ client example: publishes a box that rotates about the vertical axis. Usage: ./client_cpp [URI]
// [FRAMES]
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fire3dv/client.hpp>
#include <thread>

int main(int argc, char** argv) try {
  using namespace std::chrono_literals;
  const char* uri = argc > 1 ? argv[1] : "shm://demo";
  const long frames = argc > 2 ? std::atol(argv[2]) : 1000000;

  fire3dv::Stream stream(uri, "client_cpp");
  stream.describe({"box"});
  std::vector<fire3dv::Pose> stream_from_body(1);
  for (long i = 0; i < frames; ++i) {
    const float c = std::cos(0.01f * float(i)), s = std::sin(0.01f * float(i));
    stream_from_body[0] = {c, 0, s, 0, 0, 1, 0, 1, -s, 0, c, 0};  // 1 m above the floor
    stream.publish(i * 10ms, stream_from_body);
    stream.poll();
    std::this_thread::sleep_for(10ms);
  }
  std::printf("client_cpp: %ld frames published\n", frames);
  return 0;
} catch (const fire3dv::ClientError& error) {
  std::fprintf(stderr, "client_cpp: %s\n", error.what());
  return 1;
}
