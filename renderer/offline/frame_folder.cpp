#include "renderer/offline/frame_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/files.h"
#include "base/process/start_thread.h"

namespace fire3dv::offline {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kMaxWorkers = 16;
constexpr int kMaxNesting = 16;                            // of a line's JSON; copies of it are recursive
constexpr uint64_t kMaxQueuedBytes = uint64_t{512} << 20;  // of images that wait for an encoder

// Line reader for an untrusted file: neither a pipe nor an endless line blocks it.
class ListLines {
 public:
  // Returns false if the file is missing or not a regular file.
  bool open(const fs::path& path) {
    file_ = UniqueFd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    struct stat about {};
    return file_ && ::fstat(file_.get(), &about) == 0 && S_ISREG(about.st_mode);
  }
  // Returns false at the end; an unterminated last line is dropped.
  bool next(std::string& line) {
    line.clear();
    for (;;) {
      const auto end = std::find(buffer_.begin() + at_, buffer_.begin() + have_, '\n');
      line.append(buffer_.begin() + at_, end);
      if (line.size() > kMaxLineBytes) return too_long_ = true, false;
      at_ = end - buffer_.begin();
      if (at_ < have_) return ++at_, true;
      ssize_t got = 0;
      do got = ::read(file_.get(), buffer_.data(), buffer_.size());
      while (got < 0 && errno == EINTR);
      if (got <= 0) return false;
      at_ = 0;
      have_ = got;
    }
  }
  bool too_long() const { return too_long_; }

 private:
  UniqueFd file_;
  std::array<char, 1 << 16> buffer_{};
  ssize_t at_ = 0, have_ = 0;
  bool too_long_ = false;
};

bool is_nested_too_deep(const std::string& line) {
  int depth = 0;
  bool is_in_string = false;
  for (size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (is_in_string) {
      if (c == '\\') ++i;
      if (c == '"') is_in_string = false;
    } else if (c == '"') {
      is_in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxNesting) return true;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return false;
}

// Without pixels.
sinks::FrameImage numbered(uint64_t frame) {
  sinks::FrameImage image;
  image.frame_index = frame;
  return image;
}

// First entry of a folder without a manifest that the run could overwrite or be mixed with. The temporary
// manifest of a run that was killed at its start is not one.
std::string foreign_entry(const fs::path& folder, const FrameFormat& format) {
  std::error_code fault;
  for (fs::directory_iterator entry(folder, fault), end; !fault && entry != end; entry.increment(fault)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with(std::string(kManifestName) + std::string(base::kTemporaryMark))) continue;
    const bool is_frame = name.starts_with("frame_") && name.ends_with(".png");
    if (format.needs_empty_folder() || is_frame || name == kFrameListName) return name;
  }
  return {};
}

Error in_the_way(const fs::path& folder, const std::string& why) {
  return Error{folder.string() + " holds frames of another run (" + why +
               "): name another folder, or remove this one"};
}

}  // namespace

Result<FrameLines> listed_frames(const fs::path& folder, const Manifest& manifest,
                                 const FrameFormat& format) {
  FrameLines frames;
  const Error strange{(folder / kFrameListName).string() + " is not what fire3dv render writes: remove " +
                      folder.string()};
  std::error_code fault;
  if (!fs::exists(folder / kFrameListName, fault) && !fault) return frames;
  ListLines list;
  if (!list.open(folder / kFrameListName)) return strange;
  const Part part = manifest.part();
  const bool is_packed = format.is_packed(folder);
  // An unterminated line is the one during which the run was killed.
  for (std::string line; list.next(line);) {
    if (is_nested_too_deep(line)) continue;
    const auto json = nlohmann::json::parse(line, nullptr, false);
    const auto number = json.is_object() ? json.find("frame") : json.end();
    if (!json.is_object() || number == json.end() || !number->is_number_unsigned()) continue;
    const auto frame = number->get<uint64_t>();
    if (frame < part.first || frame - part.first >= part.frames || frames.contains(frame)) continue;
    if (format.is_complete(folder, frame, json, is_packed)) frames[frame] = std::move(line);
  }
  if (list.too_long()) return strange;
  return frames;
}

Result<std::unique_ptr<FrameFolder>> FrameFolder::open(const fs::path& folder, const Manifest& manifest,
                                                       std::shared_ptr<FrameFormat> format) {
  if (auto made = base::create_folder(folder); !made) return made.error();
  std::unique_ptr<FrameFolder> result(new FrameFolder(folder, manifest, std::move(format)));
  if (auto locked = result->lock(); !locked) return locked.error();
  auto before = read_manifest(folder);
  if (!before) return before.error();
  if (*before) {
    if (const auto other = difference(**before, manifest, true)) return in_the_way(folder, *other);
    result->machine_before_ = (*before)->machine;
    auto listed = listed_frames(folder, manifest, *result->format_);
    if (!listed) return listed.error();
    result->existing_ = std::move(*listed);
  } else {
    const std::string entry = foreign_entry(folder, *result->format_);
    if (!entry.empty() && result->format_->needs_empty_folder())
      return Error{folder.string() + " is not empty (" + quote(entry) +
                   " is in it), and no data set: name a new folder"};
    if (!entry.empty()) return in_the_way(folder, std::string("it has no ") + kManifestName);
  }
  return result;
}

