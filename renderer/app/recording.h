// Recordings in the renderer: recorder of its links, and the scene attached to a recording.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/record/attachments.h"
#include "protocol/record/log_thread.h"
#include "protocol/record/mcap/reader.h"
#include "protocol/transport/link.h"
#include "renderer/app/options/recording_options.h"

namespace fire3dv::app {

// Recorder of the renderer's links, on its own thread. Disk problems never block the renderer: the first loss
// is reported once, the total at the end.
class Recording {
 public:
  // Creates the file. scene: the displayed scene, attached if the options request it. It must be a .glb file
  // by its name, and readable for the lifetime of the recording.
  static Result<std::unique_ptr<Recording>> open(const RecordingOptions& options,
                                                 const record::AttachedFile& scene);

  // Records an event of the listener with this index. Never blocks. Any thread.
  void take(size_t listener, const transport::LinkEvent& event);
  // Messages to the user since the last call.
  std::vector<std::string> take_log_messages();
  // Writes the queue. Returns a summary sentence with the counts of the file.
  std::string finish();
  // What the recording lacks, with reasons. Call after finish().
  std::vector<Error> shortfalls() const;
  // Ends the recording without a file: no listener was opened.
  void discard();

 private:
  Recording(std::string path, std::string file, record::StreamLog log)
      : path_(std::move(path)), file_(std::move(file)), log_(std::move(log)) {}

  std::string path_;  // for messages
  std::string file_;
  std::vector<std::string> notes_;
  bool is_name_fault_reported_ = false;
  bool is_failure_reported_ = false, is_loss_reported_ = false, is_unrecorded_reported_ = false;
  record::LogThread log_;
};

// Scene attached to a recording, extracted to a temporary file for loaders, caches and converters.
class RecordedScene {
 public:
  // Extracts the first attached .glb file to a private temporary folder, which is removed with this object.
  // Fails if there is none or it is damaged.
  static Result<std::unique_ptr<RecordedScene>> extract(record::Reader& reader);
  ~RecordedScene();
  RecordedScene(const RecordedScene&) = delete;
  RecordedScene& operator=(const RecordedScene&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const std::string& name() const { return name_; }  // name of the attachment; for messages
  // The error with "NAME in RECORDING" in place of the temporary path.
  Error with_name(Error error, const std::string& recording) const;

 private:
  RecordedScene() = default;

  std::filesystem::path folder_, path_;
  std::string name_;
};

}  // namespace fire3dv::app
