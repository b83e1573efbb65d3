// Test of the expansion of xacro files: the expected texts are those of the program xacro (1.14), and bounds
// and access rights are those of docs/convert.md.
#include "convert/xacro/xacro.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

#include "convert/readers.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

class Xacro : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) {
    fs::create_directories((folder_.path() / name).parent_path());
    folder_.write(name, std::string_view(text));
  }
  // Expands <robot>INSIDE</robot> in the package "arm".
  Result<std::string> expand(const std::string& inside,
                             const std::map<std::string, std::string>& arguments = {}) {
    write("arm/package.xml", "<package><name>arm</name></package>");
    write("arm/urdf/arm.urdf.xacro",
          "<robot xmlns:xacro=\"http://ros.org/wiki/xacro\">\n" + inside + "</robot>");
    ReadOptions options;
    options.xacro_arguments = arguments;
    options.package_folders = folders_;
    warnings_.clear();
    return read_urdf_text(folder_.path() / "arm/urdf/arm.urdf.xacro", options, warnings_);
  }
  // The elements inside <robot>, without line breaks and indentation.
  std::string inside_of(const std::string& inside, const std::map<std::string, std::string>& arguments = {}) {
    const Result<std::string> text = expand(inside, arguments);
    if (!text) return "error: " + text.error().message;
    std::string flat;
    for (size_t at = 0; at < text->size(); ++at) {
      if ((*text)[at] == '\n')
        while (at + 1 < text->size() && (*text)[at + 1] == ' ') ++at;
      else
        flat += (*text)[at];
    }
    const size_t begin = flat.find('>', flat.find("<robot")) + 1, end = flat.rfind("</robot>");
    return end == std::string::npos ? "" : flat.substr(begin, end - begin);
  }
  void expect_error(const std::string& inside, const std::string& reason) {
    const std::string text = inside_of(inside);
    EXPECT_TRUE(text.starts_with("error: ")) << inside.substr(0, 300);
    EXPECT_NE(text.find(reason), std::string::npos) << text.substr(0, 500);
  }

  test::ScratchFolder folder_;
  std::vector<fs::path> folders_;
  std::vector<std::string> warnings_;
};

TEST_F(Xacro, PropertiesAreTypedLazyAndScoped) {
  EXPECT_EQ(inside_of("<xacro:property name='b' value='${a * 2}'/><xacro:property name='a' value='1.50'/>"
                      "<l b='${b}' text='x${a}y' plain='$5' escaped='$${a}'/>"),
            "<l b=\"3.0\" text=\"x1.5y\" plain=\"$5\" escaped=\"${a}\"/>");
  EXPECT_EQ(
      inside_of(
          "<xacro:property name='a' value='1'/><xacro:property name='b' value='${a}' lazy_eval='false'/>"
          "<xacro:property name='a' value='2'/><xacro:property name='a' default='3'/><l v='${a} ${b}'/>"),
      "<l v=\"2 1\"/>");
  EXPECT_EQ(inside_of("<xacro:property name='n' value='1_0'/><xacro:property name='t' value='true'/>"
                      "<l v=\"${n + 'a'} ${t and 7}\"/>"),
            "<l v=\"1_0a 7\"/>");
  EXPECT_EQ(inside_of("<xacro:macro name='m'><xacro:property name='x' value='1' scope='parent'/>"
                      "<xacro:property name='y' value='2' scope='global'/><xacro:property name='z' "
                      "value='3'/></xacro:macro>"
                      "<xacro:property name='z' value='0'/><xacro:m/><l v='${x}${y}${z}'/>"),
            "<l v=\"120\"/>");
  EXPECT_EQ(inside_of("<xacro:property name='a' value='1'/><xacro:property name='a' remove='true'/>"
                      "<xacro:property name='a' default='2'/><l v='${a}'/>"),
            "<l v=\"2\"/>");
  EXPECT_EQ(inside_of("<xacro:property name='pi' value='3'/><l v='${pi}'/>"), "<l v=\"3\"/>");
  expect_error("<xacro:property name='a' value='${b}'/><xacro:property name='b' value='${a}'/><l v='${a}'/>",
               "depends on itself");
  expect_error("<xacro:property name='2a' value='1'/>", "\"2a\" is not a name of a property");
}

