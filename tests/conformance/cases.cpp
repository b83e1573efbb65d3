// Golden messages of protocol 1.0: valid, of later versions, and with invalid values.
#include "tests/conformance/cases.h"

#include <cmath>
#include <limits>

#include "later_generated.h"

namespace fire3dv::conformance {
namespace {

using namespace wire;

constexpr uint64_t kEpoch = 0x0123456789abcdef;

Affine3x4 pose(float x) {
  return {{0, 0, 1, x, 0, 1, 0, -0.5f, -1, 0, 0, 2.25f}};
}

StreamDescription description() {
  StreamDescription result;
  result.protocol_minor = 0;  // these golden messages date from version 1.0 and keep it
  result.adapter_name = "conformance";
  result.epoch = kEpoch;
  result.node_names = {"base", "arm"};
  return result;
}

StreamDescription full_description() {
  StreamDescription result = description();
  result.node_names = {"base", "arm", "robot/link 1", "Körper ~ 体", "🤖"};
  result.world_from_stream.m = {0.001, 0, 0, 1e6, 0, 0, 0.001, 0, 0, -0.001, 0, -2.5};
  for (size_t i = 0; i < 5; ++i) result.body_from_node.push_back(pose(static_cast<float>(i)));
  result.nominal_rate_hz = 240;
  result.scene_uri = "file:scene.glb";
  result.clock = {"1b4e28ba-2fa1-11d2-883f-0016d3cca427", 123456789, 1700000000000000000, 0.5};
  return result;
}

Bytes frame(uint32_t node_count, uint32_t first_node, const std::vector<Affine3x4>& poses,
            PoseFrameHeader header) {
  return encode(PoseFrameView{header, node_count, first_node, poses});
}

constexpr PoseFrameHeader kHeader{kEpoch, 1, 0, 1000000, 0, 0};

template <typename T>
Bytes to_bytes(flatbuffers::FlatBufferBuilder& builder, later::Body type, flatbuffers::Offset<T> body) {
  builder.Finish(later::CreateMessage(builder, type, body.Union()), later::MessageIdentifier());
  const auto* begin = reinterpret_cast<const std::byte*>(builder.GetBufferPointer());
  return {begin, begin + builder.GetSize()};
}

}  // namespace

std::vector<Case> cases_of_this_version() {
  std::vector<Case> result;
  const auto add = [&](std::string name, Bytes bytes) {
    result.push_back({std::move(name), std::move(bytes), true, {}});
  };

  add("stream_description-minimal", encode(description()));
  add("stream_description-full", encode(full_description()));
  StreamDescription d = description();
  d.node_names.clear();
  add("stream_description-no_nodes", encode(d));
  d = description();
  d.body_from_node = {pose(1)};
  add("stream_description-body_from_node_for_all", encode(d));
  d = description();
  d.protocol_minor = 7;
  add("stream_description-later_minor", encode(d));

  add("pose_frame-no_nodes", frame(0, 0, {}, kHeader));
  add("pose_frame-whole", frame(3, 0, {pose(1), pose(2), pose(3)}, kHeader));
  add("pose_frame-part", frame(1000, 997, {pose(1), pose(2), pose(3)}, kHeader));
  add("pose_frame-all_header_fields",
      frame(1, 0, {pose(1)},
            {UINT64_MAX, UINT64_MAX - 1, INT64_MIN, UINT64_MAX - 2, UINT64_MAX - 3, UINT32_MAX}));
  add("pose_frame-discontinuity", frame(1, 0, {pose(1)}, {kEpoch, 2, -5, 1000000, 0, kFrameDiscontinuity}));
  // Negative zero, the smallest and largest floats, and a singular matrix.
  constexpr float kTiny = std::numeric_limits<float>::denorm_min();
  add("pose_frame-extreme_numbers",
      frame(2, 0, {{{-0.0f, kTiny, -kTiny, 1e12f, 0, 0, 0, -1e12f, 0, 0, 0, 0.1f}}, {{0}}}, kHeader));

  add("welcome-accepted", encode(Welcome{WelcomeStatus::accepted, 1, 0, kEpoch, "fire3dv", "", {}, {}}));
  add("welcome-names", encode(Welcome{WelcomeStatus::accepted,
                                      1,
                                      0,
                                      kEpoch,
                                      "fire3dv",
                                      "2 of 5 nodes move nothing",
                                      {"Körper ~ 体", "arm"},
                                      {"base"}}));
  add("welcome-bad_description",
      encode(Welcome{WelcomeStatus::bad_description, 1, 0, 0, "fire3dv", "node_names[1] is empty", {}, {}}));
  add("welcome-refused",
      encode(Welcome{WelcomeStatus::refused, 1, 3, kEpoch, "fire3dv", "too many streams", {}, {}}));
  add("welcome-bad_key", encode(Welcome{WelcomeStatus::bad_key, 1, 0, 0, "fire3dv", "", {}, {}}));
  add("ack", encode(Ack{kEpoch, 42}));
  add("ping", encode(Ping{7, 123456789}));
  add("pong", encode(Pong{7, 123456789, UINT64_MAX}));
  add("goodbye", encode(Goodbye{kEpoch}));
  add("status-contested", encode(Status{kEpoch, {"Körper ~ 体", "arm"}, "another stream asks for them too"}));
  add("status-none", encode(Status{kEpoch, {}, ""}));
  return result;
}

std::vector<Case> cases_of_later_versions() {
  std::vector<Case> result;
  const auto add = [&](std::string name, Bytes bytes) {
    result.push_back({std::move(name), std::move(bytes), false, {}});
  };
  {
    flatbuffers::FlatBufferBuilder builder;
    const auto note = later::CreateNote(builder, builder.CreateString("what 1.0 has never heard of"));
    add("later-unknown_message", to_bytes(builder, later::Body::Note, note));
  }
  {
    flatbuffers::FlatBufferBuilder builder;
    const auto note = later::CreateNote(builder, builder.CreateString("a field of 1.1"));
    const auto notes = builder.CreateVector(&note, 1);
    const auto name = builder.CreateString("fire3dv");
    later::WelcomeBuilder table(builder);
    table.add_protocol_major(1);
    table.add_protocol_minor(1);
    table.add_epoch(kEpoch);
    table.add_status(9);  // unknown status: readers treat it as refused
    table.add_renderer_name(name);
    table.add_notes(notes);
    add("later-welcome_with_new_field_and_status", to_bytes(builder, later::Body::Welcome, table.Finish()));
  }
  {
    flatbuffers::FlatBufferBuilder builder;
    const auto name = builder.CreateString("from the future");
    later::StreamDescriptionBuilder table(builder);
    table.add_adapter_name(name);
    table.add_epoch(kEpoch);
    table.add_protocol_major(2);
    table.add_protocol_minor(3);
    table.add_node_names(0xffffffff);
    add("later-description_of_another_major",
        to_bytes(builder, later::Body::StreamDescription, table.Finish()));
  }
  {
    flatbuffers::FlatBufferBuilder builder;
    later::WelcomeBuilder table(builder);
    table.add_status(1);
    table.add_protocol_major(2);
    table.add_epoch(kEpoch);
    add("later-welcome_of_another_major", to_bytes(builder, later::Body::Welcome, table.Finish()));
  }
  return result;
}

std::vector<Case> refused_cases() {
  std::vector<Case> result;
  const auto add = [&](std::string name, Bytes bytes, std::string refused) {
    result.push_back({"refused-" + std::move(name), std::move(bytes), false, std::move(refused)});
  };
  const auto add_description = [&](std::string name, std::string refused, auto change) {
    StreamDescription d = full_description();
    change(d);
    add("description_" + std::move(name), encode(d), "StreamDescription." + std::move(refused));
  };
  add_description("epoch_zero", "epoch", [](auto& d) { d.epoch = 0; });
  add_description("name_empty", "node_names[1]", [](auto& d) { d.node_names[1] = ""; });
  add_description("name_twice", "node_names[4]", [](auto& d) { d.node_names[4] = "base"; });
  add_description("name_control_character", "node_names[2]",
                  [](auto& d) { d.node_names[2] = "\x1b[2Jgone"; });
  add_description("name_nul", "node_names[2]", [](auto& d) { d.node_names[2] = std::string("a\0b", 3); });
  add_description("name_c1_control", "node_names[2]", [](auto& d) {
    d.node_names[2] =
        "a\xc2\x9b"
        "31m";
  });
  add_description("name_turns_direction", "node_names[2]",
                  [](auto& d) { d.node_names[2] = "\xe2\x80\xaegnp.exe"; });
  add_description("name_overlong_utf8", "node_names[0]", [](auto& d) { d.node_names[0] = "\xc0\xaf"; });
  add_description("name_surrogate", "node_names[0]", [](auto& d) { d.node_names[0] = "\xed\xa0\x80"; });
  add_description("name_cut_utf8", "node_names[0]", [](auto& d) { d.node_names[0] = "\xe2\x82"; });
  add_description("name_too_long", "node_names[3]",
                  [](auto& d) { d.node_names[3] = std::string(1025, 'x'); });
  add_description("adapter_name_newline", "adapter_name", [](auto& d) { d.adapter_name = "a\nb"; });
  add_description("uri_too_long", "scene_uri", [](auto& d) { d.scene_uri = std::string(4097, 'x'); });
  add_description("boot_id_tab", "clock.boot_id", [](auto& d) { d.clock.boot_id = "\t"; });
  add_description("world_nan", "world_from_stream[11]", [](auto& d) { d.world_from_stream.m[11] = NAN; });
  add_description("world_huge", "world_from_stream[0]", [](auto& d) { d.world_from_stream.m[0] = 1e300; });
  add_description("body_from_node_count", "body_from_node has 4",
                  [](auto& d) { d.body_from_node.pop_back(); });
  add_description("body_from_node_infinite", "body_from_node[2] row 1",
                  [](auto& d) { d.body_from_node[2].m[6] = INFINITY; });
  add_description("rate_negative", "nominal_rate_hz", [](auto& d) { d.nominal_rate_hz = -1; });
  add_description("rate_nan", "nominal_rate_hz", [](auto& d) { d.nominal_rate_hz = NAN; });
  add_description("sim_rate_infinite", "clock.sim_seconds",
                  [](auto& d) { d.clock.sim_seconds_per_second = INFINITY; });

  PoseFrameHeader header = kHeader;
  header.epoch = 0;
  add("pose_frame_epoch_zero", frame(1, 0, {pose(0)}, header), "PoseFrame.epoch");
  header = kHeader;
  header.sequence = 0;
  add("pose_frame_sequence_zero", frame(1, 0, {pose(0)}, header), "PoseFrame.sequence");
  Affine3x4 bad = pose(0);
  bad.m[5] = NAN;
  add("pose_frame_nan", frame(2, 0, {pose(0), bad}, kHeader), "PoseFrame.poses[1] row 1 column 1 is NaN");
  bad.m[5] = -INFINITY;
  add("pose_frame_infinite", frame(2, 0, {bad, pose(0)}, kHeader),
      "PoseFrame.poses[0] row 1 column 1 is -infinity");
  bad.m[5] = 1.1e12f;
  add("pose_frame_huge", frame(1, 0, {bad}, kHeader), "PoseFrame.poses[0] row 1 column 1");
  add("pose_frame_too_many_nodes", frame(UINT32_MAX, 0, {pose(0)}, kHeader), "PoseFrame.node_count");
  add("pose_frame_more_poses_than_nodes", frame(1, 0, {pose(0), pose(1)}, kHeader), "PoseFrame.first_node");
  add("pose_frame_first_node_too_large", frame(2, 2, {pose(0)}, kHeader), "PoseFrame.first_node");
  add("pose_frame_first_node_wraps", frame(2, UINT32_MAX, {pose(0)}, kHeader), "PoseFrame.first_node");
  {
    flatbuffers::FlatBufferBuilder builder;
    const auto poses = builder.CreateVector(std::vector<uint32_t>{});
    later::PoseFrameBuilder table(builder);
    table.add_epoch(kEpoch);
    table.add_sequence(1);
    table.add_node_count(5);
    table.add_node_indices(poses);
    add("pose_frame_partial", to_bytes(builder, later::Body::PoseFrame, table.Finish()),
        "PoseFrame.node_indices");
  }

  {
    // A decompression bomb: a thousand entries share one name, so the message is small and its copy large.
    flatbuffers::FlatBufferBuilder builder;
    const auto name = builder.CreateString(std::string(1000, 'x'));
    const auto names = builder.CreateVector(std::vector(1000, name));
    later::WelcomeBuilder table(builder);
    table.add_protocol_major(1);
    table.add_unmatched_names(names);
    add("welcome_names_overlap", to_bytes(builder, later::Body::Welcome, table.Finish()),
        "Welcome.unmatched_names");
  }

  Welcome welcome{WelcomeStatus::accepted, 1, 0, kEpoch, "fire3dv", "hello", {"a"}, {"b"}};
  welcome.message = "line\nline";
  add("welcome_message_newline", encode(welcome), "Welcome.message");
  welcome.message = "";
  welcome.renderer_name = "\xff";
  add("welcome_renderer_name_utf8", encode(welcome), "Welcome.renderer_name");
  welcome.renderer_name = "";
  welcome.unmatched_names = {"a", "\x07"};
  add("welcome_unmatched_bell", encode(welcome), "Welcome.unmatched_names[1]");

  add("status_epoch_zero", encode(Status{0, {"arm"}, ""}), "Status.epoch");
  add("status_name_control_character", encode(Status{kEpoch, {"arm", "\x1b[2J"}, ""}),
      "Status.contested_names[1]");
  add("status_message_newline", encode(Status{kEpoch, {}, "line\nline"}), "Status.message");
  return result;
}

}  // namespace fire3dv::conformance
