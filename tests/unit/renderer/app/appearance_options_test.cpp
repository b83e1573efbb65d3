// Test of the options that the provenance of images stores: they give the same options again, and name no
// file.
#include "renderer/app/options/appearance_options.h"

#include <gtest/gtest.h>

#include <string>
#include <variant>
#include <vector>

namespace fire3dv::app {
namespace {

Options parsed(std::vector<std::string> words) {
  words.insert(words.begin(), "fire3dv");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  auto options = parse_options(static_cast<int>(arguments.size()), arguments.data(), false);
  EXPECT_TRUE(std::holds_alternative<Options>(options)) << words.back();
  return std::holds_alternative<Options>(options) ? std::get<Options>(options) : Options();
}

std::vector<std::string> words_of(const sinks::RunProvenance::Values& values) {
  std::vector<std::string> words;
  for (const auto& [name, value] : values)
    words.push_back("--" + name + (name == "frame-all" ? "" : "=" + value));
  return words;
}

TEST(AppearanceOptions, GiveTheSameOptionsAgain) {
  EXPECT_EQ(appearance_options(parsed({})), (sinks::RunProvenance::Values{{"size", "1280x720"}}));
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"--size", "64x48", "--camera", "left eye", "--frame-all", "--ground", "0.5", "--key-light",
            "off"},
           {"--animate", "all", "--variant", "red", "--markers", "all", "--view", "normals"},
           {"--exposure", "1.37", "--background", "20a0ff", "--environment-rotation", "33.3", "--bloom",
            "0.2"},
           {"--render", "path", "--spp", "7", "--seed", "5", "--f-number", "2.8", "--focus-distance", "0.3"},
           {"--shadows", "small-map", "--samples", "1", "--ray-effects", "ao,bounce", "--ground", "off"}}) {
    const auto values = appearance_options(parsed(words));
    EXPECT_GT(values.size(), 4u) << words.front();
    EXPECT_EQ(appearance_options(parsed(words_of(values))), values) << words.front();
    for (const auto& [name, value] : values) EXPECT_TRUE(is_appearance_option(name)) << name;
  }
}

TEST(AppearanceOptions, NameNoFile) {
  for (const char* name :
       {"environment", "overlay", "assets", "config", "cache", "out", "record", "listen", "stats",
        "package-path", "xacro-arg", "key-file", "instances", "size=1x1 --out", ""})
    EXPECT_FALSE(is_appearance_option(name)) << name;
}

}  // namespace
}  // namespace fire3dv::app
