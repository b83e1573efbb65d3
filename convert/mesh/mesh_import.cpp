#include "convert/mesh/mesh_import.h"

#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/mesh.h>
#include <assimp/scene.h>
#include <assimp/texture.h>
#include <algorithm>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "base/color/srgb.h"
#include "base/files.h"
#include "convert/description_files.h"
#include "convert/mesh/geometry/triangulate.h"
#include "convert/mesh/gltf_mesh.h"
#include "convert/mesh/mesh_store.h"
#include "convert/mesh/mtl.h"
#include "convert/mesh/node_frames.h"
#include "convert/mesh/ply.h"
#include "convert/mesh/stl.h"
#include "convert/mesh/text/dae_repair.h"
#include "convert/mesh/text/mesh_text.h"
#include "convert/mesh/text/obj_text.h"
#include "convert/mesh/three_mf.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

constexpr uint64_t kMaxBytes = uint64_t{1} << 28;

std::string_view view_of(const FileBytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data.get()), bytes.size};
}

class MemoryStream : public Assimp::IOStream {
 public:
  explicit MemoryStream(std::string bytes) : bytes_(std::move(bytes)) {}

  size_t Read(void* to, size_t size, size_t count) override {
    if (size == 0) return 0;
    count = std::min(count, (bytes_.size() - at_) / size);
    if (count > 0) std::memcpy(to, bytes_.data() + at_, size * count);
    at_ += size * count;
    return count;
  }
  size_t Write(const void*, size_t, size_t) override { return 0; }
  aiReturn Seek(size_t offset, aiOrigin origin) override {
    const size_t from = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? at_ : bytes_.size();
    // Negative offsets arrive as large unsigned ones; the sum wraps as intended.
    const size_t to = from + offset;
    if (to > bytes_.size()) return aiReturn_FAILURE;
    at_ = to;
    return aiReturn_SUCCESS;
  }
  size_t Tell() const override { return at_; }
  size_t FileSize() const override { return bytes_.size(); }
  void Flush() override {}

 private:
  std::string bytes_;
  size_t at_ = 0;
};

// File access of assimp: only the mesh file itself and files below its folder exist. Of MTL
// files assimp reads the names alone.
class ImportFiles : public Assimp::IOSystem {
 public:
  // contents: what assimp reads as the mesh file. besides: receives all further files that assimp requests,
  // found or not. materials: receives those of MTL files.
  ImportFiles(const std::filesystem::path& file, std::string contents, Sources& besides,
              MtlMaterials& materials);

  bool Exists(const char* file) const override;
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* file, const char* mode) override;
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  std::filesystem::path file_;
  std::string contents_;
  Sources& besides_;
  MtlMaterials& materials_;
  AllowedFolders folders_;
};

ImportFiles::ImportFiles(const std::filesystem::path& file, std::string contents, Sources& besides,
                         MtlMaterials& materials)
    : file_(file), contents_(std::move(contents)), besides_(besides), materials_(materials) {
  folders_.add(file.parent_path());
}

bool ImportFiles::Exists(const char* name) const {
  if (file_ == name) return true;
  const Result<std::filesystem::path> found = regular_file(name);
  return found && folders_.hold(*found);
}

Assimp::IOStream* ImportFiles::Open(const char* name, const char* mode) {
  if (std::strpbrk(mode, "wa+")) return nullptr;
  if (file_ == name) return new MemoryStream(contents_);
  besides_.add(name);
  const Result<std::filesystem::path> found = regular_file(name);
  if (!found || !folders_.hold(*found)) return nullptr;
  const Result<FileBytes> bytes = read_file(name, kMaxBytes);
  if (!bytes) return nullptr;
  if (lower_extension(file_) != ".obj") return new MemoryStream(std::string(view_of(*bytes)));
  const std::optional<std::string> decoded = utf8_of_utf16(view_of(*bytes));
  const std::filesystem::path folder =
      std::filesystem::path(name).lexically_relative(file_.parent_path()).parent_path();
  materials_.add(decoded ? *decoded : view_of(*bytes), folder.string());
  return new MemoryStream("# names\n" + materials_.names());
}

