#include <algorithm>
#include <atomic>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "renderer/scene/gltf/gltf_document.h"
#include "renderer/scene/gltf/meshes/draco_mesh.h"
#include "renderer/scene/gltf/meshes/draco_primitives.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;

// Upper bounds of the decoder's memory per compressed byte, and of what any stream may take. Real meshes stay
// below 300; streams of a few bytes could otherwise claim any amount of memory.
constexpr uint64_t kMaxDecodedPerByte = 4096, kMinDecoded = uint64_t{16} << 20;

size_t aligned(size_t bytes) {
  return (bytes + 3) / 4 * 4;
}

Result<std::span<const std::byte>> bytes_of_view(const json& root, const GltfDocument& document,
                                                 size_t index) {
  const std::string name = element("bufferViews", index);
  const json* view = element_at(root, "bufferViews", index);
  if (view == nullptr) return Error{"bufferView is missing, or there is no " + name};
  const auto buffer = view->value("buffer", size_t{0});
  if (!view->contains("buffer") || buffer >= document.buffers.size())
    return Error{name + " refers to no buffer of the file"};
  const auto offset = view->value("byteOffset", uint64_t{0}), length = view->value("byteLength", uint64_t{0});
  const auto bytes = document.buffers[buffer];
  if (offset > bytes.size() || length > bytes.size() - offset) {
    return Error{name + " reaches from byte " + std::to_string(offset) + " over " + std::to_string(length) +
                 " bytes, but " + element("buffers", buffer) + " holds " + std::to_string(bytes.size())};
  }
  return bytes.subspan(offset, length);
}

Result<void> check_header(const DracoHeader& header, const DracoPrimitive& use) {
  if (header.faces > use.max_faces) {
    return Error{"the Draco stream states " + std::to_string(header.faces) +
                 " triangles, but the accessor of the indices has room for " + std::to_string(use.max_faces)};
  }
  if (header.points_are_exact && header.max_points > use.max_points) {
    return Error{"the Draco stream states " + std::to_string(header.max_points) +
                 " vertices, but the accessor of POSITION has " + std::to_string(use.max_points)};
  }
  return {};
}

// Memory that the file may take for decoded meshes. Used by several threads.
class Room {
 public:
  Room(const GltfDocument& document, const LoadLimits& limits) : limits_(limits) {
    uint64_t room = kMinDecoded;
    for (const auto& buffer : document.buffers) room += buffer.size() * kMaxDecodedPerByte;
    left_ = std::min(room, limits.max_file_bytes);
  }

  Result<void> take(uint64_t bytes) {
    uint64_t left = left_;
    while (bytes <= left && !left_.compare_exchange_weak(left, left - bytes)) {
    }
    if (bytes > left) return Error{"the file's compressed bytes cannot hold so much geometry"};
    return limits_.reserve ? limits_.reserve(bytes) : Result<void>();
  }

  bool stop_requested() const { return limits_.stop_requested && limits_.stop_requested(); }

 private:
  const LoadLimits& limits_;
  std::atomic<uint64_t> left_;
};

Result<DracoArrays> arrays_of(const DracoMesh& mesh, const DracoPrimitive& use, Room& room) {
  DracoArrays arrays;
  arrays.faces = mesh.face_count();
  arrays.points = mesh.point_count();
  size_t size = arrays.faces * 3 * sizeof(uint32_t);
  for (const DracoAttribute& attribute : use.attributes)
    size += aligned(attribute.packed_bytes * arrays.points);
  if (auto done = room.take(size); !done) return done.error();
  arrays.bytes = FileBytes{std::make_unique_for_overwrite<std::byte[]>(size), size};
  std::vector<uint32_t> indices(arrays.faces * 3);
  mesh.copy_indices(indices.data());
  std::copy_n(reinterpret_cast<const std::byte*>(indices.data()), indices.size() * sizeof(uint32_t),
              arrays.bytes.data.get());
  std::byte* to = arrays.bytes.data.get() + indices.size() * sizeof(uint32_t);
  for (const DracoAttribute& attribute : use.attributes) {
    auto done = mesh.copy_attribute(attribute.unique_id, attribute.component_type, attribute.components, to);
    if (!done) return Error{attribute.name + ": " + done.error().message};
    to += aligned(attribute.packed_bytes * arrays.points);
  }
  return arrays;
}

// Decodes a stream once for all its uses. Runs on any thread.
Result<void> decode(const json& root, const GltfDocument& document, Room& room, DracoStream& stream) {
  if (room.stop_requested()) return Error{"the load was stopped"};
  auto bytes = bytes_of_view(root, document, stream.view);
  if (!bytes) return bytes.error();
  auto header = read_draco_header(*bytes);
  if (!header) return header.error();
  bool is_wanted = false;
  for (DracoPrimitive& use : stream.uses) {
    if (use.fault || use.same_as) continue;
    if (auto fits = check_header(*header, use); !fits) use.fault = fits.error();
    is_wanted |= !use.fault;
  }
  if (!is_wanted) return {};
  uint64_t left = kMinDecoded + bytes->size() * kMaxDecodedPerByte;
  auto mesh = DracoMesh::decode(*header, [&](uint64_t more) -> Result<void> {
    if (more > left) return Error{"the compressed bytes cannot hold so much geometry"};
    left -= more;
    return room.take(more);
  });
  if (!mesh) return mesh.error();
  for (DracoPrimitive& use : stream.uses) {
    if (use.fault || use.same_as) continue;
    auto arrays = arrays_of(*mesh, use, room);
    if (!arrays) {
      use.fault = arrays.error();
    } else {
      use.arrays = std::move(*arrays);
    }
  }
  return {};
}

