#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/plural.h"
#include "renderer/dataset/layouts/image_files.h"
#include "renderer/dataset/layouts/layouts.h"
#include "renderer/sinks/file_sink.h"

namespace fire3dv::dataset {
namespace {

using nlohmann::ordered_json;

constexpr double kC3vdRangeMm = 100;  // of depth images
constexpr double kC3vdRangePx = 20;   // of flow images, to both sides

std::string number_text(uint64_t number, const char* format) {
  char text[24];
  std::snprintf(text, sizeof text, format, static_cast<unsigned long long>(number));
  return text;
}

std::vector<uint16_t> c3vd_depth(const std::vector<float>& depth_m) {
  std::vector<uint16_t> units(depth_m.size());
  for (size_t i = 0; i < units.size(); ++i) {
    const double share = std::clamp(double{depth_m[i]} * kMillimetres / kC3vdRangeMm, 0.0, 1.0);
    units[i] = static_cast<uint16_t>(std::lround(share * UINT16_MAX));
  }
  return units;
}

// From half floats in the world to 0 .. 65535 for -1 .. 1 in the camera's axes.
std::vector<uint16_t> c3vd_normals(const std::vector<uint8_t>& plane, const glm::dmat3& camera_from_world) {
  std::vector<uint16_t> units;
  units.reserve(plane.size() / 8 * 3);
  for (size_t at = 0; at + 8 <= plane.size(); at += 8) {
    uint16_t halves[3];
    std::memcpy(halves, plane.data() + at, sizeof halves);
    const glm::dvec3 world(glm::unpackHalf1x16(halves[0]), glm::unpackHalf1x16(halves[1]),
                           glm::unpackHalf1x16(halves[2]));
    const bool is_background = world == glm::dvec3(0);
    const glm::dvec3 normal = is_background ? glm::dvec3(-1) : glm::normalize(camera_from_world * world);
    for (int c = 0; c < 3; ++c)
      units.push_back(
          static_cast<uint16_t>(std::lround((std::clamp(normal[c], -1.0, 1.0) + 1) / 2 * UINT16_MAX)));
  }
  return units;
}

// Red and green: 0 to 65535 for -20 to 20 pixels right and down. 0 where the other image does not show the
// point.
std::vector<uint16_t> c3vd_flow(const sinks::Flow& flow, const std::vector<uint32_t>& instances) {
  std::vector<uint16_t> units(3 * flow.occlusion.size());
  for (size_t i = 0; i < flow.occlusion.size(); ++i) {
    if (flow.occlusion[i] != sinks::Flow::kSeen || instances[i] == 0) continue;
    for (size_t c = 0; c < 2; ++c) {
      const double share = (double{flow.motion_px[2 * i + c]} + kC3vdRangePx) / (2 * kC3vdRangePx);
      units[3 * i + c] = static_cast<uint16_t>(std::lround(std::clamp(share, 0.0, 1.0) * UINT16_MAX));
    }
  }
  return units;
}

// Pixels: fx * baseline / depth; 0 where there is no surface.
std::vector<uint8_t> encode_disparity(const sinks::FrameImage& image, const ImagePoses& poses) {
  std::vector<float> disparity_px = plane_values<float>(image, wire::kDepthF32);
  for (float& value : disparity_px)
    value = std::isfinite(value)
                ? static_cast<float>(double{poses.intrinsics.fx_px} * *poses.baseline_m / double{value})
                : 0;
  const std::array<uint64_t, 2> shape{image.height, image.width};
  return sinks::encode_npy(
      "<f4", shape,
      {reinterpret_cast<const uint8_t*>(disparity_px.data()), disparity_px.size() * sizeof(float)});
}

// Motion and occlusion of each pixel.
void add_flow_files(const sinks::Flow& flow, uint32_t width, uint32_t height,
                    std::vector<std::vector<uint8_t>>& files) {
  const std::array<uint64_t, 3> shape{height, width, 2};
  const std::span<const uint8_t> motion(reinterpret_cast<const uint8_t*>(flow.motion_px.data()),
                                        flow.motion_px.size() * sizeof(float));
  files.push_back(sinks::encode_npy("<f4", shape, motion));
  files.push_back(sinks::encode_npy("|u1", std::span(shape).first(2), flow.occlusion));
}

std::string dump_numbers(const std::vector<double>& values, const char* separator) {
  std::string text;
  for (const double value : values) {
    char number[32];
    std::snprintf(number, sizeof number, "%.10g", value);
    text += (text.empty() ? "" : separator) + std::string(number);
  }
  return text + "\n";
}

// Camera to world, 4x4 by columns; millimetres.
std::string c3vd_pose(const ordered_json& line) {
  const auto rotation = line.at("cam_R_w2c").get<std::vector<double>>();
  const auto translation = line.at("cam_t_w2c").get<std::vector<double>>();
  std::vector<double> pose;
  for (size_t column = 0; column < 3; ++column) {
    for (size_t row = 0; row < 3; ++row) pose.push_back(rotation.at(3 * column + row));
    pose.push_back(0);
  }
  for (size_t row = 0; row < 3; ++row) {
    double value = 0;
    for (size_t i = 0; i < 3; ++i) value -= rotation.at(3 * i + row) * translation.at(i);
    pose.push_back(value == 0 ? 0.0 : value);  // no minus zero
  }
  pose.push_back(1);
  return dump_numbers(pose, ",");
}

// Masks of the labelled instances.
std::vector<uint8_t> encode_silhouettes(const sinks::FrameImage& image, const ImageLabels& labels) {
  FIRE3DV_ASSERT(image.amodal);
  const sinks::Amodal& all = *image.amodal;
  std::array<uint64_t, 3> shape = sinks::masks_shape(image);
  shape[0] = labels.instances.size();
  const auto mask_bytes = static_cast<std::ptrdiff_t>(shape[1] * shape[2]);
  std::vector<uint8_t> masks;
  auto label = labels.instances.begin();
  for (size_t i = 0; i < all.records.size() && label != labels.instances.end(); ++i) {
    if (all.records[i].instance != label->number) continue;
    const auto mask = all.masks.begin() + static_cast<std::ptrdiff_t>(i) * mask_bytes;
    masks.insert(masks.end(), mask, mask + mask_bytes);
    ++label;
  }
  return sinks::encode_npy("|u1", shape, masks);
}

std::vector<std::string> camera_folders(const Description& description) {
  std::vector<std::string> folders;
  for (uint32_t camera = 0; camera < description.cameras.size(); ++camera)
    folders.push_back(camera_folder(description, camera));
  return folders;
}

std::string folder_of_image(const Description& description, uint64_t image) {
  return camera_folder(description, description.index_of_camera(image)) + "/";
}

bool has_c3vd_flow(const Description& description, uint64_t image) {
  return description.flow_frames != 0 && description.frame_of(image) >= description.flow_frames;
}

// cam.txt of each camera, from its first image.
std::vector<offline::FolderFile> camera_matrices(const Description& description,
                                                 const offline::FrameLines& lines) {
  std::vector<offline::FolderFile> files;
  for (uint32_t camera = 0; camera < description.cameras.size(); ++camera) {
    const auto first = lines.find(camera);
    if (first == lines.end()) continue;
    const auto k = ordered_json::parse(first->second).at("cam_K").get<std::vector<double>>();
    std::string text;
    for (size_t row = 0; row < 3; ++row)
      text += dump_numbers({k.at(3 * row), k.at(3 * row + 1), k.at(3 * row + 2)}, " ");
    files.push_back(text_file(camera_folder(description, camera) + "/cam.txt", text));
  }
  return files;
}

class C3vdLayout final : public Layout {
 public:
  wire::ImageOutputs further_outputs() const override { return wire::ImageOutputs(wire::kNormal); }
  bool has_flow_forward() const override { return false; }
  std::optional<Depth16> depth16(const Description&) const override {
    return Depth16{kC3vdRangeMm / UINT16_MAX, "65535 there: the depth of C3VD ends at 100 mm"};
  }
  std::vector<std::string> folders(const Description& description) const override;
  std::string color_name(const Description& description, uint64_t image) const override;
  std::vector<std::string> file_names(const Description& description, uint64_t image,
                                      size_t instances) const override;
  Result<std::vector<std::vector<uint8_t>>> encode(const Description& description,
                                                   const sinks::FrameImage& image, const ImageLabels& labels,
                                                   std::vector<uint8_t> color) const override;
  Result<std::vector<offline::FolderFile>> list_files(const Description& description,
                                                      const offline::FrameLines& lines) const override;
  std::string conventions(const Description& description) const override;
};

class FolderLayout final : public Layout {
 public:
  wire::ImageOutputs further_outputs() const override {
    return wire::ImageOutputs(wire::kNormal | wire::kSemanticU32 | wire::kAmodal);
  }
  std::vector<std::string> folders(const Description& description) const override;
  std::string color_name(const Description& description, uint64_t image) const override;
  std::vector<std::string> file_names(const Description& description, uint64_t image,
                                      size_t instances) const override;
  Result<std::vector<std::vector<uint8_t>>> encode(const Description& description,
                                                   const sinks::FrameImage& image, const ImageLabels& labels,
                                                   std::vector<uint8_t> color) const override;
  Result<std::vector<offline::FolderFile>> list_files(const Description& description,
                                                      const offline::FrameLines& lines) const override;
  std::string conventions(const Description& description) const override;
};

std::vector<std::string> C3vdLayout::folders(const Description& description) const {
  return camera_folders(description);
}

std::string C3vdLayout::color_name(const Description& description, uint64_t image) const {
  return folder_of_image(description, image) + number_text(description.frame_of(image), "%llu") +
         "_color.png";
}

std::vector<std::string> C3vdLayout::file_names(const Description& description, uint64_t image,
                                                size_t) const {
  const std::string begin =
      folder_of_image(description, image) + number_text(description.frame_of(image), "%04llu");
  std::vector<std::string> names{color_name(description, image), begin + "_depth.tiff",
                                 begin + "_normals.tiff"};
  if (has_c3vd_flow(description, image)) names.push_back(begin + "_flow.tiff");
  return names;
}

Result<std::vector<std::vector<uint8_t>>> C3vdLayout::encode(const Description& description,
                                                             const sinks::FrameImage& image,
                                                             const ImageLabels& labels,
                                                             std::vector<uint8_t> color) const {
  std::vector<std::vector<uint8_t>> files;
  files.push_back(std::move(color));
  files.push_back(
      encode_tiff(c3vd_depth(plane_values<float>(image, wire::kDepthF32)), image.width, image.height, 1));
  const sinks::FramePlane* const normals = find_plane(image, wire::kNormal);
  FIRE3DV_ASSERT(normals);
  const glm::dmat3 camera_from_world(glm::inverse(labels.poses.world_from_camera));
  files.push_back(encode_tiff(c3vd_normals(normals->bytes, camera_from_world), image.width, image.height, 3));
  if (has_c3vd_flow(description, image.frame_index)) {
    FIRE3DV_ASSERT(image.flow_backward);
    files.push_back(
        encode_tiff(c3vd_flow(*image.flow_backward, plane_values<uint32_t>(image, wire::kInstanceU32)),
                    image.width, image.height, 3));
  }
  return files;
}

Result<std::vector<offline::FolderFile>> C3vdLayout::list_files(const Description& description,
                                                                const offline::FrameLines& lines) const {
  std::vector<std::string> poses(description.cameras.size());
  for (const auto& [image, text] : lines)
    poses[description.index_of_camera(image)] += c3vd_pose(ordered_json::parse(text));
  std::vector<offline::FolderFile> files = camera_matrices(description, lines);
  for (uint32_t camera = 0; camera < poses.size(); ++camera)
    files.push_back(text_file(camera_folder(description, camera) + "/pose.txt", poses[camera]));
  return files;
}

std::string C3vdLayout::conventions(const Description& description) const {
  std::string text = R"(C3VD's layout, one folder for each camera. Images are those of a pinhole.

| file | contents |
|---|---|
| `N_color.png` | 8-bit colours, sRGB |
| `NNNN_depth.tiff` | 16 bits: 0 to 65535 is 0 to 100 mm along the camera's axis; farther, and no surface: 65535 |
| `NNNN_normals.tiff` | 16 bits, RGB: x, y, z of the normal in the camera's axes, 0 to 65535 is -1 to 1; no surface: 0 |
| `pose.txt` | one line an image: camera to world, 4x4 by columns, millimetres |
| `cam.txt` | camera matrix by rows, pixels |

)";
  if (description.flow_frames != 0)
    text += "`NNNN_flow.tiff` of each image but the first " + counted(description.flow_frames, "frame") +
            ": 16 bits, RGB. Red and green are how far right and down the image " +
            counted(description.flow_frames, "frame") +
            " earlier shows the point, 0 to 65535 is -20 to 20 pixels, and more is cut off. Both are 0 where "
            "that image does not show the point, and where there is no surface.\n\n";
  return text +
         "Not written: `occlusion.png` (where a second surface lies behind the one that is seen), and "
         "the coverage mesh.\n";
}

std::vector<std::string> FolderLayout::folders(const Description& description) const {
  return camera_folders(description);
}

std::string FolderLayout::color_name(const Description& description, uint64_t image) const {
  return folder_of_image(description, image) + six_digits(description.frame_of(image)) + ".png";
}

std::vector<std::string> FolderLayout::file_names(const Description& description, uint64_t image,
                                                  size_t) const {
  const std::string begin = folder_of_image(description, image) + six_digits(description.frame_of(image));
  std::vector<std::string> names{color_name(description, image)};
  for (const char* ending :
       {".depth.npy", ".instance.npy", ".semantic.npy", ".normal.npy", ".amodal.npy", ".json"})
    names.push_back(begin + ending);
  if (description.is_stereo) names.push_back(begin + ".disparity.npy");
  if (description.flow_frames == 0) return names;
  for (const char* ending :
       {".flow_forward.npy", ".occlusion_forward.npy", ".flow_backward.npy", ".occlusion_backward.npy"})
    names.push_back(begin + ending);
  return names;
}

Result<std::vector<std::vector<uint8_t>>> FolderLayout::encode(const Description& description,
                                                               const sinks::FrameImage& image,
                                                               const ImageLabels& labels,
                                                               std::vector<uint8_t> color) const {
  std::vector<std::vector<uint8_t>> files;
  files.push_back(std::move(color));
  for (const auto output : {wire::kDepthF32, wire::kInstanceU32, wire::kSemanticU32, wire::kNormal}) {
    const sinks::FramePlane* const plane = find_plane(image, output);
    FIRE3DV_ASSERT(plane);
    files.push_back(sinks::encode_npy(*plane, image.width, image.height));
  }
  files.push_back(encode_silhouettes(image, labels));
  ordered_json json;
  add_json(labels, description, json);
  const std::string text = json.dump(1) + "\n";
  files.emplace_back(text.begin(), text.end());
  if (description.is_stereo) {
    if (!labels.poses.baseline_m) return Error{labels.poses.stereo_fault};
    files.push_back(encode_disparity(image, labels.poses));
  }
  if (description.flow_frames == 0) return files;
  FIRE3DV_ASSERT(image.flow_forward && image.flow_backward);
  add_flow_files(*image.flow_forward, image.width, image.height, files);
  add_flow_files(*image.flow_backward, image.width, image.height, files);
  return files;
}

Result<std::vector<offline::FolderFile>> FolderLayout::list_files(const Description& description,
                                                                  const offline::FrameLines& lines) const {
  return camera_matrices(description, lines);
}

std::string FolderLayout::conventions(const Description& description) const {
  std::string text = R"(One folder for each camera; `numpy.load` reads `.npy`.

| file | contents |
|---|---|
| `IMAGE.png` | 8-bit colours, sRGB |
| `IMAGE.depth.npy` | float32 (h, w): metres along the camera's axis; infinite: no surface |
| `IMAGE.instance.npy` | uint32 (h, w): instance, of the table below; 0: none |
| `IMAGE.semantic.npy` | uint32 (h, w): class; 0: none |
| `IMAGE.normal.npy` | float16 (h, w, 4): normal in the world, and 0 |
| `IMAGE.amodal.npy` | uint8 (n, h, ceil(w / 8)): silhouettes of the n instances of the JSON file, in its order; `numpy.unpackbits(a, axis=2, count=w)` |
| `IMAGE.json` | `cam_K`, `cam_R_w2c`, `cam_t_w2c` (mm), instances with poses (mm), boxes, visible masks (COCO's RLE), visible shares, keypoints |
| `cam.txt` | camera matrix of the first image by rows, pixels |
)";
  if (description.is_stereo)
    text +=
        "| `IMAGE.disparity.npy` | float32 (h, w): pixels between the two images of the pair, fx * baseline "
        "/ "
        "depth; x_left - x_right in both; 0: no surface. `IMAGE.json` has `baseline_m` |\n";
  if (description.flow_frames == 0) return text;
  const std::string apart = counted(description.flow_frames, "frame");
  return text + "| `IMAGE.flow_forward.npy` | float32 (h, w, 2): pixels right and down to where the image " +
         apart +
         " later shows the point that is visible here; NaN: behind that camera, hidden as a node, or no such "
         "image |\n| `IMAGE.occlusion_forward.npy` | uint8 (h, w): that image shows the point: 0 seen (also "
         "the "
         "background), 1 hidden, 2 outside, or no such image |\n| `IMAGE.flow_backward.npy`, "
         "`IMAGE.occlusion_backward.npy` | the same to the image " +
         apart + " earlier |\n";
}

}  // namespace

std::unique_ptr<Layout> make_c3vd_layout() {
  return std::make_unique<C3vdLayout>();
}

std::unique_ptr<Layout> make_folder_layout() {
  return std::make_unique<FolderLayout>();
}

}  // namespace fire3dv::dataset
