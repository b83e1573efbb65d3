#include "convert/glb/write_glb.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <ostream>
#include <streambuf>
#include <string_view>
#include <tuple>
#include <utility>

#include "convert/glb/glb_joints.h"
#include "convert/surfaces.h"

namespace fire3dv::convert {
namespace {

// tinygltf 2.9 and newer write a node's light from this member and drop the extension without it.
template <typename Node>
void set_light(int light, Node& node) {
  if constexpr (requires { node.light; }) node.light = light;
}

static_assert(std::endian::native == std::endian::little, "glTF's buffers are little-endian");

constexpr size_t kMaxBytes = size_t{3} << 30;  // limit below the 32-bit size field of GLB

// Sanitises without truncation, since streams look nodes up by name.
std::string fit_name(const std::string& name) {
  return sanitize_text(name, name.size());
}

std::vector<double> list(const glm::vec3& v) {
  return {v.x, v.y, v.z};
}

// In-memory stream buffer without a second copy, since a scene may fill most of the memory.
class Bytes : public std::streambuf {
 public:
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::streamsize xsputn(const char* text, std::streamsize count) override {
    const auto* first = reinterpret_cast<const std::byte*>(text);
    bytes_.insert(bytes_.end(), first, first + count);
    return count;
  }
  int_type overflow(int_type character) override {
    if (!traits_type::eq_int_type(character, traits_type::eof()))
      bytes_.push_back(static_cast<std::byte>(traits_type::to_char_type(character)));
    return traits_type::not_eof(character);
  }

  std::vector<std::byte> bytes_;
};

// tinygltf writes an absent far plane as 0, which glTF forbids: blanks replace the member in the JSON chunk.
// Quotes inside of texts are escaped, so that only the member has this form.
void remove_zero_far_planes(std::vector<std::byte>& glb) {
  constexpr size_t kJsonBegin = 20;  // header of the file and of the chunk
  if (glb.size() < kJsonBegin) return;
  uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof length);
  const std::span<char> json(reinterpret_cast<char*>(glb.data()) + kJsonBegin,
                             std::min<size_t>(length, glb.size() - kJsonBegin));
  constexpr std::string_view kMember = "\"zfar\":0.0,";
  for (auto at = json.begin();; at += kMember.size()) {
    at = std::search(at, json.end(), kMember.begin(), kMember.end());
    if (at == json.end()) return;
    std::fill_n(at, kMember.size(), ' ');
  }
}

class Writer {
 public:
  Writer(const Model& model, std::vector<std::string>* warnings) : model_(model), warnings_(warnings) {
    out_.asset.version = "2.0";
    out_.asset.generator = "fire3dv-convert";
    out_.buffers.emplace_back();
  }

  Result<std::vector<std::byte>> write() {
    add_meshes();
    for (const Camera& camera : model_.cameras) add_camera(camera);
    for (const Light& light : model_.lights) add_light(light);
    for (const Skin& skin : model_.skins) add_skin(skin);
    add_nodes();
    if (out_.buffers[0].data.size() > kMaxBytes) {
      return Error{"the scene holds " + std::to_string(out_.buffers[0].data.size() >> 20) +
                   " MiB of meshes and images; one binary glTF file holds 3072 MiB: split it"};
    }
    if (out_.buffers[0].data.empty()) out_.buffers.clear();
    Bytes bytes;
    std::ostream stream(&bytes);
    tinygltf::TinyGLTF gltf;
    if (!gltf.WriteGltfSceneToStream(&out_, stream, false, true)) return Error{"glTF could not be written"};
    std::vector<std::byte> glb = bytes.take();
    remove_zero_far_planes(glb);
    return glb;
  }

 private:
  void warn(const std::string& text) {
    if (warnings_) warnings_->push_back(text);
  }

  template <typename T>
  int add_view(std::span<const T> values, int target) {
    std::vector<unsigned char>& data = out_.buffers[0].data;
    data.resize((data.size() + 3) & ~size_t{3});
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = data.size();
    view.byteLength = values.size_bytes();
    view.target = target;
    const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
    data.insert(data.end(), bytes, bytes + values.size_bytes());
    out_.bufferViews.push_back(std::move(view));
    return static_cast<int>(out_.bufferViews.size()) - 1;
  }

  template <typename T>
  int add_accessor(const std::vector<T>& values, int component, int type, int target) {
    tinygltf::Accessor accessor;
    accessor.bufferView = add_view(std::span(values), target);
    accessor.componentType = component;
    accessor.type = type;
    accessor.count = values.size();
    out_.accessors.push_back(std::move(accessor));
    return static_cast<int>(out_.accessors.size()) - 1;
  }

