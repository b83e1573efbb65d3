// Test of description file detection by content, and of refusals that protect the XML readers.
#include "convert/description_files.h"

#include <gtest/gtest.h>

#include <vector>

namespace fire3dv::convert {
namespace {

std::string refused(const std::string& text) {
  const auto kind = kind_of("some.file", text);
  EXPECT_FALSE(kind.ok()) << text;
  return kind ? "" : kind.error().message;
}

TEST(DescriptionKind, ContentDecidesKind) {
  const auto kind = [](const std::string& text) {
    const auto found = kind_of("some.file", text);
    EXPECT_TRUE(found.ok()) << found.error().message;
    return found ? *found : DescriptionKind::adf;
  };
  EXPECT_EQ(kind("<?xml version=\"1.0\"?>\n<!-- <mujoco> -->\n<robot name='r'/>"), DescriptionKind::urdf);
  EXPECT_EQ(kind("<robot xmlns:xacro=\"http://ros.org/wiki/xacro\" name=\"made by xacro\"></robot>"),
            DescriptionKind::urdf);
  EXPECT_EQ(kind("<robot name='r'><xacro:include filename='x'/></robot>"), DescriptionKind::urdf);
  EXPECT_EQ(kind("  \n<mujoco model=\"a > b\">\n</mujoco>"), DescriptionKind::mjcf);
  EXPECT_EQ(kind("<sdf version='1.6'/>"), DescriptionKind::sdf);
  EXPECT_EQ(kind("# AMBF Version: (0.1)\nbodies: [BODY base]\n"), DescriptionKind::adf);
  EXPECT_EQ(kind("world config: world.yaml\nmultibody configs:\n  - \"a.yaml\"\n"), DescriptionKind::adf);
  EXPECT_EQ(kind("---\nlights   : [light1]\n"), DescriptionKind::adf);
}

TEST(DescriptionKind, RefusalsNameFormatAndRemedy) {
  EXPECT_NE(refused("glTF\2\0\0\0").find("glTF already"), std::string::npos);
  EXPECT_NE(refused("<svg/>").find("\"svg\""), std::string::npos);
  EXPECT_NE(refused("<gazebo version='1.2'/>").find("before version 1.3"), std::string::npos);
  EXPECT_NE(refused("nobodies: 3\nx: y\n").find("not a supported description"), std::string::npos);
  EXPECT_NE(refused("").find("\"some.file\""), std::string::npos);
  EXPECT_NE(refused(std::string("bodies: [a]\0", 12)).find("not text"), std::string::npos);
}

TEST(DescriptionKind, HarmfulXmlIsRefusedByLine) {
  EXPECT_NE(refused("<!DOCTYPE r [\n<!ENTITY a \"aaaa\">\n<!ENTITY b \"&a;&a;\">\n]>\n<robot>&b;</robot>")
                .find("entities"),
            std::string::npos);
  std::string deep = "<robot>\n";
  for (int i = 0; i < 100'000; ++i) deep += "<a>";
  EXPECT_NE(refused(deep).find("line 2: more than 100 elements inside each other"), std::string::npos);
  // Parsers compare each attribute with all others.
  std::string wide = "<robot>\n<a";
  for (int i = 0; i < 1001; ++i) wide += " b" + std::to_string(i) + "='\"=\"'";
  EXPECT_NE(refused(wide + "/></robot>").find("line 2: an element with more than 1000 attributes"),
            std::string::npos);
  EXPECT_NE(refused("<robot>\n\n<link name=\"a>").find("line 3"), std::string::npos);
  EXPECT_NE(refused("<robot>\n<!-- never closed").find("line 2"), std::string::npos);
  std::string many = "<robot>";
  for (int i = 0; i < 1000; ++i) many += "<a><b/></a>";
  EXPECT_TRUE(xml_root(many + "</robot>").ok());
}

// XML that readers parse differently: for one of them it ends earlier, and hidden elements appear.
TEST(DescriptionKind, AmbiguousXmlIsRefused) {
  const std::string robot = "<robot name='q'><link name='l'/></robot>";
  std::string deep;
  for (int i = 0; i < 200; ++i) deep += "<a>";
  EXPECT_NE(refused("<!x \"><robot name='r'>" + deep + "</robot><!y \">" + robot).find("'<!'"),
            std::string::npos);
  EXPECT_NE(refused("<?x >" + deep + "<!-- ?>" + robot + "<!-- -->").find("'<?'"), std::string::npos);
  EXPECT_NE(refused("<?x ><mujoco/><!-- ?><mujoco><asset><mesh name=\"m\" file=\"/a/fifo.stl\"/></asset>"
                    "</mujoco><!-- -->")
                .find("'<?'"),
            std::string::npos);
  for (const std::string& text : std::vector<std::string>{
           "<?xml version=\"1.0?>" + robot, "<?xml ' version=\"1.0' ?>" + robot,
           robot + "<?xml version='1.0'?>", "<?xml version='1.0'><a>?>" + robot,
           "<!DOCTYPE r \"><a>\">" + robot, "<1 \"><a>\">" + robot, "</x \"><a>\">" + robot,
           robot + "</a></a>", "< a>" + robot, "<?xml version='1.0'?><robot name=\"\xf0\"><a>\"></robot>",
           robot + "<!ELEMENT a>"})
    EXPECT_FALSE(xml_root(text).ok()) << text;
  for (const std::string before :
       {"<?xml version=\"1.0\" ?>", "\n<?xml version='1.0' encoding='utf-8' standalone=\"yes\"?>\n",
        "<?xml?><!DOCTYPE robot>", "<!-- > \" --><!DOCTYPE robot>",
        "<?xml version='1.0' encoding='latin1'?>"}) {
    const auto root = xml_root(before + "<robot name=\"r\xc3\xa4\"><![CDATA[<a \"]]></robot >\n");
    ASSERT_TRUE(root.ok()) << before << root.error().message;
    EXPECT_EQ(*root, "robot");
  }
}

}  // namespace
}  // namespace fire3dv::convert
