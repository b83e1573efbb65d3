// Test of the files of data sets: where they may be written, what is kept, and texts.
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "made_set.h"
#include "renderer/dataset/layouts/hdf5_file.h"
#include "renderer/dataset/layouts/layout.h"

namespace fire3dv::dataset {
namespace {

namespace fs = std::filesystem;

using SetFiles = MadeSet;

// What a check makes again is what a run has written, and all but the images' own files and the pages.
void expect_made_again(const fs::path& folder, const DatasetFormat& format) {
  const offline::Manifest manifest = made_manifest();
  const auto lines = offline::listed_frames(folder, manifest, format);
  ASSERT_TRUE(lines.ok() && lines->size() == kImages);
  auto files = format.first_files();
  const auto lists = format.last_files(*lines);
  ASSERT_TRUE(lists.ok());
  files.insert(files.end(), lists->begin(), lists->end());
  std::set<std::string> names{offline::kManifestName, offline::kFrameListName};
  for (const std::string& page : format.page_names()) names.insert(page);
  for (const offline::FolderFile& file : files) {
    const auto stored = format.read_run_file(folder, file.name);
    EXPECT_TRUE(stored.ok() && *stored == file.bytes) << file.name;
    names.insert(file.name);
  }
  uint64_t others = 0;  // each image has one at least
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    others += entry.is_regular_file() && !names.contains(entry.path().lexically_relative(folder).string()) &&
              entry.path().extension() != ".tar";
  const bool is_packed = format.is_packed(folder);
  EXPECT_TRUE(is_packed ? others == 0 : others >= kImages) << others;
}

TEST_F(SetFiles, EachFormatIsWhole) {
  for (const std::string format : kAllFormats) {
    const fs::path folder = root_ / format;
    if (format == "hdf5" && !can_write_hdf5().ok()) {
      std::printf("left out: %s\n", can_write_hdf5().error().message.c_str());
      continue;
    }
    ASSERT_EQ(run(folder, made_description(format)), "") << format;
    for (const char* name : {"README.md", "index.html", "dataset.json", "frames.jsonl", "manifest.json"})
      EXPECT_TRUE(fs::exists(folder / name)) << format << " " << name;
    expect_made_again(folder, *format_of(made_description(format)));
    ASSERT_EQ(run(folder, made_description(format)), "");
    EXPECT_EQ(existing_, kImages) << format;
    for (const auto& entry : fs::recursive_directory_iterator(root_))
      EXPECT_TRUE(entry.path() == folder || entry.path().string().starts_with(folder.string() + "/"))
          << entry.path() << " is outside of the set";
    fs::remove_all(folder);
  }
}

// Wherever a run is killed while it packs its images, the next one gives the same set.
TEST_F(SetFiles, AKilledEndOfAWebdatasetIsRepeated) {
  Description description = made_description("webdataset");
  description.tar_bytes = 1;  // one archive for each image
  const fs::path loose = root_ / "loose", whole = root_ / "whole";
  ASSERT_EQ(run(loose, description, made_manifest(), false), "");
  ASSERT_EQ(run(whole, description), "");
  const auto wanted = files_of(whole);
  ASSERT_TRUE(wanted.contains("shard-000003.tar") && !fs::exists(whole / "images"));
  const std::vector<std::vector<const char*>> ends{
      {},
      {"shard-000000.tar"},
      {"shard-000000.tar", "shard-000001.tar", "shard-000002.tar", "shard-000003.tar"},
      {"shard-000000.tar", "shard-000001.tar", "shard-000002.tar", "shard-000003.tar", "shards.json"},
      {"shard-000000.tar", "shard-000001.tar", "shard-000002.tar", "shard-000003.tar", "shards.json",
       "README.md", "index.html"}};
  for (const auto& names : ends) {
    for (const bool has_removed_some : {false, true}) {
      if (has_removed_some && names.size() < 7) continue;  // removal is last
      const fs::path set = root_ / "set";
      fs::copy(loose, set, fs::copy_options::recursive);
      for (const char* name : names) fs::copy(whole / name, set / name);
      write(set / "shard-000001.tar.part-abcdef", "half");
      if (has_removed_some) fs::remove(set / "images" / "000002.png");
      ASSERT_EQ(run(set, description), "") << names.size();
      EXPECT_EQ(existing_, kImages) << "images were drawn again";
      fs::remove(set / "shard-000001.tar.part-abcdef");  // a finished set is not looked through for them
      EXPECT_EQ(files_of(set), wanted) << names.size();
      fs::remove_all(set);
    }
  }
}

TEST_F(SetFiles, ArchivesHaveAtMostTheirSize) {
  Description description = made_description("webdataset");
  for (const uint64_t bytes : {uint64_t{20480}, uint64_t{30720}, uint64_t{40000}}) {
    description.tar_bytes = bytes;
    ASSERT_EQ(run(root_ / "set", description), "");
    for (const auto& entry : fs::directory_iterator(root_ / "set")) {
      if (entry.path().extension() == ".tar") {
        EXPECT_LE(entry.file_size(), bytes) << entry.path();
      }
    }
    fs::remove_all(root_ / "set");
  }
}

// Files that nobody has listed are not the set's.
TEST_F(SetFiles, OnlyFilesOfImagesAreRemovedAfterPacking) {
  const Description description = made_description("webdataset");
  const fs::path set = root_ / "set";
  ASSERT_EQ(run(set, description, made_manifest(), false), "");
  write(set / "images" / "notes.txt", "mine");
  ASSERT_EQ(run(set, description), "");
  EXPECT_EQ(files_of(set / "images"), (std::map<std::string, std::string>{{"notes.txt", "mine"}}));
}

// Sets of earlier versions named the number of an object otherwise.
TEST_F(SetFiles, OldNamesOfObjectsAreRead) {
  const fs::path set = root_ / "set";
  ASSERT_EQ(run(set, made_description("bop")), "");
  const std::string text = text_of(set / kDescriptionName);
  EXPECT_NE(text.find("\"obj_id\": 2"), std::string::npos);
  std::string old = text;
  for (const char* name : {"\"id\": ", "\"object\": "}) {  // of both objects, then of both instances
    for (int i = 0; i < 2; ++i) old.replace(old.find("\"obj_id\": "), 10, name);
  }
  ASSERT_EQ(old.find("obj_id"), std::string::npos);
  write(set / kDescriptionName, old);
  EXPECT_EQ(to_json(read_description(set).value()), text);
}

TEST_F(SetFiles, FilesOfOthersStay) {
  const fs::path folder = root_ / "mine";
  fs::create_directories(folder / "images");
  write(folder / "images" / "000000.png", "a photograph");
  const std::string said = run(folder, made_description("coco"));
  EXPECT_NE(said.find("is not empty (\"images\" is in it), and no data set: name a new folder"),
            std::string::npos)
      << said;
  EXPECT_EQ(text_of(folder / "images" / "000000.png"), "a photograph");
  EXPECT_FALSE(fs::exists(folder / "manifest.json"));
  fs::remove_all(folder);
  fs::create_directories(folder);
  write(folder / "manifest.json.part-abcdef", "of a run that was killed at its start");
  EXPECT_EQ(run(folder, made_description("coco")), "");
}

TEST_F(SetFiles, LinksAreNoFoldersOfTheSet) {
  const fs::path folder = root_ / "set", elsewhere = root_ / "elsewhere";
  for (const char* name : {"train", "train/000000", "train/000001/rgb", "models"}) {
    ASSERT_EQ(run(folder, made_description("bop")), "");
    fs::create_directories(elsewhere);
    fs::remove_all(folder / name);
    fs::create_directory_symlink(elsewhere, folder / name);
    const std::string said = run(folder, made_description("bop"));
    EXPECT_NE(said.find(std::string(name) + " is a symbolic link and not a folder of the data set"),
              std::string::npos)
        << said;
    EXPECT_TRUE(fs::is_empty(elsewhere)) << name;
    fs::remove_all(folder);
  }
}

TEST_F(SetFiles, TemporariesOfKilledRunsAreRemoved) {
  const fs::path folder = root_ / "set";
  ASSERT_EQ(run(folder, made_description("bop")), "");
  const auto add = [&] {
    for (const char* name : {"README.md", "train/000001/scene_gt.json", "train/000000/mask_visib/x.png",
                             "models/models_info.json"})
      write(folder / (std::string(name) + ".part-abcdef"), "half");
  };
  const auto count = [&] {
    int found = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      found += entry.path().string().find(".part-") != std::string::npos;
    return found;
  };
  add();
  ASSERT_EQ(run(folder, made_description("bop")), "");  // all images are there
  EXPECT_EQ(count(), 0);
  add();
  fs::remove(folder / "train/000000/rgb/000000.png");
  ASSERT_EQ(run(folder, made_description("bop")), "");
  EXPECT_EQ(existing_, kImages - 1);
  EXPECT_EQ(count(), 0);
}

TEST_F(SetFiles, TextsArePrintableFromTheStart) {
  Description description = made_description("coco");
  description.license = "caf\xe9\n";
  description.command = std::string(9000, 'x') + "\xff";
  description.instances[0].name = "\x1b[31m\xc3";
  description.keypoints[0].name = "\xfe";
  const auto written = as_written(description);
  ASSERT_TRUE(written.ok());
  EXPECT_EQ(written->license, "caf??");
  EXPECT_EQ(written->command.size(), 4096u);
  EXPECT_EQ(written->instances[0].name, "?[31m?");
  EXPECT_EQ(to_json(*written), to_json(description));
  ASSERT_EQ(run(root_ / "set", description), "");
  // `fire3dv join` has the description from the file.
  const auto joined = read_description(root_ / "set");
  ASSERT_TRUE(joined.ok());
  EXPECT_EQ(joined->license, written->license);
  EXPECT_EQ(joined->keypoints[0].name, written->keypoints[0].name);
  EXPECT_NE(text_of(root_ / "set" / "annotations.json").find("caf??"), std::string::npos);
}

TEST_F(SetFiles, DepthWarningsAreOfFormatsWith16Bits) {
  Description description = made_description("bop");
  description.depth_unit_mm = 0.01;  // to 0.66 m
  description.label_alpha = 0.25;
  ASSERT_EQ(run(root_ / "bop", description), "");
  const std::string bop = text_of(root_ / "bop" / "README.md");
  EXPECT_NE(bop.find("range of the depth images (0 there; a larger --depth-scale reaches farther)"),
            std::string::npos)
      << bop;
  EXPECT_NE(bop.find("more alpha than 0.25 "), std::string::npos) << bop;
  EXPECT_NE(text_of(root_ / "bop" / "frames.jsonl").find("\"px_count_valid\":0"), std::string::npos);
  description.format = "coco";
  ASSERT_EQ(run(root_ / "coco", description), "");
  EXPECT_EQ(text_of(root_ / "coco" / "README.md").find("range of the depth"), std::string::npos);
  EXPECT_NE(text_of(root_ / "coco" / "frames.jsonl").find("\"px_count_valid\":4"), std::string::npos);
  description.format = "c3vd";
  ASSERT_EQ(run(root_ / "c3vd", description), "");
  EXPECT_NE(text_of(root_ / "c3vd" / "README.md").find("depth of C3VD ends at 100 mm"), std::string::npos);
}

}  // namespace
}  // namespace fire3dv::dataset
