// Renderer that answers image requests with lies, for tests of clients. Prints the URI of its link.
//
//   lying_renderer URI LIE
//
// LIE: none, planes (there are none), output (another one), size (1 x 1 pixels), lens (an unknown one),
// sequence (a frame that nobody has published)
#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>

#include "protocol/transport/open.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/encode.h"

namespace {

using namespace fire3dv;

wire::ImageFrame answer_to(const wire::ImageRequest& request, uint64_t number, const std::string& lie) {
  wire::ImageFrame frame;
  frame.request = request.id;
  frame.number = number;
  frame.epoch = request.epoch;
  frame.sequence = lie == "sequence" ? UINT64_MAX : request.sequence;
  frame.intrinsics = request.intrinsics;
  if (frame.intrinsics.fx == 0) {  // the camera's own projection
    frame.intrinsics.fx = frame.intrinsics.fy = 30;
    frame.intrinsics.near_m = 0.1f;
  }
  if (lie == "size") frame.intrinsics.width = frame.intrinsics.height = 1;
  if (lie == "lens") frame.intrinsics.lens.model = wire::LensModel{9};
  if (lie == "planes") return frame;
  const uint32_t bit = lie == "output" ? 2 : 0;
  const uint32_t row = wire::info_at(bit).element_bytes * frame.intrinsics.width;
  frame.planes = {{bit, wire::info_at(bit).format, frame.intrinsics.width, frame.intrinsics.height, row, 0,
                   uint64_t{row} * frame.intrinsics.height}};
  frame.pixel_bytes = (frame.planes[0].bytes + 63) / 64 * 64;
  return frame;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  auto link = transport::open_listener(argv[1]);
  if (!link) return std::fprintf(stderr, "%s\n", link.error().message.c_str()), 1;
  std::printf("%s\n", (*link)->uri().c_str());
  std::fflush(stdout);
  wire::Decoder decoder;
  wire::ImageRequest periodic;  // is answered with each frame
  uint64_t number = 0;
  for (;;) {
    (*link)->wait(std::chrono::milliseconds(10));
    (*link)->poll([&](const transport::LinkEvent& event) {
      if (event.message.empty()) return;
      const auto message = decoder.decode(event.message);
      if (!message) return;
      wire::ImageRequest due;
      if (const auto* request = std::get_if<wire::ImageRequest>(&*message)) {
        (request->when == wire::ImageWhen::every_nth ? periodic : due) = *request;
      } else if (const auto* pose = std::get_if<wire::PoseFrameView>(&*message)) {
        due = periodic;
        due.sequence = pose->header.sequence;
      }
      if (due.id == 0 || due.when == wire::ImageWhen::never) return;
      const wire::ImageFrame frame = answer_to(due, ++number, argv[2]);
      (*link)->send_image(event.peer, due.id, wire::encode(frame), frame.pixel_bytes,
                          [](std::span<std::byte> pixels) {
                            if (!pixels.empty()) std::memset(pixels.data(), 7, pixels.size());
                          });
    });
  }
}