constexpr uint64_t kMaxTriangles = 20'000'000;
constexpr size_t kMaxNodes = 1'000'000;

// Library message about an untrusted file, as one printable line.
std::string one_line(const char* text) {
  std::string line = sanitize_text(text, 200);
  while (!line.empty() && (line.back() == ' ' || line.back() == '.')) line.pop_back();
  return line.empty() ? "the importer reports no reason" : line;
}

glm::dmat4 matrix_of(const aiMatrix4x4& m) {  // assimp's matrices are row-major
  return {m.a1, m.b1, m.c1, m.d1, m.a2, m.b2, m.c2, m.d2, m.a3, m.b3, m.c3, m.d3, m.a4, m.b4, m.c4, m.d4};
}

float or_zero(float value) {
  return std::isfinite(value) ? value : 0;
}

std::optional<glm::vec3> color(const aiMaterial& from, const char* key, unsigned type, unsigned index) {
  aiColor3D c;
  if (from.Get(key, type, index, c) != AI_SUCCESS) return std::nullopt;
  return glm::vec3(or_zero(c.r), or_zero(c.g), or_zero(c.b));
}

std::string image_name(const aiMaterial& from, aiTextureType type) {
  aiString name;
  return from.GetTexture(type, 0, &name) == AI_SUCCESS ? std::string(name.C_Str()) : std::string();
}

// Converts the Blinn-Phong exponent, as AMBF's library reads it from a file, to the roughness with equal
// highlight width.
float roughness_of(const aiMaterial& from, const std::string& extension) {
  float shininess = 64;
  if (from.Get(AI_MATKEY_SHININESS, shininess) != AI_SUCCESS || !std::isfinite(shininess)) shininess = 64;
  if (extension == ".obj") shininess = std::min(128.0f, 1.28f * 1.28f * shininess);
  const std::optional<glm::vec3> specular = color(from, AI_MATKEY_COLOR_SPECULAR);
  if (specular && *specular == glm::vec3(0)) return 1;
  return std::sqrt(2 / (std::max(shininess, 0.0f) + 2));
}

// Physical properties of MTL files: Pr, Pm, map_Pr, map_Pm, map_Ke.
void add_pbr(const aiMaterial& from, ImportedMaterial& to) {
  to.emission_image = image_name(from, aiTextureType_EMISSIVE);
  to.roughness_image = image_name(from, aiTextureType_DIFFUSE_ROUGHNESS);
  to.metallic_image = image_name(from, aiTextureType_METALNESS);
  float roughness = 0, metallic = 0;
  const bool has_roughness = from.Get(AI_MATKEY_ROUGHNESS_FACTOR, roughness) == AI_SUCCESS;
  const bool has_metallic = from.Get(AI_MATKEY_METALLIC_FACTOR, metallic) == AI_SUCCESS;
  if (has_roughness) to.roughness = std::clamp(or_zero(roughness), 0.0f, 1.0f);
  if (has_metallic) to.metallic = std::clamp(or_zero(metallic), 0.0f, 1.0f);
  // Exporters write 0, or nothing, beside a map.
  if (!to.roughness_image.empty() && (!has_roughness || to.roughness == 0)) to.roughness = 1;
}

Wrap wrap_of(const aiMaterial& from, const char* key, unsigned type) {
  int mode = aiTextureMapMode_Wrap;
  if (from.Get(key, type, 0, mode) != AI_SUCCESS) return Wrap::repeat;
  if (mode == aiTextureMapMode_Mirror) return Wrap::mirror;
  return mode == aiTextureMapMode_Wrap ? Wrap::repeat : Wrap::clamp;
}

