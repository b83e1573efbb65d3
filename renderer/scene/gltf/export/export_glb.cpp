#include "renderer/scene/gltf/export/export_glb.h"

#include <cstring>
#include <exception>
#include <new>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <utility>

#include "base/glb.h"
#include "base/text.h"
#include "renderer/scene/gltf/export/export_parts.h"
#include "renderer/scene/gltf/gltf_document.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;

const char* media_type(std::span<const std::byte> bytes) {
  const auto begins = [&](std::string_view text, size_t at = 0) {
    return bytes.size() >= at + text.size() && std::memcmp(bytes.data() + at, text.data(), text.size()) == 0;
  };
  if (begins("\x89PNG")) return "image/png";
  if (begins("\xff\xd8")) return "image/jpeg";
  if (begins("RIFF") && begins("WEBP", 8)) return "image/webp";
  if (begins("\xabKTX 20")) return "image/ktx2";
  return nullptr;
}

}  // namespace

Result<uint64_t> GlbExport::append(std::span<const std::byte> bytes) {
  const uint64_t offset = (binary_.size() + 15) / 16 * 16;
  if (offset + bytes.size() > kMaxGlbBytes) return Error{"a .glb file holds less than 4 GiB"};
  if (limits_.reserve) {
    if (Result<void> room = limits_.reserve(bytes.size()); !room) return room.error();
  }
  binary_.resize(offset);
  binary_.insert(binary_.end(), bytes.begin(), bytes.end());
  return offset;
}

// All buffers become one; placeholders without bytes follow it.
Result<void> GlbExport::embed_buffers() {
  const auto buffers = root_.find("buffers");
  if (buffers == root_.end()) return {};
  struct Moved {
    size_t buffer = 0;
    uint64_t offset = 0;
  };
  std::vector<Moved> moved;
  json kept = json::array({json::object()});
  for (size_t i = 0; i < buffers->size(); ++i) {
    const json& buffer = (*buffers)[i];
    std::optional<FileBytes> read;
    std::span<const std::byte> bytes;
    if (buffer.contains("uri")) {
      Result<FileBytes> file =
          folder_.read(buffer.at("uri").get_ref<const std::string&>(), limits_.max_file_bytes);
      if (!file) return Error{element("buffers", i) + ": " + file.error().message};
      read = std::move(*file);
      bytes = read->view();
    } else if (i == 0 && container_.has_binary) {
      bytes = container_.binary;
    } else {
      moved.push_back({kept.size(), 0});
      kept.push_back(buffer);
      continue;
    }
    const auto length = buffer.at("byteLength").get<uint64_t>();
    if (length > bytes.size()) return Error{element("buffers", i) + " is shorter than its byteLength"};
    Result<uint64_t> offset = append(bytes.first(length));
    if (!offset) return offset.error();
    moved.push_back({0, *offset});
  }
  const auto move = [&](json& view) {
    const auto buffer = view.at("buffer").get<size_t>();
    if (buffer >= moved.size()) return;
    view["buffer"] = moved[buffer].buffer;
    if (const uint64_t offset = view.value("byteOffset", uint64_t{0}) + moved[buffer].offset; offset != 0)
      view["byteOffset"] = offset;
  };
  if (const auto views = root_.find("bufferViews"); views != root_.end()) {
    for (json& view : *views) {
      move(view);
      for (const char* const name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
        if (view.contains("extensions") && view["extensions"].contains(name)) move(view["extensions"][name]);
      }
    }
  }
  root_["buffers"] = std::move(kept);
  return {};
}

Result<void> GlbExport::embed_images() {
  const auto images = root_.find("images");
  if (images == root_.end()) return {};
  for (size_t i = 0; i < images->size(); ++i) {
    json& image = (*images)[i];
    if (!image.contains("uri")) continue;
    if (image.contains("bufferView")) {  // which is read
      image.erase("uri");
      continue;
    }
    Result<FileBytes> file = folder_.read(image["uri"].get_ref<const std::string&>(), limits_.max_file_bytes);
    if (!file) {  // the loader draws a placeholder
      warnings_.push_back(element("images", i) + " stays outside of the file: " + file.error().message);
      continue;
    }
    Result<uint64_t> offset = append(file->view());
    if (!offset) return offset.error();
    if (!root_.contains("buffers")) root_["buffers"] = json::array({json::object()});
    json& views = root_["bufferViews"];
    image["bufferView"] = views.is_array() ? views.size() : 0;
    views.push_back({{"buffer", 0}, {"byteOffset", *offset}, {"byteLength", file->size}});
    image.erase("uri");
    if (const char* const type = media_type(file->view())) image["mimeType"] = type;
  }
  return {};
}

Result<ExportedGlb> GlbExport::finish() {
  if (root_.contains("buffers")) {
    if (binary_.empty() && root_["buffers"].size() == 1)
      root_.erase("buffers");
    else
      root_["buffers"][0]["byteLength"] = binary_.size();
  }
  const std::string text = root_.dump();
  if (text.size() + binary_.size() > kMaxGlbBytes) return Error{"a .glb file holds less than 4 GiB"};
  return ExportedGlb{base::make_glb(text, binary_), std::move(warnings_)};
}

namespace {

Result<ExportedGlb> export_parsed(const std::filesystem::path& gltf, const ExportedEdits& edits,
                                  const LoadLimits& limits) {
  Result<GltfContainer> container = open_container(gltf, limits);
  if (!container) return container.error();
  GlbExport exported(json::parse(container->json), *container, AssetFolder(gltf), limits);
  if (Result<void> done = exported.embed_buffers(); !done) return done.error();
  if (Result<void> done = exported.embed_images(); !done) return done.error();
  if (Result<void> done = exported.apply(edits); !done) return done.error();
  return exported.finish();
}

}  // namespace

Result<ExportedGlb> export_glb(const std::filesystem::path& gltf, const ExportedEdits& edits,
                               const LoadLimits& limits) {
  try {
    Result<ExportedGlb> exported = export_parsed(gltf, edits, limits);
    if (!exported) return Error{gltf.string() + ": " + exported.error().message};
    return exported;
  } catch (const std::bad_alloc&) {
    return Error{gltf.string() + ": there is not enough memory to export it"};
  } catch (const std::exception& error) {  // of the JSON, when the file has changed since it was loaded
    return Error{gltf.string() + ": its JSON cannot be exported: " + quote(error.what())};
  }
}

}  // namespace fire3dv::scene
