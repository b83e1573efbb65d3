#include "renderer/dataset/dataset_format.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "base/files.h"
#include "base/log.h"
#include "renderer/dataset/labels/line_check.h"
#include "renderer/dataset/pages/page.h"
#include "renderer/dataset/pages/readme.h"
#include "renderer/dataset/pages/statistics.h"
#include "renderer/sinks/output_text.h"
#include "renderer/sinks/png.h"

namespace fire3dv::dataset {
namespace {

namespace fs = std::filesystem;

constexpr const char* kReadmeName = "README.md";
constexpr const char* kPageName = "index.html";  // the last file of a set
// Of a list that another program has changed.
constexpr const char* kStrangeLines =
    " has lines that fire3dv dataset does not write: run it again into another folder";

// Number of instances and sizes of the files of a listed image. nullopt: the line is no image's.
std::optional<std::pair<size_t, std::vector<uint64_t>>> listed_files(const nlohmann::json& line,
                                                                     const Description& description) {
  const auto instances = line.find("instances"), bytes = line.find("bytes");
  if (!is_image_line(line, description) || bytes == line.end() || !bytes->is_array()) return {};
  std::vector<uint64_t> sizes;
  for (const auto& size : *bytes) {
    if (!size.is_number_unsigned()) return {};
    sizes.push_back(size.get<uint64_t>());
  }
  return std::pair(instances->size(), std::move(sizes));
}

// Folders of a set, with those above them; parents come first.
std::set<fs::path> folders_of(const Layout& layout, const Description& description) {
  std::set<fs::path> folders;
  for (const std::string& name : layout.folders(description)) {
    for (fs::path path = name; !path.empty(); path = path.parent_path()) folders.insert(path);
  }
  return folders;
}

// Refuses links and files in place of folders: the set would be written into a folder that nobody named.
// Removes temporary files of writers that were killed.
Result<void> prepare_folders(const fs::path& folder, const std::set<fs::path>& names) {
  base::remove_abandoned_temporaries(folder, "");
  for (const fs::path& name : names) {
    std::error_code fault;
    const fs::file_status status = fs::symlink_status(folder / name, fault);
    if (fs::exists(status) && !fs::is_directory(status))
      return Error{(folder / name).string() + " is " +
                   (fs::is_symlink(status) ? "a symbolic link" : "a file") +
                   " and not a folder of the data set: remove it, or name another folder"};
    if (auto made = base::create_folder(folder / name); !made) return made;
    base::remove_abandoned_temporaries(folder / name, "");
  }
  return {};
}

}  // namespace

DatasetFormat::DatasetFormat(Description description, std::unique_ptr<Layout> layout,
                             std::vector<offline::FolderFile> static_files)
    : description_(std::move(description)),
      layout_(std::move(layout)),
      static_files_(std::move(static_files)) {
  layout_->prepare(description_);
}

Result<std::shared_ptr<offline::FrameFormat>> DatasetFormat::find(const std::vector<fs::path>& folders) {
  std::error_code fault;
  if (folders.empty() || !fs::exists(folders.front() / kDescriptionName, fault))
    return std::shared_ptr<offline::FrameFormat>();
  auto description = read_description(folders.front());
  if (!description) return description.error();
  auto manifest = offline::read_manifest(folders.front());
  if (!manifest) return manifest.error();
  if (*manifest && ((*manifest)->cameras != description->cameras.size() ||
                    (*manifest)->width != description->width || (*manifest)->height != description->height))
    return Error{(folders.front() / kDescriptionName).string() + " and " + offline::kManifestName +
                 " there disagree on cameras or size: run that part again into another folder"};
  auto layout = make_layout(description->format);
  if (!layout)
    return Error{(folders.front() / kDescriptionName).string() +
                 " has a format that this version does not know: join with the version that wrote it"};
  if (auto good = layout->check(*description); !good) return good.error();
  std::vector<offline::FolderFile> files;
  for (const std::string& name : layout->static_names(*description)) {
    auto bytes = read_whole_file(folders.front() / name, kMaxFileBytes);
    if (!bytes) return bytes.error();
    files.push_back({name, std::move(*bytes)});
  }
  return std::shared_ptr<offline::FrameFormat>(
      std::make_shared<DatasetFormat>(std::move(*description), std::move(layout), std::move(files)));
}

void DatasetFormat::add_poses(uint64_t image, ImagePoses poses) {
  const std::lock_guard lock(mutex_);
  poses_.insert_or_assign(image, std::move(poses));
}

Result<offline::EncodedFrame> DatasetFormat::encode(const sinks::FrameImage& drawn) {
  ImagePoses poses;
  {
    const std::lock_guard lock(mutex_);
    auto taken = poses_.extract(drawn.frame_index);
    FIRE3DV_ASSERT(!taken.empty());
    poses = std::move(taken.mapped());
  }
  std::optional<sinks::FrameImage> noisy;
  if (poses.noise > 0) {
    noisy = drawn;
    add_noise(noisy->rgba8, poses.noise, description_.seed, drawn.frame_index);
  }
  const sinks::FrameImage& image = noisy ? *noisy : drawn;
  const auto depth = layout_->depth16(description_);
  const ImageLabels labels = find_labels(image, std::move(poses), description_,
                                         depth ? std::optional(depth->unit_mm) : std::nullopt);
  auto color = sinks::encode_png(image);
  if (!color) return Error{"image " + std::to_string(image.frame_index) + ": " + color.error().message};
  auto files = layout_->encode(description_, image, labels, std::move(*color));
  if (!files) return files.error();
  const std::vector<std::string> names =
      layout_->file_names(description_, image.frame_index, labels.instances.size());
  FIRE3DV_ASSERT(names.size() == files->size());

  sinks::FrameImage tagged;  // without pixels
  tagged.width = image.width;
  tagged.height = image.height;
  tagged.frame_index = image.frame_index;
  tagged.camera = description_.cameras[description_.index_of_camera(image.frame_index)];
  tagged.shown = image.shown;
  tagged.path_traced = image.path_traced;
  tagged.hidden_streams = image.hidden_streams;
  auto line = nlohmann::ordered_json::parse(sinks::frame_line({names.front(), {}}, tagged));
  offline::EncodedFrame frame;
  line["bytes"] = nlohmann::ordered_json::array();
  for (size_t i = 0; i < names.size(); ++i) {
    line["bytes"].push_back((*files)[i].size());
    frame.files.push_back({names[i], std::move((*files)[i])});
  }
  add_json(labels, description_, line);
  frame.line = line.dump();
  return frame;
}

bool DatasetFormat::is_packed(const fs::path& folder) const {
  std::error_code fault;
  return layout_->is_packed(folder) && fs::exists(folder / kPageName, fault);
}

bool DatasetFormat::is_complete(const fs::path& folder, uint64_t image, const nlohmann::json& line,
                                bool is_packed) const {
  const auto listed = listed_files(line, description_);
  if (!listed) return false;
  const auto& [instances, sizes] = *listed;
  const std::vector<std::string> names = layout_->file_names(description_, image, instances);
  if (names.size() != sizes.size()) return false;
  if (is_packed) return true;
  for (size_t i = 0; i < names.size(); ++i) {
    std::error_code fault;
    const fs::path path = folder / names[i];
    if (!fs::is_regular_file(fs::symlink_status(path, fault)) || fs::file_size(path, fault) != sizes[i] ||
        fault)
      return false;
  }
  return true;
}

Result<offline::EncodedFrame> DatasetFormat::load(const fs::path& folder, uint64_t image,
                                                  const std::string& line, const offline::Manifest&) const {
  const auto listed = listed_files(nlohmann::json::parse(line, nullptr, false), description_);
  offline::EncodedFrame frame;
  frame.line = line;
  if (!listed) return Error{folder.string() + ": the line of image " + std::to_string(image) + " is damaged"};
  if (is_packed(folder))
    return Error{folder.string() + " is a finished data set and no part of one: copy the folder instead"};
  const auto names = layout_->file_names(description_, image, listed->first);
  for (size_t i = 0; i < names.size(); ++i) {
    auto bytes = read_whole_file(folder / names[i], kMaxFileBytes);
    if (!bytes) return bytes.error();
    if (i >= listed->second.size() || bytes->size() != listed->second[i])
      return Error{(folder / names[i]).string() + " is not complete: run its shard again"};
    frame.files.push_back({names[i], std::move(*bytes)});
  }
  return frame;
}

Result<void> DatasetFormat::begin(const fs::path& folder) {
  if (auto prepared = prepare_folders(folder, folders_of(*layout_, description_)); !prepared) return prepared;
  for (const offline::FolderFile& file : static_files_) {
    if (auto written = write_whole_file(folder / file.name, file.bytes); !written) return written;
  }
  static_files_ = {};
  return write_text(folder / kDescriptionName, to_json(description_));
}

Result<void> DatasetFormat::complete(const fs::path& folder, const offline::FrameLines& lines) {
  if (is_packed(folder)) {
    layout_->remove_loose(folder, description_, lines);  // a run that was killed may have left them
    return {};
  }
  if (auto prepared = prepare_folders(folder, folders_of(*layout_, description_)); !prepared) return prepared;
  try {
    return write_final_files(folder, lines);
  } catch (const nlohmann::json::exception&) {
    return Error{(folder / offline::kFrameListName).string() + kStrangeLines};
  }
}

Result<void> DatasetFormat::write_final_files(const fs::path& folder,
                                              const offline::FrameLines& lines) const {
  if (auto packed = layout_->pack(folder, description_, lines); !packed) return packed;
  const auto lists = layout_->list_files(description_, lines);
  if (!lists) return lists.error();
  for (const offline::FolderFile& file : *lists) {
    if (auto written = write_whole_file(folder / file.name, file.bytes); !written) return written;
  }
  const Statistics statistics = count(description_, *layout_, lines);
  for (const std::string& text : statistics.warnings) log_message(warning(text));
  if (auto written = write_text(folder / kReadmeName, make_readme(description_, *layout_, statistics));
      !written)
    return written;
  auto page = make_page(folder, description_, *layout_, statistics, lines);
  if (!page) return page.error();
  if (auto written = write_text(folder / kPageName, *page); !written) return written;
  layout_->remove_loose(folder, description_, lines);
  return {};
}

std::vector<offline::FolderFile> DatasetFormat::first_files() const {
  std::vector<offline::FolderFile> files = static_files_;
  files.push_back(text_file(kDescriptionName, to_json(description_)));
  return files;
}

Result<std::vector<offline::FolderFile>> DatasetFormat::last_files(const offline::FrameLines& lines) const {
  try {
    return layout_->list_files(description_, lines);
  } catch (const nlohmann::json::exception&) {
    return Error{std::string(offline::kFrameListName) + kStrangeLines};
  }
}

std::vector<std::string> DatasetFormat::page_names() const {
  std::vector<std::string> names{kReadmeName, kPageName};
  for (std::string& name : layout_->unlisted_names()) names.push_back(std::move(name));
  return names;
}

// The description has the command, which names the inputs as they were called then.
Result<std::vector<uint8_t>> DatasetFormat::read_run_file(const fs::path& folder,
                                                          const std::string& name) const {
  if (name != kDescriptionName) return read_whole_file(folder / name, kMaxFileBytes);
  auto stored = read_description(folder);
  if (!stored) return stored.error();
  stored->command = description_.command;
  return text_file(name, to_json(*stored)).bytes;
}

}  // namespace fire3dv::dataset
