#include "renderer/scene/gltf/meshes/draco_mesh.h"

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <utility>

#include "base/text.h"
#include "renderer/scene/gltf/gltf_accessors.h"

namespace fire3dv::scene {
namespace {

// Working copy of each component and of each value: integers before the dequantisation, and sequences.
constexpr uint64_t kPortableBytes = 4, kSequenceBytes = 16;

// Attributes are charged when the decoder has read their description and before it allocates their values.
class BoundedMesh : public draco::Mesh {
 public:
  BoundedMesh(uint64_t max_points, const std::function<Result<void>(uint64_t)>& reserve)
      : max_points_(max_points), reserve_(reserve) {}

  struct Refused : std::exception {};
  const Error& fault() const { return fault_; }

  void SetAttribute(int id, std::unique_ptr<draco::PointAttribute> attribute) override {
    const uint64_t points = num_points() > 0 ? num_points() : max_points_;
    const auto components = uint64_t{attribute->num_components()};
    const auto value_bytes = static_cast<uint64_t>(std::max<int64_t>(attribute->byte_stride(), 0));
    if (auto room = reserve_(points * (value_bytes + components * kPortableBytes + kSequenceBytes)); !room) {
      fault_ = room.error();
      throw Refused();
    }
    draco::Mesh::SetAttribute(id, std::move(attribute));
  }

 private:
  uint64_t max_points_;
  const std::function<Result<void>(uint64_t)>& reserve_;
  Error fault_;
};

template <typename Component>
bool convert(const draco::PointAttribute& attribute, draco::AttributeValueIndex value, int components,
             std::byte* to) {
  Component converted[16];
  if (!attribute.ConvertValue<Component>(value, static_cast<int8_t>(components), converted)) return false;
  std::memcpy(to, converted, static_cast<size_t>(components) * sizeof(Component));
  return true;
}

// The glTF component type with the same bytes as a Draco type; 0: none.
int component_type_of(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return TINYGLTF_COMPONENT_TYPE_BYTE;
    case draco::DT_UINT8:
      return TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
    case draco::DT_INT16:
      return TINYGLTF_COMPONENT_TYPE_SHORT;
    case draco::DT_UINT16:
      return TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
    case draco::DT_UINT32:
      return TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    case draco::DT_FLOAT32:
      return TINYGLTF_COMPONENT_TYPE_FLOAT;
    default:
      return 0;
  }
}

bool convert_to(int component_type, const draco::PointAttribute& attribute, draco::AttributeValueIndex value,
                int components, std::byte* to) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return convert<int8_t>(attribute, value, components, to);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return convert<uint8_t>(attribute, value, components, to);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return convert<int16_t>(attribute, value, components, to);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return convert<uint16_t>(attribute, value, components, to);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return convert<uint32_t>(attribute, value, components, to);
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return convert<float>(attribute, value, components, to);
    default:
      return false;
  }
}

}  // namespace

DracoMesh::DracoMesh(std::unique_ptr<draco::Mesh> mesh) : mesh_(std::move(mesh)) {}
DracoMesh::DracoMesh(DracoMesh&& other) noexcept = default;
DracoMesh& DracoMesh::operator=(DracoMesh&& other) noexcept = default;
DracoMesh::~DracoMesh() = default;

Result<DracoMesh> DracoMesh::decode(const DracoHeader& header,
                                    const std::function<Result<void>(uint64_t bytes)>& reserve) {
  if (auto room = reserve(header.connectivity_bytes()); !room) return room.error();
  std::unique_ptr<BoundedMesh> mesh;
  try {
    mesh = std::make_unique<BoundedMesh>(header.max_points, reserve);
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(header.stream.data()), header.stream.size());
    draco::Decoder decoder;
    const draco::Status status = decoder.DecodeBufferToGeometry(&buffer, mesh.get());
    if (!status.ok()) return Error{"the Draco stream is damaged: " + quote(status.error_msg_string())};
  } catch (const BoundedMesh::Refused&) {
    return mesh->fault();
  } catch (const std::bad_alloc&) {
    return Error{"the decoded Draco stream does not fit into memory"};
  } catch (const std::exception& error) {
    return Error{"the Draco stream is damaged: " + quote(error.what())};
  }
  if (mesh->num_faces() == 0 || mesh->num_points() == 0) return Error{"the Draco stream holds no triangles"};
  return DracoMesh(std::move(mesh));
}

size_t DracoMesh::face_count() const {
  return mesh_->num_faces();
}

size_t DracoMesh::point_count() const {
  return mesh_->num_points();
}

void DracoMesh::copy_indices(uint32_t* to) const {
  for (draco::FaceIndex face(0); face < mesh_->num_faces(); ++face) {
    for (const draco::PointIndex& point : mesh_->face(face)) *to++ = point.value();
  }
}

Result<void> DracoMesh::copy_attribute(uint32_t unique_id, int component_type, int components,
                                       std::byte* to) const {
  const draco::PointAttribute* attribute = mesh_->GetAttributeByUniqueId(unique_id);
  if (attribute == nullptr) return Error{"the Draco stream has no attribute " + std::to_string(unique_id)};
  if (attribute->num_components() != components) {
    return Error{"attribute " + std::to_string(unique_id) + " of the Draco stream has " +
                 std::to_string(int{attribute->num_components()}) +
                 " components, but the accessor's type has " + std::to_string(components)};
  }
  const size_t packed = component_bytes(component_type) * static_cast<size_t>(components);
  const bool is_same = component_type_of(attribute->data_type()) == component_type;
  const auto stride = static_cast<size_t>(attribute->byte_stride());
  const size_t held = attribute->buffer() == nullptr ? 0 : attribute->buffer()->data_size();
  if (stride == 0 || attribute->size() > held / stride || (is_same && stride < packed))
    return Error{"attribute " + std::to_string(unique_id) + " of the Draco stream is cut short"};
  for (draco::PointIndex point(0); point < mesh_->num_points(); ++point, to += packed) {
    // Streams with damaged connectivity leave points without a value.
    if (!attribute->is_mapping_identity() && point.value() >= attribute->indices_map_size())
      return Error{"attribute " + std::to_string(unique_id) + " of the Draco stream lacks vertices"};
    const draco::AttributeValueIndex value = attribute->mapped_index(point);
    if (value.value() >= attribute->size())
      return Error{"attribute " + std::to_string(unique_id) + " of the Draco stream lacks vertices"};
    if (is_same) {
      std::memcpy(to, attribute->GetAddress(value), packed);
    } else if (!convert_to(component_type, *attribute, value, components, to)) {
      return Error{"attribute " + std::to_string(unique_id) +
                   " of the Draco stream cannot be converted to the accessor's componentType"};
    }
  }
  return {};
}

}  // namespace fire3dv::scene
