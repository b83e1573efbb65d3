#include "renderer/verify/set_check.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/plural.h"
#include "base/process/start_thread.h"
#include "renderer/offline/frame_folder.h"
#include "renderer/verify/file_difference.h"

namespace fire3dv::verify {
namespace {

constexpr unsigned kMaxWorkers = 16;

// Lists all lines, whatever became of the files.
class AllListed final : public offline::FrameFormat {
 public:
  Result<offline::EncodedFrame> encode(const sinks::FrameImage&) override {
    return Error{"no image is written"};
  }
  bool is_complete(const std::filesystem::path&, uint64_t, const nlohmann::json&, bool) const override {
    return true;
  }
  Result<offline::EncodedFrame> load(const std::filesystem::path&, uint64_t, const std::string&,
                                     const offline::Manifest&) const override {
    return Error{"no image is copied"};
  }
};

// Times and number of images, without the settings, which the provenance has.
std::optional<std::string> schedule_difference(offline::Manifest there, offline::Manifest here) {
  there.settings.clear();
  here.settings.clear();
  return offline::difference(there, here, false);
}

// The first names of a list.
std::string shortened_list(const std::vector<std::string>& names) {
  constexpr size_t kMaxListed = 8;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kMaxListed); ++i) text += (i ? ", " : "") + names[i];
  return text + (names.size() > kMaxListed ? " and " + std::to_string(names.size() - kMaxListed) + " more"
                                           : std::string());
}

}  // namespace

SetCheck::SetCheck(std::filesystem::path folder, offline::Manifest manifest, sinks::RunProvenance provenance,
                   std::optional<uint64_t> sample)
    : folder_(std::move(folder)),
      manifest_(std::move(manifest)),
      provenance_(std::move(provenance)),
      sample_(sample) {}

SetCheck::~SetCheck() {
  end_threads();
}

Result<bool> SetCheck::begin(const offline::Manifest& manifest, const sinks::RunProvenance& provenance,
                             std::shared_ptr<offline::FrameFormat> format) {
  run_difference_ = run_difference(provenance_, provenance, false);
  if (!run_difference_) run_difference_ = schedule_difference(manifest_, manifest);
  if (run_difference_) return false;
  format_ = format ? std::move(format) : std::make_shared<offline::PngFrames>();
  auto lines = offline::listed_frames(folder_, manifest_, AllListed());
  if (!lines) return lines.error();
  lines_ = std::move(*lines);
  const offline::Part part = manifest_.part();
  const uint64_t count = std::min(sample_.value_or(part.frames), part.frames);
  // Evenly spread, at the middle of equal intervals.
  for (uint64_t i = 0; i < count; ++i) wanted_.insert(part.first + (2 * i + 1) * part.frames / (2 * count));
  if (wanted_.empty()) unchecked_ = folder_.string() + ": it has no image";
  if (unchecked_) return false;
  const unsigned workers = std::clamp(std::thread::hardware_concurrency(), 1u, kMaxWorkers);
  for (unsigned i = 0; i < workers; ++i) workers_.push_back(start_thread("image check", [this] { work(); }));
  return true;
}

Result<void> SetCheck::consume(sinks::FrameImage&& image) {
  std::unique_lock lock(mutex_);
  if (!drawn_provenance_) drawn_provenance_ = image.run_provenance;
  changed_.wait(lock, [&] { return queue_.size() < workers_.size() + 2; });
  queue_.push_back(std::move(image));
  changed_.notify_all();
  return {};
}

void SetCheck::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return !queue_.empty() || closing_; });
    if (queue_.empty()) return;
    const sinks::FrameImage image = std::move(queue_.front());
    queue_.pop_front();
    changed_.notify_all();
    lock.unlock();
    auto difference = check(image);
    lock.lock();
    if (difference)
      differences_.emplace(image.frame_index, std::move(*difference));
    else
      ++identical_;
  }
}

