#include <algorithm>
#include <cstring>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <span>
#include <tuple>
#include <utility>

#include "base/files.h"
#include "renderer/dataset/layouts/hdf5_file.h"
#include "renderer/dataset/layouts/image_files.h"
#include "renderer/dataset/layouts/layouts.h"
#include "renderer/sinks/output_text.h"

namespace fire3dv::dataset {
namespace {

using nlohmann::ordered_json;

// All planes and labels of an image in memory, and the file made of them.
constexpr uint64_t kMaxImageBytes = uint64_t{1} << 30;
constexpr uint64_t kBytesPerPixel = 3 + 4 + 4 + 4 + 6;

class Hdf5Layout final : public Layout {
 public:
  Result<void> check(const Description& description) const override;
  wire::ImageOutputs further_outputs() const override {
    return wire::ImageOutputs(wire::kNormal | wire::kSemanticU32 | wire::kAmodal);
  }
  std::vector<std::string> folders(const Description&) const override { return {"images"}; }
  std::string color_name(const Description&, uint64_t image) const override {
    return "images/" + six_digits(image) + ".hdf5";
  }
  Result<std::vector<uint8_t>> read_color(const std::filesystem::path& folder, const Description& description,
                                          uint64_t image) const override;
  std::vector<std::string> file_names(const Description& description, uint64_t image, size_t) const override {
    return {color_name(description, image)};
  }
  Result<std::vector<std::vector<uint8_t>>> encode(const Description& description,
                                                   const sinks::FrameImage& image, const ImageLabels& labels,
                                                   std::vector<uint8_t> color) const override;
  Result<std::vector<offline::FolderFile>> list_files(const Description& description,
                                                      const offline::FrameLines& lines) const override;
  std::string conventions(const Description& description) const override;
};

Result<void> Hdf5Layout::check(const Description& description) const {
  if (uint64_t{description.width} * description.height * kBytesPerPixel > kMaxImageBytes)
    return Error{"images of " + std::to_string(description.width) + "x" + std::to_string(description.height) +
                 " are too large for --format hdf5: choose a smaller --size, or another format"};
  return can_write_hdf5();
}

std::vector<double> rows_of(const glm::dmat4& matrix) {
  std::vector<double> rows;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) rows.push_back(matrix[column][row]);
  }
  return rows;
}

std::vector<double> camera_matrix(const passes::Intrinsics& k) {
  return {double{k.fx_px}, 0, double{k.cx_px}, 0, double{k.fy_px}, double{k.cy_px}, 0, 0, 1};
}

void append(std::vector<int32_t>& values, const Rectangle& box) {
  for (const int64_t value : {box.left, box.top, box.width, box.height})
    values.push_back(static_cast<int32_t>(value));
}

// Planes without the alpha of colours and the fourth element of normals.
void add_planes(const sinks::FrameImage& image, Hdf5File& file) {
  const uint64_t height = image.height, width = image.width;
  std::vector<uint8_t> colors;
  colors.reserve(width * height * 3);
  for (size_t at = 0; at + 4 <= image.rgba8.size(); at += 4)
    colors.insert(colors.end(), image.rgba8.data() + at, image.rgba8.data() + at + 3);
  file.add_array("/colors", Hdf5Type::u8, {height, width, 3}, colors, true);
  for (const auto& [name, output, type] : {std::tuple("/depth", wire::kDepthF32, Hdf5Type::f32),
                                           std::tuple("/instance", wire::kInstanceU32, Hdf5Type::u32),
                                           std::tuple("/semantic", wire::kSemanticU32, Hdf5Type::u32)}) {
    const sinks::FramePlane* const plane = find_plane(image, output);
    FIRE3DV_ASSERT(plane);
    file.add_array(name, type, {height, width}, plane->bytes, true);
  }
  const sinks::FramePlane* const plane = find_plane(image, wire::kNormal);
  FIRE3DV_ASSERT(plane);
  std::vector<uint8_t> normals;
  normals.reserve(width * height * 6);
  for (size_t at = 0; at + 8 <= plane->bytes.size(); at += 8)
    normals.insert(normals.end(), plane->bytes.data() + at, plane->bytes.data() + at + 6);
  file.add_array("/normals", Hdf5Type::f16, {height, width, 3}, normals, true);
}

