// Test of the joints of SDF files. Expected values are computed by hand.
#include <numbers>

#include "tests/unit/convert/sdf/sdf_fixture.h"

namespace fire3dv::convert {
namespace {

std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& inside = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent>" + parent + "</parent><child>" + child +
         "</child>" + inside + "</joint>\n";
}
constexpr const char* kZ = "<axis><xyz>0 0 1</xyz></axis>";

class SdfJoints : public Sdf {
 protected:
  static const Joint& joint_named(const Model& model, const std::string& name) {
    static const Joint none;
    const auto found = std::ranges::find(model.kinematics.joints, name, &Joint::name);
    EXPECT_NE(found, model.kinematics.joints.end()) << name;
    return found == model.kinematics.joints.end() ? none : *found;
  }
  static const Body& body_of(const Model& model, const std::string& node_name) {
    static const Body none;
    for (const Body& body : model.kinematics.bodies)
      if (model.nodes[body.node].name == node_name) return body;
    ADD_FAILURE() << node_name;
    return none;
  }
};

TEST_F(SdfJoints, AxesAreInChildFrame) {
  // The child is turned by 90 degrees about Z: X of the model is -Y of the child. The joint is turned
  // further.
  const Model model = read(model_of(
      "m",
      link("base", "<pose>0 0 1 0 0 0</pose>") + link("tip", "<pose>0 0 3 0 0 1.5707963267948966</pose>") +
          joint("hinge", "revolute", "base", "tip",
                "<pose>0 0 -0.5 0 0 1.5707963267948966</pose><axis><xyz expressed_in='__model__'>2 0 0</xyz>"
                "<limit><lower>-1</lower><upper>2</upper></limit></axis>")));
  EXPECT_EQ(warnings(model),
            std::string(folder_.path() / "world.sdf") + ": nothing to draw: no <visual> can be drawn\n");
  const Joint& hinge = joint_named(model, "hinge");
  EXPECT_EQ(hinge.type, Joint::Type::revolute);
  expect_near(hinge.axis, {0, -1, 0});
  expect_near(hinge.anchor, {0, 0, -0.5});
  EXPECT_EQ(hinge.limits, std::pair(-1.0, 2.0));
  EXPECT_EQ(hinge.initial, std::vector<double>{0});
  const Body& tip = body_of(model, "m/tip");
  expect_near(tip.translation, {0, 0, 2});
  ASSERT_TRUE(tip.parent);
  EXPECT_EQ(model.nodes[model.kinematics.bodies[*tip.parent].node].name, "m/base");
}

TEST_F(SdfJoints, OfAllTypes) {
  std::string inside = link("a");
  for (const std::string name : {"b", "c", "d", "e", "f", "g"}) inside += link(name);
  const std::string second = "<axis2><xyz>1 0 0</xyz></axis2>";
  const Model model = read(model_of(
      "m", inside + joint("slide", "prismatic", "a", "b", kZ) + joint("turn", "continuous", "a", "c", kZ) +
               joint("weld", "fixed", "a", "d") + joint("socket", "ball", "a", "e") +
               joint("cross", "universal", "a", "f", kZ + second) + joint("thread", "screw", "a", "g", kZ)));
  EXPECT_EQ(joint_named(model, "slide").type, Joint::Type::prismatic);
  EXPECT_EQ(joint_named(model, "turn").type, Joint::Type::revolute);
  EXPECT_FALSE(joint_named(model, "turn").limits);
  EXPECT_EQ(joint_named(model, "weld").type, Joint::Type::fixed);
  EXPECT_EQ(joint_named(model, "socket").type, Joint::Type::ball);
  EXPECT_EQ(joint_named(model, "socket").initial.size(), 4u);
  expect_near(joint_named(model, "cross").axis, {0, 0, 1});
  expect_near(joint_named(model, "cross#2").axis, {1, 0, 0});
  EXPECT_EQ(joint_named(model, "cross#2").body, joint_named(model, "cross").body);
  EXPECT_TRUE(warns(model, "joint \"thread\": a screw turns without moving along its axis"))
      << warnings(model);
}

TEST_F(SdfJoints, OfNestedModelsAndWorld) {
  const Model model = read(
      model_of("m", link("a") + model_of("n", link("b") + link("c") + joint("j", "revolute", "b", "c", kZ)) +
                        joint("j", "prismatic", "a", "n::b", kZ) + joint("root", "fixed", "world", "a")));
  EXPECT_EQ(joint_named(model, "m/j").type, Joint::Type::prismatic);
  EXPECT_EQ(joint_named(model, "m/n/j").type, Joint::Type::revolute);
  EXPECT_FALSE(body_of(model, "m/a").parent);
  EXPECT_TRUE(body_of(model, "m/n/b").parent);
}

TEST_F(SdfJoints, LoopsAreSkipped) {
  const Model model =
      read(model_of("m", link("a") + link("b") + link("c") + joint("ab", "revolute", "a", "b", kZ) +
                             joint("bc", "revolute", "b", "c", kZ) + joint("ca", "revolute", "c", "a", kZ) +
                             joint("ac", "revolute", "a", "c", kZ)));
  EXPECT_EQ(model.kinematics.joints.size(), 2u);
  EXPECT_TRUE(warns(model, "joint \"ca\" closes a loop")) << warnings(model);
  EXPECT_TRUE(warns(model, "joint \"ac\" closes a loop")) << warnings(model);
}

// SDF 1.11: position = multiplier * (leader - reference) + offset.
TEST_F(SdfJoints, MimicOthers) {
  const auto model = try_read(
      world(model_of("m", link("a") + link("b") + link("c") + joint("lead", "revolute", "a", "b", kZ) +
                              joint("follow", "revolute", "a", "c",
                                    "<axis><xyz>0 0 1</xyz><mimic joint='lead'><multiplier>2</multiplier>"
                                    "<offset>0.5</offset><reference>0.1</reference></mimic></axis>")),
            "1.11"));
  ASSERT_TRUE(model.ok()) << model.error().message;
  EXPECT_TRUE(warns(*model, "SDF 1.11 is read as SDF 1.9")) << warnings(*model);
  const Joint& follow = joint_named(*model, "follow");
  ASSERT_TRUE(follow.mimic) << warnings(*model);
  EXPECT_EQ(model->kinematics.joints[follow.mimic->joint].name, "lead");
  EXPECT_DOUBLE_EQ(follow.mimic->multiplier, 2);
  EXPECT_NEAR(follow.mimic->offset, 0.3, 1e-12);
}

}  // namespace
}  // namespace fire3dv::convert