  int add_positions(const std::vector<glm::vec3>& positions) {
    glm::vec3 low = positions[0], high = positions[0];
    for (const glm::vec3& position : positions) {
      low = glm::min(low, position);
      high = glm::max(high, position);
    }
    const int index = add_accessor(positions, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3,
                                   TINYGLTF_TARGET_ARRAY_BUFFER);
    out_.accessors.back().minValues = list(low);
    out_.accessors.back().maxValues = list(high);
    return index;
  }

  // 16 bits: 8 bits of linear light are too few in the dark.
  int add_colors(const std::vector<glm::vec4>& colors) {
    std::vector<glm::u16vec4> steps;
    steps.reserve(colors.size());
    for (const glm::vec4& color : colors) {
      // min and max also replace what is no number.
      const glm::vec4 sound(std::min(1.0f, std::max(0.0f, color.r)), std::min(1.0f, std::max(0.0f, color.g)),
                            std::min(1.0f, std::max(0.0f, color.b)), std::min(1.0f, std::max(0.0f, color.a)));
      steps.emplace_back(sound * 65535.0f + 0.5f);
    }
    const int index = add_accessor(steps, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4,
                                   TINYGLTF_TARGET_ARRAY_BUFFER);
    out_.accessors.back().normalized = true;
    return index;
  }

