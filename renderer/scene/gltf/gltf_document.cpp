#include "renderer/scene/gltf/gltf_document.h"

#include <bit>
#include <climits>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/json/json_fault.h"
#include "renderer/scene/gltf/foreign_file.h"
#include "renderer/scene/gltf/gltf_container.h"
#include "renderer/scene/gltf/gltf_parts.h"

namespace fire3dv::scene {
namespace {

struct Container {
  std::string_view json;
  std::span<const std::byte> binary;  // BIN chunk of a GLB
  bool has_binary = false;
};

static_assert(std::endian::native == std::endian::little, "glTF's numbers are read as they are in memory");

constexpr uint32_t kGlbMagic = 0x46546C67;   // "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr uint32_t kBinChunk = 0x004E4942;   // "BIN\0"
constexpr size_t kGlbHeaderBytes = 12, kChunkHeaderBytes = 8;

uint32_t word_at(std::span<const std::byte> bytes, size_t offset) {
  uint32_t word;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// A GLB is detected by its magic, independent of the file name; other files are JSON.
Result<Container> split_container(std::span<const std::byte> file) {
  Container container;
  if (file.size() < 4 || word_at(file, 0) != kGlbMagic) {
    container.json = as_text(file);
    if (container.json.starts_with("\xEF\xBB\xBF")) container.json.remove_prefix(3);
    return container;
  }
  if (file.size() < kGlbHeaderBytes) return Error{"the GLB header is cut short"};
  if (word_at(file, 4) != 2)
    return Error{"GLB version " + std::to_string(word_at(file, 4)) + " is not supported: only 2 is"};
  const size_t length = word_at(file, 8);
  if (length > file.size() || length < kGlbHeaderBytes) {
    return Error{"the GLB header states " + std::to_string(length) + " bytes, but the file holds " +
                 std::to_string(file.size())};
  }
  for (size_t offset = kGlbHeaderBytes, chunk = 0; offset < length; ++chunk) {
    const std::string name = "GLB chunk " + std::to_string(chunk);
    if (length - offset < kChunkHeaderBytes) return Error{name + " is cut short"};
    const size_t chunk_length = word_at(file, offset);
    const uint32_t type = word_at(file, offset + 4);
    offset += kChunkHeaderBytes;
    if (chunk_length > length - offset) {
      return Error{name + " states " + std::to_string(chunk_length) + " bytes, but only " +
                   std::to_string(length - offset) + " follow"};
    }
    const auto data = file.subspan(offset, chunk_length);
    offset += chunk_length;
    if ((chunk == 0) != (type == kJsonChunk))
      return Error{name + (chunk == 0 ? " is not the JSON" : " is a second JSON")};
    if (type == kJsonChunk) container.json = as_text(data);
    if (type == kBinChunk && !container.has_binary) {
      container.binary = data;
      container.has_binary = true;
    }
  }
  if (container.json.empty()) return Error{"the GLB holds no JSON"};
  return container;
}

// Upper bound on the number of JSON values, without parsing. Fails above max_depth, since JSON parsers and
// printers recurse.
Result<uint64_t> count_json_values(std::string_view json, uint32_t max_depth) {
  uint32_t depth = 0;
  uint64_t values = 1;
  bool in_string = false;
  for (size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == ',') {
      ++values;
    } else if (c == '{' || c == '[') {
      ++values;
      if (++depth > max_depth)
        return Error{"the JSON is nested deeper than " + std::to_string(max_depth) + " levels"};
    } else if ((c == '}' || c == ']') && depth > 0) {
      --depth;
    }
  }
  return values;
}

using nlohmann::json;

const json& array_of(const json& object, const char* member) {
  static const json kEmpty = json::array();
  const auto found = object.find(member);
  return found == object.end() ? kEmpty : *found;
}

Result<int> needed_index(const json& object, const char* member, const std::string& where) {
  const auto found = object.find(member);
  if (found == object.end() || !found->is_number()) return Error{where + ": " + member + " is missing"};
  return found->get<int>();
}

Result<AnimationSource::Sampler> sampler_of(const json& source, const std::string& where) {
  AnimationSource::Sampler sampler;
  auto input = needed_index(source, "input", where);
  if (!input) return input.error();
  auto output = needed_index(source, "output", where);
  if (!output) return output.error();
  sampler.input = *input;
  sampler.output = *output;
  sampler.interpolation = source.value("interpolation", std::string("LINEAR"));
  return sampler;
}

Result<AnimationSource::Channel> channel_of(const json& source, const std::string& where) {
  AnimationSource::Channel channel;
  auto sampler = needed_index(source, "sampler", where);
  if (!sampler) return sampler.error();
  channel.sampler = *sampler;
  const auto target = source.find("target");
  if (target == source.end() || !target->is_object()) return Error{where + ": target is missing"};
  channel.node = target->value("node", -1);
  channel.path = target->value("path", std::string());
  if (channel.path.empty()) return Error{where + ".target: path is missing"};
  return channel;
}

Result<AnimationSource> animation_of(const json& source, const std::string& where) {
  AnimationSource animation;
  animation.name = source.value("name", std::string());
  const json& samplers = array_of(source, "samplers");
  for (size_t i = 0; i < samplers.size(); ++i) {
    auto sampler = sampler_of(samplers[i], where + "." + element("samplers", i));
    if (!sampler) return sampler.error();
    animation.samplers.push_back(std::move(*sampler));
  }
  const json& channels = array_of(source, "channels");
  for (size_t i = 0; i < channels.size(); ++i) {
    auto channel = channel_of(channels[i], where + "." + element("channels", i));
    if (!channel) return channel.error();
    animation.channels.push_back(std::move(*channel));
  }
  return animation;
}

// Index accessors without a buffer view, which tinygltf refuses: their indices are 0, or sparse.
struct IndexAccessor {
  size_t mesh = 0, primitive = 0;
  int accessor = -1;
};

std::vector<IndexAccessor> take_zero_indices(json& root) {
  std::vector<IndexAccessor> taken;
  json& meshes = root["meshes"];
  const json& accessors = array_of(root, "accessors");
  for (size_t m = 0; m < meshes.size(); ++m) {
    if (!meshes[m].contains("primitives")) continue;
    json& primitives = meshes[m]["primitives"];
    for (size_t p = 0; p < primitives.size(); ++p) {
      const auto indices = primitives[p].find("indices");
      if (indices == primitives[p].end()) continue;
      if (accessors[indices->get<size_t>()].contains("bufferView")) continue;
      taken.push_back({m, p, indices->get<int>()});
      primitives[p].erase(indices);
    }
  }
  if (meshes.empty()) root.erase("meshes");
  return taken;
}

// Moves skins and animations out of a document that passed check_and_reduce(). tinygltf refuses skins without
// inverse bind matrices and channels without a node, both of which glTF allows.
Result<void> take_motion(json& root, std::vector<SkinSource>& skins,
                         std::vector<AnimationSource>& animations) {
  for (const json& source : array_of(root, "skins")) {
    SkinSource skin;
    skin.name = source.value("name", std::string());
    for (const json& joint : array_of(source, "joints")) skin.joints.push_back(joint.get<int>());
    skin.inverse_bind_matrices = source.value("inverseBindMatrices", -1);
    skins.push_back(std::move(skin));
  }
  const json& sources = array_of(root, "animations");
  for (size_t i = 0; i < sources.size(); ++i) {
    auto animation = animation_of(sources[i], element("animations", i));
    if (!animation) return animation.error();
    animations.push_back(std::move(*animation));
  }
  root.erase("skins");
  root.erase("animations");
  return {};
}

// Estimate for nlohmann::json: 16 bytes per value, plus a map node with its key for object members.
constexpr uint64_t kBytesOfJsonValue = 128;
// Estimate for tinygltf: its largest structure, Material, has 1.6 KB.
constexpr uint64_t kBytesOfModelObject = 2048;

Result<json> parsed(std::string_view text) {
  try {
    return json::parse(text);
  } catch (const json::exception& error) {
    return Error{"the JSON cannot be read: " + quote(json_fault(error.what()))};
  }
}

Result<void> take_buffers(const json& root, const Container& container, const LoadLimits& limits,
                          GltfDocument& document) {
  const auto buffers = root.find("buffers");
  if (buffers == root.end()) return {};
  for (size_t i = 0; i < buffers->size(); ++i) {
    const json& buffer = (*buffers)[i];
    const std::string where = element("buffers", i);
    if (!buffer.contains("byteLength")) return Error{where + ": byteLength is missing"};
    const auto length = buffer["byteLength"].get<uint64_t>();
    std::span<const std::byte> bytes;
    if (is_meshopt_fallback(buffer)) {
      document.buffers.emplace_back();
      continue;
    }
    if (buffer.contains("uri")) {
      auto read = document.folder.read(buffer["uri"].get_ref<const std::string&>(), limits.max_file_bytes);
      if (!read) return Error{where + ": " + read.error().message};
      document.owned.push_back(std::move(*read));
      bytes = document.owned.back().view();
    } else if (i == 0 && container.has_binary) {
      bytes = container.binary;
    } else {
      // Placeholder, for example of an unsupported extension; an error only if it is referenced.
      document.buffers.emplace_back();
      continue;
    }
    if (length == 0) return Error{where + ": byteLength is 0"};
    if (bytes.size() < length) {
      return Error{where + ": byteLength is " + std::to_string(length) + ", but only " +
                   std::to_string(bytes.size()) + " bytes are there"};
    }
    document.buffers.push_back(bytes.first(length));
  }
  return {};
}

void take_images(json& root, GltfDocument& document) {
  const auto images = root.find("images");
  if (images == root.end()) return;
  for (size_t i = 0; i < images->size(); ++i) {
    json& image = (*images)[i];
    ImageSource source;
    source.name = image.value("name", std::string());
    source.buffer_view = image.value("bufferView", -1);
    if (image.contains("uri")) source.uri = std::move(image["uri"].get_ref<std::string&>());
    if (!source.uri.empty() && source.buffer_view >= 0) {
      document.warnings.push_back(element("images", i) +
                                  " has both a uri and a bufferView; the bufferView is read");
    }
    document.images.push_back(std::move(source));
  }
}

// tinygltf must not access files; these callbacks refuse all requests.
tinygltf::FsCallbacks no_files() {
  tinygltf::FsCallbacks callbacks{};
  callbacks.FileExists = [](const std::string&, void*) { return false; };
  callbacks.ExpandFilePath = [](const std::string&, void*) { return std::string(); };
  callbacks.ReadWholeFile = [](std::vector<unsigned char>*, std::string*, const std::string&, void*) {
    return false;
  };
  callbacks.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  return callbacks;
}

Result<void> parse_model(const std::string& text, tinygltf::Model& model) {
  if (text.size() > UINT_MAX) return Error{"the JSON is larger than 4 GiB"};
  tinygltf::TinyGLTF parser;
  parser.SetFsCallbacks(no_files());
  parser.SetImageLoader([](tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*,
                           int, void*) { return false; },
                        nullptr);
  std::string error, warning;
  const bool parsed_whole = parser.LoadASCIIFromString(&model, &error, &warning, text.data(),
                                                       static_cast<unsigned>(text.size()), std::string());
  // tinygltf reports some errors and continues with defaults; such files are refused.
  if (parsed_whole && error.empty()) return {};
  while (!error.empty() && error.back() == '\n') error.pop_back();
  return Error{"the glTF cannot be read: " + quote(error)};
}

Result<void> reserve(uint64_t bytes, const LoadLimits& limits) {
  if (!limits.reserve) return {};
  if (Result<void> reserved = limits.reserve(bytes); !reserved)
    return Error{"the JSON: " + reserved.error().message};
  return {};
}

// Model objects are far larger than their "{}" in the file.
Result<void> reserve_model(const json& root, const LoadLimits& limits) {
  uint64_t objects = 0;
  for (const auto& member : root) objects += member.is_array() ? member.size() : 0;
  if (const auto nodes = root.find("nodes"); nodes != root.end() && nodes->size() > limits.max_nodes)
    return Error{"the file has more than " + std::to_string(limits.max_nodes) + " nodes"};
  return reserve(kBytesOfModelObject * objects, limits);
}

Result<GltfDocument> document_of(FileBytes file, AssetFolder folder, const LoadLimits& limits) {
  auto container = split_container(file.view());
  if (!container) return container.error();
  auto values = count_json_values(container->json, limits.max_json_depth);
  if (!values) return values.error();
  if (auto room = reserve(kBytesOfJsonValue * *values, limits); !room) return room.error();
  auto root = parsed(container->json);
  if (!root) return root.error();

  GltfDocument document{.folder = std::move(folder)};
  if (auto done = check_and_reduce(*root, document.warnings); !done) return done.error();
  if (auto done = take_buffers(*root, *container, limits, document); !done) return done.error();
  if (auto done = decompress_buffer_views(*root, limits, document); !done) return done.error();
  if (auto done = decompress_draco_primitives(*root, limits, document); !done) return done.error();
  take_images(*root, document);
  if (auto done = take_motion(*root, document.skins, document.animations); !done) return done.error();
  if (auto room = reserve_model(*root, limits); !room) return room.error();
  root->erase("buffers");
  root->erase("images");
  const std::vector<IndexAccessor> zero_indices = take_zero_indices(*root);
  if (auto done = parse_model(root->dump(), document.model); !done) return done.error();
  for (const IndexAccessor& taken : zero_indices)
    document.model.meshes[taken.mesh].primitives[taken.primitive].indices = taken.accessor;
  document.owned.push_back(std::move(file));
  if (auto done = check_references(document); !done) return done.error();
  return document;
}

}  // namespace

Result<GltfContainer> open_container(const std::filesystem::path& path, const LoadLimits& limits) {
  auto file = read_file(path, limits.max_file_bytes);
  if (!file) return file.error();
  auto container = split_container(file->view());
  if (!container) return container.error();
  if (auto values = count_json_values(container->json, limits.max_json_depth); !values) return values.error();
  return GltfContainer{std::move(*file), container->json, container->binary, container->has_binary};
}

Result<GltfDocument> open_gltf(const std::filesystem::path& path, const LoadLimits& limits,
                               std::vector<SourceFile>* sources, const StampedDigest* known) {
  auto file = read_file(path, limits.max_file_bytes);
  if (!file) return file.error();
  if (sources)
    sources->push_back({"", known && known->holds(path) ? known->digest : digest_of(file->view())});
  if (const auto other = describe_foreign_file(file->view(), path)) return Error{*other};
  return document_of(std::move(*file), AssetFolder(path, sources), limits);
}

Result<GltfDocument> read_glb(std::span<const std::byte> bytes, const LoadLimits& limits) {
  if (bytes.size() > limits.max_file_bytes) {
    return Error{"it holds " + std::to_string(bytes.size()) + " bytes; at most " +
                 std::to_string(limits.max_file_bytes) + " are read"};
  }
  if (const auto other = describe_foreign_file(bytes, {})) return Error{*other};
  FileBytes file;
  file.size = bytes.size();
  file.data = std::make_unique_for_overwrite<std::byte[]>(file.size);
  std::copy(bytes.begin(), bytes.end(), file.data.get());
  return document_of(std::move(file), AssetFolder::none(), limits);
}

Result<std::span<const std::byte>> buffer_view_bytes(const GltfDocument& document, int buffer_view,
                                                     const std::string& where) {
  const auto& views = document.model.bufferViews;
  if (!in_range(buffer_view, views.size()))
    return out_of_range(where, "bufferViews", buffer_view, views.size());
  const tinygltf::BufferView& view = views[static_cast<size_t>(buffer_view)];
  const std::string name = element("bufferViews", static_cast<size_t>(buffer_view));
  if (!in_range(view.buffer, document.buffers.size())) {
    return out_of_range(name, "buffers", view.buffer, document.buffers.size());
  }
  const auto buffer = document.buffers[static_cast<size_t>(view.buffer)];
  if (buffer.empty()) {
    return Error{
        where + ": " + element("buffers", static_cast<size_t>(view.buffer)) +
        " holds no bytes: it has neither a uri nor the GLB's binary chunk, or is the fallback of compressed "
        "buffer views"};
  }
  if (view.byteOffset > buffer.size() || view.byteLength > buffer.size() - view.byteOffset) {
    return Error{name + " reaches from byte " + std::to_string(view.byteOffset) + " over " +
                 std::to_string(view.byteLength) + " bytes, but " +
                 element("buffers", static_cast<size_t>(view.buffer)) + " holds " +
                 std::to_string(buffer.size())};
  }
  return buffer.subspan(view.byteOffset, view.byteLength);
}

}  // namespace fire3dv::scene