// One row for each labelled instance.
void add_instances(const Description& description, const ImageLabels& labels, Hdf5File& file) {
  std::vector<uint32_t> numbers, objects, classes, visible_px, silhouette_px;
  std::vector<int32_t> visible_boxes, silhouette_boxes;
  std::vector<double> poses, shares;
  std::vector<uint8_t> truncated;
  for (const InstanceLabel& label : labels.instances) {
    const Instance& instance = description.instances[label.index];
    const Silhouette& silhouette = label.silhouette.value();
    numbers.push_back(label.number);
    objects.push_back(description.objects[instance.object].id);
    classes.push_back(instance.semantic);
    glm::dmat4 pose(1);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        pose[column][row] = label.camera_from_model[static_cast<size_t>(3 * row + column)];
      pose[3][row] = label.camera_from_model_mm[static_cast<size_t>(row)] / kMillimetres;
    }
    const std::vector<double> rows = rows_of(pose);
    poses.insert(poses.end(), rows.begin(), rows.end());
    append(visible_boxes, label.visible_box);
    append(silhouette_boxes, silhouette.box);
    visible_px.push_back(static_cast<uint32_t>(label.visible_px));
    silhouette_px.push_back(static_cast<uint32_t>(silhouette.px));
    shares.push_back(silhouette.visibility);
    truncated.push_back(silhouette.is_truncated);
  }
  const uint64_t count = numbers.size();
  file.add_group("/instances");
  file.add_numbers("/instances/instance", Hdf5Type::u32, {count}, numbers);
  file.add_numbers("/instances/obj_id", Hdf5Type::u32, {count}, objects);
  file.add_numbers("/instances/class", Hdf5Type::u32, {count}, classes);
  file.add_numbers("/instances/camera_from_model", Hdf5Type::f64, {count, 4, 4}, poses);
  file.add_numbers("/instances/bbox_visib", Hdf5Type::i32, {count, 4}, visible_boxes);
  file.add_numbers("/instances/bbox_obj", Hdf5Type::i32, {count, 4}, silhouette_boxes);
  file.add_numbers("/instances/px_count_visib", Hdf5Type::u32, {count}, visible_px);
  file.add_numbers("/instances/px_count_all", Hdf5Type::u32, {count}, silhouette_px);
  file.add_numbers("/instances/visib_fract", Hdf5Type::f64, {count}, shares);
  file.add_numbers("/instances/truncated", Hdf5Type::u8, {count}, truncated);
}

// One row for each keypoint of dataset.json, in its order.
void add_keypoints(const ImageLabels& labels, Hdf5File& file) {
  std::vector<double> pixels, depths;
  std::vector<uint8_t> states;
  for (const KeypointLabel& label : labels.keypoints) {
    pixels.insert(pixels.end(), {label.x_px, label.y_px});
    depths.push_back(label.depth_m);
    states.push_back(static_cast<uint8_t>(label.state));
  }
  const uint64_t count = states.size();
  file.add_group("/keypoints");
  file.add_numbers("/keypoints/pixel", Hdf5Type::f64, {count, 2}, pixels);
  file.add_numbers("/keypoints/depth", Hdf5Type::f64, {count}, depths);
  file.add_numbers("/keypoints/state", Hdf5Type::u8, {count}, states);
}

void add_units(const std::string& group, Hdf5File& file) {
  for (const auto& [name, unit] :
       {std::pair("colors", "sRGB, 0 to 255"), std::pair("depth", "m along the camera's axis; inf: none"),
        std::pair("normals", "unit vector in the world"), std::pair("cam_K", "pixels"),
        std::pair("world_from_camera", "m; camera axes right, down, forward")})
    file.add_text(group + name, "unit", unit);
}

Result<std::vector<std::vector<uint8_t>>> Hdf5Layout::encode(const Description& description,
                                                             const sinks::FrameImage& image,
                                                             const ImageLabels& labels,
                                                             std::vector<uint8_t>) const {
  auto file = Hdf5File::create();
  if (!file) return file.error();
  add_planes(image, *file);
  file->add_numbers("/cam_K", Hdf5Type::f64, {3, 3}, camera_matrix(labels.poses.intrinsics));
  file->add_numbers("/world_from_camera", Hdf5Type::f64, {4, 4}, rows_of(labels.poses.world_from_camera));
  add_units("/", *file);
  add_instances(description, labels, *file);
  add_keypoints(labels, *file);
  file->add_text("/", "camera", description.cameras[description.index_of_camera(image.frame_index)]);
  file->add_text("/", "license", description.license);
  auto bytes = file->finish();
  if (!bytes) return bytes.error();
  std::vector<std::vector<uint8_t>> files;
  files.push_back(std::move(*bytes));
  return files;
}