  int add_indices(const std::vector<uint32_t>& indices, size_t vertices) {
    // 65535 is the primitive restart index.
    if (vertices < 0xffff) {
      return add_accessor(std::vector<uint16_t>(indices.begin(), indices.end()),
                          TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_SCALAR,
                          TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    }
    return add_accessor(indices, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR,
                        TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  }

  void add_meshes() {
    mesh_of_.assign(model_.meshes.size(), -1);
    std::vector<bool> used(model_.meshes.size());
    for (const Node& node : model_.nodes)
      if (node.mesh) used[*node.mesh] = true;
    for (size_t i = 0; i < model_.meshes.size(); ++i) {
      if (!used[i]) continue;
      tinygltf::Mesh mesh;
      mesh.name = fit_name(model_.meshes[i].name);
      for (const Surface& surface : model_.meshes[i].surfaces) add_surface(surface, mesh);
      if (mesh.primitives.empty()) continue;
      if (model_.meshes[i].unbounded)
        mesh.extras = tinygltf::Value(tinygltf::Value::Object{{"unbounded", tinygltf::Value(true)}});
      mesh_of_[i] = static_cast<int>(out_.meshes.size());
      out_.meshes.push_back(std::move(mesh));
    }
  }

  void add_surface(Surface surface, tinygltf::Mesh& mesh) {
    if (const std::string repairs = repair(surface); !repairs.empty())
      warn("mesh \"" + mesh.name + "\": " + repairs);
    if (surface.indices.empty()) return;
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.attributes["POSITION"] = add_positions(surface.positions);
    if (!surface.normals.empty()) {
      primitive.attributes["NORMAL"] = add_accessor(surface.normals, TINYGLTF_COMPONENT_TYPE_FLOAT,
                                                    TINYGLTF_TYPE_VEC3, TINYGLTF_TARGET_ARRAY_BUFFER);
    }
    if (!surface.uvs.empty()) {
      primitive.attributes["TEXCOORD_0"] = add_accessor(surface.uvs, TINYGLTF_COMPONENT_TYPE_FLOAT,
                                                        TINYGLTF_TYPE_VEC2, TINYGLTF_TARGET_ARRAY_BUFFER);
    }
    if (!surface.influences.empty()) add_influences(surface.influences, primitive);
    if (!surface.colors.empty()) primitive.attributes["COLOR_0"] = add_colors(surface.colors);
    primitive.indices = add_indices(surface.indices, surface.positions.size());
    primitive.material = material(surface.material, !surface.uvs.empty());
    mesh.primitives.push_back(std::move(primitive));
  }

  void add_influences(const std::vector<Influences>& influences, tinygltf::Primitive& primitive) {
    const bool has_second = std::any_of(influences.begin(), influences.end(), [](const Influences& each) {
      return std::any_of(each.weights.begin() + 4, each.weights.end(), [](float w) { return w != 0; });
    });
    for (size_t set = 0; set < (has_second ? 2 : 1); ++set) {
      std::vector<std::array<uint16_t, 4>> joints;
      std::vector<std::array<float, 4>> weights;
      for (const Influences& each : influences) {
        std::copy_n(each.joints.begin() + static_cast<ptrdiff_t>(4 * set), 4, joints.emplace_back().begin());
        std::copy_n(each.weights.begin() + static_cast<ptrdiff_t>(4 * set), 4,
                    weights.emplace_back().begin());
      }
      primitive.attributes["JOINTS_" + std::to_string(set)] = add_accessor(
          joints, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4, TINYGLTF_TARGET_ARRAY_BUFFER);
      primitive.attributes["WEIGHTS_" + std::to_string(set)] = add_accessor(
          weights, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC4, TINYGLTF_TARGET_ARRAY_BUFFER);
    }
  }

  // Surfaces without texture coordinates get the material without its textures.
  int material(size_t index, bool has_uvs) {
    const auto [entry, is_new] =
        material_of_.try_emplace({index, has_uvs}, static_cast<int>(out_.materials.size()));
    if (!is_new) return entry->second;
    const Material& source = model_.materials.at(index);
    out_.materials.emplace_back();
    tinygltf::Material made;
    made.name = fit_name(source.name);
    const glm::vec4 color = glm::clamp(source.base_color, 0.0f, 1.0f);
    made.pbrMetallicRoughness.baseColorFactor = {color.r, color.g, color.b, color.a};
    made.pbrMetallicRoughness.metallicFactor = std::clamp(source.metallic, 0.0f, 1.0f);
    made.pbrMetallicRoughness.roughnessFactor = std::clamp(source.roughness, 0.0f, 1.0f);
    if (has_uvs) {
      set_texture(source.base_color_image, source.base_color_placement,
                  made.pbrMetallicRoughness.baseColorTexture);
      set_texture(source.normal_image, source.normal_placement, made.normalTexture);
      set_texture(source.emission_image, source.emission_placement, made.emissiveTexture);
      set_texture(source.metallic_roughness_image, source.metallic_roughness_placement,
                  made.pbrMetallicRoughness.metallicRoughnessTexture);
      set_texture(source.occlusion_image, {}, made.occlusionTexture);
    }
    const glm::vec3 emission = glm::max(source.emission, 0.0f);
    const float strength = std::max({emission.r, emission.g, emission.b, 1.0f});
    made.emissiveFactor = list(emission / strength);
    if (strength > 1) {
      tinygltf::Value::Object members;
      members["emissiveStrength"] = tinygltf::Value(static_cast<double>(strength));
      made.extensions["KHR_materials_emissive_strength"] = tinygltf::Value(std::move(members));
      use_extension("KHR_materials_emissive_strength");
    }
    made.doubleSided = source.double_sided;
    made.alphaMode = source.alpha_cutoff ? "MASK" : source.blended ? "BLEND" : "OPAQUE";
    if (source.alpha_cutoff) made.alphaCutoff = std::clamp(*source.alpha_cutoff, 0.0f, 1.0f);
    out_.materials[static_cast<size_t>(entry->second)] = std::move(made);
    return entry->second;
  }

  // Info: a texture reference of tinygltf.
  template <typename Info>
  void set_texture(const std::optional<size_t>& image, const ImagePlacement& placement, Info& to) {
    if (!image) return;
    to.index = texture(*image, placement.wrap_u, placement.wrap_v);
    if (to.index < 0 || (placement.scale == glm::vec2(1) && placement.offset == glm::vec2(0))) return;
    const auto pair = [](const glm::vec2& v) {
      return tinygltf::Value(
          tinygltf::Value::Array{tinygltf::Value(double{v.x}), tinygltf::Value(double{v.y})});
    };
    tinygltf::Value::Object members;
    members["scale"] = pair(placement.scale);
    members["offset"] = pair(placement.offset);
    to.extensions["KHR_texture_transform"] = tinygltf::Value(std::move(members));
    use_extension("KHR_texture_transform");
  }

  // Returns -1 for the default of glTF, which repeats.
  int sampler(Wrap u, Wrap v) {
    if (u == Wrap::repeat && v == Wrap::repeat) return -1;
    const auto [entry, is_new] = sampler_of_.try_emplace({u, v}, static_cast<int>(out_.samplers.size()));
    if (!is_new) return entry->second;
    const auto mode = [](Wrap wrap) {
      return wrap == Wrap::repeat   ? TINYGLTF_TEXTURE_WRAP_REPEAT
             : wrap == Wrap::mirror ? TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT
                                    : TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    };
    tinygltf::Sampler made;
    made.wrapS = mode(u);
    made.wrapT = mode(v);
    out_.samplers.push_back(std::move(made));
    return entry->second;
  }

  // Returns -1 for an undecodable image, with one warning.
  int texture(size_t index, Wrap u, Wrap v) {
    const auto [entry, is_new] = texture_of_.try_emplace({index, u, v}, -1);
    if (!is_new) return entry->second;
    const int image = image_index(index);
    if (image < 0) return -1;
    tinygltf::Texture made;
    made.source = image;
    made.sampler = sampler(u, v);
    entry->second = static_cast<int>(out_.textures.size());
    out_.textures.push_back(std::move(made));
    return entry->second;
  }

  int image_index(size_t index) {
    const auto [entry, is_new] = image_of_.try_emplace(index, -1);
    if (!is_new) return entry->second;
    const Image& source = model_.images.at(index);
    const Result<GlbImage> encoded = glb_image(source, pixels_left_);
    if (!encoded) {
      warn("the image \"" + fit_name(source.name) + "\" is left out: " + encoded.error().message);
      return -1;
    }
    tinygltf::Image image;
    image.name = fit_name(source.name);
    image.mimeType = encoded->mime_type;
    image.bufferView = add_view(encoded->bytes, 0);
    entry->second = static_cast<int>(out_.images.size());
    out_.images.push_back(std::move(image));
    return entry->second;
  }

  void add_camera(const Camera& source) {
    tinygltf::Camera camera;
    camera.name = fit_name(source.name);
    if (source.height_m) {
      camera.type = "orthographic";
      camera.orthographic.ymag = std::max(*source.height_m / 2, 1e-6f);
      camera.orthographic.xmag = camera.orthographic.ymag * source.aspect.value_or(1);
      camera.orthographic.znear = std::max(source.near_m, 0.0f);
      camera.orthographic.zfar = std::max(source.far_m.value_or(0), source.near_m + 1);
      out_.cameras.push_back(std::move(camera));
      return;
    }
    camera.type = "perspective";
    camera.perspective.yfov = std::clamp(source.vertical_fov_rad, 1e-3f, 3.14f);
    camera.perspective.znear = std::max(source.near_m, 1e-5f);
    if (source.far_m && *source.far_m > camera.perspective.znear) camera.perspective.zfar = *source.far_m;
    if (source.aspect && *source.aspect > 0) camera.perspective.aspectRatio = *source.aspect;
    // As the scene loader reads them; glTF itself has centred cameras with square pixels.
    tinygltf::Value::Object members;
    const auto number = [](float value, float most) {
      return tinygltf::Value(static_cast<double>(std::isfinite(value) ? std::clamp(value, -most, most) : 0));
    };
    if (source.pixel_aspect != 1 && source.pixel_aspect > 0)
      members["pixelAspectRatio"] = number(std::max(source.pixel_aspect, 1e-3f), 1e3f);
    if (source.principal_point != glm::vec2(0))
      members["principalPoint"] = tinygltf::Value(tinygltf::Value::Array{
          number(source.principal_point.x, 1e3f), number(source.principal_point.y, 1e3f)});
    if (!members.empty()) camera.extras = tinygltf::Value(std::move(members));
    out_.cameras.push_back(std::move(camera));
  }

  void add_light(const Light& source) {
    tinygltf::Light light;
    light.name = fit_name(source.name);
    light.type = source.type == Light::Type::directional ? "directional"
                 : source.type == Light::Type::point     ? "point"
                                                         : "spot";
    light.color = list(glm::clamp(source.color, 0.0f, 1.0f));
    light.intensity = std::max(source.intensity, 0.0f);
    if (source.type == Light::Type::spot) {
      light.spot.outerConeAngle =
          std::clamp(static_cast<double>(source.outer_cone_rad), 1e-3, std::numbers::pi / 2);
      light.spot.innerConeAngle =
          std::clamp(static_cast<double>(source.inner_cone_rad), 0.0, light.spot.outerConeAngle * 0.999);
    }
    out_.lights.push_back(std::move(light));
  }

  void add_skin(const Skin& source) {
    tinygltf::Skin skin;
    skin.name = fit_name(source.name);
    std::vector<glm::mat4> matrices;
    for (const Skin::Joint& joint : source.joints) {
      skin.joints.push_back(static_cast<int>(joint.node) + 1);  // after the root node
      matrices.emplace_back(joint.from_mesh);
    }
    skin.inverseBindMatrices = add_accessor(matrices, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_MAT4, 0);
    out_.skins.push_back(std::move(skin));
  }

  // The root node's name must differ from all others, since streams look nodes up by name.
  std::string root_name() const {
    std::string name = fit_name(model_.name);
    const auto is_taken = [&](const Node& node) { return node.name == name; };
    while (std::any_of(model_.nodes.begin(), model_.nodes.end(), is_taken)) name += " (scene)";
    return name;
  }

  void add_nodes() {
    tinygltf::Node root;
    root.name = root_name();
    set_rotation(model_.gltf_from_model, root);
    add_joints(root);
    out_.nodes.push_back(std::move(root));
    for (const Node& source : model_.nodes) {
      tinygltf::Node node;
      node.name = fit_name(source.name);
      if (source.translation != glm::dvec3(0))
        node.translation = {source.translation.x, source.translation.y, source.translation.z};
      set_rotation(source.rotation, node);
      if (source.scale != glm::dvec3(1)) node.scale = {source.scale.x, source.scale.y, source.scale.z};
      if (source.mesh) node.mesh = mesh_of_[*source.mesh];
      if (source.skin && node.mesh >= 0) node.skin = static_cast<int>(*source.skin);
      if (source.camera) node.camera = static_cast<int>(*source.camera);
      if (source.light) {
        tinygltf::Value::Object members;
        members["light"] = tinygltf::Value(static_cast<int>(*source.light));
        node.extensions["KHR_lights_punctual"] = tinygltf::Value(std::move(members));
        set_light(static_cast<int>(*source.light), node);
      }
      const auto index = static_cast<int>(out_.nodes.size());
      out_.nodes[source.parent ? *source.parent + 1 : 0].children.push_back(index);
      out_.nodes.push_back(std::move(node));
    }
    out_.scenes.emplace_back();
    out_.scenes[0].nodes = {0};
    tinygltf::Value::Object members;
    if (const int sky = model_.sky_image ? texture(*model_.sky_image, Wrap::repeat, Wrap::clamp) : -1;
        sky >= 0)
      members["skyTexture"] = tinygltf::Value(sky);
    if (model_.view_from) {
      const glm::dvec3 from = model_.gltf_from_model * *model_.view_from;
      members["viewFrom"] = tinygltf::Value(
          tinygltf::Value::Array{tinygltf::Value(from.x), tinygltf::Value(from.y), tinygltf::Value(from.z)});
    }
    if (!members.empty()) out_.scenes[0].extras = tinygltf::Value(std::move(members));
    out_.defaultScene = 0;
  }

  void add_joints(tinygltf::Node& root) {
    std::vector<std::string> names, problems;
    if (model_.kinematics.has_joints())
      for (const Node& node : model_.nodes) names.push_back(fit_name(node.name));
    if (auto extras = joint_extras(model_.kinematics, names, problems)) root.extras = std::move(*extras);
    for (const std::string& problem : problems) warn(problem);
  }

  static void set_rotation(const glm::dquat& rotation, tinygltf::Node& node) {
    const glm::dquat unit = glm::normalize(rotation);
    if (unit != glm::dquat(1, 0, 0, 0)) node.rotation = {unit.x, unit.y, unit.z, unit.w};
  }

  void use_extension(const std::string& name) {
    if (std::find(out_.extensionsUsed.begin(), out_.extensionsUsed.end(), name) == out_.extensionsUsed.end())
      out_.extensionsUsed.push_back(name);
  }

  const Model& model_;
  std::vector<std::string>* warnings_;
  tinygltf::Model out_;
  std::vector<int> mesh_of_;
  std::map<std::pair<size_t, bool>, int> material_of_;
  std::map<size_t, int> image_of_;
  std::map<std::tuple<size_t, Wrap, Wrap>, int> texture_of_;
  std::map<std::pair<Wrap, Wrap>, int> sampler_of_;
  uint64_t pixels_left_ = kMaxPixelsInAll;
};

}  // namespace

Result<std::vector<std::byte>> write_glb(const Model& model, std::vector<std::string>* warnings) {
  for (size_t i = 0; i < model.nodes.size(); ++i) {
    const Node& node = model.nodes[i];
    FIRE3DV_ASSERT((!node.parent || *node.parent < i) && (!node.mesh || *node.mesh < model.meshes.size()));
    FIRE3DV_ASSERT((!node.camera || *node.camera < model.cameras.size()) &&
                   (!node.light || *node.light < model.lights.size()));
    FIRE3DV_ASSERT(!node.skin || *node.skin < model.skins.size());
    const double sum = glm::dot(node.translation, node.translation) + glm::dot(node.scale, node.scale) +
                       glm::dot(node.rotation, node.rotation);
    if (!std::isfinite(sum))
      return Error{"the pose of \"" + fit_name(node.name) + "\" is not made of finite numbers"};
  }
  for (const Skin& skin : model.skins)
    for (const Skin::Joint& joint : skin.joints) FIRE3DV_ASSERT(joint.node < model.nodes.size());
  return Writer(model, warnings).write();
}

}  // namespace fire3dv::convert
