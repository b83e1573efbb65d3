#include "renderer/app/recording.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <utility>

#include "base/clock.h"
#include "base/log.h"
#include "base/plural.h"
#include "protocol/wire/check.h"

namespace fire3dv::app {

Result<std::unique_ptr<Recording>> Recording::open(const RecordingOptions& options,
                                                   const record::AttachedFile& scene) {
  std::vector<record::AttachedFile> attached;
  if (options.attach_scene) attached.push_back(scene);
  if (options.attach_scene && record::media_type_of(scene.name) != record::kGlbType)
    return Error{"--record-scene: " + wire::printable(scene.name, 4096) +
                 " refers to further files; only a .glb file, a robot description or a mesh file can be "
                 "attached: convert "
                 "it to .glb, or leave --record-scene out"};
  record::LogOptions log;
  log.foxglove = options.foxglove;
  log.flush_ns = static_cast<uint64_t>(options.record_sync_s * 1e9);
  std::vector<std::string> left_out;
  if (options.foxglove) {
    auto models = record::load_models(attached, left_out);
    if (!models) return models.error();
    log.models = std::move(*models);
  }
  auto sink = record::create_sink(options.record);
  if (!sink) return Error{"--record: " + sink.error().message};
  auto only_sink = std::make_shared<std::unique_ptr<record::Sink>>(std::move(*sink));
  std::unique_ptr<Recording> recording(new Recording(
      wire::printable(options.record, 4096), options.record,
      record::StreamLog(
          [only_sink](uint32_t) -> Result<std::unique_ptr<record::Sink>> { return std::move(*only_sink); },
          [attached](record::Writer& writer, uint64_t now_ns) {
            return record::attach_files(attached, writer, now_ns);
          },
          log)));
  recording->notes_ = std::move(left_out);
  return recording;
}

void Recording::take(size_t listener, const transport::LinkEvent& event) {
  using Kind = transport::LinkEvent::Kind;
  const uint64_t peer = uint64_t{listener} << 48 | event.peer;
  const int64_t at_ns = event.received_ns != 0 ? event.received_ns : monotonic_ns();
  if (event.kind == Kind::pose || event.kind == Kind::control)
    log_.take(peer, event.message, at_ns, event.kind == Kind::pose);
  if (event.kind == Kind::disconnected) log_.end_peer(peer, at_ns);
}

std::vector<std::string> Recording::take_log_messages() {
  if (!log_.has_trouble() || is_failure_reported_) return std::exchange(notes_, {});
  const record::LogLosses losses = log_.losses();
  if (losses.failure && !std::exchange(is_failure_reported_, true))
    notes_.push_back(error_line("recording ended: " + *losses.failure));
  if (losses.unrecorded_streams != 0 && !std::exchange(is_unrecorded_reported_, true))
    notes_.push_back(
        warning("a stream is not recorded in " + path_ +
                ": too many are live, or were in this file; record with fire3dv-record --split-s"));
  if (!losses.failure && losses.name_fault && !std::exchange(is_name_fault_reported_, true))
    notes_.push_back(warning("--record: " + *losses.name_fault));
  if (!losses.failure && losses.unwritten != 0 && !std::exchange(is_loss_reported_, true))
    notes_.push_back(warning("the disk is too slow for " + path_ + ": messages are dropped"));
  return std::exchange(notes_, {});
}

std::string Recording::finish() {
  log_.finish();
  const record::LogStatus status = log_.status();
  uint64_t frames = status.reclaimed_frames;
  for (const record::StreamSeen& stream : status.streams) frames += stream.frames;
  char size[32];
  std::snprintf(size, sizeof size, "%.1f MB", static_cast<double>(status.file_bytes) / 1e6);
  std::string text = counted(frames, "frame") + " of " +
                     counted(status.streams.size() + status.reclaimed_streams, "stream") + " recorded in " +
                     path_ + ", " + size;
  if (status.unwritten != 0) text += "; " + counted(status.unwritten, "message") + " missing";
  if (status.unrecorded_streams != 0)
    text += "; " + counted(status.unrecorded_streams, "stream") + " not recorded";
  return text;
}

std::vector<Error> Recording::shortfalls() const {
  const record::LogStatus status = log_.status();
  std::vector<Error> faults;
  const auto add = [&](const std::string& what) {
    faults.push_back(Error{"the recording is incomplete: " + what});
  };
  if (status.failure) {
    add(*status.failure);
    return faults;  // it explains the rest
  }
  if (status.unwritten != 0)
    add(counted(status.unwritten, "message") + " missing: the disk is too slow for " + path_ +
        "; record to a faster disk");
  if (status.unrecorded_streams != 0)
    add(counted(status.unrecorded_streams, "stream") + " not recorded in " + path_ +
        ": too many were live, or in this file; record with fire3dv-record --split-s");
  if (const auto gaps = record::describe_gaps(status)) add(path_ + ": " + *gaps);
  return faults;
}

void Recording::discard() {
  log_.finish();
  ::unlink(file_.c_str());
}

Result<std::unique_ptr<RecordedScene>> RecordedScene::extract(record::Reader& reader) {
  const std::string file = wire::printable(reader.name(), 4096);
  const auto& attachments = reader.index().attachments;
  const auto found = std::ranges::find(attachments, record::kGlbType, &record::AttachmentIndex::media_type);
  if (found == attachments.end())
    return Error{"no scene is attached to " + file + "; name it: fire3dv SCENE.glb --replay " + file};
  std::error_code failure;
  std::string folder = (std::filesystem::temp_directory_path(failure) / "fire3dv-scene-XXXXXX").string();
  if (failure || ::mkdtemp(folder.data()) == nullptr)
    return Error{"cannot make a folder for the scene attached to " + file + ": " +
                 (failure ? failure.message() : std::strerror(errno)) + "; set TMPDIR to a writable folder"};
  std::unique_ptr<RecordedScene> scene(new RecordedScene);
  scene->folder_ = folder;
  // Fixed file name: the name in the recording is untrusted.
  scene->path_ = scene->folder_ / "scene.glb";
  scene->name_ = wire::printable(found->name, 256);
  std::ofstream out(scene->path_, std::ios::binary);
  const auto good = reader.read_attachment(*found, [&](std::span<const std::byte> piece) -> Result<void> {
    out.write(reinterpret_cast<const char*>(piece.data()), static_cast<std::streamsize>(piece.size()));
    return out ? Result<void>()
               : Result<void>(Error{scene->path_.string() + " cannot be written; is the disk full?"});
  });
  out.close();
  if (!good) return good.error();
  if (!out) return Error{scene->path_.string() + " cannot be written; is the disk full?"};
  return scene;
}

Error RecordedScene::with_name(Error error, const std::string& recording) const {
  const std::string from = path_.string(), to = name_ + " in " + wire::printable(recording, 4096);
  for (size_t at = error.message.find(from); at != std::string::npos;
       at = error.message.find(from, at + to.size()))
    error.message.replace(at, from.size(), to);
  return error;
}

RecordedScene::~RecordedScene() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

}  // namespace fire3dv::app
