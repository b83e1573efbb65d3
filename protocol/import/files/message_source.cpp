#include "protocol/import/files/message_source.h"

#include <algorithm>
#include <map>
#include <system_error>
#include <tuple>
#include <utility>

#include "base/files.h"
#include "base/plural.h"
#include "base/text.h"
#include "protocol/import/files/mcap_messages.h"
#include "protocol/import/files/sqlite_messages.h"

namespace fire3dv::imported {
namespace {

constexpr size_t kMaxFiles = 10'000;  // of a folder

Result<std::unique_ptr<MessageSource>> open_file(const std::filesystem::path& path,
                                                 const ShouldStop& should_stop) {
  return is_sqlite_file(path) ? open_sqlite_messages(path, should_stop)
                              : open_mcap_messages(path.string(), should_stop);
}

// Files of a folder, one after the other. One is open at a time.
class FolderMessages final : public MessageSource {
 public:
  static Result<std::unique_ptr<MessageSource>> open(const std::filesystem::path& folder,
                                                     std::vector<std::filesystem::path> files,
                                                     const ShouldStop& should_stop) {
    auto messages = std::make_unique<FolderMessages>(folder.string(), std::move(files), should_stop);
    for (size_t file = 0; file < messages->files_.size(); ++file)
      if (Result<void> opened = messages->open_part(file); !opened) return opened.error();
    return std::unique_ptr<MessageSource>(std::move(messages));
  }
  FolderMessages(std::string name, std::vector<std::filesystem::path> files, ShouldStop should_stop)
      : name_(std::move(name)), files_(std::move(files)), should_stop_(std::move(should_stop)) {}

  const std::string& name() const override { return name_; }
  const std::vector<Topic>& topics() const override { return topics_; }
  Result<void> rewind(const std::vector<size_t>& topics) override {
    counts_.assign(topics_.size(), 0);
    is_wanted_.assign(topics_.size(), false);
    for (const size_t topic : topics) is_wanted_[topic] = true;
    return begin_part(0);
  }
  Result<std::optional<SourceMessage>> next() override {
    while (true) {
      Result<std::optional<SourceMessage>> message = part_->next();
      if (!message) return message;
      if (*message) {
        (*message)->topic = topics_of_part_[(*message)->topic];
        (*message)->number = ++counts_[(*message)->topic];
        return message;
      }
      take_part_warnings();
      if (file_ + 1 == files_.size()) return message;
      if (Result<void> begun = begin_part(file_ + 1); !begun) return begun.error();
    }
  }
  double progress() const override {
    return (static_cast<double>(file_) + part_->progress()) / static_cast<double>(files_.size());
  }
  std::vector<std::string> take_warnings() override {
    take_part_warnings();
    return std::exchange(warnings_, {});
  }

 private:
  Result<void> begin_part(size_t file) {
    if (Result<void> opened = open_part(file); !opened) return opened;
    std::vector<size_t> wanted;
    for (size_t i = 0; i < topics_of_part_.size(); ++i)
      if (is_wanted_[topics_of_part_[i]]) wanted.push_back(i);
    return part_->rewind(wanted);
  }
  Result<void> open_part(size_t file) {
    auto part = open_file(files_[file], should_stop_);
    if (!part) return part.error();
    part_ = std::move(*part);
    file_ = file;
    topics_of_part_.clear();
    for (const Topic& topic : part_->topics()) {
      const auto [at, is_new] = index_.try_emplace({topic.name, topic.type, topic.encoding}, topics_.size());
      if (is_new) topics_.push_back(topic);
      topics_of_part_.push_back(at->second);
    }
    if (topics_.size() > kMaxTopics)
      return Error{quote(name_) + " has more than 65536 topics: name one of its files"};
    counts_.resize(topics_.size());
    is_wanted_.resize(topics_.size());
    return {};
  }
  void take_part_warnings() {
    for (std::string& text : part_->take_warnings()) warnings_.push_back(std::move(text));
  }

  std::string name_;
  std::vector<std::filesystem::path> files_;
  ShouldStop should_stop_;
  std::vector<Topic> topics_;
  std::map<std::tuple<std::string, std::string, std::string>, size_t> index_;  // of topics_
  std::vector<bool> is_wanted_;
  std::vector<uint64_t> counts_;
  std::vector<std::string> warnings_;
  std::unique_ptr<MessageSource> part_;
  std::vector<size_t> topics_of_part_;
  size_t file_ = 0;
};

bool is_message_file(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".mcap" || extension == ".db3";
}

// Parts of a bag end with a number without leading zeros: bag_9 comes before bag_10.
bool comes_before(const std::filesystem::path& a, const std::filesystem::path& b) {
  const std::string first = a.filename().string(), second = b.filename().string();
  return std::tuple(first.size(), first) < std::tuple(second.size(), second);
}

}  // namespace

Result<std::unique_ptr<MessageSource>> open_messages(const std::filesystem::path& path,
                                                     const ShouldStop& should_stop) {
  std::error_code fault;
  if (!std::filesystem::is_directory(path, fault)) return open_file(path, should_stop);
  std::vector<std::filesystem::path> files;
  for (std::filesystem::directory_iterator at(path, fault), end; !fault && at != end; at.increment(fault)) {
    if (!is_message_file(at->path())) continue;
    if (files.size() == kMaxFiles)
      return Error{quote(path.string()) + " has more than " + counted(kMaxFiles, "recording") +
                   ": name one of them"};
    files.push_back(at->path());
  }
  if (fault) return Error{quote(path.string()) + " cannot be read: " + fault.message()};
  if (files.empty())
    return Error{quote(path.string()) +
                 " has no .mcap or .db3 file: name a recording, or the folder of a bag or "
                 "of a LeRobot data set, which has meta/info.json"};
  std::sort(files.begin(), files.end(), comes_before);
  return FolderMessages::open(path, std::move(files), should_stop);
}

}  // namespace fire3dv::imported
