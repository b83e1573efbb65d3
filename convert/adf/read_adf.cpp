// Reader for AMBF's launch, world and model files (ADF). Launch files name a world and models; a world names
// its environment model. Files are read in AMBF's order: environment, lights and cameras of the world, models
// as listed.

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <optional>
#include <string>

#include "convert/adf/adf_objects.h"
#include "convert/adf/adf_visual.h"
#include "convert/adf/adf_yaml.h"
#include "convert/description_files.h"
#include "convert/model.h"
#include "convert/readers.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

// Targets of the blocks of ADF model and world files. Objects are appended in AMBF's creation order.
struct AdfReading {
  AdfReport& report;
  AdfVisuals& visuals;
  AdfObjects& objects;
  std::string name_prefix;  // AMBF's --ns
  size_t files = 0;         // model files read so far
};

using Kind = AdfObject::Kind;

std::string single_slashes(const std::string& text) {
  std::string single;
  for (const char c : text)
    if (c != '/' || single.empty() || single.back() != '/') single += c;
  return single;
}

// Returns namespace and block id. An absolute namespace of the block replaces the file's.
std::string identifier_of(const AdfFile& file, const AdfFile::Block& block, const AdfReading& reading) {
  const std::string outer = single_slashes(file["namespace"].text()),
                    own = single_slashes(block.value["namespace"].text());
  return reading.name_prefix + (own.starts_with('/') ? own : outer + own) + block.id;
}

// R = Rz(yaw) Ry(pitch) Rx(roll)
glm::dquat rotation_of(const AdfValue& orientation) {
  const glm::dvec3 rpy = orientation.vector(glm::dvec3(0), "rpy");
  return glm::angleAxis(rpy.z, glm::dvec3(0, 0, 1)) * glm::angleAxis(rpy.y, glm::dvec3(0, 1, 0)) *
         glm::angleAxis(rpy.x, glm::dvec3(1, 0, 0));
}

AdfObject object_of(Kind kind, const AdfFile& file, const AdfFile::Block& block, const AdfReading& reading) {
  AdfObject object;
  object.kind = kind;
  object.identifier = identifier_of(file, block, reading);
  object.location = block.value.location();
  object.id = block.id;
  object.file = reading.files;
  if (kind != Kind::body && kind != Kind::soft_body) object.parent = block.value["parent"].text();
  file.note_unknown_fields(block.value);
  return object;
}

bool read_bodies(const AdfFile& file, const char* list, Kind kind, AdfReading& reading) {
  const AdfSearchPaths search_paths{file.folder(), file["high resolution path"].text()};
  for (const AdfFile::Block& block : file.blocks(list)) {
    AdfObject object = object_of(kind, file, block, reading);
    const AdfValue location = block.value["location"];
    object.translation = location["position"].vector(glm::dvec3(0));
    object.rotation = rotation_of(location["orientation"]);
    const AdfAppearance appearance = reading.visuals.appearance_of(block.value, block.id, search_paths);
    object.mesh = appearance.mesh;
    object.scale = block.value["scale"].number(1);
    object.dropped_by_ambf = appearance.mesh_is_missing;
    if (!reading.objects.add(std::move(object))) return false;
  }
  return true;
}

bool read_cameras(const AdfFile& file, AdfReading& reading) {
  for (const AdfFile::Block& block : file.blocks("cameras")) {
    AdfObject object = object_of(Kind::camera, file, block, reading);
    const AdfValue& b = block.value;
    object.translation = b["location"].vector(glm::dvec3(0));
    const auto rotation = adf_camera_rotation(object.translation, b["look at"].vector(glm::dvec3(0)),
                                              b["up"].vector(glm::dvec3(0, 0, 1)));
    if (rotation)
      object.rotation = *rotation;
    else
      b.warn("its \"look at\" equals its position or lies along its \"up\": its direction is undefined");

    const double fov = b["field view angle"].number(0.7);
    object.camera.vertical_fov_rad = static_cast<float>(std::clamp(fov, 0.01, 3.1));
    if (fov < 0.01 || fov > 3.1) b["field view angle"].warn("is not an angle that a camera can have");
    double near = b["clipping plane"]["near"].number(0.1), far = b["clipping plane"]["far"].number(10);
    if (!(near >= 1e-6 && far > near && far <= 1e9)) {
      b["clipping plane"].warn("does not hold 0 < near < far; taken as 0.1 and 10");
      near = 0.1;
      far = 10;
    }
    object.camera.near_m = static_cast<float>(near);
    object.camera.far_m = static_cast<float>(far);
    if (b["orthographic view width"].is_defined())
      b["orthographic view width"].warn(
          "requests an orthographic camera; it is converted to a perspective one");
    if (b["stereo"].is_map()) object.eye_separation_m = b["stereo"]["eye separation"].number(0.2);
    if (!reading.objects.add(std::move(object))) return false;
  }
  return true;
}

