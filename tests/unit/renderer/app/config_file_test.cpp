// Test of the configuration file: its lines, its place, its precedence below the command line, and errors
// that name the line.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "renderer/app/options/config_file.h"
#include "renderer/app/options/options.h"

namespace fire3dv::app {
namespace {

TEST(ConfigLines, AreNamesWithOptionalValue) {
  const Result<std::vector<ConfigLine>> lines = parse_config(
      "# comment\n\nsize = 640x480\r\n  --lod off\nheadless\nxacro-arg a=b\nxacro-arg = c = d\nout=~/x y "
      "\nwatch=\n",
      "/home/me");
  ASSERT_TRUE(lines);
  EXPECT_EQ(*lines, (std::vector<ConfigLine>{{3, "size", "640x480"},
                                             {4, "lod", "off"},
                                             {5, "headless", std::nullopt},
                                             {6, "xacro-arg", "a=b"},
                                             {7, "xacro-arg", "c = d"},
                                             {8, "out", "/home/me/x y"},
                                             {9, "watch", ""}}));
  EXPECT_EQ((*lines)[0].argument(), "--size=640x480");
  EXPECT_EQ((*lines)[2].argument(), "--headless");
}

TEST(ConfigLines, InvalidLinesAreErrors) {
  for (const char* text : {"a\n= 3\n", "a\n--\n", "a\n---b\n", "a\n-h\n"}) {
    const auto lines = parse_config(text, "");
    ASSERT_FALSE(lines) << text;
    EXPECT_TRUE(lines.error().message.starts_with("2: ")) << lines.error().message;
  }
  EXPECT_FALSE(parse_config(std::string_view("a\0b", 3), ""));
  std::string many;
  for (int i = 0; i < 501; ++i) many += "listen shm://a\n";
  EXPECT_FALSE(parse_config(many, ""));
}

TEST(ConfigPlaces, OptionVariableThenFolder) {
  std::map<std::string, std::string> variables;
  const auto place = [&](const std::string& option) {
    return config_path(option, [&](const char* name) -> const char* {
      const auto found = variables.find(name);
      return found == variables.end() ? nullptr : found->second.c_str();
    });
  };
  EXPECT_TRUE(place("").file.empty());
  variables["HOME"] = "/home/me";
  EXPECT_EQ(place("").file, "/home/me/.config/fire3dv/config");
  EXPECT_FALSE(place("").must_exist);
  variables["XDG_CONFIG_HOME"] = "relative";
  EXPECT_EQ(place("").file, "/home/me/.config/fire3dv/config");
  variables["XDG_CONFIG_HOME"] = "/etc/me";
  EXPECT_EQ(place("").file, "/etc/me/fire3dv/config");
  variables["FIRE3DV_CONFIG"] = "none";
  EXPECT_TRUE(place("").file.empty());
  EXPECT_EQ(place("a.conf").file, "a.conf");
  EXPECT_TRUE(place("a.conf").must_exist);
  variables["FIRE3DV_CONFIG"] = "b.conf";
  EXPECT_EQ(place("").file, "b.conf");
  EXPECT_TRUE(place("none").file.empty());
}

class Config : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / "fire3dv_config_test.XXXXXX";
    std::string name = folder_.string();
    ASSERT_TRUE(mkdtemp(name.data()));
    folder_ = name;
    file_ = folder_ / "config";
    setenv("FIRE3DV_CONFIG", file_.c_str(), 1);
  }
  void TearDown() override {
    unsetenv("FIRE3DV_CONFIG");
    std::filesystem::remove_all(folder_);
  }
  // Parses a command line with these lines in the file. Keeps what it prints.
  std::variant<Options, int> parse(const std::string& lines, std::vector<std::string> words) {
    std::ofstream(file_) << lines;
    words.insert(words.begin(), "fire3dv");
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    testing::internal::CaptureStderr();
    auto parsed = parse_options(static_cast<int>(argv.size()), argv.data());
    printed_ = testing::internal::GetCapturedStderr();
    return parsed;
  }
  Options options(const std::string& lines, std::vector<std::string> words) {
    auto parsed = parse(lines, std::move(words));
    if (auto* const good = std::get_if<Options>(&parsed)) return std::move(*good);
    ADD_FAILURE() << printed_;
    return {};
  }
  void expect_error(const std::string& lines, std::vector<std::string> words, const std::string& text) {
    const auto parsed = parse(lines, std::move(words));
    ASSERT_TRUE(std::holds_alternative<int>(parsed)) << lines;
    EXPECT_EQ(std::get<int>(parsed), 2);
    EXPECT_NE(printed_.find(text), std::string::npos) << printed_;
  }
  std::string at(int line) const { return file_.string() + ":" + std::to_string(line) + ": "; }