// Texture transforms of DAE (as Maya writes them) and 3DS.
ImagePlacement placement_of(const aiMaterial& from, aiTextureType type) {
  ImagePlacement to;
  if (aiUVTransform t; from.Get(_AI_MATKEY_UVTRANSFORM_BASE, type, 0, t) == AI_SUCCESS) {
    const bool is_sound = std::isfinite(t.mScaling.x) && std::isfinite(t.mScaling.y) &&
                          std::isfinite(t.mTranslation.x) && std::isfinite(t.mTranslation.y);
    if (is_sound) to.scale = {t.mScaling.x, t.mScaling.y};
    if (is_sound) to.offset = {t.mTranslation.x, 1 - t.mScaling.y - t.mTranslation.y};  // v upwards
  }
  to.wrap_u = wrap_of(from, _AI_MATKEY_MAPPINGMODE_U_BASE, type);
  to.wrap_v = wrap_of(from, _AI_MATKEY_MAPPINGMODE_V_BASE, type);
  return to;
}

ImportedMaterial material_of(const aiMaterial& from, const std::string& extension, bool has_materials,
                             const MtlMaterials& mtl) {
  ImportedMaterial to;
  if (aiString name; from.Get(AI_MATKEY_NAME, name) == AI_SUCCESS) {
    if (extension == ".obj" && mtl.contains(name.C_Str())) return mtl.material(name.C_Str());
    to.name = sanitize_text(name.C_Str(), 200);
  }
  to.is_default = to.name == AI_DEFAULT_MATERIAL_NAME || !has_materials;
  // Grey of AMBF's library for files without material; assimp's default differs.
  to.diffuse =
      to.is_default ? glm::vec3(0.7f) : color(from, AI_MATKEY_COLOR_DIFFUSE).value_or(glm::vec3(0.8f));
  if (to.is_default) return to;
  to.emission = color(from, AI_MATKEY_COLOR_EMISSIVE).value_or(glm::vec3(0));
  if (float opacity; from.Get(AI_MATKEY_OPACITY, opacity) == AI_SUCCESS)
    to.opacity = std::clamp(or_zero(opacity), 0.0f, 1.0f);
  // Exporters disagree whether a <transparency> of 0 or 1 is opaque, and nobody draws an invisible mesh.
  constexpr float kInvisible = 0.01f;
  if (extension == ".dae" && to.opacity < kInvisible) to.opacity = 1;
  to.roughness = roughness_of(from, extension);
  add_pbr(from, to);
  to.diffuse_image = image_name(from, aiTextureType_DIFFUSE);
  to.diffuse_placement = placement_of(from, aiTextureType_DIFFUSE);
  // Exporters write a black colour beside a map that is meant to replace it, not to be multiplied with it.
  if (!to.diffuse_image.empty() && to.diffuse == glm::vec3(0)) to.diffuse = glm::vec3(1);
  to.normal_image = image_name(from, aiTextureType_NORMALS);
  to.normal_placement = placement_of(from, aiTextureType_NORMALS);
  return to;
}

// Checks that all arrays and indices of assimp's mesh are valid.
bool is_sound(const aiMesh& mesh) {
  if (!mesh.mVertices || !mesh.mFaces) return mesh.mNumFaces == 0;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    for (unsigned i = 0; i < face.mNumIndices; ++i)
      if (face.mIndices[i] >= mesh.mNumVertices) return false;
  }
  return true;
}

class SceneReader {
 public:
  SceneReader(const aiScene& scene, Nodes nodes, ImportedMesh& to)
      : scene_(scene), keeps_nodes_(nodes == Nodes::keep), to_(to) {}

