#include "renderer/scene/gltf/foreign_file.h"

#include <algorithm>
#include <cctype>
#include <array>
#include <cstdint>
#include <string_view>

#include "protocol/base/files.h"

namespace fire3dv::scene {
namespace {

constexpr size_t kHead = 4096;
constexpr const char* kExport = "export it as glTF (.glb), for example with Blender";
constexpr const char* kConvert = "convert it first: fire3dv-convert FILE -o scene.glb";
constexpr const char* kByName =
    "fire3dv-convert converts AMBF, URDF and MJCF descriptions, recognised by .yaml, .urdf, .xml or .xacro";

struct Signature {
  std::string_view start;
  const char* format;
  const char* remedy;
};

constexpr Signature kSignatures[] = {
    {"#usda ", "a USD scene (text)", kExport},
    {"PXR-USDC", "a USD scene (binary)", kExport},
    {"PK\x03\x04", "a ZIP archive, such as .usdz or .3mf", kExport},
    {"Kaydara FBX Binary", "an FBX scene", kExport},
    {"; FBX ", "an FBX scene (text)", kExport},
    {"BLENDER", "a Blender project", kExport},
    {"ply\n", "a PLY mesh", kExport},
    {"ply\r\n", "a PLY mesh", kExport},
    {"OFF\n", "an OFF mesh", kExport},
    {"\x28\xB5\x2F\xFD", "a Zstandard archive", "unpack it first"},
    {"\x1F\x8B", "a gzip archive", "unpack it first"},
    {"\x89MCAP0\r\n", "a recording (MCAP)", "replay it: fire3dv SCENE.glb --replay FILE"},
    {"\x89PNG", "a PNG image", "name a scene in glTF (.glb or .gltf)"},
    {"\xFF\xD8\xFF", "a JPEG image", "name a scene in glTF (.glb or .gltf)"},
    {"#?RADIANCE", "an environment map (Radiance)", "name a scene, and this file with --environment"},
    {"version https://git-lfs", "a pointer of Git LFS", "fetch the file itself: git lfs pull"},
};

struct Extension {
  std::string_view extension;
  const char* format;
  const char* remedy;
};

constexpr Extension kExtensions[] = {
    {".obj", "a Wavefront OBJ mesh", kExport}, {".stl", "an STL mesh", kExport},
    {".ply", "a PLY mesh", kExport},           {".off", "an OFF mesh", kExport},
    {".3ds", "a 3D Studio scene", kExport},    {".fbx", "an FBX scene", kExport},
    {".usd", "a USD scene", kExport},          {".usda", "a USD scene", kExport},
    {".usdc", "a USD scene", kExport},         {".usdz", "a USD scene", kExport},
    {".blend", "a Blender project", kExport},  {".step", "a STEP model", kExport},
    {".stp", "a STEP model", kExport},         {".mjcf", "an MJCF model", kByName},
    {".sdf", "an SDF description", kByName},
};

std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return extension;
}

// Format and remedy of an XML document by its root element, which stands in the first bytes.
std::string describe_xml(std::string_view head) {
  const auto has = [&](std::string_view element) { return head.find(element) != std::string_view::npos; };
  if (has("<COLLADA")) return std::string("a COLLADA scene, not glTF; ") + kExport;
  if (has("<robot")) return std::string("a URDF description, not glTF; ") + kConvert;
  if (has("<mujoco")) return std::string("an MJCF description, not glTF; ") + kConvert;
  if (has("<sdf")) return std::string("an SDF description, not glTF; convert it to URDF or MJCF first");
  return std::string("an XML file, not glTF; ") + kByName;
}

}  // namespace

std::optional<std::string> describe_foreign_file(std::span<const std::byte> bytes,
                                                 const std::filesystem::path& file) {
  std::string_view head(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), kHead));
  if (head.starts_with("glTF")) return std::nullopt;
  if (head.empty()) return "the file is empty; name a scene in glTF (.glb or .gltf)";
  for (const Signature& each : kSignatures)
    if (head.starts_with(each.start))
      return std::string(each.format) + ", not glTF; " + each.remedy;
  if (head.starts_with("\xEF\xBB\xBF")) head.remove_prefix(3);
  const size_t first = head.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && (head[first] == '{' || head[first] == '[')) return std::nullopt;
  if (first != std::string_view::npos && head[first] == '<') return describe_xml(head);
  const std::string extension = lower_extension(file);
  for (const Extension& each : kExtensions)
    if (extension == each.extension)
      return std::string(each.format) + ", not glTF; " + each.remedy;
  if (head.starts_with("solid ")) return std::string("an STL mesh (text), not glTF; ") + kExport;
  return std::string("not glTF: neither JSON nor binary; ") + kExport;
}

Result<void> check_is_gltf(const std::filesystem::path& file) {
  const auto opened = OpenFile::open(file, UINT64_MAX);
  if (!opened) return Error{file.string() + ": " + opened.error().message};
  std::array<std::byte, kHead> bytes;
  const std::span<std::byte> head(bytes.data(), std::min<uint64_t>(opened->size(), kHead));
  if (!opened->read(0, head)) return Error{file.string() + ": it cannot be read; check the disk"};
  if (const auto other = describe_foreign_file(head, file)) return Error{file.string() + ": " + *other};
  return {};
}

}  // namespace fire3dv::scene
