#include "renderer/scene/gltf/gltf_document.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "renderer/scene/gltf/meshes/meshopt_vertices.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;

// The first is the successor of the second. Both have the same members.
constexpr std::array<const char*, 2> kMeshoptExtensions{"KHR_meshopt_compression", "EXT_meshopt_compression"};
// Upper bound of the compression ratio, reached by equal elements of four bytes. Views that share bytes could
// otherwise claim any amount of memory.
constexpr uint64_t kMaxDecodedPerByte = 1024;

enum class Filter { none, octahedral, quaternion, exponential, color };

struct CompressedView {
  std::span<const std::byte> bytes;
  size_t count = 0, stride = 0;
  std::string mode;
  Filter filter = Filter::none;
  size_t decoded_bytes() const { return count * stride; }
};

const json* extension_of(const json& object, const char* name) {
  const auto extensions = object.find("extensions");
  if (extensions == object.end()) return nullptr;
  const auto extension = extensions->find(name);
  return extension == extensions->end() ? nullptr : &*extension;
}

struct Compression {
  const char* name = nullptr;  // of the extension
  const json* members = nullptr;
};

// Null members: the object is not compressed.
Result<Compression> compression_of(const json& object, const std::string& where) {
  Compression found;
  for (const char* name : kMeshoptExtensions) {
    const json* members = extension_of(object, name);
    if (members == nullptr) continue;
    if (found.members != nullptr)
      return Error{where + " has both " + found.name + " and " + name + ": only one of them may be there"};
    found = {name, members};
  }
  return found;
}

Result<Filter> filter_of(const std::string& name, size_t stride, bool has_color, const std::string& where) {
  Filter filter = Filter::none;
  bool fits = true;
  if (name == "OCTAHEDRAL") {
    filter = Filter::octahedral;
    fits = stride == 4 || stride == 8;
  } else if (name == "QUATERNION") {
    filter = Filter::quaternion;
    fits = stride == 8;
  } else if (name == "EXPONENTIAL") {
    filter = Filter::exponential;  // attribute strides are multiples of 4 already
  } else if (name == "COLOR" && has_color) {
    filter = Filter::color;
    fits = stride == 4 || stride == 8;
  } else if (name != "NONE") {
    return Error{where + " has the unknown filter " + quote(name)};
  }
  if (!fits)
    return Error{where + ": the filter " + name + " does not go with a byteStride of " +
                 std::to_string(stride)};
  return filter;
}

Result<void> check_shape(const CompressedView& view, const std::string& where) {
  const std::string stride = std::to_string(view.stride);
  if (view.mode == "ATTRIBUTES") {
    if (view.stride == 0 || view.stride % 4 != 0 || view.stride > 256)
      return Error{where + " has a byteStride of " + stride + ", not a multiple of 4 up to 256"};
    return {};
  }
  if (view.mode != "TRIANGLES" && view.mode != "INDICES")
    return Error{where + " has the unknown mode " + quote(view.mode)};
  if (view.stride != 2 && view.stride != 4)
    return Error{where + " has a byteStride of " + stride + ", but indices have 2 or 4"};
  if (view.mode == "TRIANGLES" && view.count % 3 != 0)
    return Error{where + " has a count of " + std::to_string(view.count) + ", not a multiple of 3"};
  if (view.filter != Filter::none) return Error{where + " has a filter, which only attributes may have"};
  return {};
}

Result<CompressedView> compressed_view(const json& parent, const Compression& compression,
                                       const GltfDocument& document, const std::string& where) {
  const json& extension = *compression.members;
  for (const char* member : {"buffer", "byteLength", "byteStride", "count", "mode"}) {
    if (!extension.contains(member)) return Error{where + ": " + member + " is missing"};
  }
  const auto buffer = extension["buffer"].get<size_t>();
  if (buffer >= document.buffers.size())
    return out_of_range(where, "buffers", static_cast<int>(buffer), document.buffers.size());
  const auto offset = extension.value("byteOffset", uint64_t{0}),
             length = extension["byteLength"].get<uint64_t>();
  const auto bytes = document.buffers[buffer];
  if (offset > bytes.size() || length > bytes.size() - offset) {
    return Error{where + " reaches from byte " + std::to_string(offset) + " over " + std::to_string(length) +
                 " bytes, but " + element("buffers", buffer) + " holds " + std::to_string(bytes.size())};
  }
  CompressedView view;
  view.bytes = bytes.subspan(offset, length);
  view.count = extension["count"].get<size_t>();
  view.stride = extension["byteStride"].get<size_t>();
  view.mode = extension["mode"].get<std::string>();
  if (view.count == 0) return Error{where + " has a count of 0"};
  auto filter = filter_of(extension.value("filter", std::string("NONE")), view.stride,
                          compression.name == kMeshoptExtensions[0], where);
  if (!filter) return filter.error();
  view.filter = *filter;
  if (auto ok = check_shape(view, where); !ok) return ok.error();
  // Sizes are at most 2^53: the product overflows only for sizes that are refused here.
  const uint64_t decoded = parent.value("byteLength", uint64_t{0});
  if (decoded / view.stride != view.count || decoded % view.stride != 0) {
    return Error{where + " holds " + std::to_string(view.count) + " elements of " +
                 std::to_string(view.stride) + " bytes, but the buffer view's byteLength is " +
                 std::to_string(decoded)};
  }
  if (const auto own = parent.value("byteStride", view.stride); own != view.stride) {
    return Error{where + " has a byteStride of " + std::to_string(view.stride) +
                 ", but the buffer view's is " + std::to_string(own)};
  }
  return view;
}

