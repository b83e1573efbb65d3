// Discovery of asset collections, and generation of the made assets.
#include "tests/render/assets/asset_collection.h"

#include <algorithm>
#include <fstream>

#include "examples/gallery/scenes.h"
#include "tests/support/asset_collection_folder.h"
#include "tests/unit/renderer/scene/gltf/motion_file.h"

namespace fire3dv::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json parsed(const fs::path& file) {
  std::ifstream bytes(file);
  return bytes ? json::parse(bytes) : json::object();
}

// A square in the XY plane with vertex colours and texture coordinates.
size_t add_square(GltfBuilder& builder, json material_or_null, bool colored) {
  json attributes = {{"POSITION", builder.add_positions({-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0})},
                     {"TEXCOORD_0", builder.add_data<float>({0, 1, 1, 1, 0, 0, 1, 0}, "VEC2", kFloat, 2)}};
  if (colored)
    attributes["COLOR_0"] = builder.add_data<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0}, "VEC3", kFloat, 3);
  json primitive = {{"attributes", attributes}, {"indices", builder.add_indices({0, 1, 2, 2, 1, 3})}};
  if (!material_or_null.is_null()) primitive["material"] = material_or_null;
  return builder.add_mesh(primitive);
}

GltfBuilder textured_square() {
  GltfBuilder builder;
  builder.add_node(
      "square", {{"mesh", add_square(builder, builder.add_textured_material(png(4, 4, 0xff2050c0)), false)}});
  return builder;
}

GltfBuilder colored_square() {
  GltfBuilder builder;
  builder.add_node("square", {{"mesh", add_square(builder, nullptr, true)}});
  return builder;
}

// Its alpha equals the cutoff, so the alpha test passes everywhere.
GltfBuilder masked_square() {
  GltfBuilder builder;
  builder.root["materials"] = {{{"alphaMode", "MASK"},
                                {"alphaCutoff", 0.5},
                                {"pbrMetallicRoughness", {{"baseColorFactor", {0.2, 0.6, 0.1, 0.5}}}}}};
  builder.add_node("square", {{"mesh", add_square(builder, 0, false)}});
  return builder;
}

GltfBuilder blended_squares() {
  GltfBuilder builder;
  builder.root["materials"] = {
      {{"alphaMode", "BLEND"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.9, 0.1, 0.1, 0.5}}}}},
      {{"pbrMetallicRoughness", {{"baseColorFactor", {0.1, 0.7, 0.1, 1}}, {"metallicFactor", 0}}}}};
  builder.add_node("glass", {{"mesh", add_square(builder, 0, false)}, {"translation", {0.5, 0.3, 0.8}}});
  builder.add_node("wall", {{"mesh", add_square(builder, 1, false)}});
  return builder;
}

GltfBuilder default_triangle_and_lines() {
  GltfBuilder builder = triangle_file();
  const size_t corners = builder.add_positions({0, 0, 0.5, 1, 0, 0.5, 1, 1, 0.5, 0, 1, 0.5});
  builder.add_node("frame",
                   {{"mesh", builder.add_mesh({{"attributes", {{"POSITION", corners}}}, {"mode", 2}})}});
  return builder;
}

}  // namespace

std::vector<CollectedAsset> collected_assets() {
  const fs::path root = asset_collection_folder();
  std::vector<CollectedAsset> assets;
  std::error_code error;
  if (!fs::is_directory(root, error)) return assets;
  const json validated = parsed(root / "VALIDATION.json").value("files", json::object());
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
    const std::string extension = entry.path().extension().string();
    if (!entry.is_regular_file() || (extension != ".gltf" && extension != ".glb")) continue;
    CollectedAsset asset{entry.path().lexically_relative(root).generic_string(), entry.path(), false, {}};
    const json said = validated.value(asset.name, json::object());
    const json report = parsed(entry.path().string() + ".report.json");
    asset.faulty = report.contains("issues") ? report["issues"]["numErrors"] != 0 : said.value("e", 1) != 0;
    if (said.contains("info") && said["info"].is_object() && said["info"].contains("tri"))
      asset.triangles = said["info"]["tri"].get<uint64_t>();
    assets.push_back(std::move(asset));
  }
  std::sort(assets.begin(), assets.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return assets;
}

MadeAssets::MadeAssets() {
  add("textured_square.glb", textured_square().glb());
  add("colored_square.glb", colored_square().glb());
  add("masked_square.glb", masked_square().glb());
  add("blended_squares.glb", blended_squares().glb());
  add("default_triangle_and_lines.glb", default_triangle_and_lines().glb());
  add("moving.glb", motion_file().glb());
  for (const gallery::SceneFile& file : gallery::make_scenes())
    add("gallery_" + file.name, std::as_bytes(std::span(file.bytes)));
}

void MadeAssets::add(const std::string& name, std::span<const std::byte> bytes) {
  assets_.push_back({"made/" + name, folder_.write(name, bytes), false, {}});
}

}  // namespace fire3dv::test