  std::filesystem::path folder_, file_;
  std::string printed_;
};

TEST_F(Config, SetsOptionsThatCommandLineOverrules) {
  const std::string lines =
      "size 640x480\nsamples = 1\nlisten shm://a\nlisten shm://b\ninsecure\nfxaa = off\n";
  Options parsed = options(lines, {"scene.glb"});
  EXPECT_EQ(parsed.scene, "scene.glb");
  EXPECT_EQ(parsed.width, 640u);
  EXPECT_EQ(parsed.draw.samples, 1u);
  EXPECT_FALSE(parsed.draw.post.fxaa);
  EXPECT_TRUE(parsed.insecure);
  EXPECT_EQ(parsed.listen, (std::vector<std::string>{"shm://a", "shm://b"}));
  EXPECT_EQ(printed_, "");
  parsed = options(lines, {"scene.glb", "--size", "10x20", "--listen", "shm://c"});
  EXPECT_EQ(parsed.width, 10u);
  EXPECT_EQ(parsed.listen, (std::vector<std::string>{"shm://c"}));
  EXPECT_EQ(parsed.draw.samples, 1u);
  parsed = options(lines, {"scene.glb", "--config", "none"});
  EXPECT_EQ(parsed.width, 1280u);
  EXPECT_TRUE(parsed.draw.post.fxaa);
}

TEST_F(Config, ValuelessOptionKeepsScene) {
  const Options parsed = options("animate\n", {"scene.glb"});
  EXPECT_EQ(parsed.scene, "scene.glb");
  EXPECT_EQ(options("animate walk\n", {"--", "scene.glb"}).animate, "walk");
}

TEST_F(Config, ErrorsNameTheLine) {
  expect_error("# x\nsise 3x3\n", {"a.glb"}, at(2) + "unknown option --sise, did you mean --size?");
  for (const char* line : {"samples = 99\n", "samples\n"}) {
    expect_error(line, {"a.glb"}, at(1));
    EXPECT_NE(printed_.find("--samples"), std::string::npos) << printed_;
  }
  expect_error("lod = sharp\n", {"a.glb", "--lod", "off"}, at(1));  // also if it is overruled
  EXPECT_NE(printed_.find("--lod"), std::string::npos) << printed_;
  expect_error("size 3x3\nlod off\nsize 4x4\n", {"a.glb"}, at(3) + "--size is set in line 1 already");
  expect_error("help\n", {"a.glb"}, at(1) + "--help is an option of command lines only");
  expect_error("config = b\n", {"a.glb"}, at(1) + "--config is an option of command lines only");
  expect_error("drake = h:1\n", {"a.glb"}, at(1) + "--drake is an option of command lines only");
  expect_error("scene a.glb\n", {}, at(1) + "unknown option --scene");
  expect_error("= 3\n", {"a.glb"}, at(1) + "no option's name");
  std::filesystem::remove(file_);
  testing::internal::CaptureStderr();
  std::string program = "fire3dv", scene = "a.glb";
  char* argv[] = {program.data(), scene.data()};
  EXPECT_TRUE(std::holds_alternative<int>(parse_options(2, argv))) << "FIRE3DV_CONFIG must exist";
  EXPECT_NE(testing::internal::GetCapturedStderr().find(file_.string()), std::string::npos);
}

TEST_F(Config, ContradictingLineIsSkipped) {
  Options parsed =
      options("window front\nlisten shm://a\nscreenshots /tmp\nserve-tokens t\nserve 127.0.0.1:1\n",
              {"a.glb", "--headless"});
  EXPECT_TRUE(parsed.headless);
  EXPECT_TRUE(parsed.window_cameras.empty());
  EXPECT_EQ(parsed.listen, (std::vector<std::string>{"shm://a"}));
  EXPECT_EQ(parsed.serve_tokens, "t") << "needs a later line";
  EXPECT_NE(printed_.find("info: " + at(1) + "--window is left out"), std::string::npos) << printed_;
  EXPECT_NE(printed_.find("info: " + at(3) + "--screenshots is left out"), std::string::npos) << printed_;
  parsed = options("device = 1\n", {"a.glb", "--listen", "shm://a", "--devices", "all"});
  EXPECT_EQ(parsed.devices, "all");
  EXPECT_EQ(parsed.device, "");
  EXPECT_EQ(printed_, "");
}

TEST_F(Config, ErrorOfCommandLineAloneStays) {
  expect_error("", {}, "name a scene");
  expect_error("lockstep\n", {}, "name a scene");
}

}  // namespace
}  // namespace fire3dv::app