  Result<void> read(const glm::dmat4& file_from_root) {
    // Iterative, since the nesting depth of nodes is untrusted.
    struct Left {
      const aiNode* node;
      glm::dmat4 file_from_parent;
      int64_t parent;  // index into to_.nodes
    };
    std::vector<Left> left{{scene_.mRootNode, file_from_root, -1}};
    size_t nodes = 0;
    while (!left.empty()) {
      const auto [node, file_from_parent, parent] = left.back();
      left.pop_back();
      if (++nodes > kMaxNodes) return Error{"it has more than " + std::to_string(kMaxNodes) + " nodes"};
      const glm::dmat4 file_from_node = file_from_parent * matrix_of(node->mTransformation);
      if (keeps_nodes_)
        to_.nodes.push_back({sanitize_text(node->mName.C_Str()), parent, rigid_part(file_from_node)});
      for (unsigned i = 0; i < node->mNumMeshes; ++i) {
        if (node->mMeshes[i] >= scene_.mNumMeshes) return Error{"a node shows a mesh that it does not have"};
        warn_if_far(*node, *scene_.mMeshes[node->mMeshes[i]], file_from_node);
        if (keeps_nodes_ && i == 0)
          to_.nodes.back().mesh_name = sanitize_text(scene_.mMeshes[node->mMeshes[i]]->mName.C_Str());
        Result<void> added = add(*scene_.mMeshes[node->mMeshes[i]], surface_from_mesh(file_from_node));
        if (!added) return added;
      }
      const int64_t self = keeps_nodes_ ? static_cast<int64_t>(to_.nodes.size()) - 1 : -1;
      for (unsigned i = node->mNumChildren; i-- > 0;)
        left.push_back({node->mChildren[i], file_from_node, self});
    }
    for (auto& [key, builder] : builders_) {
      Surface surface = builder.take();
      surface.material = key.material;
      if (surface.indices.empty()) continue;
      to_.surfaces.push_back(std::move(surface));
      if (keeps_nodes_) to_.surface_nodes.push_back(key.node);
    }
    if (left_out_faces_ > 0) {
      const std::string reason = "a vertex is not finite, or too far away for a number of 32 bits";
      if (to_.surfaces.empty()) return Error{reason};
      to_.warnings.push_back(std::to_string(left_out_faces_) +
                             (left_out_faces_ == 1 ? " face is" : " faces are") +
                             " left out (first in mesh " + quote(first_left_out_) + "): " + reason);
    }
    if (std::string crossing = polygons_.warning(); !crossing.empty())
      to_.warnings.push_back(std::move(crossing));
    return {};
  }

 private:
  // Surfaces are apart by these.
  struct Key {
    size_t node = 0, material = 0;
    bool normals = false, uvs = false, colors = false;
    auto operator<=>(const Key&) const = default;
  };

  // Positions of 32 bits fall together far away from the origin.
  void warn_if_far(const aiNode& node, const aiMesh& mesh, const glm::dmat4& file_from_node) {
    constexpr double kFar = 1e4, kTooFar = 1e6;  // the latter in sizes of the mesh
    const double distance = glm::length(glm::dvec3(file_from_node[3]));
    if (distance < kFar || !mesh.mVertices || warned_far_ == node.mName.C_Str()) return;
    double size = 0;
    const aiVector3D& first = mesh.mVertices[0];
    for (unsigned i = 1; i < mesh.mNumVertices; ++i) {
      const aiVector3D offset = mesh.mVertices[i] - first;
      size =
          std::max(size, glm::length(glm::dmat3(file_from_node) * glm::dvec3(offset.x, offset.y, offset.z)));
    }
    if (distance < kTooFar * size) return;
    warned_far_ = node.mName.C_Str();
    if (++far_nodes_ > kMaxFarNodes) return;
    char text[32];
    std::snprintf(text, sizeof text, "%.1g", distance);
    to_.warnings.push_back("node " + quote(warned_far_) + " lies " + text +
                           " away, so far that it cannot be drawn: check its transform");
  }

  // Of the vertices of the current node.
  glm::dmat4 surface_from_mesh(const glm::dmat4& file_from_node) const {
    if (!keeps_nodes_) return file_from_node;
    return without_rounding(glm::inverse(to_.nodes.back().file_from_node) * file_from_node);
  }