// The files, then the line.
std::optional<std::string> SetCheck::check(const sinks::FrameImage& image) {
  const auto number = "image " + std::to_string(image.frame_index);
  auto drawn = format_->encode(image);
  if (!drawn) return number + ": " + drawn.error().message;
  {
    const std::lock_guard lock(mutex_);
    drawn_lines_.emplace(image.frame_index, drawn->line);
  }
  const auto line = lines_.find(image.frame_index);
  if (line == lines_.end())
    return (folder_ / offline::kFrameListName).string() + ": " + number + " is not in the list";
  for (const offline::FolderFile& file : drawn->files) {
    auto stored = format_->read_file(folder_, image.frame_index, file.name);
    if (!stored) return stored.error().message;
    if (auto difference = file_difference(file.name, *stored, file.bytes))
      return (folder_ / file.name).string() + ": " + *difference;
  }
  if (auto difference = line_difference(line->second, drawn->line))
    return (folder_ / offline::kFrameListName).string() + ": " + number + ": " + *difference;
  return std::nullopt;
}

void SetCheck::end_threads() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
    changed_.notify_all();
  }
  for (std::thread& worker : workers_) worker.join();
  workers_.clear();
}

// Lines of this run. The sizes of files, and the lines of images that are not drawn again, are those of the
// folder. Error: the lists cannot be made.
Result<SetCheck::Files> SetCheck::make_lists() const {
  offline::FrameLines lines;
  for (const auto& [image, stored] : lines_) {
    const auto drawn = drawn_lines_.find(image);
    const auto before = nlohmann::json::parse(stored, nullptr, false);
    if (!format_->is_complete(folder_, image, before, true))
      return Error{"the line of image " + std::to_string(image) + " is damaged"};
    if (drawn == drawn_lines_.end()) {
      lines.emplace(image, stored);
      continue;
    }
    auto line = nlohmann::ordered_json::parse(drawn->second);
    if (const auto bytes = before.find("bytes"); bytes != before.end()) line["bytes"] = *bytes;
    lines.emplace(image, line.dump());
  }
  if (const uint64_t missing = manifest_.images() - lines.size(); missing != 0)
    return Error{counted(missing, "image") + (missing == 1 ? " is" : " are") + " missing"};
  return format_->last_files(lines);
}

void SetCheck::compare(const Files& made) {
  std::vector<std::string> same;
  for (const offline::FolderFile& file : made) {
    const auto stored = format_->read_run_file(folder_, file.name);
    if (!stored)
      file_differences_.push_back(stored.error().message);
    else if (const auto difference = file_difference(file.name, *stored, file.bytes))
      file_differences_.push_back((folder_ / file.name).string() + ": " + *difference);
    else
      same.push_back(file.name);
  }
  if (!same.empty()) notes_.push_back("identical, too: " + shortened_list(same));
}

// After the images.
void SetCheck::check_run_files() {
  Files files = format_->first_files();
  if (files.empty()) return;
  if (manifest_.shards > 1) {
    notes_.push_back("not compared: files of the whole set, which fire3dv join writes");
  } else if (auto lists = make_lists()) {
    std::move(lists->begin(), lists->end(), std::back_inserter(files));
  } else {
    notes_.push_back("not compared: files of the whole set, since " + lists.error().message);
  }
  compare(files);
  if (drawn_lines_.size() < lines_.size() && manifest_.shards == 1)
    notes_.push_back("labels of images that are not drawn again are those of " +
                     std::string(offline::kFrameListName));
  if (const auto pages = format_->page_names(); manifest_.shards == 1 && !pages.empty())
    notes_.push_back("not compared: " + shortened_list(pages));
}

Result<void> SetCheck::finish() {
  end_threads();
  check_run_files();
  return {};
}

Outcome SetCheck::outcome() {
  end_threads();
  Outcome outcome;
  outcome.identical = identical_;
  outcome.unchecked = unchecked_;
  if (run_difference_) outcome.differences.push_back(folder_.string() + ": " + *run_difference_);
  for (const auto& [image, text] : differences_) outcome.differences.push_back(text);
  outcome.file_differences = file_differences_;
  outcome.notes = notes_;
  return outcome;
}

}  // namespace fire3dv::verify
