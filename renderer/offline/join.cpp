#include "renderer/offline/commands.h"

#include <algorithm>
#include <map>
#include <memory>
#include <system_error>

#include "base/log.h"
#include "base/plural.h"
#include "base/process/progress.h"
#include "protocol/wire/check.h"
#include "renderer/app/stop_signals.h"
#include "renderer/offline/frame_folder.h"
#include "renderer/offline/output_frames.h"
#include "renderer/sinks/video/video_sink.h"

namespace fire3dv::offline {
namespace {

struct Found {
  std::filesystem::path folder;
  std::string line;
};

struct Whole {
  Manifest manifest;                    // of all shards together
  std::map<uint64_t, Found> frames;     // complete
  std::shared_ptr<FrameFormat> format;  // null: colours alone
  bool is_data_set = false, has_colors = true;
};

std::string frames_text(uint64_t first, uint64_t last) {
  return first == last ? "frame " + std::to_string(first)
                       : "frames " + std::to_string(first) + " to " + std::to_string(last);
}

Result<Manifest> manifest_of(const std::filesystem::path& folder) {
  auto manifest = read_manifest(folder);
  if (!manifest) return manifest.error();
  if (!*manifest)
    return Error{folder.string() + " has no " + kManifestName +
                 ": it is not a folder that fire3dv render has written"};
  return std::move(**manifest);
}

// Warns if shards were rendered on different machines.
void warn_of_different_machines(const std::vector<std::pair<std::filesystem::path, Machine>>& machines) {
  const auto text = [](const Machine& machine) {
    return wire::printable(machine.device) + ", " + wire::printable(machine.driver) + ", " +
           wire::printable(machine.cpu);
  };
  const auto other = std::find_if(machines.begin(), machines.end(),
                                  [&](const auto& each) { return each.second != machines.front().second; });
  if (other == machines.end()) return;
  log_message("warning: " + machines.front().first.string() + " was drawn by " +
              text(machines.front().second) + ", and " + other->first.string() + " by " +
              text(other->second) + ": frames may differ in a pixel's last digits");
}

// Fails with the first gap, and names the shard that would fill it.
Result<void> check_all_there(const Whole& whole) {
  const uint64_t frames = whole.manifest.images();
  uint64_t next = 0;
  for (const auto& [frame, found] : whole.frames) {
    if (frame != next) break;
    ++next;
  }
  if (next == frames) return {};
  const auto after = whole.frames.lower_bound(next);
  const uint64_t last = (after == whole.frames.end() ? frames : after->first) - 1;
  std::string text = frames_text(next, last) + " of " + std::to_string(frames) +
                     (next == last ? " is" : " are") + " missing";
  if (whole.manifest.shards > 1) {
    for (uint32_t shard = 1; shard <= whole.manifest.shards; ++shard) {
      const Part part = part_of(frames, shard, whole.manifest.shards);
      if (next - part.first >= part.frames || next < part.first) continue;
      const std::string word = std::to_string(shard) + "/" + std::to_string(whole.manifest.shards);
      return Error{text + ": render again with --shard " + word +
                   ", which goes on where it stopped, and name its folder"};
    }
  }
  return Error{text + ": render them with the same command, which goes on where it stopped"};
}

Result<Whole> begin_assembly(const std::vector<std::filesystem::path>& folders,
                             const FindFormat& find_format = nullptr) {
  Whole whole;
  if (find_format) {
    auto found = find_format(folders);
    if (!found) return found.error();
    whole.format = std::move(*found);
    whole.is_data_set = whole.format != nullptr;
  }
  if (!whole.format) {
    const auto first = manifest_of(folders.front());
    if (!first) return first.error();
    const auto outputs = outputs_of(*first);
    if (!outputs) return Error{folders.front().string() + ": " + outputs.error().message};
    whole.has_colors = outputs->has(wire::kColorSrgb8);
    if (*outputs != wire::ImageOutputs()) whole.format = std::make_shared<OutputFrames>(*outputs);
  }
  const PngFrames png_frames;
  const FrameFormat& format = whole.format ? *whole.format : static_cast<const FrameFormat&>(png_frames);
  std::vector<std::pair<std::filesystem::path, Machine>> machines;
  for (const std::filesystem::path& folder : folders) {
    auto manifest = manifest_of(folder);
    if (!manifest) return manifest.error();
    if (&folder == &folders.front()) whole.manifest = *manifest;
    if (const auto other = difference(*manifest, whole.manifest, false))
      return Error{folder.string() + " and " + folders.front().string() +
                   " do not belong together: " + *other + " (there: " + folder.string() + ")"};
    auto frames = listed_frames(folder, *manifest, format);
    if (!frames) return frames.error();
    if (!frames->empty()) machines.emplace_back(folder, manifest->machine);
    for (auto& [frame, line] : *frames) {
      const auto [at, is_new] = whole.frames.try_emplace(frame, Found{folder, line});
      if (!is_new)
        return Error{"frame " + std::to_string(frame) + " is in " + at->second.folder.string() + " and in " +
                     folder.string() + ": name each part once"};
    }
  }
  if (auto all = check_all_there(whole); !all) return all.error();
  if (!machines.empty()) warn_of_different_machines(machines);
  return whole;
}

Result<bool> encode(const Whole& whole, const std::filesystem::path& out, const VideoOptions& video) {
  sinks::VideoSettings settings;
  settings.path = out;
  settings.codec = video.codec;
  settings.crf = video.crf;
  settings.full_chroma = video.full_chroma;
  settings.width = whole.manifest.width;
  settings.height = whole.manifest.height;
  settings.fps_numerator = whole.manifest.times.rate.numerator;
  settings.fps_denominator = whole.manifest.times.rate.denominator;
  auto sink = sinks::VideoSink::open(settings);
  if (!sink) return sink.error();
  Progress progress("fire3dv", "encoding:");
  for (const auto& [frame, found] : whole.frames) {
    if (app::stop_was_requested()) {
      (*sink)->abandon();
      log_message("stopped; nothing is left of the video");
      return false;
    }
    auto stored = read_frame(found.folder, frame, whole.manifest);
    if (!stored) return stored.error();
    if (auto consumed = (*sink)->consume(std::move(stored->image)); !consumed) return consumed.error();
    progress.update_with_end(frame + 1, whole.manifest.times.frames);
  }
  if (auto finished = (*sink)->finish(); !finished) return finished.error();
  log_message(std::to_string(whole.frames.size()) + " frames in " + out.string());
  return true;
}

Result<bool> copy_all(const Whole& whole, const std::filesystem::path& out) {
  Manifest manifest = whole.manifest;
  manifest.shard = manifest.shards = 1;
  auto folder = FrameFolder::open(out, manifest, whole.format ? whole.format : std::make_shared<PngFrames>());
  if (!folder) return folder.error();
  if (auto begun = (*folder)->begin(manifest.machine); !begun) return begun.error();
  for (const auto& [frame, found] : whole.frames) {
    if ((*folder)->has(frame)) continue;
    if (app::stop_was_requested()) {
      log_message("stopped; the same command goes on from here");
      return false;
    }
    if (auto copied = (*folder)->copy(frame, found.folder, found.line); !copied) return copied.error();
  }
  if (auto finished = (*folder)->finish(); !finished) return finished.error();
  if (auto completed = (*folder)->complete_run(); !completed) return completed.error();
  log_message(counted(whole.frames.size(), whole.format ? "image" : "frame") + " in " + out.string());
  return true;
}

}  // namespace

int join(const JoinOptions& options, const FindFormat& find_format) {
  const auto whole = begin_assembly(options.folders, find_format);
  if (!whole) return report_failure(whole.error());
  if (sinks::is_video_name(options.out) && (whole->is_data_set || !whole->has_colors))
    return report_failure(Error{std::string(whole->is_data_set ? "the parts are of a data set, not of a video"
                                                               : "the parts have no colours for a video") +
                                ": name a folder with --out"});
  const auto done = sinks::is_video_name(options.out) ? encode(*whole, options.out, options.video)
                                                      : copy_all(*whole, options.out);
  if (!done) return report_failure(done.error());
  return *done ? 0 : 1;
}

Result<bool> encode_and_clear(const std::filesystem::path& folder, const std::filesystem::path& out,
                              const VideoOptions& video) {
  const auto whole = begin_assembly({folder});
  if (!whole) return whole.error();
  const auto encoded = encode(*whole, out, video);
  if (!encoded || !*encoded) return encoded;
  std::error_code fault;
  for (const auto& [frame, found] : whole->frames)
    std::filesystem::remove(folder / frame_file_name(frame), fault);
  for (const char* name : {kFrameListName, kManifestName}) std::filesystem::remove(folder / name, fault);
  std::filesystem::remove(folder, fault);  // fails unless the folder is empty
  return true;
}

}  // namespace fire3dv::offline
