#include "renderer/scene/gltf/gltf_accessors.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace fire3dv::scene {

size_t component_bytes(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

namespace {

// MAT4 is the only matrix type in use (skins); its columns have no padding.
int component_count(int type) {
  switch (type) {
    case TINYGLTF_TYPE_SCALAR:
      return 1;
    case TINYGLTF_TYPE_VEC2:
      return 2;
    case TINYGLTF_TYPE_VEC3:
      return 3;
    case TINYGLTF_TYPE_VEC4:
      return 4;
    case TINYGLTF_TYPE_MAT4:
      return 16;
    default:
      return 0;
  }
}

// Calls `body` with a value of the C++ type of the component type.
template <typename Body>
void with_component(int component_type, Body body) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      body(int8_t{});
      break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      body(uint8_t{});
      break;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      body(int16_t{});
      break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      body(uint16_t{});
      break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      body(uint32_t{});
      break;
    default:
      body(float{});
      break;
  }
}

template <typename Component>
float to_float(Component value, bool normalized) {
  if constexpr (std::is_floating_point_v<Component>) {
    return value;
  } else {
    if (!normalized) return static_cast<float>(value);
    // -128 and -127 both map to -1.
    return std::max(static_cast<float>(value) / static_cast<float>(std::numeric_limits<Component>::max()),
                    -1.0f);
  }
}

template <typename Component>
Component load(const std::byte* from) {
  Component value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

// Converts elements; returns false for non-finite floats.
template <typename Component>
bool convert(const std::byte* from, size_t stride, size_t count, int components, bool normalized, float* to,
             size_t stride_floats) {
  bool finite = true;
  for (size_t i = 0; i < count; ++i, from += stride, to += stride_floats) {
    for (int c = 0; c < components; ++c) {
      to[c] = to_float(load<Component>(from + static_cast<size_t>(c) * sizeof(Component)), normalized);
      finite &= std::isfinite(to[c]);
    }
  }
  return finite;
}

Error beyond_view(const std::string& name, int buffer_view) {
  return Error{name + " reaches beyond the end of " +
               element("bufferViews", static_cast<size_t>(buffer_view))};
}

}  // namespace

bool AccessorReader::has_data(int accessor) const {
  const auto& accessors = document_.model.accessors;
  if (!in_range(accessor, accessors.size())) return true;  // an error of its own
  const tinygltf::Accessor& source = accessors[static_cast<size_t>(accessor)];
  return source.bufferView >= 0 || source.sparse.isSparse;
}

Result<size_t> AccessorReader::count(int accessor, const std::string& where) const {
  const auto& accessors = document_.model.accessors;
  if (!in_range(accessor, accessors.size()))
    return out_of_range(where, "accessors", accessor, accessors.size());
  const size_t count = accessors[static_cast<size_t>(accessor)].count;
  const std::string name = element("accessors", static_cast<size_t>(accessor));
  if (count == 0) return Error{where + ": " + name + " has a count of 0"};
  if (count > limits_.max_elements) {
    return Error{where + ": " + name + " has " + std::to_string(count) + " elements; at most " +
                 std::to_string(limits_.max_elements) + " are read"};
  }
  // Validated before callers allocate memory for the elements.
  if (auto checked = elements(accessors[static_cast<size_t>(accessor)], where + ": " + name); !checked) {
    return checked.error();
  }
  return count;
}

Result<void> AccessorReader::reserve(uint64_t bytes, const std::string& where) const {
  if (!limits_.reserve) return {};
  if (Result<void> reserved = limits_.reserve(bytes); !reserved)
    return Error{where + ": " + reserved.error().message};
  return {};
}