TEST_F(Xacro, MacrosTakeParametersDefaultsAndBlocks) {
  const std::string macro =
      "<xacro:macro name='m' params=\"name size:=2 prefix:='' parent:=^ side:=^|left wide:=${size * 2} "
      "*origin **more\">"
      "<l n='${prefix}${name}' s='${size}' p='${parent}' d='${side}' w='${wide}'><xacro:insert_block "
      "name='origin'/>"
      "</l><xacro:insert_block name='more'/></xacro:macro>";
  EXPECT_EQ(
      inside_of(macro + "<xacro:property name='size' value='7'/><xacro:property name='parent' value='base'/>"
                        "<xacro:m name='a' prefix='b_'><o x='${1+1}'/><any><c/><d/></any></xacro:m>"),
      "<l n=\"b_a\" s=\"2\" p=\"base\" d=\"left\" w=\"14\"><o x=\"2\"/></l><c/><d/>");
  expect_error(macro + "<xacro:m name='a'><o/><any/></xacro:m>", "the caller has no property parent");
  expect_error(macro +
                   "<xacro:property name='parent' value='b'/><xacro:property name='size' value='1'/><xacro:m "
                   "name='a'><o/></xacro:m>",
               "the block **more is missing");
  expect_error(macro + "<xacro:m nam='a'/>", "the macro has no parameter \"nam\"");
  expect_error("<xacro:macro name='m' params='a'/><xacro:m/>", "the parameter a has no value");
  expect_error("<xacro:macro name='m'/><xacro:m><o/></xacro:m>", "the macro takes no block <o>");
  expect_error("<xacro:n/>", "line 2, <xacro:n>: there is no macro \"n\"");
  EXPECT_EQ(inside_of("<xacro:macro name='count' params='n'><xacro:if value='${n > 0}'><i n='${n}'/>"
                      "<xacro:count n='${n - 1}'/></xacro:if></xacro:macro><xacro:count n='3'/>"
                      "<xacro:property name='which' value='count'/><xacro:call macro='${which}' n='1'/>"),
            "<i n=\"3\"/><i n=\"2\"/><i n=\"1\"/><i n=\"1\"/>");
  EXPECT_EQ(
      inside_of(
          "<xacro:property name='b'><c v='${v}'/><d/></xacro:property><xacro:property name='v' value='1'/>"
          "<xacro:insert_block name='b'/>"),
      "<c v=\"1\"/><d/>");
}

TEST_F(Xacro, ConditionsElementsAndAttributes) {
  EXPECT_EQ(inside_of("<xacro:property name='a' value='4'/><xacro:if value='${a == 4}'><y/></xacro:if>"
                      "<xacro:unless value='${a == 4}'><n/></xacro:unless><xacro:if value='0'><n/></xacro:if>"
                      "<xacro:if value='True'><z/></xacro:if>"),
            "<y/><z/>");
  expect_error("<xacro:if value='maybe'/>",
               "the condition \"maybe\" is \"maybe\", which is neither true nor false");
  EXPECT_EQ(
      inside_of(
          "<xacro:element xacro:name='${\"l\" + \"ink\"}' name='x'><xacro:attribute name='k' value='${2}'/>"
          "</xacro:element>"),
      "<link name=\"x\" k=\"2\"/>");
  EXPECT_EQ(inside_of("<t>a ${1 + 1} &lt; &amp;</t><![CDATA[${1}]]><!-- ${nothing} -->"),
            "<t>a 2 &lt; &amp;</t><![CDATA[${1}]]>");
}

TEST_F(Xacro, ArgumentsAndEnvironment) {
  const std::string text =
      "<xacro:arg name='a' default='${1 + 1}'/><l a='$(arg a)' e='$(optenv HOME none at all)'/>";
  EXPECT_EQ(inside_of(text), "<l a=\"2\" e=\"none at all\"/>");
  EXPECT_EQ(inside_of(text, {{"a", "x"}, {"HOME", "y"}}), "<l a=\"x\" e=\"y\"/>");
  EXPECT_TRUE(warnings_.empty());
  inside_of(text, {{"b", "x"}});
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].find("--xacro-arg b: the file has no such argument"), std::string::npos)
      << warnings_[0];
  expect_error("<l a='$(arg b)'/>",
               "line 2, <l>, attribute a: the argument b has no value: give one with --xacro-arg b=");
  expect_error("<l a='$(env HOME)'/>",
               "environment variables are not read; give its value with --xacro-arg HOME=");
  EXPECT_EQ(inside_of("<xacro:arg name='n' default='2'/><l a='$(eval n * 3 + 1)' b='$(eval n == 2)'/>"),
            "<l a=\"7\" b=\"True\"/>");
  expect_error("<l a='$(eval x)'/>", "$(eval x): the name x is not defined");
  expect_error("<l a='$(anon 1)'/>",
               "does not evaluate; expand the file with the program xacro: xacro arm.urdf.xacro > "
               "arm.expanded.urdf, or name the program with --xacro PROGRAM");
  expect_error("<l a='${1'/>", "'${1' has no closing }");
}

