// Test of conversion records: a cached conversion is valid while no source file and no result has changed.
#include "renderer/scene/cache_files.h"

#include <gtest/gtest.h>

#include <functional>

#include "convert/model.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::scene {
namespace {

constexpr int64_t kLater = INT64_MAX;  // later than all writes

class ConversionRecords : public testing::Test {
 protected:
  bool still_holds() const {
    const auto file = folder_.write("record", text_of(record_of(result_, sources(), kLater)));
    const auto record = read_conversion_record(file);
    EXPECT_TRUE(record.ok());
    change_();
    return record && holds(*record, result_);
  }
  test::ScratchFolder folder_;
  std::filesystem::path result_ = folder_.write("scene.glb", std::string_view("glTF"));
  std::filesystem::path source_ = folder_.write("a name\nof two lines\\ \xff", std::string_view("first"));
  std::filesystem::path missing_ = folder_.path() / "missing.stl";
  std::vector<ConversionRecord::Source> sources() const {
    return {{source_, stamp_of(source_)}, {missing_, stamp_of(missing_)}};
  }
  std::function<void()> change_ = [] {};
};

TEST_F(ConversionRecords, HoldWhileNothingChanges) {
  EXPECT_TRUE(still_holds());
}

TEST_F(ConversionRecords, EndWhenSourceIsWritten) {
  change_ = [&] { folder_.write(source_.filename(), std::string_view("other")); };  // of the same size
  EXPECT_FALSE(still_holds());
}

TEST_F(ConversionRecords, ReplacedSourceEndsRecord) {
  change_ = [&] {
    const auto time = std::filesystem::last_write_time(source_);
    const auto other = folder_.write("other", std::string_view("other"));
    std::filesystem::last_write_time(other, time);
    std::filesystem::rename(other, source_);
  };
  EXPECT_FALSE(still_holds());
}

TEST_F(ConversionRecords, SourceChangeEndsRecord) {
  change_ = [&] { folder_.write("missing.stl", std::string_view("there")); };
  EXPECT_FALSE(still_holds());
  change_ = [&] { std::filesystem::remove(source_); };
  EXPECT_FALSE(still_holds());
}

TEST_F(ConversionRecords, OtherResultEndsRecord) {
  change_ = [&] {
    const auto other = folder_.write("other.glb", std::string_view("glTF"));
    std::filesystem::rename(other, result_);
  };
  EXPECT_FALSE(still_holds());
  change_ = [&] { std::filesystem::remove(result_); };
  EXPECT_FALSE(still_holds());
}

TEST_F(ConversionRecords, ConcurrentWriteEndsRecord) {
  const int64_t begun_ns = stamp_of(source_).modified_ns;
  EXPECT_FALSE(holds(record_of(result_, sources(), begun_ns), result_));
  EXPECT_TRUE(holds(record_of(result_, sources(), kLater), result_));
}

// A folder that replaces another one contains files with old time stamps.
TEST_F(ConversionRecords, ReplacedFolderEndsRecord) {
  for (const char* folder : {"meshes", "other"}) {
    std::filesystem::create_directory(folder_.path() / folder);
    folder_.write(std::filesystem::path(folder) / "part.stl", std::string_view(folder));
  }
  convert::Sources sources;
  sources.add(folder_.path() / "meshes/part.stl");
  std::filesystem::rename(folder_.path() / "meshes", folder_.path() / "before");
  std::filesystem::rename(folder_.path() / "other", folder_.path() / "meshes");
  sources.add(folder_.path() / "meshes/part.stl");  // the second request keeps the stamp of the first
  EXPECT_EQ(sources.all().size(), 1u);
  EXPECT_FALSE(holds(record_of(result_, sources.all(), kLater), result_));
}

TEST_F(ConversionRecords, KeepWarningsAndNames) {
  ConversionRecord record = record_of(result_, sources(), kLater);
  record.warnings = {"one \\n of them", "and\nanother"};
  const auto back = read_conversion_record(folder_.write("record", text_of(record)));
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back->warnings, record.warnings);
  ASSERT_EQ(back->sources.size(), 2u);
  EXPECT_EQ(back->sources[0].file, source_);
  EXPECT_EQ(back->sources[1].stamp, FileStamp{});
}

TEST_F(ConversionRecords, AreRefusedWhenDamaged) {
  const std::string whole = text_of(record_of(result_, sources(), kLater));
  for (size_t length = 0; length + 1 < whole.size(); ++length) {
    const auto record =
        read_conversion_record(folder_.write("record", std::string_view(whole).substr(0, length)));
    EXPECT_FALSE(record.ok()) << length << " bytes of " << whole.size();
  }
  for (const std::string text : {"fire3dv conversion 1\nresult 1 x\nend\n",
                                 "fire3dv conversion 1\nwhat\nend\n", "fire3dv conversion 2\nend\n", "\n"}) {
    EXPECT_FALSE(read_conversion_record(folder_.write("record", std::string_view(text))).ok()) << text;
  }
}

}  // namespace
}  // namespace fire3dv::scene