Result<AccessorReader::Elements> AccessorReader::elements(const tinygltf::Accessor& accessor,
                                                          const std::string& name) const {
  Elements result;
  result.count = accessor.count;
  result.component_type = accessor.componentType;
  result.components = component_count(accessor.type);
  result.normalized = accessor.normalized;
  const size_t component = component_bytes(accessor.componentType);
  if (component == 0)
    return Error{name + " has the unknown componentType " + std::to_string(accessor.componentType)};
  if (result.components == 0) {
    const bool is_unknown = accessor.name.starts_with("unknown type");
    return Error{name +
                 (is_unknown ? " has the " + accessor.name : " is a matrix of a size that has no use")};
  }
  const size_t packed_bytes = component * static_cast<size_t>(result.components);
  result.stride = packed_bytes;
  if (accessor.bufferView < 0) {
    // All zeros except sparse values. The limit prevents a few bytes of JSON from claiming gigabytes.
    size_t bytes = 1u << 20;
    for (const auto& buffer : document_.buffers) bytes += buffer.size();
    if (accessor.count > bytes)
      return Error{name + " has no bufferView but " + std::to_string(accessor.count) + " elements"};
    return result;
  }
  auto bytes = buffer_view_bytes(document_, accessor.bufferView, name);
  if (!bytes) return bytes.error();
  const size_t stride = document_.model.bufferViews[static_cast<size_t>(accessor.bufferView)].byteStride;
  if (stride != 0) {
    if (stride < packed_bytes) {
      return Error{name + ": " + element("bufferViews", static_cast<size_t>(accessor.bufferView)) +
                   " has a byteStride of " + std::to_string(stride) + ", less than the " +
                   std::to_string(packed_bytes) + " bytes of an element"};
    }
    result.stride = stride;
  }
  size_t reach = 0;
  if (__builtin_mul_overflow(accessor.count - 1, result.stride, &reach) ||
      __builtin_add_overflow(reach, packed_bytes, &reach) ||
      __builtin_add_overflow(reach, accessor.byteOffset, &reach) || reach > bytes->size()) {
    return beyond_view(name, accessor.bufferView);
  }
  result.data = bytes->data() + accessor.byteOffset;
  return result;
}

Result<AccessorReader::Elements> AccessorReader::packed(int buffer_view, int byte_offset, size_t count,
                                                        int component_type, int components,
                                                        const std::string& name) const {
  auto bytes = buffer_view_bytes(document_, buffer_view, name);
  if (!bytes) return bytes.error();
  const size_t stride = component_bytes(component_type) * static_cast<size_t>(components);
  size_t reach = 0;
  if (byte_offset < 0 || __builtin_mul_overflow(count, stride, &reach) ||
      __builtin_add_overflow(reach, static_cast<size_t>(byte_offset), &reach) || reach > bytes->size()) {
    return beyond_view(name, buffer_view);
  }
  return Elements{bytes->data() + byte_offset, stride, count, component_type, components, false};
}

template <typename Sink>
Result<void> AccessorReader::for_each_sparse(const tinygltf::Accessor& accessor, const Elements& base,
                                             const std::string& name, Sink sink) const {
  if (!accessor.sparse.isSparse) return {};
  const std::string sparse = name + ".sparse";
  if (accessor.sparse.count <= 0 || static_cast<size_t>(accessor.sparse.count) > base.count) {
    return Error{sparse + " has a count of " + std::to_string(accessor.sparse.count) + ", outside 1 to " +
                 std::to_string(base.count)};
  }
  const int type = accessor.sparse.indices.componentType;
  if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
      type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) {
    return Error{sparse + ".indices has the componentType " + std::to_string(type) +
                 ", which is not for indices"};
  }
  const auto count = static_cast<size_t>(accessor.sparse.count);
  auto indices = packed(accessor.sparse.indices.bufferView, accessor.sparse.indices.byteOffset, count, type,
                        1, sparse + ".indices");
  if (!indices) return indices.error();
  auto values = packed(accessor.sparse.values.bufferView, accessor.sparse.values.byteOffset, count,
                       base.component_type, base.components, sparse + ".values");
  if (!values) return values.error();
  int64_t before = -1;
  bool in_order = true, in_count = true;
  with_component(type, [&](auto component) {
    using Component = decltype(component);
    if constexpr (std::is_unsigned_v<Component>) {
      for (size_t i = 0; i < count && in_order && in_count; ++i) {
        const auto index = int64_t{load<Component>(indices->data + i * sizeof(Component))};
        in_order = index > before;
        in_count = static_cast<size_t>(index) < base.count;
        if (in_order && in_count) sink(static_cast<size_t>(index), values->data + i * values->stride);
        before = index;
      }
    }
  });
  if (!in_count)
    return Error{sparse + ".indices holds " + std::to_string(before) + ", but the accessor has " +
                 std::to_string(base.count) + " elements"};
  if (!in_order) return Error{sparse + ".indices are not in rising order"};
  return {};
}