void decode_or_fail(const json& root, const GltfDocument& document, Room& room, DracoStream& stream) {
  const auto fail = [&](const Error& fault) {
    for (DracoPrimitive& use : stream.uses) {
      if (!use.fault) use.fault = fault;
    }
  };
  try {
    if (auto done = decode(root, document, room, stream); !done) fail(done.error());
  } catch (const std::bad_alloc&) {
    fail(Error{"the decoded mesh does not fit into memory"});
  }
}

// True if the primitive's accessors hold an uncompressed version.
bool has_fallback(const json& root, const json& primitive) {
  const auto has_bytes = [&](const json& accessor) {
    const json* source = element_at(root, "accessors", accessor.get<size_t>());
    return source != nullptr && source->contains("bufferView");
  };
  const json& attributes = primitive["attributes"];
  return std::all_of(attributes.begin(), attributes.end(), has_bytes) &&
         (!primitive.contains("indices") || has_bytes(primitive["indices"]));
}

size_t append(json& root, const char* array, json value) {
  json& elements = root[array];
  elements.push_back(std::move(value));
  return elements.size() - 1;
}

size_t add_accessor(json& root, size_t buffer, size_t offset, size_t bytes, json accessor) {
  accessor["bufferView"] =
      append(root, "bufferViews", json{{"buffer", buffer}, {"byteOffset", offset}, {"byteLength", bytes}});
  return append(root, "accessors", std::move(accessor));
}

// Lets the primitive refer to new accessors of the decoded arrays.
void redirect(DracoPrimitive& use, json& root, GltfDocument& document) {
  DracoArrays& arrays = use.arrays;
  const size_t buffer = document.buffers.size();
  json& primitive = *use.primitive;
  size_t offset = arrays.faces * 3 * sizeof(uint32_t);
  primitive["indices"] = add_accessor(root, buffer, 0, offset,
                                      json{{"componentType", TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT},
                                           {"type", "SCALAR"},
                                           {"count", arrays.faces * 3}});
  primitive["mode"] = TINYGLTF_MODE_TRIANGLES;
  for (const DracoAttribute& attribute : use.attributes) {
    const json& source = root["accessors"][attribute.accessor];
    json accessor{{"componentType", attribute.component_type},
                  {"type", source["type"]},
                  {"normalized", source.value("normalized", false)},
                  {"count", arrays.points}};
    const size_t bytes = attribute.packed_bytes * arrays.points;
    primitive["attributes"][attribute.name] = add_accessor(root, buffer, offset, bytes, std::move(accessor));
    offset += aligned(bytes);
  }
  document.owned.push_back(std::move(arrays.bytes));
  document.buffers.push_back(document.owned.back().view());
}

void share(const DracoPrimitive& decoded, json& primitive) {
  const json& same = *decoded.primitive;
  primitive["indices"] = same["indices"];
  primitive["mode"] = same["mode"];
  for (const DracoAttribute& attribute : decoded.attributes)
    primitive["attributes"][attribute.name] = same["attributes"][attribute.name];
}

Result<void> apply(DracoStream& stream, json& root, GltfDocument& document) {
  for (DracoPrimitive& use : stream.uses) {
    DracoPrimitive& decoded = use.same_as ? stream.uses[*use.same_as] : use;
    const std::optional<Error>& failed = use.fault ? use.fault : decoded.fault;
    if (failed) {
      const std::string reason = use.where + ": " + failed->message;
      if (!has_fallback(root, *use.primitive)) return Error{reason};
      document.warnings.push_back(reason + "; the uncompressed accessors are drawn");
    } else if (use.same_as) {
      share(decoded, *use.primitive);
    } else {
      if (use.arrays.points != use.max_points) {
        document.warnings.push_back(use.where + ": the Draco stream holds " +
                                    std::to_string(use.arrays.points) +
                                    " vertices, but the accessor of POSITION states " +
                                    std::to_string(use.max_points) + "; those of the stream are drawn");
      }
      redirect(use, root, document);
    }
    use.primitive->erase("extensions");
  }
  return {};
}

}  // namespace

Result<void> decompress_draco_primitives(json& root, const LoadLimits& limits, GltfDocument& document) {
  std::vector<DracoStream> streams = draco_streams(root, limits);
  Room room(document, limits);
  parallel_for(streams.size(), [&](size_t i) { decode_or_fail(root, document, room, streams[i]); });
  for (DracoStream& stream : streams) {
    if (auto done = apply(stream, root, document); !done) return done;
  }
  return {};
}

}  // namespace fire3dv::scene
