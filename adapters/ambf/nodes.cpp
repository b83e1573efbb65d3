#include "adapters/ambf/nodes.h"

#include <yaml-cpp/yaml.h>
#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <unordered_set>
#include <utility>

#include "protocol/wire/check.h"
#include "protocol/wire/decode.h"

namespace fire3dv::ambf {

NodeTable::NodeTable(const std::vector<Object>& objects, Options::Names names) {
  const uint32_t limit = wire::DecodeLimits().max_name_bytes;
  std::unordered_set<std::string> taken;
  for (const Object& object : objects) {
    if (object.kind == Kind::soft_body) {
      nodes_.emplace_back();
      continue;
    }
    const std::string& name = names == Options::Names::key ? object.key : object.name;
    const auto good = wire::check_text("name", name, limit);
    const char* const reason = name.empty() ? "it has no name"
                               : !good.ok()
                                   ? "no renderer takes a name with such characters or of that length"
                               : !taken.insert(name).second ? "another object has this name"
                                                            : nullptr;
    if (reason) {
      warnings_.push_back("'" + name + "' is left out: " + reason);
      nodes_.emplace_back();
      continue;
    }
    nodes_.emplace_back(names_.size());
    names_.push_back(name);
  }
}

std::optional<size_t> find_parent(const std::vector<Object>& objects, const std::vector<size_t>& added,
                                  size_t child, const std::string& name) {
  if (name.empty()) return std::nullopt;
  const auto has_name = [&](size_t object) { return objects[object].key.find(name) != std::string::npos; };
  const auto at_child = std::find(added.begin(), added.end(), child);
  struct Answer {
    std::optional<size_t> exact, part;
    size_t parts = 0;
  };
  std::map<Kind, Answer> answers;
  for (auto it = added.begin(); it != at_child; ++it) {
    if (!has_name(*it)) continue;
    Answer& answer = answers[objects[*it].kind];
    if (objects[*it].key == name) answer.exact = *it;
    answer.part = *it;
    ++answer.parts;
  }
  std::optional<size_t> found;
  size_t kinds = 0;
  for (const auto& [kind, answer] : answers) {
    if (!answer.exact && answer.parts != 1) continue;
    found = answer.exact ? answer.exact : answer.part;
    ++kinds;
  }
  if (kinds == 1) return found;
  if (at_child == added.end()) return std::nullopt;
  const auto later = std::find_if(at_child + 1, added.end(), has_name);
  if (later == added.end()) return std::nullopt;
  return *later;
}

namespace {

namespace fs = std::filesystem;

void read_vector(const YAML::Node& node, double (&vector)[3]) {
  if (!node) return;
  vector[0] = node["x"].as<double>();
  vector[1] = node["y"].as<double>();
  vector[2] = node["z"].as<double>();
}

bool normalise(double (&v)[3]) {
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (!(length > 1e-9) || !std::isfinite(length)) return false;
  for (double& element : v) element /= length;
  return true;
}

void cross(const double (&a)[3], const double (&b)[3], double (&result)[3]) {
  for (size_t i = 0; i < 3; ++i)
    result[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

std::string without_doubled_slashes(const std::string& text) {
  std::string clean;
  for (const char c : text) {
    if (c != '/' || clean.empty() || clean.back() != '/') clean.push_back(c);
  }
  return clean;
}

// Defaults are those of AMBF.
CameraDefinition read_camera(const YAML::Node& block, const std::string& id, const std::string& name_space) {
  CameraDefinition camera;
  std::string name = block["name"] ? block["name"].as<std::string>() : "";
  name.erase(std::remove(name.begin(), name.end(), ' '), name.end());
  const YAML::Node own = block["namespace"];
  const std::string prefix = merge_namespaces(name_space, own ? own.as<std::string>() : "");
  camera.key = prefix + id;
  camera.name = prefix + name;
  if (block["parent"]) camera.parent = block["parent"].as<std::string>();

  double position[3]{}, target[3]{}, up[3]{0, 0, 1};
  read_vector(block["location"], position);
  read_vector(block["look at"], target);
  read_vector(block["up"], up);
  const auto frame = look_at(position, target, up);
  if (frame) camera.parent_from_camera = *frame;

  if (!block["orthographic view width"]) {
    Intrinsics intrinsics;
    if (const YAML::Node plane = block["clipping plane"]) {
      intrinsics.near_m = plane["near"].as<double>();
      intrinsics.far_m = plane["far"].as<double>();
    }
    if (block["field view angle"]) intrinsics.vertical_fov_rad = block["field view angle"].as<double>();
    intrinsics.two_eyes = static_cast<bool>(block["stereo"]);
    camera.intrinsics = intrinsics;
  }
  return camera;
}

// Lists of a file in AMBF's creation order.
struct List {
  const char* name;
  Kind kind;
};
constexpr List kModelLists[] = {{"bodies", Kind::rigid_body},
                                {"soft bodies", Kind::soft_body},
                                {"ghost objects", Kind::ghost_object},
                                {"cameras", Kind::camera},
                                {"lights", Kind::light}};
constexpr List kWorldLists[] = {{"lights", Kind::light}, {"cameras", Kind::camera}};

class Reading {
 public:
  explicit Reading(const std::string& prefix) : prefix_(prefix) {}

  void read_file(const fs::path& file, std::span<const List> lists) {
    try {
      const YAML::Node root = YAML::LoadFile(file.string());
      const std::string name_space = root["namespace"] ? root["namespace"].as<std::string>() : "";
      for (const List& list : lists) {
        const YAML::Node ids = root[list.name];
        if (!ids || !ids.IsSequence()) continue;
        for (const YAML::Node& id_node : ids) read_object(file, root, id_node, name_space, list.kind);
      }
    } catch (const YAML::Exception& error) {
      found.warnings.push_back(file.string() + ": " + error.what() + "; its cameras are left out");
    }
  }

  CameraDefinitions found;

 private:
  void read_object(const fs::path& file, const YAML::Node& root, const YAML::Node& id_node,
                   const std::string& name_space, Kind kind) {
    if (!id_node.IsScalar()) return;
    const std::string id = id_node.as<std::string>();
    const YAML::Node block = root[id];
    if (!block || !block.IsMap()) return;
    if (kind != Kind::camera) {
      const YAML::Node own = block["namespace"];
      list(kind, merge_namespaces(name_space, own && own.IsScalar() ? own.as<std::string>() : "") + id);
      return;
    }
    try {
      CameraDefinition camera = read_camera(block, id, name_space);
      camera.key = list(kind, camera.key);
      camera.name = prefix_ + camera.name;
      found.cameras.push_back(std::move(camera));
    } catch (const YAML::Exception& error) {
      found.warnings.push_back(file.string() + ": camera " + id + ": " + error.what());
    }
  }

  // AMBF appends a number to a key that exists already.
  std::string list(Kind kind, const std::string& identifier) {
    std::string key = prefix_ + identifier;
    for (size_t number = 1; !keys_.emplace(kind, key).second; ++number)
      key = prefix_ + identifier + std::to_string(number);
    found.listed.push_back({kind, key});
    return key;
  }

  const std::string prefix_;
  std::set<std::pair<Kind, std::string>> keys_;
};

// Returns the world's environment model, which may define cameras, too. Empty: none.
fs::path environment_of(const fs::path& world) {
  try {
    const YAML::Node environment = YAML::LoadFile(world.string())["environment"];
    if (environment) return world.parent_path() / environment.as<std::string>();
  } catch (const YAML::Exception&) {
    // read_file has reported the error already.
  }
  return {};
}

}  // namespace

std::string merge_namespaces(const std::string& outer, const std::string& inner) {
  const std::string name = without_doubled_slashes(inner);
  return !name.empty() && name.front() == '/' ? name : without_doubled_slashes(outer) + name;
}

std::optional<Transform> look_at(const double (&position)[3], const double (&target)[3],
                                 const double (&up)[3]) {
  double x[3], y[3], z[3]{up[0], up[1], up[2]};
  for (size_t i = 0; i < 3; ++i) x[i] = position[i] - target[i];
  if (!normalise(x) || !normalise(z)) return std::nullopt;
  cross(z, x, y);
  if (!normalise(y)) return std::nullopt;
  cross(x, y, z);
  Transform frame;
  for (size_t row = 0; row < 3; ++row) {
    frame.m[0][row] = x[row];
    frame.m[1][row] = y[row];
    frame.m[2][row] = z[row];
    frame.m[3][row] = position[row];
  }
  return frame;
}

CameraDefinitions read_cameras(const Launch& launch) {
  Reading reading(launch.name_space);
  if (!launch.world.empty()) {
    const fs::path environment = environment_of(launch.world);
    if (!environment.empty()) reading.read_file(environment, kModelLists);
    reading.read_file(launch.world, kWorldLists);
  }
  for (const fs::path& model : launch.models) reading.read_file(model, kModelLists);
  return std::move(reading.found);
}

}  // namespace fire3dv::ambf
