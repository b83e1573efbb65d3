// Messages of recordings of other programs, in the order of their log times, and the topics of the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/import/messages/messages.h"

namespace fire3dv::imported {

constexpr size_t kMaxTopics = 65'536;  // of a file, and of all files of a folder

struct SourceMessage {
  size_t topic = 0;  // index into MessageSource::topics()
  uint64_t log_time_ns = 0;
  uint64_t number = 0;                 // of the topic's messages, from 1; for texts
  std::span<const std::byte> message;  // valid until the next call
};

// Not thread-safe. Memory is bounded whatever the file contains.
class MessageSource {
 public:
  virtual ~MessageSource() = default;

  virtual const std::string& name() const = 0;  // for texts
  virtual const std::vector<Topic>& topics() const = 0;
  // Begins again. topics: only their messages follow.
  virtual Result<void> rewind(const std::vector<size_t>& topics) = 0;
  // Nothing at the end.
  virtual Result<std::optional<SourceMessage>> next() = 0;
  // Part of the file that is read, 0 to 1; for a progress bar.
  virtual double progress() const = 0;
  // Returns and clears sentences on damage that was passed over.
  virtual std::vector<std::string> take_warnings() = 0;
};

// True: end with the error "stopped". Called often within long searches; may be empty.
using ShouldStop = std::function<bool()>;

// Opens an MCAP or SQLite file, or the folder of a ROS 2 bag with such files, which are read one after the
// other.
Result<std::unique_ptr<MessageSource>> open_messages(const std::filesystem::path& path,
                                                     const ShouldStop& should_stop = {});

}  // namespace fire3dv::imported
