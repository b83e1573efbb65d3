// Test of scalars through the client library: declarations and values arrive, frames do not wait for them,
// and invalid calls are refused with a message.
#include "fire3dv/scalars.h"

#include <cmath>
#include <string>
#include <vector>

#include "fire3dv/client.hpp"
#include "tests/unit/adapters/generic/client_fixture.h"

namespace fire3dv::test {
namespace {

using namespace std::chrono_literals;

struct ScalarRenderer {
  std::unique_ptr<transport::ListenerLink> link;
  wire::Decoder decoder;
  wire::Scalars declared;
  uint64_t declaration = 0, scene_version = 0, sequence = 0;
  std::vector<wire::ScalarValues> received;
  size_t cleared = 0;

  explicit ScalarRenderer(const std::string& uri) { link = std::move(*transport::open_listener(uri)); }
  void poll() {
    link->wait(1ms);
    link->poll([this](const transport::LinkEvent& event) {
      using Kind = transport::LinkEvent::Kind;
      if (event.kind != Kind::pose && event.kind != Kind::control) return;
      auto message = decoder.decode(event.message);
      ASSERT_TRUE(message.ok()) << message.error().message;
      if (const auto* frame = std::get_if<wire::PoseFrameView>(&*message)) {
        scene_version = frame->header.scene_version;
        sequence = frame->header.sequence;
      }
      auto* edit = std::get_if<wire::SceneEdit>(&*message);
      if (!edit) return;
      if (auto* scalars = std::get_if<wire::Scalars>(&edit->value)) {
        declared = *scalars;
        declaration = edit->version;
      }
      if (auto* values = std::get_if<wire::ScalarValues>(&edit->value)) received.push_back(*values);
      cleared += std::holds_alternative<wire::Cleared>(edit->value);
    });
  }
};

constexpr const char* kNames[] = {"shoulder", "elbow", "K\u00f6rper"};
constexpr const char* kUnits[] = {"rad", nullptr, "N\u00b7m"};
constexpr fire3dv_scalars kArm{sizeof(fire3dv_scalars), kNames, kUnits, 3};

class ClientScalars : public testing::TestWithParam<const char*> {};

TEST_P(ClientScalars, FramesDoNotWait) {
  const std::string scheme = GetParam();
  ScalarRenderer renderer(listener_uri(scheme));
  Stream stream(renderer.link->uri());
  stream.set_visible("a", true);
  ASSERT_EQ(fire3dv_declare_scalars(stream.get(), "early", &kArm), FIRE3DV_OK) << fire3dv_last_error();
  stream.describe({"a"});
  ASSERT_EQ(fire3dv_declare_scalars(stream.get(), "arm", &kArm), FIRE3DV_OK) << fire3dv_last_error();
  constexpr int kSteps = 300;
  for (int step = 1; step <= kSteps; ++step) {
    const double values[] = {0.5 * step, NAN, -1e300};
    ASSERT_EQ(fire3dv_set_scalars(stream.get(), "arm", step * 1'000'000, values, 3), FIRE3DV_OK)
        << fire3dv_last_error();
    if (step % 50 == 0) renderer.poll();
  }
  ASSERT_TRUE(repeat_until([&] {
    stream.publish(1s, std::vector<Pose>(1));
    renderer.poll();
    return renderer.sequence != 0 && !renderer.received.empty() &&
           renderer.received.back().sim_time_ns == kSteps * 1'000'000;
  }));
  EXPECT_EQ(renderer.scene_version, 1u) << "of set_visible";
  EXPECT_EQ(renderer.declared,
            (wire::Scalars{{"shoulder", "elbow", "K\u00f6rper"}, {"rad", "", "N\u00b7m"}}));
  if (scheme == "shm") {
    EXPECT_EQ(renderer.received.size(), size_t{kSteps});
  }
  int64_t last_ns = 0;
  for (const wire::ScalarValues& values : renderer.received) {
    EXPECT_EQ(values.declaration, renderer.declaration);
    ASSERT_EQ(values.values.size(), 3u);
    EXPECT_EQ(values.values[0], 0.5 * static_cast<double>(values.sim_time_ns / 1'000'000));
    EXPECT_TRUE(std::isnan(values.values[1]));
    EXPECT_EQ(values.values[2], -1e300);
    EXPECT_GT(values.sim_time_ns, std::exchange(last_ns, values.sim_time_ns));
  }

  // Kept like edits: a new epoch has them again, and its numbers still agree.
  renderer.declaration = 0;
  renderer.received.clear();
  stream.describe({"a", "b"});
  ASSERT_TRUE(repeat_until([&] {
    renderer.poll();
    return renderer.declaration != 0 && !renderer.received.empty();
  }));
  EXPECT_EQ(renderer.received.back().declaration, renderer.declaration);
  ASSERT_EQ(fire3dv_clear_scalars(stream.get(), "arm"), FIRE3DV_OK) << fire3dv_last_error();
  ASSERT_TRUE(repeat_until([&] {
    renderer.poll();
    return renderer.cleared == 2;
  }));
}

INSTANTIATE_TEST_SUITE_P(Links, ClientScalars, testing::Values("shm", "tcp", "udp"),
                         [](const auto& test) { return std::string(test.param); });

TEST(ClientScalarErrors, ErrorsNameTheArgument) {
  Stream stream(unique_shm_uri());
  const auto expect = [](int code, int expected, const std::string& text) {
    EXPECT_EQ(code, expected) << text;
    EXPECT_NE(std::string(fire3dv_last_error()).find(text), std::string::npos) << fire3dv_last_error();
  };
  const auto declare = [&](const char* group, const fire3dv_scalars& scalars) {
    return fire3dv_declare_scalars(stream.get(), group, &scalars);
  };
  const double values[] = {1, 2, 3};
  expect(fire3dv_set_scalars(stream.get(), "arm", 0, values, 3), FIRE3DV_ERROR_STATE,
         "declare_scalars first");
  constexpr int kArgument = FIRE3DV_ERROR_ARGUMENT;
  expect(fire3dv_declare_scalars(nullptr, "arm", &kArm), kArgument, "stream is NULL");
  expect(declare(nullptr, kArm), kArgument, "group is NULL");
  expect(fire3dv_declare_scalars(stream.get(), "arm", nullptr), kArgument, "scalars is NULL");
  expect(declare("arm", {}), kArgument, "struct_size");
  expect(declare("arm", {sizeof kArm, nullptr, nullptr, 3}), kArgument, "names is NULL");
  expect(declare("arm", {sizeof kArm, kUnits, nullptr, 3}), kArgument, "names[1] is NULL");
  expect(declare("", kArm), kArgument, "name of the group");
  const char* const twice[] = {"a", "b", "a"};
  expect(declare("arm", {sizeof kArm, twice, nullptr, 3}), kArgument, "names[2] repeats");
  expect(fire3dv_set_scalars(stream.get(), "arm", 0, values, 3), FIRE3DV_ERROR_STATE, "not declared");

  ASSERT_EQ(declare("arm", kArm), FIRE3DV_OK) << fire3dv_last_error();
  expect(fire3dv_set_scalars(stream.get(), "arm", 0, values, 2), kArgument, "count is 2");
  expect(fire3dv_set_scalars(stream.get(), "arm", 0, nullptr, 3), kArgument, "values is NULL");
  expect(declare("arm", {sizeof kArm, twice, nullptr, 3}), kArgument, "repeats");
  EXPECT_EQ(fire3dv_set_scalars(stream.get(), "arm", 0, values, 3), FIRE3DV_OK) << "the old declaration";

  std::vector<std::string> texts;
  for (int i = 0; i < FIRE3DV_MAX_SCALARS; ++i) texts.push_back("scalar " + std::to_string(i));
  std::vector<const char*> names;
  for (const std::string& text : texts) names.push_back(text.c_str());
  fire3dv_scalars many{sizeof many, names.data(), nullptr, names.size()};
  expect(declare("many", many), FIRE3DV_ERROR_BUDGET, "at most 4096 scalars");
  many.count -= 3;
  EXPECT_EQ(declare("many", many), FIRE3DV_OK) << fire3dv_last_error();
  EXPECT_EQ(fire3dv_clear_scalars(stream.get(), "arm"), FIRE3DV_OK);
  EXPECT_EQ(fire3dv_clear_scalars(stream.get(), "never"), FIRE3DV_OK);
  many.count += 3;
  EXPECT_EQ(declare("many", many), FIRE3DV_OK) << fire3dv_last_error();
}

}  // namespace
}  // namespace fire3dv::test
