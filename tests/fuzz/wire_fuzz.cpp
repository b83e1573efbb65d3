// Fuzz target of the wire decoder: each accepted message can be traversed completely, and its encoding is
// accepted again.
#include <cmath>

#include "base/error.h"
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
wire::Bytes encode_again(const wire::UnknownEdit&) {
  return {};
}

wire::Bytes edit(wire::Property property, wire::EditValue value) {
  return wire::encode(wire::SceneEdit{7, 3, "link_1", property, std::move(value)});
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
  wire::PoseFrameView partial = frame;
  const std::vector<uint32_t> indices{1, 4};
  partial.poses = frame.poses.first(2);
  partial.node_indices = indices;
  wire::NodeAdded node;
  node.parent = "base";
  node.asset_glb.resize(20);
  wire::ImageRequest request;
  request.epoch = 7;
  request.id = 1;
  request.node = "camera";
  request.intrinsics = {64, 48, 50, 50, 31.5f, 23.5f, 0.1f, 0, {}};
  wire::ImageFrame image;
  image.request = image.number = 1;
  image.epoch = 7;
  image.intrinsics = request.intrinsics;
  image.pixel_bytes = 65536;
  image.planes = {{0, wire::ImageFormat::rgba8, 64, 48, 256, 0, 12288},
                  {3, wire::ImageFormat::r32u, 64, 48, 256, 12288, 12288},
                  {7, wire::ImageFormat::box2d, 2, 1, 64, 24576, 64}};
  wire::Marker points;
  points.positions = {{0, 0, 0}, {1, 2, 3}};
  points.colors = {0xff0000ff};
  wire::Marker texts = points;
  texts.kind = wire::MarkerKind::texts;
  texts.texts.assign(texts.positions.size(), "K\u00f6rper\n2");
  wire::Marker boxes = points;
  boxes.kind = wire::MarkerKind::boxes;
  boxes.parent = "base";
  boxes.lifetime_ns = 1;
  boxes.sizes = {{1, 2, 3}};
  boxes.rotations = {{0, 0, 0, 1}, {0, 0.6f, 0, 0.8f}};
  wire::Marker quad = boxes;
  quad.kind = wire::MarkerKind::images;
  quad.colors.clear();
  quad.image = {2, 1, 3, {255, 0, 0, 0, 255, 0}};
  wire::ImageRequest with_markers = request;
  with_markers.markers = true;
  with_markers.complete = true;
  wire::ImageRequest with_lens = request;
  with_lens.intrinsics.f_number = 1.8f;
  with_lens.intrinsics.focus_distance_m = 2;
  wire::ImageFrame blurred = image;
  blurred.intrinsics = with_lens.intrinsics;
  blurred.hidden_streams = 1;
  wire::Input slider;
  slider.kind = wire::InputKind::slider;
  slider.maximum = 2;
  slider.unit = "rad";
  wire::Input choice;
  choice.kind = wire::InputKind::choice;
  choice.choices = {"a", "b"};
  wire::Input run;
  run.kind = wire::InputKind::run;
  run.flags = wire::kInputRunPause | wire::kInputSpeed;
  run.maximum = 4;
  wire::InputEvent drag;
  drag.epoch = 7;
  drag.source = drag.sequence = 1;
  drag.input = "drag";
  drag.action = wire::InputAction::move;
  drag.target = {1, 2, 3};
  wire::InputEvent note = drag;
  note.action = wire::InputAction::set;
  note.text = "K\u00f6rper";
  wire::ImageRequest of_batch = request;
  of_batch.when = wire::ImageWhen::batch;
  wire::ImageBatch batch;
  batch.worlds = 2;
  batch.node_indices = {1, 0};
  batch.poses.resize(4);
  batch.world_of_view = {1, 0, 1};
  batch.view_poses.resize(3);
  batch.view_projections.resize(3, {50, 50, 31.5f, 23.5f});
  batch.active = {1, 0};
  of_batch.batch = std::move(batch);
  wire::ImageFrame images = image;
  images.views = 2;
  images.planes = {{3, wire::ImageFormat::r32u, 64, 96, 256, 0, 24576}};
  using P = wire::Property;
  return {input_of(wire::encode(request)),
          input_of(wire::encode(of_batch)),
          input_of(wire::encode(images)),
          input_of(wire::encode(with_lens)),
          input_of(wire::encode(blurred)),
          input_of(wire::encode(with_markers)),
          input_of(wire::encode(image)),
          input_of(wire::encode(wire::ImageRefused{7, 1, wire::ImageRefusal::too_many, "too many"})),
          input_of(wire::encode(description)),
          input_of(wire::encode(partial)),
          input_of(edit(P::visible, wire::Visible{false})),
          input_of(edit(P::base_color, wire::BaseColor{})),
          input_of(edit(P::light, wire::Light{})),
          input_of(edit(P::camera, wire::Camera{})),
          input_of(edit(P::camera, wire::Camera{1, 0.1f, 0, 0, 1.8f, 2})),
          input_of(edit(P::node, node)),
          input_of(edit(P::node, wire::NodeRemoved{})),
          input_of(edit(P::vertices, wire::Vertices{{{0, 0, 0}, {1, 2, 3}}, {{0, 0, 1}, {0, 1, 0}}})),
          input_of(edit(P::light, wire::Cleared{})),
          input_of(edit(P::marker, texts)),
          input_of(edit(P::marker, points)),
          input_of(edit(P::marker, boxes)),
          input_of(edit(P::marker, quad)),
          input_of(edit(P::scalars, wire::Scalars{{"shoulder", "elbow"}, {"rad", ""}})),
          input_of(edit(P::scalar_values, wire::ScalarValues{1, -2, {0.5, std::nan("")}})),
          input_of(edit(P::input, slider)),
          input_of(edit(P::input, choice)),
          input_of(edit(P::input, run)),
          input_of(wire::encode(drag)),
          input_of(wire::encode(note)),
          input_of(wire::encode(welcome)),
          input_of(wire::encode(wire::Status{7, {"base", "link_1"}, "requested"})),
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
    FIRE3DV_ASSERT(!frame->node_indices.empty() ||
                   frame->first_node + uint64_t{frame->poses.size()} <= frame->node_count);
    for (const uint32_t index : frame->node_indices) FIRE3DV_ASSERT(index < frame->node_count);
    for (const wire::Affine3x4& pose : frame->poses)
      for (const float element : pose.m) FIRE3DV_ASSERT(std::isfinite(element));
  }
  if (const auto* image = std::get_if<wire::ImageFrame>(&*message))
    for (const wire::ImagePlane& plane : image->planes) {
      FIRE3DV_ASSERT(plane.offset + plane.bytes <= image->pixel_bytes);
      FIRE3DV_ASSERT(uint64_t{plane.row_stride} * plane.height == plane.bytes);
    }
  if (const auto* one = std::get_if<wire::SceneEdit>(&*message))
    FIRE3DV_ASSERT(wire::fits(one->property, one->value));
  if (const auto* one = std::get_if<wire::SceneEdit>(&*message))
    if (const auto* scalars = std::get_if<wire::Scalars>(&one->value))
      FIRE3DV_ASSERT(scalars->names.size() == scalars->units.size() &&
                     scalars->names.size() <= wire::kMaxScalars);
  if (const auto* one = std::get_if<wire::SceneEdit>(&*message))
    if (const auto* input = std::get_if<wire::Input>(&one->value))
      FIRE3DV_ASSERT(std::isfinite(input->value) && input->choices.size() <= wire::kMaxInputChoices);
  if (const auto* event = std::get_if<wire::InputEvent>(&*message))
    FIRE3DV_ASSERT(std::isfinite(event->value) && std::isfinite(event->target[0]) && event->epoch != 0);
  const wire::Bytes again = std::visit([](const auto& m) { return fuzz::encode_again(m); }, *message);
  // A description of another major version has only the fields common to all versions.
  const auto* description = std::get_if<wire::StreamDescription>(&*message);
  const auto* welcome = std::get_if<wire::Welcome>(&*message);
  const bool ours = (description == nullptr || description->protocol_major == wire::kProtocolMajor) &&
                    (welcome == nullptr || welcome->protocol_major == wire::kProtocolMajor);
  if (!again.empty() && ours) FIRE3DV_ASSERT(second.decode(again).ok());
  return 0;
}
