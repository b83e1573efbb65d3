#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/files.h"
#include "convert/description_files.h"
#include "convert/mesh/mesh_files.h"
#include "convert/mesh/mesh_store.h"
#include "convert/mesh/text/mesh_text.h"
#include "convert/readers.h"
#include "renderer/scene/files.h"
#include "renderer/scene/gltf/foreign_file.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

bool says_its_frame(const std::string& extension) {
  return extension == ".dae" || extension == ".3mf";
}

// Whole names of an OBJ file by their first word, which is all that assimp reads. Words that begin several
// names are left out.
std::map<std::string, std::string> names_with_blanks(const fs::path& file) {
  std::map<std::string, std::string> names;
  std::ifstream bytes(file, std::ios::binary);
  std::array<char, 4> head{};
  bytes.read(head.data(), head.size());
  const bool is_utf16 = utf8_of_utf16({head.data(), head.size()}).has_value();
  bytes.clear();
  bytes.seekg(0);
  std::istringstream decoded;
  if (is_utf16)
    decoded.str(
        *utf8_of_utf16(std::string(std::istreambuf_iterator<char>(bytes), std::istreambuf_iterator<char>())));
  std::istream& in = is_utf16 ? static_cast<std::istream&>(decoded) : bytes;
  constexpr size_t kMaxLines = 100'000'000, kMaxName = 1024;
  std::string line;
  for (size_t i = 0; i < kMaxLines && std::getline(in, line); ++i) {
    const bool is_name = line.starts_with("o ") || line.starts_with("g ");
    if (!is_name || line.size() > kMaxName) continue;
    const size_t first = line.find_first_not_of(" \t", line.find(' '));
    const size_t last = line.find_last_not_of(" \t\r");
    if (first == std::string::npos || last < first) continue;
    const std::string name = sanitize_text(line.substr(first, last + 1 - first));
    const std::string word = name.substr(0, name.find_first_of(" \t"));
    const auto [known, is_new] = names.try_emplace(word, name);
    if (!is_new && known->second != name) known->second = word;
  }
  return names;
}

class SceneModel {
 public:
  SceneModel(const fs::path& file, const ReadOptions& options, Model& model)
      : file_(file), extension_(lower_extension(file)), options_(options), model_(model) {
    model_.name = sanitize_text(file.stem().string());
    unit_m_ = options.mesh_unit_m.value_or(1);
    const bool is_y_up = options.mesh_up ? *options.mesh_up == MeshUp::y : extension_ == ".obj";
    if (is_y_up) model_.gltf_from_model = glm::dquat(1, 0, 0, 0);
  }

  Result<void> take(ImportedMesh mesh) {
    if (extension_ == ".obj") names_ = names_with_blanks(file_);
    std::vector<Mesh> meshes(mesh.nodes.size());
    for (size_t i = 0; i < mesh.surfaces.size(); ++i) {
      Surface& surface = mesh.surfaces[i];
      if (Result<void> scaled = scale(surface); !scaled) return scaled;
      meshes[mesh.surface_nodes[i]].surfaces.push_back(std::move(surface));
    }
    // The importer's root stands for the file, as the root of the model does, unless it has a mesh.
    const bool drops_root = mesh.nodes.size() > 1 && meshes[0].surfaces.empty();
    MeshStore store(model_, options_.max_triangles);
    for (size_t i = drops_root ? 1 : 0; i < mesh.nodes.size(); ++i) {
      const int64_t parent = mesh.nodes[i].parent - (drops_root ? 1 : 0);
      Node node;
      node.name = name_of(mesh.nodes[i], i);
      if (parent >= 0) node.parent = static_cast<size_t>(parent);
      const glm::dmat4 pose =
          parent >= 0 ? glm::inverse(mesh.nodes[static_cast<size_t>(mesh.nodes[i].parent)].file_from_node) *
                            mesh.nodes[i].file_from_node
                      : mesh.nodes[i].file_from_node;
      node.translation = without_rounding(glm::dvec3(pose[3]) * unit_m_);
      node.rotation = without_rounding(glm::quat_cast(glm::dmat3(pose)));
      meshes[i].name = node.name;
      node.mesh = store.add(std::move(meshes[i]));
      model_.nodes.push_back(std::move(node));
    }
    if (store.is_full()) return Error{quote(file_.string()) + ": " + store.why_full()};
    for (const std::string& loss : mesh.losses)
      model_.warnings.push_back(quote(file_.string()) + ": " + loss +
                                " are left out; export glTF to keep them");
    return {};
  }

