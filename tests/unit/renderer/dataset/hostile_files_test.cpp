// Test of dataset.json and frames.jsonl that other programs have changed: an error or a new drawing, no
// crash.
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "made_set.h"
#include "renderer/dataset/labels/line_check.h"
#include "renderer/dataset/layouts/hdf5_file.h"

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
       {std::pair("\"obj_id\": 2", "\"obj_id\": 1"), std::pair("\"instance\": 5", "\"instance\": 2")}) {
    std::string other = text;
    other.replace(other.find(from), std::string(from).size(), to);
    EXPECT_FALSE(read(other)) << to;
  }
  json many = json::parse(text);
  many["cameras"] = std::vector<std::string>(1001, "c");
  EXPECT_FALSE(read(many.dump()));
}

TEST_F(HostileFiles, ListsAreChecked) {
  for (const std::string format : {"bop", "coco", "webdataset", "hdf5"}) {
    if (format == "hdf5" && !can_write_hdf5().ok()) continue;
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

// The list of archives decides whether images are drawn again.
TEST_F(HostileFiles, ListsOfArchivesAreChecked) {
  Description description = made_description("webdataset");
  description.tar_bytes = 1;
  const std::filesystem::path folder = root_ / "set";
  ASSERT_EQ(run(folder, description), "");
  const auto wanted = files_of(folder);
  json list = json::parse(text_of(folder / "shards.json"));
  ASSERT_EQ(list.size(), kImages);
  int drawn_again = 0;
  const auto expect_whole = [&](const std::string& text) {
    write(folder / "shards.json", text);
    ASSERT_EQ(run(folder, description), "") << text;
    EXPECT_FALSE(std::filesystem::exists(folder / "images"));
    if (existing_ == kImages) return;
    ++drawn_again;
    EXPECT_EQ(existing_, 0u);
    EXPECT_EQ(files_of(folder), wanted) << text;
  };
  for (const json& odd : odd_values()) {
    for (const char* name : {"bytes", "name"}) {
      json changed = list;
      changed[1][name] = odd;
      expect_whole(changed.dump());
    }
    json changed = list;
    changed[2] = odd;
    expect_whole(changed.dump());
    expect_whole(odd.dump());
  }
  EXPECT_GE(drawn_again, 3 * 12) << "only a name is of no account";
  expect_whole("[");
  expect_whole(std::string(100'000, '['));
  json longer = list;
  longer.push_back(list[0]);
  expect_whole(longer.dump());
  // Another archive than the listed one, and links.
  for (const bool is_link : {false, true}) {
    write(folder / "shards.json", wanted.at("shards.json"));
    const std::filesystem::path archive = folder / "shard-000001.tar";
    if (is_link) {
      std::filesystem::rename(archive, root_ / "elsewhere.tar");
      std::filesystem::create_symlink(root_ / "elsewhere.tar", archive);
    } else {
      write(archive, "short");
    }
    ASSERT_EQ(run(folder, description), "");
    EXPECT_EQ(existing_, 0u);
    EXPECT_EQ(files_of(folder), wanted);
  }
  EXPECT_EQ(text_of(root_ / "elsewhere.tar"), wanted.at("shard-000001.tar"));
}

// Parts may come from others: the page of the whole set reads their colours.
TEST_F(HostileFiles, DamagedHdf5FilesAreRefused) {
  if (!can_write_hdf5().ok()) GTEST_SKIP() << can_write_hdf5().error().message;
  const std::filesystem::path folder = root_ / "set", file = folder / "images" / "000000.hdf5";
  ASSERT_EQ(run(folder, made_description("hdf5")), "");
  const std::string whole = text_of(file);
  constexpr uint64_t kBytes = uint64_t{3} * kWidth * kHeight;
  ASSERT_TRUE(read_hdf5_bytes(file, "/colors", kBytes).ok());
  const auto read = [&](const std::string& changed) {
    write(file, changed);
    const auto colors = read_hdf5_bytes(file, "/colors", kBytes);
    if (!colors) {
      EXPECT_NE(colors.error().message.find("000000.hdf5"), std::string::npos);
    }
    return colors.ok();
  };
  for (const std::string& changed :
       {std::string(), std::string("x"), whole.substr(0, whole.size() / 2), std::string(whole.size(), '\0')})
    EXPECT_FALSE(read(changed)) << changed.size();
  EXPECT_FALSE(read_hdf5_bytes(file, "/colors", kBytes + 1).ok());
  std::mt19937 random(7);
  int refused = 0;
  for (int i = 0; i < 300; ++i) {
    std::string damaged = whole;
    for (int k = 0; k < 8; ++k) damaged[random() % damaged.size()] = static_cast<char>(random());
    refused += !read(damaged);
  }
  EXPECT_GT(refused, 20);
  EXPECT_TRUE(read(whole)) << "the library does not work any more";
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
