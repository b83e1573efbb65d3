// Test of fire3dv-inspect's report of a link.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/clock.h"
#include "programs/inspect/observer.h"
#include "programs/inspect/recorded_edits.h"
#include "protocol/wire/encode.h"
#include "tests/unit/protocol/transport/link_fixture.h"

namespace fire3dv::inspect {
namespace {

using namespace transport::test;

struct Inspect : testing::TestWithParam<const char*> {
  static wire::Bytes frame(uint64_t sequence) {
    static const std::vector<wire::Affine3x4> poses(2);
    wire::PoseFrameView view;
    view.header.epoch = 5;
    view.header.sequence = sequence;
    view.header.publish_time_ns = static_cast<uint64_t>(fire3dv::monotonic_ns());
    view.node_count = 2;
    view.poses = poses;
    return wire::encode(view);
  }
};

TEST_P(Inspect, CountsFramesGapsAndAges) {
  transport::ListenerOptions options;
  options.delivery = transport::Delivery::all;
  const std::string uri = std::string(GetParam()) == "shm" ? unique_shm_uri("inspect") : "tcp://127.0.0.1:0";
  Listener listener(uri, options);
  auto publisher = open_publisher_or_fail(listener.link->uri());
  wire::StreamDescription description;
  description.epoch = 5;
  description.adapter_name = "a simulator";
  description.node_names = {"x", "y"};
  std::ifstream("/proc/sys/kernel/random/boot_id") >> description.clock.boot_id;
  ASSERT_TRUE(publisher->set_description(wire::encode(description)));
  Observer observer;
  const auto poll_until = [&](const std::function<bool()>& done) {
    const auto until = std::chrono::steady_clock::now() + kHangLimit;
    while (!done() && std::chrono::steady_clock::now() < until) {
      listener.link->wait(std::chrono::milliseconds(5));
      observer.poll(*listener.link);
    }
    return done();
  };
  ASSERT_TRUE(poll_until([&] { return observer.streams().size() == 1; }));
  const transport::PeerId peer = observer.streams().begin()->first;
  const StreamSeen& stream = observer.streams().at(peer);
  uint64_t expected = 0;
  for (const uint64_t sequence : {1, 2, 3, 7, 8}) {
    const wire::Bytes message = frame(sequence);
    publisher->publish({message, {}});
    ++expected;
    ASSERT_TRUE(poll_until([&] { return stream.frames == expected; })) << sequence;
  }
  EXPECT_EQ(stream.missing, 3u);
  EXPECT_EQ(stream.nodes, 2u);
  EXPECT_GT(stream.rate_hz(), 0);
  EXPECT_GT(stream.age_us(0.99), 0u);
  wire::SceneEdit edit;
  edit.epoch = 5;
  edit.version = 1;
  edit.node = "x";
  edit.property = wire::Property::marker;
  edit.value = wire::Cleared{};
  const wire::Bytes edit_message = wire::encode(edit);
  publisher->send_control(edit_message);
  ASSERT_TRUE(poll_until([&] { return stream.edits == 1; }));
  const auto send_scalars = [&](uint64_t version, wire::Property property, wire::EditValue value) {
    publisher->send_control(wire::encode(wire::SceneEdit{5, version, "arm", property, std::move(value)}));
  };
  send_scalars(2, wire::Property::scalars, wire::Scalars{{"shoulder", "energy"}, {"rad", ""}});
  constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();
  uint64_t version = 2;
  for (const double value : {0.5, -1.25, 0.25})
    send_scalars(++version, wire::Property::scalar_values, wire::ScalarValues{2, 0, {value, kNoValue}});
  // Links may repeat an edit: it does not count again.
  send_scalars(version, wire::Property::scalar_values, wire::ScalarValues{2, 0, {7, kNoValue}});
  ASSERT_TRUE(poll_until([&] { return stream.scalar_edits == 5; }));
  publisher->publish(message_of("not a message"));
  ASSERT_TRUE(poll_until([&] { return observer.refused_messages() == 1; }));

  const auto json = nlohmann::json::parse(observer.json(*listener.link));
  EXPECT_EQ(json["streams"][0]["name"], "a simulator");
  EXPECT_EQ(json["streams"][0]["missing"], 3);
  EXPECT_EQ(json["streams"][0]["edits"], 6);
  EXPECT_EQ(json["streams"][0]["scalars"][0],
            nlohmann::json::parse(R"({"group": "arm", "name": "shoulder", "unit": "rad", "count": 3,
                                      "min": -1.25, "max": 0.5, "last": 0.25})"));
  EXPECT_EQ(json["streams"][0]["scalars"][1]["count"], 0);
  EXPECT_TRUE(json["streams"][0]["scalars"][1]["max"].is_null());
  EXPECT_EQ(json["streams"][0]["marker_edits"], 1);
  EXPECT_EQ(json["not_understood"], 1);
  EXPECT_EQ(json["rejected"]["bad_key"], 0);
  uint64_t ages = 0;
  for (const auto& count : json["streams"][0]["ages_below_power_of_two_us"]) ages += count.get<uint64_t>();
  EXPECT_EQ(ages, 5u) << "each frame has one age";
  const std::string text = observer.text(*listener.link);
  EXPECT_NE(text.find("\"a simulator\": 2 nodes"), std::string::npos);
  EXPECT_NE(text.find("6 scene edits (1 of markers) (5 of scalars)"), std::string::npos) << text;
  EXPECT_NE(text.find("  arm/shoulder [rad]: 3 values, min -1.25, max 0.5, last 0.25\n"), std::string::npos)
      << text;
  EXPECT_NE(text.find("  arm/energy: 0 values\n"), std::string::npos) << text;
  EXPECT_NE(text.find("half below"), std::string::npos) << text;
  EXPECT_NE(text.find(" us        "), std::string::npos) << text;
  EXPECT_NE(text.find("########"), std::string::npos) << "the fullest bar is as long as any may be: " << text;
  publisher.reset();
  EXPECT_TRUE(poll_until([&] { return stream.ended; }));
}

INSTANTIATE_TEST_SUITE_P(Links, Inspect, testing::Values("shm", "tcp"),
                         [](const auto& link) { return std::string(link.param); });

wire::SceneEdit edit_of(uint64_t epoch, uint64_t version, const std::string& name, wire::Property property,
                        wire::EditValue value) {
  return {epoch, version, name, property, std::move(value)};
}

wire::Marker marker_of(wire::MarkerKind kind, size_t positions) {
  wire::Marker marker;
  marker.kind = kind;
  marker.positions.resize(positions);
  return marker;
}

TEST(RecordedEdits, ScalarsAndMarkersAreListed) {
  using wire::Property;
  RecordedEdits edits;
  edits.take("arm", edit_of(5, 1, "joints", Property::scalars, wire::Scalars{{"elbow"}, {"rad"}}));
  edits.take("arm", edit_of(5, 2, "joints", Property::scalar_values, wire::ScalarValues{1, 0, {0.5}}));
  edits.take("arm", edit_of(5, 3, "joints", Property::scalar_values, wire::ScalarValues{1, 9, {-2}}));
  edits.take("arm",
             edit_of(5, 2, "joints", Property::scalar_values, wire::ScalarValues{1, 0, {9}}));  // snapshot
  edits.take("arm", edit_of(5, 4, "forces", Property::marker, marker_of(wire::MarkerKind::arrows, 6)));
  edits.take("arm", edit_of(5, 5, "forces", Property::marker, marker_of(wire::MarkerKind::arrows, 4)));
  edits.take("arm", edit_of(5, 6, "scan", Property::marker, marker_of(wire::MarkerKind::points, 1000)));
  edits.take("arm", edit_of(5, 7, "scan", Property::marker, wire::Cleared{}));
  edits.take("arm",
             edit_of(5, 8, "later", Property::marker, marker_of(static_cast<wire::MarkerKind>(99), 2)));
  edits.take("arm", edit_of(5, 9, "link", Property::visible, wire::Visible{false}));
  EXPECT_EQ(edits.text("arm"),
            "    joints/elbow [rad]: 2 values, min -2, max 0.5, last -2\n"
            "    marker forces: arrows, 2 elements, set 2 times\n"
            "    marker later: kind 99, 2 elements, set 1 time\n"
            "    marker scan: points, 1000 elements, set 1 time, cleared\n");
  EXPECT_EQ(edits.text("leg"), "");
  nlohmann::json json;
  edits.add_json("arm", json);
  EXPECT_EQ(json["scalars"][0]["last"], -2);
  EXPECT_EQ(json["scalars"][0]["unit"], "rad");
  EXPECT_EQ(json["markers"].size(), 3u);
  EXPECT_EQ(json["markers"][0], nlohmann::json::parse(R"({"name": "forces", "kind": "arrows", "elements": 2,
                                                          "values": 2, "cleared": false})"));
  // A new run: other scalars, the same marker.
  edits.take("arm", edit_of(6, 1, "forces", Property::marker, marker_of(wire::MarkerKind::arrows, 2)));
  EXPECT_NE(edits.text("arm").find("forces: arrows, 1 element, set 3 times\n"), std::string::npos);
  EXPECT_EQ(edits.text("arm").find("elbow"), std::string::npos);
}

TEST(RecordedEdits, HostileNamesAreBounded) {
  RecordedEdits edits;
  for (uint64_t i = 1; i <= RecordedEdits::kMaxMarkers + 3; ++i)
    edits.take("arm", edit_of(5, i, "m" + std::to_string(i), wire::Property::marker,
                              marker_of(wire::MarkerKind::points, 1)));
  nlohmann::json json;
  edits.add_json("arm", json);
  EXPECT_EQ(json["markers"].size(), RecordedEdits::kMaxMarkers);
  const std::string text = edits.text("arm");
  EXPECT_LT(std::count(text.begin(), text.end(), '\n'), 70);
  EXPECT_NE(text.find("    and 3 values of further markers\n"), std::string::npos) << text;
  // Control characters of names do not reach terminals.
  RecordedEdits hostile;
  hostile.take("arm",
               edit_of(5, 1, "\x1b[2J", wire::Property::marker, marker_of(wire::MarkerKind::points, 1)));
  EXPECT_EQ(hostile.text("arm").find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace fire3dv::inspect
