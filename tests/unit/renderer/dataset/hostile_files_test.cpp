// Test of dataset.json and frames.jsonl that other programs have changed: an error or a new drawing, no
// crash.
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "made_set.h"
#include "renderer/dataset/labels/line_check.h"

namespace fire3dv::dataset {
namespace {

using nlohmann::json;

using HostileFiles = MadeSet;

std::vector<json> odd_values() {
  json nested = 1;
  for (int i = 0; i < 12; ++i) nested = json::array({nested});
  return {nullptr,
          true,
          -1,
          1e300,
          4294967296.0,
          3,
          "",
          "../../x",
          json::array(),
          json::object(),
          nested,
          json::array({1, "x"})};
}

// Visits each value of a document, also of lists, with a function that may change it.
template <typename Visit>
void visit_all(json& value, Visit&& visit) {
  visit(value);
  if (!value.is_structured()) return;
  for (auto& each : value) visit_all(each, visit);
}

TEST_F(HostileFiles, DescriptionsAreChecked) {
  const std::filesystem::path path = root_ / kDescriptionName;
  const std::string text = to_json(made_description("bop"));
  const auto read = [&](const std::string& changed) {
    std::filesystem::remove(path);
    write(path, changed);
    const auto description = read_description(root_);
    if (!description) {
      EXPECT_NE(description.error().message.find("dataset.json is not what fire3dv dataset writes"),
                std::string::npos);
      return false;
    }
    EXPECT_FALSE(description->cameras.empty());
    for (const Instance& instance : description->instances)
      EXPECT_LT(instance.object, description->objects.size());
    return true;
  };
  EXPECT_TRUE(read(text));
  json document = json::parse(text);
  int refused = 0;
  for (const json& odd : odd_values()) {
    visit_all(document, [&](json& value) {
      const json before = std::exchange(value, odd);
      refused += !read(document.dump());
      value = before;
    });
  }
  EXPECT_GT(refused, 200);
  std::mt19937 random(7);
  for (int i = 0; i < 300; ++i) {
    std::string damaged = text;
    damaged[random() % damaged.size()] = static_cast<char>(random());
    read(damaged);
  }
  for (const auto& [from, to] :
       {std::pair("\"id\": 2", "\"id\": 1"), std::pair("\"instance\": 5", "\"instance\": 2")}) {
    std::string other = text;
    other.replace(other.find(from), std::string(from).size(), to);
    EXPECT_FALSE(read(other)) << to;
  }
  json many = json::parse(text);
  many["cameras"] = std::vector<std::string>(1001, "c");
  EXPECT_FALSE(read(many.dump()));
}

TEST_F(HostileFiles, ListsAreChecked) {
  for (const std::string format : {"bop", "coco"}) {
    const std::filesystem::path folder = root_ / format;
    const Description description = made_description(format);
    ASSERT_EQ(run(folder, description), "");
    const std::string list = text_of(folder / "frames.jsonl");
    const std::string whole = text_of(folder / "README.md");
    json line = json::parse(list.substr(0, list.find('\n')));
    const std::string rest = list.substr(list.find('\n') + 1);
    const auto values = odd_values();
    size_t turn = 0, drawn_again = 0;
    visit_all(line, [&](json& value) {
      if (&value == &line) return;
      const json before = std::exchange(value, values[turn++ % values.size()]);
      const bool is_listed = is_image_line(line, description);
      write(folder / "frames.jsonl", line.dump() + "\n" + rest);
      value = before;
      drawn_again += !is_listed;
      if (is_listed && turn % 4 == 0) {
        EXPECT_EQ(run(folder, description), "") << format << " " << turn;
      }
    });
    EXPECT_GT(drawn_again, 50u);
    // Deeper than the copies of a JSON value may be.
    write(folder / "frames.jsonl",
          R"({"frame":0,"cam_K":)" + std::string(1 << 20, '[') + std::string(1 << 20, ']') + "}\n" + rest);
    EXPECT_EQ(run(folder, description), "");
    EXPECT_EQ(existing_, kImages - 1);
    EXPECT_EQ(text_of(folder / "README.md"), whole);
  }
}

TEST_F(HostileFiles, LinesNameInstancesOfTheSet) {
  ASSERT_EQ(run(root_ / "set", made_description("coco")), "");
  const std::string list = text_of(root_ / "set" / "frames.jsonl");
  const json line = json::parse(list.substr(0, list.find('\n')));
  const Description description = made_description("coco");
  EXPECT_TRUE(is_image_line(line, description));
  json other = line;
  other["instances"][0]["instance"] = 3;
  EXPECT_FALSE(is_image_line(other, description));
  other = line;
  other["instances"][1]["obj_id"] = 1;
  EXPECT_FALSE(is_image_line(other, description));
}

// `fire3dv join` reads the description of the first part.
TEST_F(HostileFiles, PartsAgreeWithTheirManifest) {
  ASSERT_EQ(run(root_ / "set", made_description("folder")), "");
  EXPECT_TRUE(DatasetFormat::find({root_ / "set"}).ok());
  Description description = made_description("folder");
  description.cameras.pop_back();
  std::filesystem::remove(root_ / "set" / kDescriptionName);
  write(root_ / "set" / kDescriptionName, to_json(description));
  const auto found = DatasetFormat::find({root_ / "set"});
  ASSERT_FALSE(found.ok());
  EXPECT_NE(found.error().message.find("disagree on cameras or size"), std::string::npos);
}

// A list with such a line could not be read again.
TEST_F(HostileFiles, LinesThatAreTooLongAreRefused) {
  Description description = made_description("c3vd");
  const Keypoint point = description.keypoints.front();
  for (int i = 0; i < 4500; ++i) {
    description.keypoints.push_back(point);
    description.keypoints.back().name = std::string(4000, 'n') + std::to_string(i);
  }
  auto format = format_of(description);
  auto set = offline::FrameFolder::open(root_ / "set", made_manifest(), format);
  ASSERT_TRUE(set.ok() && (*set)->begin({}).ok());
  ImagePoses poses = made_poses();
  poses.world_from_keypoint_node.resize(description.keypoints.size(), glm::dmat4(1));
  format->add_poses(0, std::move(poses));
  Result<void> result = (*set)->consume(made_image(0));
  if (result) result = (*set)->finish();
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().message.find("MiB, more than 16: label fewer nodes with --object"),
            std::string::npos)
      << result.error().message;
}

}  // namespace
}  // namespace fire3dv::dataset