TEST_F(Xacro, IncludesAndYamlAreRead) {
  write("arm/urdf/part.xacro",
        "<x xmlns:k='k'><xacro:macro name='p' params='v'><p v='${v}'/></xacro:macro><q f='${f}'/></x>");
  write("arm/config/a.yaml",
        "joint: {limits: [1, 2.5, !degrees 180], name: 'on', flag: on, e: 1e3, o: 010, u: ~}\nlist: [{a: 1}, "
        "{a: 2}]\n");
  EXPECT_EQ(
      inside_of("<xacro:property name='f' value='1'/><xacro:include filename='part.xacro'/><xacro:p v='2'/>"),
      "<q f=\"1\"/><p v=\"2\"/>");
  EXPECT_EQ(
      inside_of(
          "<xacro:property name='f' value='1'/><xacro:include filename='$(find arm)/urdf/pa*.xacro' ns='n'/>"
          "<xacro:n.p v='3'/>"),
      "<q f=\"1\"/><p v=\"3\"/>");
  EXPECT_EQ(inside_of("<xacro:property name='f' value='1'/><xacro:include filename='pa*.xacro' "
                      "ns='n'/><xacro:n.p v='3'/>"),
            "<q f=\"1\"/><p v=\"3\"/>");
  EXPECT_EQ(
      inside_of(
          "<xacro:property name='y' value=\"${xacro.load_yaml('../config/a.yaml')}\"/>"
          "<l v=\"${y['joint']['limits']} ${y.joint.name} ${y.joint.flag} ${y.joint.e + 'x'} ${y.joint.o} "
          "${y.joint.u} ${y['list'][1].a}\"/>"),
      "<l v=\"[1, 2.5, 3.141592653589793] on True 1e3x 8 None 2\"/>");
  EXPECT_EQ(inside_of("<xacro:include filename='gone.xacro' optional='true'/><l/>"), "<l/>");
  expect_error("<xacro:include filename='gone.xacro'/>", "line 2, <xacro:include>: there is no file");
  expect_error("<xacro:include filename='$(find gone)/a.xacro'/>", "the package \"gone\" is not found");
  EXPECT_EQ(inside_of("<l v='$(find gone)/a.stl'/>"), "<l v=\"$(find gone)/a.stl\"/>")
      << "it may not be drawn";
  EXPECT_EQ(warnings_.size(), 1u);
  write("arm/urdf/part.xacro", "<x>\n\n<l v='${nothing}'/></x>");
  expect_error("<xacro:include filename='part.xacro'/>",
               "part.xacro\", line 3, <l>, attribute v: ${nothing}: the name nothing");
}

// Security: a file from the network may name any file.
TEST_F(Xacro, FilesOfOthersAreNotRead) {
  write("private/a.yaml", "key: secret");
  write("private/a.xacro", "<x><secret/></x>");
  const std::string path = folder_.path().string();
  fs::create_directories(folder_.path() / "arm/urdf");
  fs::create_symlink(folder_.path() / "private/a.xacro", folder_.path() / "arm/urdf/link.xacro");
  const auto include = [](const std::string& name) { return "<xacro:include filename='" + name + "'/>"; };
  for (const std::string& name :
       {path + "/private/a.xacro", std::string("../../private/a.xacro"), std::string("link.xacro"),
        std::string("$(find private)/a.xacro"), std::string("/proc/self/status")})
    EXPECT_TRUE(inside_of(include(name)).starts_with("error: ")) << name;
  expect_error("<l v=\"${xacro.load_yaml('../../private/a.yaml').key}\"/>", "lies outside the folders");
  folders_ = {folder_.path() / "private"};
  EXPECT_EQ(inside_of(include("../../private/a.xacro")), "<secret/>");
  EXPECT_EQ(inside_of("<l v=\"${xacro.load_yaml('../../private/a.yaml').key}\"/>"), "<l v=\"secret\"/>");
}