Result<FileBytes> decoded(const CompressedView& view, const std::string& where) {
  FileBytes result{std::make_unique_for_overwrite<std::byte[]>(view.decoded_bytes()), view.decoded_bytes()};
  const auto* from = reinterpret_cast<const unsigned char*>(view.bytes.data());
  void* to = result.data.get();
  int fault = 0;
  if (view.mode == "ATTRIBUTES" && is_vertex_stream_v1(view.bytes)) {
    fault = decode_vertices_v1(result.data.get(), view.count, view.stride, view.bytes) ? 0 : 1;
  } else if (view.mode == "ATTRIBUTES") {
    fault = meshopt_decodeVertexBuffer(to, view.count, view.stride, from, view.bytes.size());
  } else if (view.mode == "TRIANGLES") {
    fault = meshopt_decodeIndexBuffer(to, view.count, view.stride, from, view.bytes.size());
  } else {
    fault = meshopt_decodeIndexSequence(to, view.count, view.stride, from, view.bytes.size());
  }
  if (fault != 0) return Error{where + ": the compressed bytes are damaged"};
  if (view.filter == Filter::octahedral) meshopt_decodeFilterOct(to, view.count, view.stride);
  if (view.filter == Filter::quaternion) meshopt_decodeFilterQuat(to, view.count, view.stride);
  if (view.filter == Filter::exponential) meshopt_decodeFilterExp(to, view.count, view.stride);
  if (view.filter == Filter::color) decode_color_filter(result.data.get(), view.count, view.stride / 4);
  return result;
}

}  // namespace

bool is_meshopt_fallback(const json& buffer) {
  return std::any_of(kMeshoptExtensions.begin(), kMeshoptExtensions.end(), [&](const char* name) {
    const json* extension = extension_of(buffer, name);
    return extension != nullptr && extension->value("fallback", false);
  });
}

Result<void> decompress_buffer_views(json& root, const LoadLimits& limits, GltfDocument& document) {
  const auto views = root.find("bufferViews");
  if (views == root.end()) return {};
  uint64_t room = 0;
  for (const auto& buffer : document.buffers) room += buffer.size() * kMaxDecodedPerByte;
  room = std::min(room, limits.max_file_bytes);
  for (size_t i = 0; i < views->size(); ++i) {
    json& parent = (*views)[i];
    auto compression = compression_of(parent, element("bufferViews", i));
    if (!compression) return compression.error();
    if (compression->members == nullptr) continue;
    const std::string where = element("bufferViews", i) + ".extensions." + compression->name;
    auto view = compressed_view(parent, *compression, document, where);
    if (!view) return view.error();
    if (view->decoded_bytes() > room) {
      return Error{where + ": the file's compressed bytes cannot hold so much as " +
                   std::to_string(view->decoded_bytes()) + " bytes more"};
    }
    room -= view->decoded_bytes();
    if (limits.reserve) {
      if (Result<void> reserved = limits.reserve(view->decoded_bytes()); !reserved)
        return Error{where + ": " + reserved.error().message};
    }
    auto bytes = decoded(*view, where);
    if (!bytes) return bytes.error();
    document.owned.push_back(std::move(*bytes));
    parent["buffer"] = document.buffers.size();
    parent["byteOffset"] = 0;
    document.buffers.push_back(document.owned.back().view());
    parent.erase("extensions");
  }
  return {};
}

}  // namespace fire3dv::scene
