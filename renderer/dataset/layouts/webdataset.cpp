#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "base/files.h"
#include "renderer/dataset/layouts/image_files.h"
#include "renderer/dataset/layouts/layouts.h"
#include "renderer/dataset/layouts/tar.h"

namespace fire3dv::dataset {
namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr const char* kLooseFolder = "images";
constexpr const char* kListName = "shards.json";
constexpr uint64_t kMaxListBytes = 1 << 26;

std::string shard_name(uint64_t shard) {
  return "shard-" + six_digits(shard) + ".tar";
}

struct Archive {
  std::vector<uint64_t> images;
  uint64_t bytes = 0;  // of their files, without the end
};

// From the sizes of files in the lines.
std::vector<Archive> plan_archives(const Description& description, const offline::FrameLines& lines) {
  std::vector<Archive> archives;
  for (const auto& [image, text] : lines) {
    uint64_t image_bytes = 0;
    const auto line = nlohmann::json::parse(text);
    for (const auto& size : line.at("bytes")) image_bytes += tar_bytes(size.get<uint64_t>());
    if (archives.empty() || archive_bytes(archives.back().bytes + image_bytes) > description.tar_bytes)
      archives.emplace_back();
    archives.back().images.push_back(image);
    archives.back().bytes += image_bytes;
  }
  return archives;
}

// Until all images are there, files of an image lie in images/. pack() writes them into archives, and
// remove_loose() removes them.
class WebDatasetLayout final : public Layout {
 public:
  std::optional<Depth16> depth16(const Description& description) const override {
    return Depth16{description.depth_unit_mm, "0 there; a larger --depth-scale reaches farther"};
  }
  std::vector<std::string> folders(const Description&) const override { return {kLooseFolder}; }
  std::string color_name(const Description&, uint64_t image) const override {
    return std::string(kLooseFolder) + "/" + six_digits(image) + ".png";
  }
  std::vector<std::string> file_names(const Description&, uint64_t image, size_t) const override {
    const std::string begin = std::string(kLooseFolder) + "/" + six_digits(image);
    return {begin + ".png", begin + ".depth.png", begin + ".instance.png", begin + ".json"};
  }
  Result<std::vector<std::vector<uint8_t>>> encode(const Description& description,
                                                   const sinks::FrameImage& image, const ImageLabels& labels,
                                                   std::vector<uint8_t> color) const override;
  Result<std::vector<uint8_t>> read_file(const fs::path& folder, uint64_t image,
                                         const std::string& name) const override;
  Result<std::vector<offline::FolderFile>> list_files(const Description& description,
                                                      const offline::FrameLines& lines) const override;
  Result<void> pack(const fs::path& folder, const Description& description,
                    const offline::FrameLines& lines) const override;
  bool is_packed(const fs::path& folder) const override;
  void remove_loose(const fs::path& folder, const Description& description,
                    const offline::FrameLines& lines) const override;
  std::string conventions(const Description& description) const override;
};

// Position in the list of instances + 1; 0: none.
std::vector<uint16_t> instance_indices(const ImageLabels& labels, uint32_t width, uint32_t height) {
  std::vector<uint16_t> indices(size_t{width} * height);
  for (size_t i = 0; i < labels.instances.size(); ++i) {
    for (const auto& [first, end] : labels.instances[i].visible) {
      for (uint32_t pixel = first; pixel < end; ++pixel)
        indices[size_t{pixel % height} * width + pixel / height] = static_cast<uint16_t>(i + 1);
    }
  }
  return indices;
}

Result<std::vector<std::vector<uint8_t>>> WebDatasetLayout::encode(const Description& description,
                                                                   const sinks::FrameImage& image,
                                                                   const ImageLabels& labels,
                                                                   std::vector<uint8_t> color) const {
  if (labels.instances.size() > UINT16_MAX)
    return Error{"image " + std::to_string(image.frame_index) + " has " +
                 std::to_string(labels.instances.size()) +
                 " labelled instances, more than 65535: label fewer nodes with --object"};
  ordered_json json;
  json["camera"] = description.cameras[description.index_of_camera(image.frame_index)];
  json["frame"] = description.frame_of(image.frame_index);
  json["depth_scale"] = description.depth_unit_mm;
  json["license"] = description.license;
  add_json(labels, description, json);
  const std::string text = json.dump() + "\n";
  std::vector<std::vector<uint8_t>> files;
  files.push_back(std::move(color));
  files.push_back(encode_gray_png(labels.depth_units, image.width, image.height));
  files.push_back(
      encode_gray_png(instance_indices(labels, image.width, image.height), image.width, image.height));
  files.emplace_back(text.begin(), text.end());
  return files;
}

Result<std::vector<offline::FolderFile>> WebDatasetLayout::list_files(
    const Description& description, const offline::FrameLines& lines) const {
  ordered_json list = ordered_json::array();
  for (const Archive& archive : plan_archives(description, lines))
    list.push_back({{"name", shard_name(list.size())},
                    {"images", archive.images.size()},
                    {"bytes", archive_bytes(archive.bytes)}});
  std::vector<offline::FolderFile> files;
  files.push_back(text_file(kListName, list.dump(1) + "\n"));
  return files;
}

Result<void> WebDatasetLayout::pack(const fs::path& folder, const Description& description,
                                    const offline::FrameLines& lines) const {
  uint64_t number = 0;
  for (const Archive& archive : plan_archives(description, lines)) {
    auto tar = TarFile::create(folder / shard_name(number++));
    if (!tar) return tar.error();
    for (const uint64_t image : archive.images) {
      for (const std::string& name : file_names(description, image, 0)) {
        auto file = read_whole_file(folder / name, kMaxFileBytes);
        if (!file) return file.error();
        if (auto added = tar->add(fs::path(name).filename().string(), *file); !added) return added;
      }
    }
    auto size = tar->finish();
    if (!size) return size.error();
    if (*size != archive_bytes(archive.bytes))
      return Error{(folder / kLooseFolder).string() +
                   " has files of another size than frames.jsonl says: run the command again"};
  }
  return {};
}

// From the archive that the list names for the image, once the image's own files are gone.
Result<std::vector<uint8_t>> WebDatasetLayout::read_file(const fs::path& folder, uint64_t image,
                                                         const std::string& name) const {
  std::error_code fault;
  if (fs::exists(fs::symlink_status(folder / name, fault)))
    return read_whole_file(folder / name, kMaxFileBytes);
  auto text = read_whole_file(folder / kListName, kMaxListBytes);
  if (!text) return text.error();
  const auto list = nlohmann::json::parse(text->begin(), text->end(), nullptr, false);
  uint64_t end = 0;  // of the images of an archive
  for (size_t i = 0; list.is_array() && i < list.size(); ++i) {
    const auto images = list[i].is_object() ? list[i].find("images") : list[i].end();
    if (images == list[i].end() || !images->is_number_unsigned()) break;
    end += images->get<uint64_t>();
    if (image < end)
      return read_tar_file(folder / shard_name(i), fs::path(name).filename().string(), kMaxFileBytes);
  }
  return Error{(folder / kListName).string() + " names no archive with image " + std::to_string(image)};
}

bool WebDatasetLayout::is_packed(const fs::path& folder) const {
  auto text = read_whole_file(folder / kListName, kMaxListBytes);
  if (!text) return false;
  const auto list = nlohmann::json::parse(text->begin(), text->end(), nullptr, false);
  if (!list.is_array() || list.empty()) return false;
  for (size_t i = 0; i < list.size(); ++i) {
    const auto bytes = list[i].is_object() ? list[i].find("bytes") : list[i].end();
    const fs::path path = folder / shard_name(i);
    std::error_code fault;
    if (bytes == list[i].end() || !bytes->is_number_unsigned() ||
        !fs::is_regular_file(fs::symlink_status(path, fault)) ||
        fs::file_size(path, fault) != bytes->get<uint64_t>())
      return false;
  }
  return true;
}

void WebDatasetLayout::remove_loose(const fs::path& folder, const Description& description,
                                    const offline::FrameLines& lines) const {
  std::error_code fault;
  if (!fs::is_directory(fs::symlink_status(folder / kLooseFolder, fault))) return;
  for (const auto& [image, line] : lines) {
    for (const std::string& name : file_names(description, image, 0)) fs::remove(folder / name, fault);
  }
  fs::remove(folder / kLooseFolder, fault);  // fails unless the folder is empty
}

std::string WebDatasetLayout::conventions(const Description& description) const {
  return R"(WebDataset: tar archives (ustar) of samples; files of one sample follow one another and share the part of
their names before the first dot, the image's number. Images of one moment follow one another, camera by
camera. `shards.json` lists the archives, their images and sizes.

| file | contents |
|---|---|
| `IMAGE.png` | 8-bit colours, sRGB |
| `IMAGE.depth.png` | 16 bits; times `depth_scale` = millimetres along the camera's axis; 0: no surface, or too far |
| `IMAGE.instance.png` | 16 bits: position in `instances` of the JSON file, from 1; 0: none |
| `IMAGE.json` | `camera`, `frame`, `cam_K`, `cam_R_w2c`, `cam_t_w2c` (mm), `depth_scale`, instances with poses (mm), boxes, masks (COCO's run lengths), visible shares, and keypoints |

`depth_scale` is )" +
         ordered_json(description.depth_unit_mm).dump() + ".\n";
}

}  // namespace

std::unique_ptr<Layout> make_webdataset_layout() {
  return std::make_unique<WebDatasetLayout>();
}

}  // namespace fire3dv::dataset