bool read_lights(const AdfFile& file, AdfReading& reading) {
  for (const AdfFile::Block& block : file.blocks("lights")) {
    AdfObject object = object_of(Kind::light, file, block, reading);
    const AdfValue& b = block.value;
    object.translation = b["location"].vector(glm::dvec3(0));
    const AdfValue direction = b["direction"];
    if (const auto rotation = adf_light_rotation(direction.vector(glm::dvec3(0))))
      object.rotation = *rotation;
    else
      b.warn("has no \"direction\"; it shines along X, as in AMBF");
    // AMBF's approximate conversion to degrees, and the limit of its library.
    const double half_angle_deg = std::clamp(b["cutoff angle"].number(0.7) * (180 / 3.14), 0.5, 90.0);
    object.light.type = Light::Type::spot;
    object.light.outer_cone_rad = static_cast<float>(glm::radians(half_angle_deg));
    // AMBF's cone edge is hard; glTF needs a non-zero width.
    object.light.inner_cone_rad = 0.97f * object.light.outer_cone_rad;
    const AdfValue attenuation = b["attenuation"];
    object.attenuation = {attenuation["constant"].number(1), attenuation["linear"].number(0),
                          attenuation["quadratic"].number(0)};
    if (!reading.objects.add(std::move(object))) return false;
  }
  return true;
}

void read_joints(const AdfFile& file, AdfReading& reading) {
  for (const AdfFile::Block& block : file.blocks("joints"))
    if (std::optional<AdfJoint> joint = read_adf_joint(block, reading.files))
      reading.objects.add(std::move(*joint));
}

void warn_about_ignored_fields(const AdfFile& file, std::initializer_list<const char*> lists) {
  for (const char* list : lists) {
    const AdfValue value = file[list];
    if (value.is_map() || !value.items().empty()) value.warn("is not converted");
  }
}

// Reads bodies, soft bodies, ghost objects, cameras and lights. Returns false when an object was skipped for
// lack of room.
bool read_adf_model(const AdfFile& file, AdfReading& reading) {
  file.note_unknown_fields();
  reading.visuals.allow_images_below(file.folder());
  warn_about_ignored_fields(file, {"vehicles", "volumes"});
  ++reading.files;
  read_joints(file, reading);
  return read_bodies(file, "bodies", Kind::body, reading) &&
         read_bodies(file, "soft bodies", Kind::soft_body, reading) &&
         read_bodies(file, "ghost objects", Kind::ghost, reading) && read_cameras(file, reading) &&
         read_lights(file, reading);
}

// Reads lights and cameras of a world file. Its environment is a model file and must be read first. Returns
// false when an object was skipped for lack of room.
bool read_adf_world(const AdfFile& file, AdfReading& reading) {
  file.note_unknown_fields();
  warn_about_ignored_fields(file, {"skybox"});
  return read_lights(file, reading) && read_cameras(file, reading);
}

class AdfReader {
 public:
  AdfReader(const ReadOptions& options, Model& model)
      : model_(model),
        report_(model),
        visuals_(model, options.max_triangles),
        objects_(report_),
        reading_{report_, visuals_, objects_, options.name_space},
        options_(options) {}

  Result<void> read(const std::filesystem::path& named) {
    Result<AdfFile> file = open(named);
    if (!file) return file.error();
    open_.push_back(named);
    visuals_.allow_images_below(named.parent_path());
    visuals_.set_smooth_angle(options_.smooth_angle_deg);
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
    if (bytes_read_ > options_.max_adf_bytes)
      return Error{"the files before it have more than " + std::to_string(options_.max_adf_bytes >> 10) +
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
