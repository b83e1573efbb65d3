// Test of MJCF skins: both formats, malformed data, attached models, and the joints in the written model.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "convert/glb/write_glb.h"
#include "convert/mjcf/deformable/skin_data.h"
#include "convert/mjcf/mjcf_reader.h"
#include "tests/unit/convert/mesh/mesh_file_bytes.h"
#include "tests/unit/convert/mjcf/mjcf_fixture.h"

namespace fire3dv::convert {
namespace {

std::string floats(std::initializer_list<float> values) {
  std::string text;
  for (const float value : values) text += test::raw(value);
  return text;
}

std::string bone(const std::string& body, uint32_t count, uint32_t first_vertex) {
  std::string text = body;
  text.resize(40, '\0');
  text += floats({0, 0, 1, 2, 0, 0, 0}) + test::raw(count);
  for (uint32_t i = 0; i < count; ++i) text += test::raw(first_vertex + i);
  for (uint32_t i = 0; i < count; ++i) text += test::raw(0.5f);
  return text;
}

// A triangle; vertex 2 follows both bones.
std::string skn() {
  std::string text;
  for (const uint32_t count : {3u, 3u, 1u, 2u}) text += test::raw(count);
  text += floats({0, 0, 0, 1, 0, 0, 0, 1, 0}) + floats({0, 0, 1, 0, 0, 1});
  for (const uint32_t corner : {0u, 1u, 2u}) text += test::raw(corner);
  return text + bone("a", 3, 0) + bone("b", 1, 2);
}

template <typename Parsed>
std::string skin_refusal(const Result<Parsed>& result) {
  return result.ok() ? "none" : result.error().message;
}

TEST(MjcfSkinFormat, BonesHaveWeights) {
  const Result<SkinData> data = parse_skn(skn());
  ASSERT_TRUE(data.ok()) << data.error().message;
  EXPECT_EQ(data->vertices[1], glm::vec3(1, 0, 0));
  EXPECT_EQ(data->uvs[2], glm::vec2(0, 1));
  ASSERT_EQ(data->bones.size(), 2u);
  EXPECT_EQ(data->bones[1].body, "b");
  EXPECT_EQ(data->bones[1].position, glm::dvec3(0, 0, 1));
  EXPECT_EQ(data->bones[1].rotation, glm::dquat(1, 0, 0, 0)) << "of unit length";
  const Result<BoundSkin> bound = bind_skin(*data, 0.25);
  ASSERT_TRUE(bound.ok()) << bound.error().message;
  EXPECT_FALSE(bound->is_rigid);
  EXPECT_TRUE(bound->has_all_bones);
  EXPECT_EQ(bound->surface.influences[0].weights[0], 1.0f) << "the sum of weights is 1";
  EXPECT_EQ(bound->surface.influences[2].weights[1], 0.5f);
  EXPECT_EQ(bound->surface.influences[2].joints[1], 1);
  EXPECT_EQ(bound->surface.positions[1], glm::vec3(1, 0, 0.25)) << "inflated along the normal";
}

TEST(MjcfSkinFormat, EveryTruncationIsError) {
  const std::string whole = skn();
  for (size_t length = 0; length < whole.size(); ++length)
    EXPECT_EQ(skin_refusal(parse_skn(std::string_view(whole).substr(0, length))),
              "the SKN file has counts that differ from its contents; export it again")
        << length;
  EXPECT_NE(skin_refusal(parse_skn(whole + "x")), "none");
}

TEST(MjcfSkinFormat, IndicesAreChecked) {
  for (size_t count = 0; count < 4; ++count) {
    std::string text = skn();
    const uint32_t huge = 0xffffffff;
    std::memcpy(text.data() + 4 * count, &huge, sizeof huge);
    EXPECT_NE(skin_refusal(parse_skn(text)).find("counts that differ"), std::string::npos) << count;
  }
  const struct {
    size_t word;
    uint32_t value;
    const char* part;
  } faults[] = {{4, 0x7fc00000, "a vertex is not finite"},
                {19, 3, "a face names vertex 3 of 3"},
                {32, 0x7f800000, "bind pose that is not finite"},
                {41, 7, "names vertex 7 of 3"},
                {44, 0x7fc00000, "weight that is not finite"}};
  for (const auto& fault : faults) {
    std::string text = skn();
    std::memcpy(text.data() + 4 * fault.word, &fault.value, sizeof fault.value);
    EXPECT_NE(skin_refusal(parse_skn(text)).find(fault.part), std::string::npos)
        << fault.word << ": " << skin_refusal(parse_skn(text));
  }
}

TEST(MjcfSkinFormat, VerticesNeedABone) {
  SkinData data = *parse_skn(skn());
  data.bones[0].weights = {0.5f, 0, 0.5f};
  EXPECT_NE(skin_refusal(bind_skin(data, 0)).find("vertex 1 has no bone"), std::string::npos);
}

TEST(MjcfSkinFormat, GreatestWeightsAreUsed) {
  SkinData data = *parse_skn(skn());
  data.bones.clear();
  for (size_t i = 0; i < 10; ++i)
    data.bones.push_back(
        {"b", {}, {1, 0, 0, 0}, {0, 1, 2}, std::vector<float>(3, static_cast<float>(i + 1))});
  const Result<BoundSkin> bound = bind_skin(data, 0);
  ASSERT_TRUE(bound.ok()) << bound.error().message;
  EXPECT_FALSE(bound->has_all_bones);
  float sum = 0;
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_GE(bound->surface.influences[0].joints[i], 2);
    sum += bound->surface.influences[0].weights[i];
  }
  EXPECT_NEAR(sum, 1, 1e-6);
}

class MjcfSkins : public Mjcf {
 protected:
  static std::string inline_skin(const std::string& name, const std::string& body) {
    return "<skin name='" + name + "' vertex='0 0 0 1 0 0 0 1 0' face='0 1 2' rgba='1 0 0 1'><bone body='" +
           body + "' bindpos='0 0 0' bindquat='1 0 0 0' vertid='0 1 2' vertweight='1 1 1'/></skin>";
  }
  const std::string body_ = "<body name='a' pos='0 0 2'><freejoint/><geom size='.1'/></body>";
};

TEST_F(MjcfSkins, SkinJointsAreBodies) {
  folder_.write("arm.skn", std::string_view(skn()));
  const Result<Model> model = try_read("<mujoco><asset><skin file='arm.skn'/></asset><worldbody>" + body_ +
                                       "<body name='b'><geom size='.1'/></body></worldbody></mujoco>");
  ASSERT_TRUE(model.ok()) << model.error().message;
  EXPECT_TRUE(model->warnings.empty()) << model->warnings.front();
  ASSERT_EQ(model->skins.size(), 1u);
  ASSERT_EQ(model->skins[0].joints.size(), 2u);
  EXPECT_EQ(model->nodes[model->skins[0].joints[1].node].name, "b");
  EXPECT_EQ(model->skins[0].joints[1].from_mesh[3], glm::dvec4(0, 0, -1, 1)) << "inverse of the bind pose";
  const Node& node = model->nodes.back();
  EXPECT_EQ(node.name, "arm");
  EXPECT_TRUE(node.mesh && node.skin && !node.parent);
  std::vector<std::string> warnings;
  const auto bytes = write_glb(*model, &warnings);
  ASSERT_TRUE(bytes.ok()) << bytes.error().message;
  EXPECT_TRUE(warnings.empty());
  const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  EXPECT_NE(text.find("JOINTS_0"), std::string_view::npos);
  EXPECT_EQ(text.find("JOINTS_1"), std::string_view::npos) << "no vertex has more than four bones";
}

TEST_F(MjcfSkins, AttachedSkinsFollowCopies) {
  folder_.write("child.xml", std::string_view("<mujoco model='child'><deformable>" + inline_skin("s", "a") +
                                              "</deformable><worldbody>" + body_ + "</worldbody></mujoco>"));
  const Result<Model> model = try_read(
      "<mujoco><asset><model name='m' file='child.xml'/></asset><worldbody>"
      "<frame pos='1 0 0'><attach model='m' body='a' prefix='l-'/></frame>"
      "<frame pos='3 0 0'><attach model='m' body='a' prefix='r-'/></frame></worldbody></mujoco>");
  ASSERT_TRUE(model.ok()) << model.error().message;
  EXPECT_TRUE(model->warnings.empty()) << model->warnings.front();
  ASSERT_EQ(model->skins.size(), 2u);
  EXPECT_EQ(model->skins[1].name, "r-s");
  EXPECT_EQ(model->nodes[model->skins[1].joints[0].node].name, "r-a");
}

TEST_F(MjcfSkins, UnreadableAreSkipped) {
  folder_.write("broken.skn", std::string_view("broken"));
  const Result<Model> model = try_read(
      "<mujoco><asset><skin file='broken.skn'/><skin name='none' file='none.skn'/><skin file='a.obj'/>"
      "<skin name='empty'/><skin name='text' vertex='a'/>" +
      inline_skin("lost", "nobody") + "<skin name='odd' vertex='0 0 0' face='0 0 0'><bone body='a'/></skin>" +
      "</asset><worldbody>" + body_ + "</worldbody></mujoco>");
  ASSERT_TRUE(model.ok()) << model.error().message;
  EXPECT_TRUE(model->skins.empty());
  ASSERT_EQ(model->warnings.size(), 7u);
  const char* const parts[] = {"counts that differ", "does not exist",     "does not exist", "lacks vertices",
                               "3 numbers",          "no body \"nobody\"", "the bone \"a\""};
  for (size_t i = 0; i < 7; ++i)
    EXPECT_NE(model->warnings[i].find(parts[i]), std::string::npos) << model->warnings[i];
}

}  // namespace
}  // namespace fire3dv::convert