// Advisory lock, released when the process ends. File systems without locks work without it.
Result<void> FrameFolder::lock() {
  lock_ = UniqueFd(::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock_ && ::flock(lock_.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    return Error{"another run is writing to " + folder_.string() +
                 ": wait for its end, or name another folder"};
  return {};
}

Result<void> FrameFolder::begin(const Machine& machine, const std::string& provenance) {
  manifest_.machine = machine;
  if (!provenance.empty()) manifest_.provenance = provenance;
  for (const std::string_view name : {std::string_view("frame"), std::string_view(kManifestName)})
    base::remove_abandoned_temporaries(folder_, name);
  if (auto written = write_manifest(folder_, manifest_); !written) return written;
  if (auto begun = format_->begin(folder_); !begun) return begun;
  if (auto written = write_list(); !written) return written;
  errno = 0;
  list_.open(folder_ / kFrameListName, std::ios::app);
  if (!list_)
    return Error{"cannot write " + (folder_ / kFrameListName).string() + ": " + system_reason(errno)};
  const unsigned workers = std::clamp(std::thread::hardware_concurrency(), 1u, kMaxWorkers);
  for (unsigned i = 0; i < workers; ++i) workers_.push_back(start_thread("image file", [this] { work(); }));
  return {};
}

FrameFolder::~FrameFolder() {
  end_threads();
}

Result<void> FrameFolder::consume(sinks::FrameImage&& image) {
  FIRE3DV_ASSERT(is_consistent(image));
  std::unique_lock lock(mutex_);
  const uint64_t bytes = sinks::memory_bytes(image);
  const auto has_room = [&] {
    return jobs_.empty() || (jobs_.size() < workers_.size() + 4 && queued_bytes_ + bytes <= kMaxQueuedBytes);
  };
  changed_.wait(lock, [&] { return has_room() || error_ || closing_; });
  if (closing_) return {};  // the program ends
  if (error_) return report_error();
  jobs_.push_back(std::make_unique<Job>());
  jobs_.back()->image = std::move(image);
  jobs_.back()->bytes = bytes;
  queued_bytes_ += bytes;
  changed_.notify_all();
  return {};
}

Result<void> FrameFolder::copy(uint64_t frame, const fs::path& from_folder, const std::string& line) {
  auto loaded = format_->load(from_folder, frame, line, manifest_);
  if (!loaded) return loaded.error();
  if (auto written = write_files(*loaded); !written) return written;
  const std::lock_guard lock(mutex_);
  auto job = std::make_unique<Job>();
  job->image = numbered(frame);
  job->line = line + "\n";
  job->started = job->written = true;
  jobs_.push_back(std::move(job));
  list_written();
  return report_error();
}

void FrameFolder::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    const auto find_queued = [&] {
      return std::find_if(jobs_.begin(), jobs_.end(), [](const auto& job) { return !job->started; });
    };
    changed_.wait(lock, [&] { return find_queued() != jobs_.end() || closing_ || error_; });
    const auto found = find_queued();
    if (found == jobs_.end() || error_) return;
    Job& job = **found;  // address-stable until it is written
    job.started = true;
    lock.unlock();
    auto encoded = format_->encode(job.image);
    Result<void> written = encoded ? write_files(*encoded) : Result<void>(encoded.error());
    if (encoded) job.line = std::move(encoded->line) + "\n";
    if (written && job.line.size() > kMaxLineBytes)
      written = Error{"the labels of image " + std::to_string(job.image.frame_index) + " take " +
                      std::to_string(job.line.size() >> 20) + " MiB, more than " +
                      std::to_string(kMaxLineBytes >> 20) + ": label fewer nodes with --object"};
    job.image = numbered(job.image.frame_index);
    lock.lock();
    queued_bytes_ -= job.bytes;
    if (!written && !error_) error_ = written.error();
    job.written = written.ok();
    list_written();
    changed_.notify_all();
  }
}

Result<void> FrameFolder::write_files(const EncodedFrame& frame) const {
  for (const FolderFile& file : frame.files) {
    auto written = write_whole_file(folder_ / file.name, file.bytes, base::Durability::contents);
    if (!written) return written;
  }
  return {};
}

void FrameFolder::list_written() {
  // Frames that were in progress when a later one failed are listed, too.
  while (list_ && !jobs_.empty() && jobs_.front()->written) {
    Job& job = *jobs_.front();
    errno = 0;
    list_ << job.line << std::flush;  // flush per line: a killed run keeps its list
    if (!list_ && !error_)
      error_ = Error{"cannot write " + (folder_ / kFrameListName).string() + ": " + system_reason(errno)};
    job.line.pop_back();
    lines_[job.image.frame_index] = std::move(job.line);
    jobs_.pop_front();
  }
}

void FrameFolder::end_threads() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
    changed_.notify_all();
  }
  for (std::thread& worker : workers_) worker.join();
  workers_.clear();
}

Result<void> FrameFolder::finish() {
  const std::lock_guard ending(ending_mutex_);
  end_threads();
  const std::lock_guard lock(mutex_);
  if (error_) return report_error();
  const bool in_order =
      existing_.empty() || lines_.empty() || existing_.rbegin()->first < lines_.begin()->first;
  existing_.merge(lines_);
  if (!in_order) return write_list();
  if (!list_.is_open()) return {};
  // File contents are flushed already; the list and the directory entries are not.
  list_.close();
  const fs::path list = folder_ / kFrameListName;
  int fault = base::flush_file(list);
  if (fault == 0) fault = base::flush_folder_of(list);
  if (fault != 0)
    return Error{"cannot flush the frames in " + folder_.string() +
                 " to the disk: " + base::system_reason(fault)};
  return {};
}

Result<void> FrameFolder::complete_run() {
  if (existing_.size() != manifest_.images()) return {};
  return format_->complete(folder_, existing_);
}

Result<void> FrameFolder::write_list() {
  std::string text;
  for (const auto& [frame, line] : existing_) text += line + "\n";
  list_.close();
  return write_whole_file(folder_ / kFrameListName,
                          {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

Result<void> FrameFolder::report_error() {
  if (!error_ || error_reported_) return {};
  error_reported_ = true;
  return *error_;
}

}  // namespace fire3dv::offline
