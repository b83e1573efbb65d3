// Adapter that violates the message rules above the link: sends one chosen message, which the client library
// would refuse to send, over a real link and prints the renderer's answer.
//
//   rude_client URI wrong_version|nan_description|pose_first|not_a_message
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <thread>

#include "protocol/transport/open.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/encode.h"

namespace {

using namespace std::chrono_literals;
namespace wire = fire3dv::wire;
namespace transport = fire3dv::transport;

wire::StreamDescription description() {
  wire::StreamDescription description;
  description.adapter_name = "rude_client";
  description.epoch = 0x1234;
  description.node_names = {"red"};
  return description;
}

wire::Bytes description_of(const std::string& fault) {
  wire::StreamDescription faulty = description();
  if (fault == "wrong_version") faulty.protocol_major = wire::kProtocolMajor + 1;
  if (fault == "nan_description") faulty.world_from_stream.m[3] = std::numeric_limits<double>::quiet_NaN();
  wire::Bytes bytes = wire::encode(faulty);
  if (fault == "not_a_message") {
    for (std::byte& byte : bytes) byte ^= std::byte{0xa5};
  }
  return bytes;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: rude_client URI wrong_version|nan_description|pose_first|not_a_message\n");
    return 2;
  }
  const std::string fault = argv[2];
  auto link = transport::open_publisher(argv[1]);
  if (!link) {
    std::fprintf(stderr, "rude_client: %s\n", link.error().message.c_str());
    return 1;
  }
  const wire::Affine3x4 pose{};
  wire::PoseFrameView frame;
  frame.header.epoch = 0x1234;
  frame.node_count = 1;
  frame.poses = {&pose, 1};
  if (fault != "pose_first") {
    if (auto set = (*link)->set_description(description_of(fault)); !set) {
      std::fprintf(stderr, "rude_client: %s\n", set.error().message.c_str());
      return 1;
    }
  }
  wire::PoseFrameEncoder encoder;
  wire::Decoder decoder;
  wire::Bytes answer;
  const auto until = std::chrono::steady_clock::now() + 120s;  // hang limit
  while (std::chrono::steady_clock::now() < until) {
    frame.header.sequence++;
    (*link)->publish(encoder.encode(frame));
    while ((*link)->poll(answer)) {
      const auto message = decoder.decode(answer);
      const auto* welcome = message ? std::get_if<wire::Welcome>(&*message) : nullptr;
      if (!welcome) continue;
      std::printf("status=%d major=%d epoch=%llx message=%s\n", static_cast<int>(welcome->status),
                  welcome->protocol_major, static_cast<unsigned long long>(welcome->epoch),
                  welcome->message.c_str());
      return 0;
    }
    // The renderer drops a pose before any description without an answer; by now enough have arrived.
    if (fault == "pose_first" && (*link)->stats().peers > 0 && frame.header.sequence > 500) {
      std::printf("sent\n");
      return 0;
    }
    std::this_thread::sleep_for(2ms);
  }
  std::fprintf(stderr, "rude_client: no answer came\n");
  return 1;
}