  Result<void> add(const aiMesh& mesh, const glm::dmat4& file_from_mesh) {
    if (!is_sound(mesh)) return Error{"a face names a vertex that it does not have"};
    if (mesh.mMaterialIndex >= to_.materials.size()) return Error{"a face names a material that it has not"};
    const bool normals = mesh.mNormals != nullptr;
    const bool uvs = mesh.mTextureCoords[0] != nullptr;
    const bool colors = keeps_nodes_ && mesh.mColors[0];
    const Key key{keeps_nodes_ ? to_.nodes.size() - 1 : 0, mesh.mMaterialIndex, normals, uvs, colors};
    SurfaceBuilder& builder = builders_.try_emplace(key, normals, uvs, colors).first->second;
    const glm::dmat3 linear(file_from_mesh);
    const bool mirrored = glm::determinant(linear) < 0;
    // Cofactor matrix: equals the inverse transpose up to a factor, and exists for flattened nodes, too.
    const glm::dmat3 normal_matrix(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                                   glm::cross(linear[0], linear[1]));
    const auto corner = [&](unsigned v) {
      SurfaceBuilder::Corner c;
      const aiVector3D& p = mesh.mVertices[v];
      c.position = glm::vec3(file_from_mesh * glm::dvec4(p.x, p.y, p.z, 1));
      if (normals) {
        const aiVector3D& n = mesh.mNormals[v];
        c.normal = glm::vec3(normal_matrix * glm::dvec3(n.x, n.y, n.z) * (mirrored ? -1.0 : 1.0));
      }
      // glTF's v starts at the top edge of the image.
      if (uvs) c.uv = {or_zero(mesh.mTextureCoords[0][v].x), or_zero(1 - mesh.mTextureCoords[0][v].y)};
      if (colors) {
        const aiColor4D& color = mesh.mColors[0][v];
        c.color = linear_from_srgb(
            glm::vec4(or_zero(color.r), or_zero(color.g), or_zero(color.b), or_zero(color.a)));
      }
      return c;
    };
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices < 3) continue;  // point or line
      triangles_ += face.mNumIndices - 2;
      if (triangles_ > kMaxTriangles)
        return Error{"it has more than " + std::to_string(kMaxTriangles) + " triangles"};
      corners_.clear();
      polygon_.clear();
      for (unsigned i = 0; i < face.mNumIndices; ++i) {
        const aiVector3D& position = mesh.mVertices[face.mIndices[i]];
        corners_.push_back(corner(face.mIndices[i]));
        polygon_.emplace_back(position.x, position.y, position.z);
      }
      const bool is_finite = std::all_of(corners_.begin(), corners_.end(), [](const auto& c) {
        return std::isfinite(c.position.x) && std::isfinite(c.position.y) && std::isfinite(c.position.z);
      });
      if (!is_finite) {
        if (left_out_faces_++ == 0) first_left_out_ = sanitize_text(mesh.mName.C_Str(), 200);
        continue;
      }
      for (const auto& [a, b, c] : polygons_.triangulate(polygon_))
        if (!(mirrored ? builder.add(corners_[a], corners_[c], corners_[b])
                       : builder.add(corners_[a], corners_[b], corners_[c])))
          return Error{"a vertex is not finite, or too far away for a number of 32 bits"};
    }
    return {};
  }

  const aiScene& scene_;
  const bool keeps_nodes_;
  ImportedMesh& to_;
  uint64_t triangles_ = 0, left_out_faces_ = 0;
  std::string first_left_out_;                // mesh
  static constexpr size_t kMaxFarNodes = 10;  // with a warning
  size_t far_nodes_ = 0;
  std::string warned_far_;  // the last one
  std::map<Key, SurfaceBuilder> builders_;
  // Of the current face.
  std::vector<SurfaceBuilder::Corner> corners_;
  std::vector<glm::dvec3> polygon_;
  PolygonTriangulator polygons_;
};

