// Test of MJCF composites that no linked libmujoco knows (cables), with computed values, and of limits and
// malformed data of all of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "convert/mjcf/mjcf_reader.h"
#include "tests/unit/convert/mjcf/mjcf_fixture.h"

namespace fire3dv::convert {
namespace {

class MjcfComposite : public Mjcf {
 protected:
  MjcfScene cable(const std::string& attributes, const std::string& inside, const std::string& after = "") {
    return scene("<worldbody><body name='p' pos='0 0 1'><composite type='cable' " + attributes + ">" +
                 inside + "</composite></body></worldbody>" + after);
  }
  static void expect_near(const glm::dvec3& a, const glm::dvec3& b) {
    EXPECT_LT(glm::distance(a, b), 1e-9) << a.x << " " << a.y << " " << a.z;
  }
};

TEST_F(MjcfComposite, CablesFollowTheirCurve) {
  const MjcfScene made =
      cable("prefix='c' curve='cos(s) sin(s) s' count='9 1 1' size='2 1 2' offset='0 0 1' initial='none'",
            "<geom type='capsule' size='.05' rgba='1 0 0 1'/>");
  EXPECT_TRUE(warnings_.empty()) << warnings_.front();
  ASSERT_EQ(made.bodies.size(), 10u);
  EXPECT_EQ(made.bodies[2].name, "cB_first");
  EXPECT_EQ(made.bodies[3].name, "cB_1");
  EXPECT_EQ(made.bodies[9].name, "cB_last");
  const auto vertex = [](int i) {
    const double angle = 3.141592653589793 * i / 4;
    return glm::dvec3(std::cos(angle), std::sin(angle), 2 + 0.25 * i);
  };
  for (int i = 0; i < 8; ++i) {
    const MjcfPose& pose = made.bodies[static_cast<size_t>(i) + 2].world_pose;
    expect_near(pose.position, vertex(i));
    expect_near(pose.rotation * glm::dvec3(1, 0, 0), glm::normalize(vertex(i + 1) - vertex(i)));
    const MjcfGeom& geom = made.geoms[static_cast<size_t>(i)];
    EXPECT_EQ(geom.name, "cG" + std::to_string(i));
    EXPECT_NEAR(geom.size.y, glm::distance(vertex(i), vertex(i + 1)) / 2, 1e-12);
    expect_near(pose * geom.pose.position, 0.5 * (vertex(i) + vertex(i + 1)));
  }
}

TEST_F(MjcfComposite, CablesHaveBallJoints) {
  // The second body turns about Y by 90 degrees.
  const MjcfScene made = cable("vertex='0 0 0 1 0 0 2 0 0 3 0 0'", "<geom type='box' size='.5 .1 .05'/>",
                               "<keyframe><key qpos='1 0 0 0  1 0 1 0  1 0 0 0'/></keyframe>");
  EXPECT_TRUE(warnings_.empty()) << warnings_.front();
  ASSERT_EQ(made.bodies.size(), 5u);
  expect_near(made.bodies[4].world_pose.position, {1, 0, 0});
  ASSERT_EQ(made.skins.size(), 1u);
  EXPECT_EQ(made.skins[0].name, "Skin");
  // Four columns of two vertices, in front and behind, inflated by the height of the box.
  ASSERT_EQ(made.skins[0].surface.positions.size(), 16u);
  glm::vec3 low(10), high(-10);
  for (const glm::vec3& position : made.skins[0].surface.positions) {
    low = glm::min(low, position);
    high = glm::max(high, position);
  }
  EXPECT_NEAR(high.y, 0.1f, 1e-6);
  EXPECT_NEAR(high.z, 1.1f, 1e-6) << "inflated";
  EXPECT_NEAR(low.z, -1, 1e-6) << "the bodies hang down";
}

TEST_F(MjcfComposite, FreeCablesAndFrames) {
  const MjcfScene made = scene(
      "<worldbody><frame pos='0 0 5'><composite type='cable' prefix='k' curve='0 s' count='3 1 1' size='2' "
      "initial='free'>"
      "<geom type='cylinder' size='.1'/></composite></frame></worldbody>");
  EXPECT_TRUE(warnings_.empty()) << warnings_.front();
  ASSERT_EQ(made.bodies.size(), 3u);
  expect_near(made.bodies[1].world_pose.position, {0, 0, 5});
  expect_near(made.bodies[2].world_pose.position, {0, 1, 5});
}

TEST_F(MjcfComposite, LongChainsAreAccepted) {
  EXPECT_EQ(cable("curve='s' count='1001 1 1' size='1'", "<geom type='capsule' size='.01'/>").bodies.size(),
            1002u);
  cable("curve='s' count='1002 1 1' size='1'", "<geom type='capsule' size='.01'/>");
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].find("more than 1001 vertices"), std::string::npos) << warnings_[0];
}

TEST_F(MjcfComposite, MalformedAreSkippedWithReason) {
  const std::string sphere = "<geom size='.1'/>", capsule = "<geom type='capsule' size='.1'/>";
  const struct {
    std::string attributes, inside;
    const char* part;
  } faults[] = {{"type='cable' count='5 1 1' curve='s'", sphere, "capsule, cylinder or box"},
                {"type='cable' count='5 1 1' curve='tan(s)'", capsule, "none of s"},
                {"type='cable' count='5 1 1' curve='s s s s'", capsule, "more than three components"},
                {"type='cable' count='5 1 1'", capsule, "two of its vertices are equal"},
                {"type='cable' count='1 1 1' curve='s'", capsule, "count is less than 2"},
                {"type='cable' vertex='0 0 0 1'", capsule, "three numbers for each"},
                {"type='cable' vertex='0 0 0 nan 0 0'", capsule, "vert"},
                {"type='grid' count='0 1 1' spacing='1'", sphere, "count is not positive"},
                {"type='grid' count='1 2 1' spacing='1'", sphere, "a count of 1 is before"},
                {"type='grid' count='2 2 2' spacing='1'", sphere, "one or two dimensions"},
                {"type='particle' count='1e9 1e9 1e9' spacing='1'", sphere, "more than 100000 bodies"},
                {"type='particle' count='2 2 2'", sphere, "spacing is not positive"},
                {"type='rope' count='5 1 1' spacing='1'", sphere, "the name of its body"},
                {"type='rope' count='5000 1 1' spacing='1'", sphere, "more than 1000 bodies in a chain"},
                {"type='cloth' count='5 5 1' spacing='1'", sphere, "the name of its body"},
                {"type='box' count='5 5 1' spacing='1'", sphere, "three dimensions"},
                {"type='star' count='5 5 1'", sphere, "type=\"star\" is unknown"}};
  for (const auto& fault : faults) {
    scene("<worldbody><body name='p'><geom size='1'/><composite " + fault.attributes + ">" + fault.inside +
          "</composite></body></worldbody>");
    const std::string said = warnings_.empty() ? "none" : warnings_[0];
    EXPECT_NE(said.find(fault.part), std::string::npos) << fault.attributes << ": " << said;
  }
}

}  // namespace
}  // namespace fire3dv::convert
