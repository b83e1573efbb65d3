// Test of the files of the import: long searches stop, and the topics of a folder are bounded.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "protocol/import/files/message_source.h"
#include "protocol/import/files/sqlite_library.h"
#include "protocol/import/stream_writer.h"

namespace fire3dv::imported {
namespace {

class ImportSources : public testing::Test {
 protected:
  ImportSources() {
    std::string name = testing::TempDir() + "import_sources_XXXXXX";
    folder_ = ::mkdtemp(name.data());
  }
  ~ImportSources() override { std::filesystem::remove_all(folder_); }

  // Bag with so many topics and messages.
  std::filesystem::path bag(const SqliteLibrary& sqlite, const std::string& name, int topics, int messages) {
    constexpr int kReadWriteCreate = 6;
    const std::filesystem::path path = folder_ / name;
    const std::string rows = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n WHERE i<";
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite.sqlite3_open_v2(path.c_str(), &database, kReadWriteCreate, nullptr), kSqliteOk);
    for (const std::string& sql :
         {std::string("CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format)"),
          std::string("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data)"),
          rows + std::to_string(topics) + ") INSERT INTO topics SELECT i, '" + name +
              "'||i, 'a', 'cdr' FROM n",
          rows + std::to_string(messages) + ") INSERT INTO messages SELECT i, 1, i, x'00' FROM n"}) {
      sqlite3_stmt* statement = nullptr;
      EXPECT_EQ(sqlite.sqlite3_prepare_v2(database, sql.c_str(), -1, &statement, nullptr), kSqliteOk);
      EXPECT_EQ(sqlite.sqlite3_step(statement), kSqliteDone);
      sqlite.sqlite3_finalize(statement);
    }
    sqlite.sqlite3_close_v2(database);
    return path;
  }

  std::filesystem::path folder_;
};

TEST_F(ImportSources, SqliteStops) {
  const auto sqlite = load_sqlite();
  ASSERT_TRUE(sqlite.ok()) << sqlite.error().message;
  const std::filesystem::path path = bag(**sqlite, "bag.db3", 1, 50'000);
  EXPECT_TRUE(open_messages(path).ok());
  EXPECT_TRUE(open_messages(path, [] { return false; }).ok());
  const auto stopped = open_messages(path, [] { return true; });
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().message, "stopped");
}

TEST_F(ImportSources, TopicsOfAFolder) {
  const auto sqlite = load_sqlite();
  ASSERT_TRUE(sqlite.ok()) << sqlite.error().message;
  bag(**sqlite, "a.db3", 40'000, 1);
  EXPECT_TRUE(open_messages(folder_).ok());
  bag(**sqlite, "b.db3", 40'000, 1);
  const auto many = open_messages(folder_);
  ASSERT_FALSE(many.ok());
  EXPECT_NE(many.error().message.find("has more than 65536 topics"), std::string::npos);
}

TEST_F(ImportSources, McapStops) {
  const std::string path = folder_ / "own.mcap";
  auto sink = record::create_sink(path);
  ASSERT_TRUE(sink.ok());
  wire::StreamDescription description;
  description.node_names = {"a"};
  auto writer = StreamWriter::open(std::move(*sink), description, 0);
  ASSERT_TRUE(writer.ok());
  ASSERT_TRUE(writer->write(1, std::vector<wire::Affine3x4>(1)).ok());
  ASSERT_TRUE(writer->finish().ok());
  bool stops = false;
  auto messages = open_messages(path, [&] { return stops; });
  ASSERT_TRUE(messages.ok());
  for (const bool each : {false, true}) {
    stops = each;
    ASSERT_TRUE((*messages)->rewind({}).ok());  // all messages are of other topics
    const auto message = (*messages)->next();
    ASSERT_EQ(message.ok(), !each);
    if (each) {
      EXPECT_EQ(message.error().message, "stopped");
    }
  }
}

}  // namespace
}  // namespace fire3dv::imported
