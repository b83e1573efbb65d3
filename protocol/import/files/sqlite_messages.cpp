#include "protocol/import/files/sqlite_messages.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "protocol/import/files/sqlite_library.h"

namespace fire3dv::imported {
namespace {

constexpr int kMaxValueBytes = 64 << 20;
constexpr int kMaxSchemaBytes = 1 << 20;       // of a value in the schema and in the table of topics
constexpr size_t kMaxTopicBytes = 64 << 20;    // of all topics
constexpr int kInstructionsPerCheck = 10'000;  // of SQLite's program: below a millisecond

class Database {
 public:
  static Result<std::unique_ptr<Database>> open(const std::filesystem::path& path, ShouldStop should_stop) {
    const Result<const SqliteLibrary*> library = load_sqlite();
    if (!library) return library.error();
    auto database = std::make_unique<Database>(**library, path.string(), std::move(should_stop));
    // An absolute path: some relative ones have a meaning of their own.
    const std::string file = std::filesystem::absolute(path).string();
    if ((*library)->sqlite3_open_v2(file.c_str(), &database->database_, kSqliteOpenReadOnly, nullptr) !=
        kSqliteOk)
      return database->fault();
    database->limit_values(kMaxSchemaBytes);
    if (database->should_stop_)
      (*library)->sqlite3_progress_handler(database->database_, kInstructionsPerCheck, check_stop,
                                           database.get());
    return database;
  }
  Database(const SqliteLibrary& library, std::string name, ShouldStop should_stop)
      : library_(library), name_(std::move(name)), should_stop_(std::move(should_stop)) {}
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  ~Database() {
    finish();
    if (database_) library_.sqlite3_close_v2(database_);
  }

  // Begins a statement, which replaces the one before.
  Result<void> begin(const std::string& sql) {
    finish();
    const int done = library_.sqlite3_prepare_v2(database_, sql.c_str(), -1, &statement_, nullptr);
    return done == kSqliteOk ? Result<void>() : fault();
  }
  // False at the end.
  Result<bool> step() {
    const int done = library_.sqlite3_step(statement_);
    if (done == kSqliteRow || done == kSqliteDone) return done == kSqliteRow;
    return fault();
  }
  void limit_values(int bytes) { (void)library_.sqlite3_limit(database_, kSqliteLimitLength, bytes); }
  int64_t number(int column) { return library_.sqlite3_column_int64(statement_, column); }
  std::string text(int column) {
    const auto* const begin = library_.sqlite3_column_text(statement_, column);
    const int size = library_.sqlite3_column_bytes(statement_, column);
    return begin ? std::string(reinterpret_cast<const char*>(begin), static_cast<size_t>(size))
                 : std::string();
  }
  // Valid until the next call.
  std::span<const std::byte> bytes(int column) {
    const auto* const begin = static_cast<const std::byte*>(library_.sqlite3_column_blob(statement_, column));
    const int size = library_.sqlite3_column_bytes(statement_, column);
    return {begin, begin ? static_cast<size_t>(size) : 0};
  }
  Error fault() const {
    if (was_stopped_) return Error{"stopped"};
    return Error{quote(name_) +
                 " cannot be read as a bag: " + printable_text(library_.sqlite3_errmsg(database_), 200)};
  }
  const std::string& name() const { return name_; }

 private:
  static int check_stop(void* argument) {
    Database& database = *static_cast<Database*>(argument);
    database.was_stopped_ = database.was_stopped_ || database.should_stop_();
    return database.was_stopped_ ? 1 : 0;
  }
  void finish() {
    if (statement_) library_.sqlite3_finalize(std::exchange(statement_, nullptr));
  }

  const SqliteLibrary& library_;
  const std::string name_;
  const ShouldStop should_stop_;
  bool was_stopped_ = false;
  sqlite3* database_ = nullptr;
  sqlite3_stmt* statement_ = nullptr;
};

class SqliteMessages final : public MessageSource {
 public:
  explicit SqliteMessages(std::unique_ptr<Database> database) : database_(std::move(database)) {}

  Result<void> open_tables();

  const std::string& name() const override { return database_->name(); }
  const std::vector<Topic>& topics() const override { return topics_; }
  Result<void> rewind(const std::vector<size_t>& topics) override {
    counts_.assign(topics_.size(), 0);
    std::vector<bool> is_wanted(topics_.size());
    for (const size_t topic : topics) is_wanted[topic] = true;
    std::string ids;
    for (const auto& [id, topic] : topic_of_id_)
      if (is_wanted[topic]) ids += (ids.empty() ? "" : ",") + std::to_string(id);
    newest_ns_ = first_ns_;
    return database_->begin("SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN (" + ids +
                            ") ORDER BY timestamp, id");
  }
  Result<std::optional<SourceMessage>> next() override {
    const Result<bool> row = database_->step();
    if (!row) return row.error();
    if (!*row) return std::optional<SourceMessage>();
    const size_t topic = topic_of_id_.at(database_->number(0));
    newest_ns_ = database_->number(1);
    return std::optional(SourceMessage{topic, static_cast<uint64_t>(std::max<int64_t>(newest_ns_, 0)),
                                       ++counts_[topic], database_->bytes(2)});
  }
  double progress() const override {
    const double length_ns = static_cast<double>(last_ns_) - static_cast<double>(first_ns_);
    if (!(length_ns > 0)) return 1;
    return std::clamp((static_cast<double>(newest_ns_) - static_cast<double>(first_ns_)) / length_ns, 0.0,
                      1.0);
  }
  std::vector<std::string> take_warnings() override { return {}; }