// Materials of an OBJ file that its MTL files do not define.
void warn_of_undefined(const aiScene& scene, const MtlMaterials& mtl, ImportedMesh& to) {
  std::set<std::string> undefined;
  for (const Surface& surface : to.surfaces) {
    if (surface.material >= scene.mNumMaterials || to.materials[surface.material].is_default) continue;
    aiString name;
    const bool has_name = scene.mMaterials[surface.material]->Get(AI_MATKEY_NAME, name) == AI_SUCCESS;
    // "default" is the importer's name of faces without a material.
    if (has_name && name != aiString("default") && !mtl.contains(name.C_Str()))
      undefined.insert(sanitize_text(name.C_Str(), 200));
  }
  if (undefined.empty()) return;
  to.warnings.push_back(
      "material " + quote(*undefined.begin()) +
      (undefined.size() > 1 ? " and " + std::to_string(undefined.size() - 1) + " more" : "") +
      " is not in its MTL file: drawn grey");
}

// Copies embedded images; those of other formats than files have a height.
Result<void> add_images(const aiScene& scene, ImportedMesh& to) {
  for (unsigned i = 0; i < scene.mNumTextures; ++i) {
    const aiTexture* texture = scene.mTextures[i];
    EmbeddedImage image;
    if (texture && texture->mHeight == 0 && texture->pcData) {
      if (texture->mWidth > kMaxBytes) return Error{"an embedded image is too large"};
      const auto* bytes = reinterpret_cast<const std::byte*>(texture->pcData);
      image.name = sanitize_text(texture->mFilename.C_Str(), 200);
      image.bytes.assign(bytes, bytes + texture->mWidth);
    }
    to.images.push_back(std::move(image));
  }
  return {};
}

}  // namespace

bool is_mesh_file_name(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  constexpr std::string_view kExtensions[] = {".obj", ".stl", ".ply", ".3ds", ".dae", ".glb", ".gltf"};
  return std::find(std::begin(kExtensions), std::end(kExtensions), extension) != std::end(kExtensions);
}

namespace {

// What assimp reads of a file.
Result<std::string> read_contents(const std::filesystem::path& file, const std::string& extension,
                                  std::vector<std::string>& warnings) {
  const Result<FileBytes> bytes = read_file(file, kMaxBytes);
  if (!bytes) return bytes.error();
  if (extension == ".dae") {
    RepairedDae repaired = repair_dae(view_of(*bytes));
    warnings = std::move(repaired.warnings);
    return std::move(repaired.text);
  }
  if (extension != ".obj") return std::string(view_of(*bytes));
  Result<ObjText> checked = checked_obj(view_of(*bytes));
  if (!checked) return checked.error();
  warnings = std::move(checked->warnings);
  return std::move(checked->text);
}

}  // namespace

Result<ImportedMesh> import_mesh(const std::filesystem::path& file, ImportRequest request) {
  if (request.nodes == Nodes::keep && lower_extension(file) == ".3mf") return import_3mf(file);
  if (!is_mesh_file_name(file))
    return Error{"its name ends in none of .obj, .stl, .ply, .3ds, .dae, .glb and .gltf"};
  const std::string extension = lower_extension(file);
  if (std::optional<Error> pointer = git_lfs_pointer(file)) return *std::move(pointer);
  if (extension == ".glb" || extension == ".gltf") return import_gltf(file, request);
  if (extension == ".ply" || extension == ".stl") {
    const Result<FileBytes> bytes = read_file(file, kMaxBytes);
    if (!bytes) return bytes.error();
    return extension == ".ply" ? import_ply(view_of(*bytes), request.nodes)
                               : import_stl(view_of(*bytes), request.nodes);
  }
  ImportedMesh mesh;
  Result<std::string> contents = read_contents(file, extension, mesh.warnings);
  if (!contents) return contents.error();
  Assimp::Importer importer;
  MtlMaterials materials;
  // Owned by the importer.
  importer.SetIOHandler(new ImportFiles(file, std::move(*contents), mesh.besides, materials));
  const bool keeps_nodes = request.nodes == Nodes::keep;
  const bool turns_up = request.dae_up == DaeUp::apply && extension == ".dae";
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, keeps_nodes);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, !turns_up);
  const aiScene* scene = importer.ReadFile(file.string(), 0);
  if (!scene || !scene->mRootNode)
    return Error{"it is damaged, or not what its name says (" + one_line(importer.GetErrorString()) + ")"};
  // An OBJ file without its material file has materials by name only.
  const std::vector<Sources::Source>& besides = mesh.besides.all();
  const bool has_materials =
      extension == ".obj" ? std::any_of(besides.begin(), besides.end(),
                                        [](const Sources::Source& source) { return source.stamp.exists; })
                          : true;
  for (unsigned i = 0; i < scene->mNumMaterials; ++i)
    mesh.materials.push_back(material_of(*scene->mMaterials[i], extension, has_materials, materials));
  for (std::string& warning : materials.warnings()) mesh.warnings.push_back(std::move(warning));
  if (Result<void> embedded = add_images(*scene, mesh); !embedded) return embedded.error();

  // assimp rotates 3DS files, and DAE files by their up_axis, to Y up; this makes it Z up.
  const glm::dmat4 upright = extension == ".3ds" || turns_up
                                 ? glm::dmat4({1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}, {0, 0, 0, 1})
                                 : glm::dmat4(1);
  Result<void> read = SceneReader(*scene, request.nodes, mesh).read(upright);
  if (!read) return read.error();
  if (mesh.surfaces.empty()) return Error{"there is no triangle in it"};
  if (extension == ".obj" && has_materials) warn_of_undefined(*scene, materials, mesh);
  if (scene->HasLights()) mesh.losses.emplace_back("its lights");
  if (scene->HasCameras()) mesh.losses.emplace_back("its cameras");
  if (scene->HasAnimations()) mesh.losses.emplace_back("its animations");
  return mesh;
}