 private:
  static glm::dvec3 without_rounding(glm::dvec3 v) {
    for (int i = 0; i < 3; ++i)
      if (std::abs(v[i]) < 1e-12) v[i] = 0;
    return v;
  }
  // Poses of 32 bits that are no rotation.
  static glm::dquat without_rounding(const glm::dquat& q) {
    return std::abs(q.w) > 1 - 1e-12 ? glm::dquat(1, 0, 0, 0) : q;
  }

  Result<void> scale(Surface& surface) const {
    if (unit_m_ == 1) return {};
    for (glm::vec3& position : surface.positions) {
      position = glm::vec3(glm::dvec3(position) * unit_m_);
      if (!std::isfinite(position.x + position.y + position.z))
        return Error{quote(file_.string()) + ": a vertex is too far away for a number of 32 bits"};
    }
    return {};
  }

  std::string name_of(const ImportedNode& node, size_t index) const {
    const bool stands_for_none = node.name.empty() || node.name.starts_with('<') ||
                                 node.name == "defaultobject" || node.name.starts_with("$ColladaAutoName$");
    if (!stands_for_none) {
      const auto whole = names_.find(node.name);
      return whole == names_.end() ? node.name : whole->second;
    }
    return model_.name + (index <= 1 ? "" : " " + std::to_string(index));
  }

  const fs::path& file_;
  const std::string extension_;
  const ReadOptions& options_;
  Model& model_;
  double unit_m_ = 1;
  std::map<std::string, std::string> names_;
};

// The error names the format of a file whose contents are of another one than its name says.
Result<void> check_format(const fs::path& file, const std::string& extension) {
  std::array<char, 4096> buffer{};
  std::ifstream in(file, std::ios::binary);
  in.read(buffer.data(), buffer.size());
  const std::string_view bytes(buffer.data(), static_cast<size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  const std::optional<std::string> decoded =
      extension == ".obj" || extension == ".dae" ? utf8_of_utf16(bytes) : std::nullopt;
  const std::string_view head = decoded ? *decoded : bytes;
  const auto has = [&](std::string_view text) { return head.find(text) != std::string_view::npos; };
  if (extension == ".ply" && head.starts_with("ply")) return {};
  if (extension == ".dae" && has("<COLLADA")) return {};
  if (extension == ".3mf" && head.starts_with("PK\x03\x04")) return {};
  // A binary STL may begin with anything; its size tells.
  if (extension == ".stl" && head.size() >= 84) {
    uint32_t triangles = 0;
    std::memcpy(&triangles, head.data() + 80, sizeof triangles);
    std::error_code error;
    if (fs::file_size(file, error) == 84 + uint64_t{50} * triangles) return {};
  }
  const std::string name = quote(file.string());
  if (head.starts_with("glTF")) return Error{name + " is glTF already: give it to fire3dv as it is"};
  // Without a name: what the contents say, not the extension.
  const std::optional<scene::FileFormat> other = scene::foreign_format(std::as_bytes(std::span(head)), {});
  if (other && other->name.starts_with("an STL") && extension == ".stl") return {};
  if (other && !other->name.empty()) return Error{name + " is " + other->name + ": " + other->remedy};
  return {};
}

}  // namespace

bool is_mesh_scene_name(const fs::path& file) {
  constexpr std::string_view kExtensions[] = {".obj", ".stl", ".ply", ".dae", ".3mf"};
  const std::string extension = lower_extension(file);
  return std::find(std::begin(kExtensions), std::end(kExtensions), extension) != std::end(kExtensions);
}

Result<Model> read_mesh_scene(const fs::path& file, const ReadOptions& options) {
  if ((options.mesh_up || options.mesh_unit_m) && says_its_frame(lower_extension(file)))
    return Error{quote(file.string()) + " names its own unit and axes: remove --up and --unit"};
  if (const Result<fs::path> resolved = regular_file(file); !resolved) return resolved.error();
  if (Result<void> fits = check_format(file, lower_extension(file)); !fits) return fits.error();
  Model model;
  MeshFiles files(model);
  files.set_smooth_angle(options.smooth_angle_deg);
  Result<ImportedMesh> mesh = files.scene(file);
  if (!mesh) return mesh.error();
  if (Result<void> taken = SceneModel(file, options, model).take(std::move(*mesh)); !taken)
    return taken.error();
  return model;
}

}  // namespace fire3dv::convert
