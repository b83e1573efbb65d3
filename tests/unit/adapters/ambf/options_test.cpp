// Test of the AMBF plugin's options from the command line, the environment and the launch file, and of AMBF's
// own command line.
#include "adapters/ambf/options.h"

#include <gtest/gtest.h>

#include "adapters/ambf/session.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::ambf {
namespace {

using Variables = std::map<std::string, std::string>;

Result<Options> read(const std::vector<std::string>& arguments, const Variables& variables = {},
                     const LaunchBlock& launch = {}) {
  return read_options(
      arguments,
      [&](const char* name) {
        const auto found = variables.find(name);
        return found == variables.end() ? nullptr : found->second.c_str();
      },
      launch);
}

std::string refusal(const std::vector<std::string>& arguments, const Variables& variables = {},
                    const LaunchBlock& launch = {}) {
  const auto options = read(arguments, variables, launch);
  return options.ok() ? "" : options.error().message;
}

TEST(AmbfOptions, HaveDefaults) {
  const auto options = read({"ambf_simulator", "-l", "0"});
  ASSERT_TRUE(options.ok()) << options.error().message;
  EXPECT_EQ(options->uris, std::vector<std::string>{"shm://ambf"});
  EXPECT_EQ(options->rate_hz, 0);
  EXPECT_EQ(options->names, Options::Names::key);
}

TEST(AmbfOptions, CommandLineWinsThenEnvironment) {
  const Variables variables{{"FIRE3DV_AMBF_RATE", "60"}, {"FIRE3DV_AMBF_KEY_FILE", "/env"}};
  const LaunchBlock launch{{"rate", "30"}, {"key file", "/launch"}, {"uri", "shm://a,udp://127.0.0.1:7000"}};
  const auto options =
      read({"ambf_simulator", "--fire3dv-rate=120", "--fire3dv-names", "name"}, variables, launch);
  ASSERT_TRUE(options.ok()) << options.error().message;
  EXPECT_EQ(options->rate_hz, 120);
  EXPECT_EQ(options->key_file, "/env");
  EXPECT_EQ(options->uris, (std::vector<std::string>{"shm://a", "udp://127.0.0.1:7000"}));
  EXPECT_EQ(options->names, Options::Names::name);
}

TEST(AmbfOptions, ErrorsNameTheRemedy) {
  EXPECT_NE(refusal({"a", "--fire3dv-rate", "fast"}).find("--fire3dv-rate is 'fast'; it takes frames"),
            std::string::npos);
  EXPECT_NE(refusal({"a", "--fire3dv-rate=-1"}), "");
  EXPECT_NE(refusal({"a", "--fire3dv-rate=nan"}), "");
  EXPECT_NE(refusal({"a", "--fire3dv-rate=inf"}), "");
  EXPECT_NE(refusal({"a", "--fire3dv-rate=1e-12"}).find("0.001"), std::string::npos) << "no period in ns";
  EXPECT_NE(refusal({"a", "--fire3dv-vertex-rate=0.0009"}).find("0.001"), std::string::npos);
  EXPECT_EQ(refusal({"a", "--fire3dv-rate=0.001", "--fire3dv-vertex-rate=0"}), "");
  EXPECT_NE(refusal({"a", "--fire3dv-uri"}).find("needs a value"), std::string::npos);
  EXPECT_NE(refusal({"a", "--fire3dv-uri=shm://a,,shm://b"}), "");
  EXPECT_NE(refusal({"a", "--fire3dv-ratte=1"}).find("--fire3dv-rate,"), std::string::npos)
      << "it lists those there are";
  EXPECT_NE(refusal({}, {{"FIRE3DV_AMBF_NAMES", "both"}}).find("FIRE3DV_AMBF_NAMES"), std::string::npos);
  EXPECT_NE(refusal({}, {}, {{"colour", "red"}}).find("the launch file's fire3dv: colour"),
            std::string::npos);
}

class AmbfLaunch : public testing::Test {
 protected:
  AmbfLaunch() {
    file_ = scratch_.write("launch.yaml", std::string_view(R"(
world config: ./world/world.yaml
color config: ./colors.yaml
input devices config: ./devices.yaml
multibody configs:
  - "a/first.yaml" #0
  - "b/second one.yaml"
  - c.yaml
fire3dv: {uri: [shm://x, "tcp://127.0.0.1:7001"], rate: 60}
)"));
  }
  std::vector<std::string> models(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"ambf_simulator", "--launch_file", file_.string()});
    const auto launch = read_launch(arguments, "/nowhere");
    if (!launch.ok()) return {launch.error().message};
    std::vector<std::string> names;
    for (const auto& model : launch->models) names.push_back(model.filename().string());
    return names;
  }
  test::ScratchFolder scratch_;
  std::filesystem::path file_;
};

TEST_F(AmbfLaunch, ModelSelectionMatchesAmbf) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(models({"-l", "2,0"}), (Names{"c.yaml", "first.yaml"}));
  EXPECT_EQ(models({"-l2, 1"}), (Names{"c.yaml", "second one.yaml"}));
  EXPECT_EQ(models({"--load_multibodies=1"}), Names{"second one.yaml"});
  EXPECT_EQ(models({"-g", "0"}), Names{"second one.yaml"}) << "number 1 where nothing is said";
  EXPECT_EQ(models({"-a", "x.yaml,y.yaml"}), (Names{"x.yaml", "y.yaml"}));
  EXPECT_EQ(models({"-l", "0", "-a", "x.yaml"}), (Names{"x.yaml", "first.yaml"}));
  EXPECT_EQ(models({"-l", "0,7,-3,99999999999999999999"}), Names{"first.yaml"});
}

TEST_F(AmbfLaunch, UniqueOptionPrefixIsAccepted) {
  const auto launch = read_launch({"a", "--lau", file_.string(), "--ns", "/pre", "-l", "0"}, "/nowhere");
  ASSERT_TRUE(launch.ok()) << launch.error().message;
  EXPECT_EQ(launch->name_space, "/pre");
  EXPECT_EQ(launch->world.filename(), "world.yaml");
  EXPECT_EQ(launch->options, (LaunchBlock{{"uri", "shm://x,tcp://127.0.0.1:7001"}, {"rate", "60"}}));
  EXPECT_FALSE(read_launch({"a", "--l", file_.string()}, "/nowhere").ok()) << "that may be three";
}

TEST_F(AmbfLaunch, BlockErrorIsReported) {
  const auto fault = [&](const char* block) {
    const auto file =
        scratch_.write("faulty.yaml", "world config: w.yaml\nfire3dv: " + std::string(block) + "\n");
    const auto launch = read_launch({"a", "--launch_file", file.string()}, "/nowhere");
    return launch.ok() ? launch->options_fault : "the file: " + launch.error().message;
  };
  EXPECT_EQ(fault("{rate: 5}"), "");
  EXPECT_EQ(fault(""), "");
  EXPECT_NE(fault("{rate: {a: 1}}").find("faulty.yaml: fire3dv: rate takes"), std::string::npos);
  EXPECT_NE(fault("{uri: [[shm://a]]}").find("uri takes"), std::string::npos);
  EXPECT_NE(fault("shm://a").find("takes options"), std::string::npos);
  EXPECT_NE(fault("[uri, shm://a]").find("takes options"), std::string::npos);
  EXPECT_NE(fault("{[a]: 1}").find("name"), std::string::npos);
}

TEST_F(AmbfLaunch, UnreadableFileIsNamed) {
  const auto missing = read_launch({"a", "--launch_file", "no/such.yaml"}, "/nowhere");
  ASSERT_FALSE(missing.ok());
  EXPECT_NE(missing.error().message.find("no/such.yaml"), std::string::npos);
  const auto broken = scratch_.write("broken.yaml", std::string_view("a: [1\nb: }"));
  const auto read = read_launch({"a", "--launch_file", broken.string()}, "/nowhere");
  ASSERT_FALSE(read.ok());
  EXPECT_NE(read.error().message.find("line"), std::string::npos) << read.error().message;
}

TEST(AmbfRateLimit, OddStepsKeepTheRate) {
  RateLimit limit(120);
  int published = 0;
  for (int64_t step = 0; step < 10'000; ++step) published += limit.due(step * 1'000'000);
  EXPECT_NEAR(published, 1200, 2);
  RateLimit every;
  EXPECT_TRUE(every.due(5) && every.due(5));
}

TEST(AmbfRateLimit, PauseIsNotMadeUp) {
  RateLimit limit(100);
  EXPECT_TRUE(limit.due(0));
  EXPECT_TRUE(limit.due(1'000'000'000));
  EXPECT_FALSE(limit.due(1'001'000'000));
  EXPECT_TRUE(limit.due(1'010'000'000));
}

}  // namespace
}  // namespace fire3dv::ambf