Result<std::vector<uint8_t>> Hdf5Layout::read_color(const std::filesystem::path& folder,
                                                    const Description& description, uint64_t image) const {
  const uint64_t pixels = uint64_t{description.width} * description.height;
  auto colors = read_hdf5_bytes(folder / color_name(description, image), "/colors", 3 * pixels);
  if (!colors) return colors.error();
  std::vector<uint8_t> rgba8(4 * pixels, 255);
  for (size_t i = 0; i < pixels; ++i) std::copy_n(colors->data() + 3 * i, 3, rgba8.data() + 4 * i);
  return rgba8;
}

// data.hdf5: the images of each camera as one array.
Result<std::vector<offline::FolderFile>> Hdf5Layout::list_files(const Description& description,
                                                                const offline::FrameLines& lines) const {
  auto file = Hdf5File::create();
  if (!file) return file.error();
  const uint64_t height = description.height, width = description.width;
  for (uint32_t camera = 0; camera < description.cameras.size(); ++camera) {
    std::vector<std::string> files;
    for (const auto& [image, line] : lines) {
      if (description.index_of_camera(image) == camera) files.push_back(color_name(description, image));
    }
    const std::string group = "/" + camera_folder(description, camera);
    file->add_group(group);
    const auto add = [&](const char* name, Hdf5Type type, const std::vector<uint64_t>& shape) {
      file->add_virtual_array(group + name, type, shape, files, name);
    };
    add("/colors", Hdf5Type::u8, {height, width, 3});
    add("/depth", Hdf5Type::f32, {height, width});
    add("/instance", Hdf5Type::u32, {height, width});
    add("/semantic", Hdf5Type::u32, {height, width});
    add("/normals", Hdf5Type::f16, {height, width, 3});
    add("/cam_K", Hdf5Type::f64, {3, 3});
    add("/world_from_camera", Hdf5Type::f64, {4, 4});
    add_units(group + "/", *file);
  }
  auto bytes = file->finish();
  if (!bytes) return bytes.error();
  std::vector<offline::FolderFile> lists;
  lists.push_back({"data.hdf5", std::move(*bytes)});
  return lists;
}

std::string Hdf5Layout::conventions(const Description&) const {
  return R"(HDF5 files; `h5py.File` reads them. `images/IMAGE.hdf5` is one image; images of one moment follow
one another, camera by camera. `data.hdf5` has a group for each camera, whose arrays join those of its
images (virtual arrays): keep it beside `images`.

| array | shape, type | contents |
|---|---|---|
| `colors` | (h, w, 3) uint8 | sRGB |
| `depth` | (h, w) float32 | metres along the camera's axis; infinite: no surface |
| `instance` | (h, w) uint32 | instance, of the table below; 0: none |
| `semantic` | (h, w) uint32 | class; 0: none |
| `normals` | (h, w, 3) float16 | normal in the world; 0: no surface |
| `cam_K` | (3, 3) float64 | camera matrix, pixels |
| `world_from_camera` | (4, 4) float64 | pose of the camera, metres; columns are its axes right, down, forward, and its place |

In `data.hdf5` each has one more dimension in front: the image. The HDF5 library keeps all files of an array
open that it reads, and reports none that it cannot open. Their images are NaN in `depth`, `normals`, `cam_K`
and `world_from_camera`, 4294967295 in `instance` and `semantic`, and black in `colors`: raise `ulimit -n`
above the number of images, or read `images/IMAGE.hdf5`.

Only `images/IMAGE.hdf5` has

| array | shape, type | contents |
|---|---|---|
| `instances/instance`, `obj_id`, `class` | (n) uint32 | the labelled instances |
| `instances/camera_from_model` | (n, 4, 4) float64 | pose of the model in the camera, metres |
| `instances/bbox_visib`, `bbox_obj` | (n, 4) int32 | left, top, width, height of the visible part, and of the silhouette; -1: hidden |
| `instances/px_count_visib`, `px_count_all` | (n) uint32 | their pixels |
| `instances/visib_fract` | (n) float64 | visible share of the silhouette |
| `instances/truncated` | (n) uint8 | 1: a part is outside of the image |
| `keypoints/pixel`, `depth`, `state` | (k, 2), (k), (k) | x and y from the centre of the top left pixel; metres; 0 outside, 1 hidden, 2 visible; in the order of `keypoints` in `dataset.json` |
)";
}

}  // namespace

std::unique_ptr<Layout> make_hdf5_layout() {
  return std::make_unique<Hdf5Layout>();
}

}  // namespace fire3dv::dataset
