// Reader for AMBF's launch, world and model files (ADF). Launch files name a world and models; a world names
// its environment model. Files are read in AMBF's order: environment, lights and cameras of the world, models
// as listed.
#include <algorithm>
#include <optional>

#include "renderer/scene/files.h"
#include "tools/convert/adf/adf_model.h"
#include "tools/convert/local_files.h"
#include "tools/convert/readers.h"
#include "tools/convert/text.h"

namespace fire3dv::convert {
namespace {

class AdfReader {
 public:
  AdfReader(const ReadOptions& options, Model& model)
      : model_(model),
        report_(model),
        visuals_(model, options.most_triangles),
        objects_(report_),
        reading_{report_, visuals_, objects_, options.name_space},
        options_(options) {}

  Result<void> read(const std::filesystem::path& named) {
    Result<AdfFile> file = open(named);
    if (!file) return file.error();
    open_.push_back(named);
    visuals_.allow_images_below(named.parent_path());
    if (file->has("multibody configs") || file->has("world config")) {
      Result<void> launched = read_launch(*file);
      if (!launched) return launched;
    } else if (file->has("bodies") || file->has("soft bodies") || file->has("ghost objects")) {
      read_adf_model(*file, reading_);
    } else if (file->has("environment") || file->has("lights") || file->has("cameras")) {
      read_world(*file);
    } else {
      return Error{quote(named.string()) +
                   " is no AMBF launch, world or model file: it has neither \"multibody configs\" nor "
                   "\"environment\" nor \"bodies\""};
    }
    if (objects_.empty()) {
      report_.finish();
      return Error{quote(named.string()) + " shows nothing: " +
                   (model_.warnings.empty() ? "its lists of bodies are empty" : model_.warnings.front())};
    }
    objects_.write(model_);
    report_.finish();
    return {};
  }

 private:
  Result<AdfFile> open(const std::filesystem::path& path) {
    // A launch file may name one file a hundred thousand times.
    if (bytes_read_ > options_.most_adf_bytes)
      return Error{"the files before it have more than " + std::to_string(options_.most_adf_bytes >> 10) +
                   " KiB together"};
    model_.sources.add(path);
    std::error_code error;
    const uintmax_t bytes = std::filesystem::file_size(path, error);
    if (!error) bytes_read_ += bytes;  // counts unreadable files, too, since they take as long
    return AdfFile::read(path, report_);
  }

  // Opens a file that another one names. An unreadable file causes a warning.
  std::optional<AdfFile> open_named_by(const AdfFile& file, const AdfValue& name) {
    const std::filesystem::path given = name.text();
    const std::filesystem::path path = tidy_path(file.folder() / given);
    if (given.empty()) {
      name.warn("names no file");
      return std::nullopt;
    }
    std::error_code error;
    const bool open_already = std::any_of(open_.begin(), open_.end(), [&](const std::filesystem::path& o) {
      return std::filesystem::equivalent(o, path, error);
    });
    if (open_already) {
      name.warn("is " + quote(given.string()) + ", which is just being read: a file cannot hold itself");
      return std::nullopt;
    }
    Result<AdfFile> read = open(path);
    if (read) return std::move(*read);
    name.warn("cannot be read: " + read.error().message);
    return std::nullopt;
  }

  bool read_world(const AdfFile& file) {
    bool more = true;
    open_.push_back(file.path());
    if (const AdfValue environment = file["environment"]; environment.is_defined()) {
      if (std::optional<AdfFile> model = open_named_by(file, environment))
        more = read_adf_model(*model, reading_);
    } else if (file["enclosure"].is_defined()) {
      file["enclosure"].warn("is not converted: its walls are left out");
    }
    more = more && read_adf_world(file, reading_);
    open_.pop_back();
    return more;
  }

  Result<void> read_launch(const AdfFile& file) {
    file.note_unknown_fields();
    const std::vector<AdfValue> configs = file["multibody configs"].items();
    std::vector<size_t> indices = options_.launch_indices;
    for (const size_t index : indices) {
      if (index >= configs.size()) {
        return Error{quote(file.path().string()) + " has no model " + std::to_string(index) + ": it lists " +
                     std::to_string(configs.size()) + ", counted from 0"};
      }
    }
    if (options_.launch_all) {
      indices.resize(configs.size());
      for (size_t i = 0; i < indices.size(); ++i) indices[i] = i;
    } else if (indices.empty() && !configs.empty()) {
      indices = {std::min<size_t>(1, configs.size() - 1)};  // AMBF's default is 1
    }
    bool more = true;
    if (const AdfValue world = file["world config"]; world.is_defined()) {
      if (std::optional<AdfFile> read = open_named_by(file, world)) more = read_world(*read);
    } else {
      report_.warn(file.path().string() + ": has no \"world config\", without which AMBF does not start");
    }
    for (size_t i = 0; more && i < indices.size(); ++i) {
      if (std::optional<AdfFile> model = open_named_by(file, configs[indices[i]]))
        more = read_adf_model(*model, reading_);
    }
    return {};
  }

  Model& model_;
  AdfReport report_;
  AdfVisuals visuals_;
  AdfObjects objects_;
  AdfReading reading_;
  const ReadOptions& options_;
  uint64_t bytes_read_ = 0;
  std::vector<std::filesystem::path> open_;  // stack of files being read, each named by the previous one
};

}  // namespace

Result<Model> read_adf(const std::filesystem::path& file, const ReadOptions& options) {
  Model model;
  model.name = sanitize_text(file.stem().string());
  Result<void> read = AdfReader(options, model).read(file);
  if (!read) return read.error();
  return model;
}

}  // namespace fire3dv::convert
