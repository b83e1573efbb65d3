// Bytes to messages: whatever is accepted can be walked from end to end, and encodes to something that is
// accepted.
#include <cmath>

#include "protocol/error.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/encode.h"
#include "tests/fuzz/target.h"

namespace fire3dv::fuzz {
namespace {

Input input_of(const wire::Bytes& bytes) {
  const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
  return {data, data + bytes.size()};
}

template <typename T>
wire::Bytes encode_again(const T& message) {
  return wire::encode(message);
}
wire::Bytes encode_again(const wire::UnknownMessage&) {
  return {};
}

}  // namespace

std::vector<Input> seeds() {
  wire::StreamDescription description;
  description.epoch = 7;
  description.adapter_name = "adapter";
  description.node_names = {"base", "link_1", "a/b~c", "gr\xc3\xbc\xc3\x9f"};
  description.body_from_node.resize(4);
  description.scene_uri = "scene.glb";
  description.clock.boot_id = "boot";
  wire::Welcome welcome;
  welcome.unmatched_names = {"x"};
  welcome.message = "accepted";
  const std::vector<wire::Affine3x4> poses(5);
  wire::PoseFrameView frame;
  frame.header.epoch = 7;
  frame.header.sequence = 1;
  frame.node_count = 5;
  frame.poses = poses;
  return {input_of(wire::encode(description)),
          input_of(wire::encode(welcome)),
          input_of(wire::encode(wire::Status{7, {"base", "link_1"}, "asked for"})),
          input_of(wire::encode(frame)),
          input_of(wire::encode(wire::Ack{7, 1})),
          input_of(wire::encode(wire::Ping{1, 2})),
          input_of(wire::encode(wire::Pong{1, 2, 3})),
          input_of(wire::encode(wire::Goodbye{7}))};
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv;
  static wire::Decoder decoder, second;
  const auto message = decoder.decode(std::as_bytes(std::span(data, size)));
  if (!message) {
    FIRE3DV_ASSERT(!message.error().message.empty());
    return 0;
  }
  if (const auto* frame = std::get_if<wire::PoseFrameView>(&*message)) {
    FIRE3DV_ASSERT(frame->first_node + uint64_t{frame->poses.size()} <= frame->node_count);
    for (const wire::Affine3x4& pose : frame->poses)
      for (const float element : pose.m) FIRE3DV_ASSERT(std::isfinite(element));
  }
  const wire::Bytes again = std::visit([](const auto& m) { return fuzz::encode_again(m); }, *message);
  // Another major's description holds only what all majors share.
  const auto* description = std::get_if<wire::StreamDescription>(&*message);
  const auto* welcome = std::get_if<wire::Welcome>(&*message);
  const bool ours = (description == nullptr || description->protocol_major == wire::kProtocolMajor) &&
                    (welcome == nullptr || welcome->protocol_major == wire::kProtocolMajor);
  if (!again.empty() && ours) FIRE3DV_ASSERT(second.decode(again).ok());
  return 0;
}
