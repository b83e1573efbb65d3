#include "renderer/verify/command.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <system_error>
#include <utility>

#include "base/files.h"
#include "base/log.h"
#include "base/plural.h"
#include "base/text.h"
#include "renderer/dataset/command.h"
#include "renderer/dataset/options.h"
#include "renderer/offline/commands.h"
#include "renderer/offline/drawing_words.h"
#include "renderer/sinks/png.h"
#include "renderer/state/motion/animation_clock.h"
#include "renderer/verify/array_file.h"
#include "renderer/verify/image_check.h"
#include "renderer/verify/run_words.h"
#include "renderer/verify/set_check.h"
#include "renderer/verify/video_check.h"

namespace fire3dv::verify {
namespace {

namespace fs = std::filesystem;
using Values = sinks::RunProvenance::Values;

constexpr size_t kMaxListed = 10;       // differences
constexpr size_t kMaxMoments = 10'000;  // of a frame in a recording

int report_unchecked(const std::string& reason) {
  log_message(error_line("cannot be checked: " + reason));
  return kUnchecked;
}

// Notes on build and machine, which may explain a difference.
std::string machine_notes(const sinks::RunProvenance& stored,
                          const std::shared_ptr<const std::string>& drawn) {
  std::string notes;
  const auto here = drawn ? sinks::decode_provenance(*drawn) : Result<sinks::RunProvenance>(Error{});
  const Values build = here ? here->build : sinks::this_build();
  if (const auto difference = sinks::first_difference(stored.build, build))
    notes += "  build: " + *difference + "\n";
  if (!here) return notes;
  if (const auto difference = sinks::first_difference(stored.machine, here->machine))
    notes += "  machine: " + *difference + "\n";
  return notes;
}

struct Report {
  std::string title;    // "images/000001.png", "60 images of set"
  uint64_t wanted = 1;  // images
  const sinks::RunProvenance& stored;
  std::shared_ptr<const std::string> drawn;
};

// drawn_code: of the run, whose error is printed already.
int report(const Outcome& outcome, const Report& report, int drawn_code) {
  std::string text;
  int exit_code = kIdentical;
  if (!outcome.differences.empty() || !outcome.file_differences.empty()) {
    for (const auto* const differences : {&outcome.differences, &outcome.file_differences}) {
      for (size_t i = 0; i < std::min(differences->size(), kMaxListed); ++i)
        text += "differs: " + (*differences)[i] + "\n";
    }
    if (report.wanted > 1)
      text += counted(outcome.identical, "image") + " of " + std::to_string(report.wanted) + " identical\n";
    exit_code = kDifferent;
  } else if (outcome.unchecked) {
    return report_unchecked(*outcome.unchecked);
  } else if (drawn_code != 0 || outcome.identical != report.wanted) {
    return report_unchecked(report.title + " was not drawn to the end");
  } else {
    text = "identical: " + report.title + "\n";
  }
  for (const std::string& note : outcome.notes) text += "  " + note + "\n";
  text += machine_notes(report.stored, report.drawn);
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
  return exit_code;
}

sinks::VideoSettings encoder_of(const offline::RenderOptions& options) {
  sinks::VideoSettings settings;
  settings.codec = options.video.codec;
  settings.crf = options.video.crf;
  settings.full_chroma = options.video.full_chroma;
  settings.fps_numerator = options.rate->numerator;
  settings.fps_denominator = options.rate->denominator;
  return settings;
}

// Runs the command that drew the images. words: after the program's name. video: of a video; else null.
int draw(const std::string& program, std::vector<std::string> words, offline::ImageConsumer& consumer,
         VideoCheck* video = nullptr) {
  std::string name = program;
  std::vector<char*> arguments{name.data()};
  for (std::string& word : words) arguments.push_back(word.data());
  const auto count = static_cast<int>(arguments.size());
  if (words.front() == "dataset") {
    auto options = dataset::parse_dataset_options(count, arguments.data());
    if (const int* exit_code = std::get_if<int>(&options)) return *exit_code;
    return dataset::run(std::get<dataset::DatasetOptions>(options), &consumer);
  }
  auto options = offline::parse_render_options(count, arguments.data());
  if (const int* exit_code = std::get_if<int>(&options)) return *exit_code;
  if (video) video->set_encoder(encoder_of(std::get<offline::RenderOptions>(options)));
  return offline::render(std::get<offline::RenderOptions>(options), nullptr, &consumer);
}

// Times at which a recording may show a frame: once in each segment of simulated time.
Result<offline::FrameTimes> times_of_frame(const offline::Timeline& timeline, int64_t sim_time_ns) {
  offline::FrameTimes times;
  times.is_recorded = true;
  for (const auto& stream : timeline.streams()) {
    for (const auto& segment : stream.segments) {
      int64_t at_ns = 0;
      if (__builtin_add_overflow(sim_time_ns, segment.line_from_sim_ns, &at_ns)) continue;
      if (at_ns >= timeline.first_ns() && at_ns <= timeline.last_ns()) times.recorded_ns.push_back(at_ns);
    }
  }
  std::sort(times.recorded_ns.begin(), times.recorded_ns.end());
  times.recorded_ns.erase(std::unique(times.recorded_ns.begin(), times.recorded_ns.end()),
                          times.recorded_ns.end());
  if (times.recorded_ns.empty()) return Error{"the recording has no frame at the time of the image"};
  if (times.recorded_ns.size() > kMaxMoments)
    return Error{"the recording has more than " + std::to_string(kMaxMoments) +
                 " frames at the time of the image"};
  times.frames = times.recorded_ns.size();
  times.first_ns = times.recorded_ns.front();
  return times;
}

// Image of a live run without a window: at rest, at the time of its animation, or at that of its streams.
int draw_live(const VerifyOptions& options, const sinks::FrameImage& stored, const Inputs& inputs,
              std::vector<std::string> words, ImageCheck& check, offline::ImageSet* set) {
  std::string name = options.program;
  auto drawing = offline::parse_drawing("verify", name.data(), std::move(words));
  if (const int* exit_code = std::get_if<int>(&drawing)) return *exit_code;
  offline::RenderOptions run;
  run.command = "fire3dv";
  run.drawing = std::move(std::get<offline::Drawing>(drawing).options);
  run.rate = offline::FrameRate{state::kHeadlessImagesPerSecond, 1};
  if (!stored.shown.empty()) {
    run.recording = inputs.recording.string();
    run.clock = stored.shown.front().stream;
    run.choose_times = [sim_time_ns = stored.shown.front().sim_time_ns](const offline::Timeline& timeline) {
      return times_of_frame(timeline, sim_time_ns);
    };
  } else if (!run.drawing.animate.empty()) {
    run.end_s = static_cast<double>(stored.frame_index) / state::kHeadlessImagesPerSecond;
  }
  return offline::render(run, set, &check);
}

// Number in the new run; nullopt: the image is found by the frames that it shows.
std::optional<uint64_t> number_in_run(const sinks::FrameImage& stored, const sinks::RunProvenance& run) {
  if (run.command != "fire3dv") return stored.frame_index;
  if (!stored.shown.empty()) return std::nullopt;
  return sinks::find_value(run.options, "animate") ? stored.frame_index : 0;
}

std::optional<std::string> reason_against_check(const sinks::FrameImage& stored,
                                                const sinks::RunProvenance& run) {
  if (!stored.hidden_streams.empty())
    return "it lacks stream " + quote(stored.hidden_streams.front()) + ", which took too much drawing time";
  if (run.command == "fire3dv" && sinks::find_value(run.options, "view"))
    return "it shows a debug view, which is drawn live only";
  for (const state::FrameTag& tag : stored.shown) {
    if (run.command == "fire3dv" && tag.condition != state::Condition::live)
      return "stream " + quote(tag.stream) + " was stale, which is marked in the image";
  }
  return std::nullopt;
}

// array: of an output, checked in place of the colours.
int verify_stored(const VerifyOptions& options, const sinks::FrameImage& stored,
                  std::optional<StoredArray> array) {
  const std::string name = options.target.string();
  if (!stored.run_provenance)
    return report_unchecked(name +
                            " has no provenance: an earlier version drew it, or a program changed it that "
                            "drops text chunks");
  const auto provenance = sinks::decode_provenance(*stored.run_provenance);
  if (!provenance) return report_unchecked(name + ": " + provenance.error().message);
  if (const auto reason = reason_against_check(stored, *provenance))
    return report_unchecked(name + ": " + *reason);
  const bool is_live = provenance->command == "fire3dv";
  if (array && !is_live && provenance->command != "render")
    return report_unchecked(name + ": name the folder of its data set");
  const auto inputs =
      find_inputs(options, options.target.parent_path(), *provenance, is_live && !stored.shown.empty());
  if (!inputs) return report_unchecked(name + ": " + inputs.error().message);
  auto words = words_of_run(*provenance, *inputs, options.words, "verify");
  if (!words) return report_unchecked(name + ": " + words.error().message);
  std::optional<ArrayOutputs> outputs;
  if (array) outputs.emplace(array->output);
  ImageCheck check(name, stored, *provenance, number_in_run(stored, *provenance), std::move(array));
  const int code =
      is_live ? draw_live(options, stored, *inputs, std::move(*words), check, outputs ? &*outputs : nullptr)
              : draw(options.program, std::move(*words), check);
  Outcome outcome = check.outcome();
  if (code == 0 && !check.drawn_provenance() && outcome.differences.empty() && !outcome.unchecked)
    outcome.unchecked = name + ": the recording does not show the same frames of its streams at that time";
  return report(outcome, {name, 1, *provenance, check.drawn_provenance()}, code);
}

int verify_image(const VerifyOptions& options) {
  if (lower_extension(options.target) == ".npy") {
    auto file = read_array(options.target);
    if (!file) return report_unchecked(file.error().message);
    return verify_stored(options, file->image, std::move(file->array));
  }
  const auto png = sinks::read_png(options.target);
  if (!png) return report_unchecked(png.error().message);
  return verify_stored(options, png->image, std::nullopt);
}

int verify_video(const VerifyOptions& options) {
  const std::string name = options.target.string();
  const auto comment = sinks::read_video_comment(options.target);
  if (!comment) return report_unchecked(comment.error().message);
  if (comment->empty()) return report_unchecked(name + " has no provenance: an earlier version drew it");
  const auto provenance = sinks::decode_provenance(*comment);
  if (!provenance) return report_unchecked(name + ": " + provenance.error().message);
  if (provenance->command != "render")
    return report_unchecked(name + ": its provenance is not of fire3dv render");
  const auto inputs = find_inputs(options, options.target.parent_path(), *provenance, false);
  if (!inputs) return report_unchecked(name + ": " + inputs.error().message);
  auto words =
      words_of_run(*provenance, *inputs, options.words, "verify" + options.target.extension().string());
  if (!words) return report_unchecked(name + ": " + words.error().message);
  VideoCheck check(options.target, *comment, *provenance);
  const int code = draw(options.program, std::move(*words), check, &check);
  return report(check.outcome(), {name, 1, *provenance, check.drawn_provenance()}, code);
}

int verify_folder(const VerifyOptions& options) {
  const fs::path& folder = options.target;
  const auto manifest = offline::read_manifest(folder);
  if (!manifest) return report_unchecked(manifest.error().message);
  if (!*manifest)
    return report_unchecked(folder.string() + " has no " + offline::kManifestName +
                            ": name a folder of fire3dv dataset or fire3dv render, or one image");
  if ((*manifest)->provenance.empty())
    return report_unchecked((folder / offline::kManifestName).string() +
                            " has no provenance: an earlier version drew the images");
  const auto provenance = sinks::decode_provenance((*manifest)->provenance);
  if (!provenance)
    return report_unchecked((folder / offline::kManifestName).string() + ": " + provenance.error().message);
  if (provenance->command == "fire3dv")
    return report_unchecked((folder / offline::kManifestName).string() + " names no command");
  const auto inputs = find_inputs(options, folder, *provenance, false);
  if (!inputs) return report_unchecked(inputs.error().message);
  auto words = words_of_run(*provenance, *inputs, options.words, "verify");
  if (!words) return report_unchecked(folder.string() + ": " + words.error().message);
  SetCheck check(folder, **manifest, *provenance, options.sample);
  const int code = draw(options.program, std::move(*words), check);
  const Outcome outcome = check.outcome();
  return report(outcome,
                {counted(check.wanted_images(), "image") + " of " + folder.string(), check.wanted_images(),
                 *provenance, check.drawn_provenance()},
                code);
}

}  // namespace

int run(const VerifyOptions& options) {
  std::error_code fault;
  if (fs::is_directory(options.target, fault)) return verify_folder(options);
  if (options.sample) return offline::usage_error("verify", "--sample is for folders");
  return sinks::is_video_name(options.target) ? verify_video(options) : verify_image(options);
}

}  // namespace fire3dv::verify