 private:
  Result<void> check_tables();
  Result<void> check_table(const std::string& table);
  Result<void> read_topics();

  std::unique_ptr<Database> database_;
  std::vector<Topic> topics_;
  std::map<int64_t, size_t> topic_of_id_;
  std::vector<uint64_t> counts_;
  int64_t first_ns_ = 0, last_ns_ = 0, newest_ns_ = 0;
};

// The schema may be of anybody: views, virtual tables and computed columns could compute without end.
Result<void> SqliteMessages::check_tables() {
  if (Result<void> begun = database_->begin("PRAGMA trusted_schema=OFF"); !begun) return begun;
  if (Result<bool> done = database_->step(); !done) return done.error();
  if (Result<void> begun =
          database_->begin("SELECT count(*) FROM sqlite_master WHERE type='table' AND name IN "
                           "('topics','messages') AND sql LIKE 'CREATE TABLE%'");
      !begun)
    return begun;
  const Result<bool> row = database_->step();
  if (!row) return row.error();
  if (database_->number(0) != 2)
    return Error{quote(name()) + " is no bag of ROS 2: it has no tables topics and messages"};
  if (Result<void> checked = check_table("topics"); !checked) return checked;
  return check_table("messages");
}

Result<void> SqliteMessages::check_table(const std::string& table) {
  // Without rows where the library is older than 3.37.
  if (Result<void> begun = database_->begin("PRAGMA table_list(" + table + ")"); !begun) return begun;
  while (true) {
    const Result<bool> row = database_->step();
    if (!row) return row.error();
    if (!*row) break;
    if (database_->text(2) != "table")
      return Error{quote(name()) + " is no bag of ROS 2: " + table + " is no plain table"};
  }
  if (Result<void> begun = database_->begin("PRAGMA table_xinfo(" + table + ")"); !begun) return begun;
  while (true) {
    const Result<bool> column = database_->step();
    if (!column) return column.error();
    if (!*column) return {};
    if (database_->number(6) != 0)
      return Error{quote(name()) + " is no bag of ROS 2: column " + quote(database_->text(1)) + " of table " +
                   table + " is computed"};
  }
}

Result<void> SqliteMessages::read_topics() {
  if (Result<void> begun = database_->begin("SELECT id, name, type, serialization_format FROM topics");
      !begun)
    return begun;
  size_t bytes = 0;
  while (true) {
    const Result<bool> next = database_->step();
    if (!next) return next.error();
    if (!*next) return {};
    if (topics_.size() == kMaxTopics) return Error{quote(name()) + " has more than 65536 topics"};
    topic_of_id_[database_->number(0)] = topics_.size();
    topics_.push_back({database_->text(1), database_->text(2), database_->text(3)});
    const Topic& topic = topics_.back();
    bytes += topic.name.size() + topic.type.size() + topic.encoding.size();
    if (bytes > kMaxTopicBytes) return Error{quote(name()) + ": the names of its topics are too long"};
  }
}

Result<void> SqliteMessages::open_tables() {
  if (Result<void> checked = check_tables(); !checked) return checked;
  if (Result<void> read = read_topics(); !read) return read;
  database_->limit_values(kMaxValueBytes);
  if (Result<void> begun = database_->begin("SELECT min(timestamp), max(timestamp) FROM messages"); !begun)
    return begun;
  if (const Result<bool> range = database_->step(); !range) return range.error();
  first_ns_ = database_->number(0);
  last_ns_ = database_->number(1);
  return {};
}

}  // namespace

bool is_sqlite_file(const std::filesystem::path& path) {
  constexpr std::string_view kMagic("SQLite format 3\0", 16);
  std::array<char, kMagic.size()> begin{};
  std::error_code fault;
  if (!std::filesystem::is_regular_file(path, fault)) return false;
  std::ifstream(path, std::ios::binary).read(begin.data(), begin.size());
  return std::string_view(begin.data(), begin.size()) == kMagic;
}

Result<std::unique_ptr<MessageSource>> open_sqlite_messages(const std::filesystem::path& path,
                                                            const ShouldStop& should_stop) {
  auto database = Database::open(path, should_stop);
  if (!database) return database.error();
  auto messages = std::make_unique<SqliteMessages>(std::move(*database));
  if (Result<void> read = messages->open_tables(); !read) return read.error();
  return std::unique_ptr<MessageSource>(std::move(messages));
}

}  // namespace fire3dv::imported