TEST_F(Xacro, WorkIsBounded) {
  expect_error("<xacro:macro name='m'><xacro:m/></xacro:macro><xacro:m/>",
               "does a macro call itself without end?");
  expect_error("<xacro:macro name='m'><a><xacro:m/></a><xacro:m/></xacro:macro><xacro:m/>", "without end?");
  expect_error("<xacro:include filename='arm.urdf.xacro'/>", "files include each other more than 50 deep");
  std::string doubling = "<xacro:property name='a0' value='xxxxxxxxxxxxxxxx'/>";
  for (int i = 1; i < 60; ++i)
    doubling +=
        "<xacro:property name='a" + std::to_string(i) + "' value='${a" + std::to_string(i - 1) + " * 2}'/>";
  expect_error(doubling + "<l v='${a59}'/>", "MiB of text");
  std::string tree = "<xacro:macro name='m0'><l/></xacro:macro>";
  for (int i = 1; i < 60; ++i) {
    const std::string call = "<xacro:m" + std::to_string(i - 1) + "/>";
    tree += "<xacro:macro name='m" + std::to_string(i) + "'>" + call + call + "</xacro:macro>";
  }
  expect_error(tree + "<xacro:m59/>", "the expansion ");
  std::string nested =
      "<xacro:macro name='m' params='n'><xacro:if value='${n}'><a><xacro:m "
      "n='${n-1}'/></a></xacro:if></xacro:macro>";
  expect_error(nested + "<xacro:m n='150'/>", "nested more than 300 deep");
  write("arm/urdf/bomb.yaml",
        "a: &a [x, x, x, x, x, x, x, x, x]\nb: &b [*a, *a, *a, *a, *a, *a, *a, *a, *a]\n"
        "c: &c [*b, *b, *b, *b, *b, *b, *b, *b, *b]\nd: &d [*c, *c, *c, *c, *c, *c, *c, *c, *c]\n"
        "e: &e [*d, *d, *d, *d, *d, *d, *d, *d, *d]\nf: &f [*e, *e, *e, *e, *e, *e, *e, *e, *e]\n"
        "g: &g [*f, *f, *f, *f, *f, *f, *f, *f, *f]\nh: [*g, *g, *g, *g, *g, *g, *g, *g, *g]\n");
  expect_error("<l v=\"${xacro.load_yaml('bomb.yaml').h[0][0]}\"/>", "the expansion ");
}

TEST_F(Xacro, OnlyElementsMakeAFileXacro) {
  EXPECT_TRUE(has_xacro_element("<robot><xacro:m/></robot>"));
  EXPECT_FALSE(has_xacro_element("<robot xmlns:xacro='x'><!-- <xacro:m/> --><![CDATA[<xacro:m/>]]></robot>"));
}

TEST_F(Xacro, ProgramNeedsOption) {
  write("arm/urdf/arm.urdf.xacro", "<robot><xacro:m/></robot>");
  const fs::path program = folder_.path() / "xacro program";
  folder_.write("xacro program", std::string_view("#!/bin/sh\n[ \"$2\" = 'a:=b c' ] || exit 3\n"
                                                  "echo '<robot name=\"r\"><link name=\"l\"/></robot>'\n"));
  fs::permissions(program, fs::perms::owner_all);
  ReadOptions options;
  options.xacro_program = program.string();
  const auto file = folder_.path() / "arm/urdf/arm.urdf.xacro";
  const auto failed = read_urdf(file, options);
  ASSERT_FALSE(failed.ok());
  EXPECT_NE(failed.error().message.find("failed on"), std::string::npos) << failed.error().message;
  options.xacro_arguments = {{"a", "b c"}};
  const auto model = read_urdf(file, options);
  ASSERT_TRUE(model.ok()) << model.error().message;
  EXPECT_EQ(model->nodes.size(), 1u);
  options.xacro_program = "/nowhere/xacro";
  EXPECT_NE(read_urdf(file, options).error().message.find("cannot run the program \"/nowhere/xacro\""),
            std::string::npos);
}

}  // namespace
}  // namespace fire3dv::convert