Result<void> AccessorReader::read_floats(int accessor, const std::string& where, float* first,
                                         size_t stride_floats, int components, int min_components,
                                         bool* is_finite) const {
  const tinygltf::Accessor& source = document_.model.accessors[static_cast<size_t>(accessor)];
  const std::string name = where + ": " + element("accessors", static_cast<size_t>(accessor));
  auto from = elements(source, name);
  if (!from) return from.error();
  if (from->components < min_components || from->components > components) {
    return Error{name + " has " + std::to_string(from->components) + " components an element, not " +
                 std::to_string(components)};
  }
  if (from->data == nullptr) {
    for (size_t i = 0; i < from->count; ++i) std::fill_n(first + i * stride_floats, from->components, 0.0f);
  }
  bool finite = true;
  Result<void> sparse;
  with_component(from->component_type, [&](auto component) {
    using Component = decltype(component);
    if (from->data != nullptr) {
      finite = convert<Component>(from->data, from->stride, from->count, from->components, from->normalized,
                                  first, stride_floats);
    }
    sparse = for_each_sparse(source, *from, name, [&](size_t index, const std::byte* value) {
      finite &= convert<Component>(value, 0, 1, from->components, from->normalized,
                                   first + index * stride_floats, 0);
    });
  });
  if (!sparse) return sparse.error();
  if (is_finite != nullptr) {
    *is_finite = finite;
  } else if (!finite) {
    return Error{name + " holds a value that is not a finite number"};
  }
  return {};
}

Result<void> AccessorReader::read_indices(int accessor, const std::string& where, uint32_t* first,
                                          uint32_t limit) const {
  const tinygltf::Accessor& source = document_.model.accessors[static_cast<size_t>(accessor)];
  const std::string name = where + ": " + element("accessors", static_cast<size_t>(accessor));
  auto from = elements(source, name);
  if (!from) return from.error();
  if (from->components != 1) return Error{name + " is not a scalar, as indices are"};
  uint32_t largest = 0;
  bool is_unsigned = false;
  Result<void> sparse;
  with_component(from->component_type, [&](auto component) {
    using Component = decltype(component);
    if constexpr (std::is_unsigned_v<Component>) {
      is_unsigned = true;
      for (size_t i = 0; i < from->count; ++i) {
        first[i] = from->data == nullptr ? 0 : uint32_t{load<Component>(from->data + i * from->stride)};
      }
      sparse = for_each_sparse(source, *from, name, [&](size_t index, const std::byte* value) {
        first[index] = load<Component>(value);
      });
      for (size_t i = 0; i < from->count; ++i) largest = std::max(largest, first[i]);
    }
  });
  if (!is_unsigned)
    return Error{name + " has the componentType " + std::to_string(from->component_type) +
                 ", which is not for indices"};
  if (!sparse) return sparse.error();
  if (largest >= limit) {
    return Error{name + " holds the index " + std::to_string(largest) + ", but there are " +
                 std::to_string(limit) + " vertices"};
  }
  return {};
}

}  // namespace fire3dv::scene
