#include "examples/common/gltf_writer.h"

#include <algorithm>
#include <charconv>

namespace examples {
namespace {

using fire3dv::base::GlbBuffer;

constexpr int kFloat = 5126, kUint32 = 5125;

// Returns the shortest text that parses to the same float, independent of the locale.
std::string number(float value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return std::string(text, end);
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + '"';
}

template <size_t N>
std::string list(const std::array<float, N>& values) {
  std::string out = "[";
  for (size_t i = 0; i < N; ++i) out += (i ? "," : "") + number(values[i]);
  return out + "]";
}

std::string joined(const std::vector<std::string>& parts) {
  std::string out;
  for (size_t i = 0; i < parts.size(); ++i) out += (i ? ",\n" : "\n") + parts[i];
  return out;
}

// Returns a JSON member with an array, or nothing: glTF forbids empty arrays.
std::string member(const char* name, const std::vector<std::string>& parts) {
  return parts.empty() ? "" : ",\n\"" + std::string(name) + "\":[" + joined(parts) + "]";
}

std::string view_text(const GlbBuffer::View& view) {
  std::string text = "{\"buffer\":0,\"byteOffset\":" + std::to_string(view.offset) +
                     ",\"byteLength\":" + std::to_string(view.bytes);
  if (view.target != GlbBuffer::Target::none)
    text += ",\"target\":" + std::to_string(static_cast<int>(view.target));
  return text + "}";
}

}  // namespace

size_t GltfWriter::add_accessor(size_t view, int component_type, size_t count, const char* type,
                                const std::string& extra) {
  accessors_.push_back("{\"bufferView\":" + std::to_string(view) +
                       ",\"componentType\":" + std::to_string(component_type) +
                       ",\"count\":" + std::to_string(count) + ",\"type\":\"" + type + "\"" + extra + "}");
  return accessors_.size() - 1;
}

size_t GltfWriter::add_texture(const std::string& name, std::span<const uint8_t> png) {
  const size_t view = buffer_.add_view(std::as_bytes(png));
  images_.push_back("{\"name\":" + quoted(name) +
                    ",\"mimeType\":\"image/png\",\"bufferView\":" + std::to_string(view) + "}");
  textures_.push_back("{\"sampler\":0,\"source\":" + std::to_string(images_.size() - 1) + "}");
  return textures_.size() - 1;
}

size_t GltfWriter::add_material(const GltfMaterial& m) {
  const auto texture = [](const char* name, std::optional<size_t> index) {
    return index ? ",\"" + std::string(name) + "\":{\"index\":" + std::to_string(*index) + "}"
                 : std::string();
  };
  std::string extensions;
  const auto extension = [&](const char* name, const std::string& members) {
    extensions_used_.insert(name);
    extensions += (extensions.empty() ? "\"" : ",\"") + std::string(name) + "\":{" + members + "}";
  };
  if (m.specular) extension("KHR_materials_specular", "\"specularFactor\":" + number(*m.specular));
  if (m.ior) extension("KHR_materials_ior", "\"ior\":" + number(*m.ior));
  if (m.transmission > 0)
    extension("KHR_materials_transmission", "\"transmissionFactor\":" + number(m.transmission));
  if (m.thickness_m > 0) extension("KHR_materials_volume", "\"thicknessFactor\":" + number(m.thickness_m));
  if (!extensions.empty()) extensions = ",\"extensions\":{" + extensions + "}";
  const std::array<float, 4> color = {m.base_color[0], m.base_color[1], m.base_color[2], 1};
  materials_.push_back(
      "{\"name\":" + quoted(m.name) + ",\"pbrMetallicRoughness\":{\"baseColorFactor\":" + list(color) +
      ",\"metallicFactor\":" + number(m.metallic) + ",\"roughnessFactor\":" + number(m.roughness) +
      texture("baseColorTexture", m.base_color_texture) +
      texture("metallicRoughnessTexture", m.metallic_roughness_texture) + "}" +
      texture("normalTexture", m.normal_texture) + ",\"emissiveFactor\":" + list(m.emissive) + extensions +
      "}");
  return materials_.size() - 1;
}

size_t GltfWriter::add_mesh(const std::string& name, std::span<const Primitive> primitives) {
  std::vector<std::string> texts;
  for (const Primitive& primitive : primitives) {
    std::vector<float> positions, normals, tangents, uvs;
    Vec3 low = primitive.mesh->vertices.front().position, high = low;
    for (const Vertex& v : primitive.mesh->vertices) {
      positions.insert(positions.end(), {v.position.x, v.position.y, v.position.z});
      normals.insert(normals.end(), {v.normal.x, v.normal.y, v.normal.z});
      tangents.insert(tangents.end(), {v.tangent.x, v.tangent.y, v.tangent.z, v.handedness});
      // glTF's v grows downwards in the image; the negation makes the bitangent point up.
      uvs.insert(uvs.end(), {v.u * primitive.uv_scale, -v.v * primitive.uv_scale});
      low = {std::min(low.x, v.position.x), std::min(low.y, v.position.y), std::min(low.z, v.position.z)};
      high = {std::max(high.x, v.position.x), std::max(high.y, v.position.y), std::max(high.z, v.position.z)};
    }
    const auto floats = [&](const std::vector<float>& data, size_t width, const char* type,
                            const std::string& extra) {
      const size_t view = buffer_.add_view(std::as_bytes(std::span(data)), GlbBuffer::Target::array_buffer);
      return std::to_string(add_accessor(view, kFloat, data.size() / width, type, extra));
    };
    const std::string bounds = ",\"min\":" + list(std::array<float, 3>{low.x, low.y, low.z}) +
                               ",\"max\":" + list(std::array<float, 3>{high.x, high.y, high.z});
    std::string attributes = "\"POSITION\":" + floats(positions, 3, "VEC3", bounds);
    attributes += ",\"NORMAL\":" + floats(normals, 3, "VEC3", "");
    attributes += ",\"TANGENT\":" + floats(tangents, 4, "VEC4", "");
    attributes += ",\"TEXCOORD_0\":" + floats(uvs, 2, "VEC2", "");
    const auto& indices = primitive.mesh->indices;
    const size_t view =
        buffer_.add_view(std::as_bytes(std::span(indices)), GlbBuffer::Target::element_array_buffer);
    const size_t accessor = add_accessor(view, kUint32, indices.size(), "SCALAR", "");
    texts.push_back("{\"attributes\":{" + attributes + "},\"indices\":" + std::to_string(accessor) +
                    ",\"material\":" + std::to_string(primitive.material) + "}");
  }
  meshes_.push_back("{\"name\":" + quoted(name) + ",\"primitives\":[" + joined(texts) + "]}");
  return meshes_.size() - 1;
}

size_t GltfWriter::add_camera(const std::string& name, float vertical_fov_rad, float near_m) {
  cameras_.push_back("{\"name\":" + quoted(name) + ",\"type\":\"perspective\",\"perspective\":{\"yfov\":" +
                     number(vertical_fov_rad) + ",\"znear\":" + number(near_m) + "}}");
  return cameras_.size() - 1;
}

size_t GltfWriter::add_light(const GltfLight& light) {
  extensions_used_.insert("KHR_lights_punctual");
  std::string text = "{\"name\":" + quoted(light.name) + ",\"type\":" + quoted(light.type) +
                     ",\"color\":" + list(light.color) + ",\"intensity\":" + number(light.intensity);
  if (light.type == "spot") {
    text += ",\"spot\":{\"innerConeAngle\":" + number(light.inner_cone_rad) +
            ",\"outerConeAngle\":" + number(light.outer_cone_rad) + "}";
  }
  lights_.push_back(text + "}");
  return lights_.size() - 1;
}

void GltfWriter::add_node(const Node& node) {
  const GltfMatrix& m = node.parent_from_node;
  const std::array<float, 16> columns = {m[0], m[4], m[8],  0, m[1], m[5], m[9],  0,
                                         m[2], m[6], m[10], 0, m[3], m[7], m[11], 1};
  std::string text = "{\"name\":" + quoted(node.name) + ",\"matrix\":" + list(columns);
  if (node.mesh) text += ",\"mesh\":" + std::to_string(*node.mesh);
  if (node.camera) text += ",\"camera\":" + std::to_string(*node.camera);
  if (node.light) {
    text += ",\"extensions\":{\"KHR_lights_punctual\":{\"light\":" + std::to_string(*node.light) + "}}";
  }
  nodes_.push_back(text + "}");
}

std::vector<std::byte> GltfWriter::finish(const std::string& root_name, const std::string& generator) const {
  std::string children;
  for (size_t i = 0; i < nodes_.size(); ++i) children += (i ? "," : "") + std::to_string(i);
  std::vector<std::string> nodes = nodes_;
  nodes.push_back("{\"name\":" + quoted(root_name) + ",\"children\":[" + children + "]}");
  std::vector<std::string> views;
  for (const GlbBuffer::View& view : buffer_.views()) views.push_back(view_text(view));

  std::string json = "{\"asset\":{\"version\":\"2.0\",\"generator\":" + quoted(generator) + "}";
  json += ",\n\"scene\":0,\"scenes\":[{\"nodes\":[" + std::to_string(nodes.size() - 1) + "]}]";
  json += member("nodes", nodes) + member("meshes", meshes_) + member("materials", materials_) +
          member("textures", textures_) + member("images", images_) + member("cameras", cameras_) +
          member("accessors", accessors_) + member("bufferViews", views);
  if (!textures_.empty()) {
    json += ",\n\"samplers\":[{\"magFilter\":9729,\"minFilter\":9987,\"wrapS\":10497,\"wrapT\":10497}]";
  }
  std::string extensions_used;
  for (const std::string& name : extensions_used_)
    extensions_used += (extensions_used.empty() ? "" : ",") + quoted(name);
  if (!extensions_used.empty()) json += ",\n\"extensionsUsed\":[" + extensions_used + "]";
  if (!lights_.empty()) {
    json += ",\n\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[" + joined(lights_) + "]}}";
  }
  json += ",\n\"buffers\":[{\"byteLength\":" + std::to_string(buffer_.bytes().size()) + "}]}";
  return fire3dv::base::make_glb(json, buffer_.bytes());
}

}  // namespace examples