Result<void> check_imported(const ImportedMesh& mesh) {
  const auto finite = [](const auto& v) {
    for (int i = 0; i < v.length(); ++i)
      if (!std::isfinite(v[i])) return false;
    return true;
  };
  for (const ImportedMaterial& m : mesh.materials) {
    for (const ImagePlacement* placement : {&m.diffuse_placement, &m.normal_placement, &m.emission_placement,
                                            &m.roughness_placement, &m.opacity_placement})
      if (!finite(placement->scale) || !finite(placement->offset))
        return Error{"a texture transform is not finite"};
    if (!finite(m.diffuse) || !finite(m.emission) || !std::isfinite(m.opacity) ||
        !std::isfinite(m.roughness) || !std::isfinite(m.metallic) || !std::isfinite(m.alpha_cutoff))
      return Error{"a number of a material is not finite"};
  }
  for (const Surface& s : mesh.surfaces) {
    const size_t count = s.positions.size();
    const bool fits = s.material < mesh.materials.size() && s.indices.size() % 3 == 0 &&
                      (s.normals.empty() || s.normals.size() == count) &&
                      (s.uvs.empty() || s.uvs.size() == count) &&
                      (s.colors.empty() || s.colors.size() == count) &&
                      std::all_of(s.indices.begin(), s.indices.end(), [&](uint32_t i) { return i < count; });
    if (!fits || !std::all_of(s.positions.begin(), s.positions.end(), finite) ||
        !std::all_of(s.normals.begin(), s.normals.end(), finite) ||
        !std::all_of(s.uvs.begin(), s.uvs.end(), finite) ||
        !std::all_of(s.colors.begin(), s.colors.end(), finite)) {
      return Error{"its surfaces are not whole"};
    }
  }
  if (!mesh.nodes.empty() && mesh.surface_nodes.size() != mesh.surfaces.size())
    return Error{"its surfaces have no nodes"};
  for (const size_t node : mesh.surface_nodes)
    if (node >= mesh.nodes.size()) return Error{"a surface has no node"};
  for (size_t i = 0; i < mesh.nodes.size(); ++i) {
    const ImportedNode& node = mesh.nodes[i];
    bool sound = node.parent >= -1 && node.parent < static_cast<int64_t>(i);
    for (int c = 0; c < 4; ++c) sound = sound && finite(node.file_from_node[c]);
    if (!sound) return Error{"the pose of the node " + quote(node.name) + " is not made of finite numbers"};
  }
  return {};
}

}  // namespace fire3dv::convert
