// Records what the renderer's links bring, message by message, on a thread of its own. Whatever the disk
// does, the renderer goes on: it hears once that something is not recorded, and at the end how much.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "protocol/record/log_thread.h"
#include "protocol/transport/link.h"
#include "renderer/app/recording_options.h"

namespace fire3dv::app {

class Recording {
 public:
  // Makes the file. scene: what is shown; it is attached where the options say so.
  static Result<std::unique_ptr<Recording>> open(const RecordingOptions& options,
                                                 const std::filesystem::path& scene);

  // An event of the listener of this number. Never waits.
  void take(size_t listener, const transport::LinkEvent& event);
  // Sentences for the user since the last call.
  std::vector<std::string> take_notes();
  // Writes what is left. What there is in the file, in a sentence.
  std::string finish();

 private:
  Recording(std::string path, record::StreamLog log) : path_(std::move(path)), log_(std::move(log)) {}

  std::string path_;
  std::vector<std::string> notes_;
  bool failure_told_ = false, loss_told_ = false, unrecorded_told_ = false;
  record::LogThread log_;
};

}  // namespace fire3dv::app
