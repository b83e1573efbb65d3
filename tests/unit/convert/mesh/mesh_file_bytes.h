// Small mesh files for tests, each of a few triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

namespace fire3dv::test {

// A square with two materials, a pentagon, and elements that are not drawn. Names contain blanks.
inline const std::string kObj = R"(# two materials
mtllib some colours.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0.5 1.5 0
vt 0 0
vt 1 0.25
vt 1 1
vn 0 0 2
o square with a roof
usemtl red one
f 1/1/1 2/2/1 3/3/1
usemtl glass
f 1//1 3//1 5//1
usemtl red one
l 1 3
l 2 4 5
p 1
f 1/1/1 2/2/1 3/3/1 5/1/1 4/1/1
)";
inline const std::string kMtl = R"(newmtl red one
Ka 1 1 1
Kd 0.5 0 1
Ks 0.5 0.5 0.5
Ke 0 0.5 0
Ns 10
map_Kd the image.png
newmtl glass
Kd 1 1 1
Ks 0 0 0
d 0.25
)";

inline const std::string kAsciiStl = R"(solid two
facet normal 0 0 1
outer loop
vertex 0 0 3
vertex 1 0 3
vertex 1 1 3
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 3
vertex 1 1 3
vertex 0 1 3
endloop
endfacet
endsolid two
)";

// A triangle in millimetres, Z up, below a node with a mirroring transform.
inline const std::string kDae = R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="c"><lambert>
<diffuse><color>0.5 0.25 0 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m" name="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 1000 0 0 0 0 2000</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1" material="m"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><matrix>-1 0 0 0  0 1 0 3000  0 0 1 0  0 0 0 1</matrix>
<instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="m" target="#m"/>
</technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
)";

inline const std::string kPly = R"(ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 2 0
3 0 1 2
)";

template <typename T>
std::string raw(T value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

inline std::string binary_stl() {
  std::string file(80, ' ');
  file += raw<uint32_t>(1);
  for (const float f : {0.f, 0.f, 0.f, 0.f, 0.f, 5.f, 1.f, 0.f, 5.f, 0.f, 1.f, 5.f}) file += raw(f);
  return file + raw<uint16_t>(0);
}

// One triangle (0 0 0, 1 0 0, 0 2 0) below a node moved by Z 3; its material has linear factors and `image`,
// embedded. Laid out by hand after the specification of glTF 2.0.
inline std::string glb(const std::string& image, const std::string& alpha_mode) {
  std::string data;
  for (const float f : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 2.f, 0.f}) data += raw(f);  // positions
  for (const float f : {0.f, 0.f, 1.f, 0.f, 0.f, 0.25f}) data += raw(f);               // texture coordinates
  for (const uint16_t i : {0, 1, 2, 0}) data += raw(i);  // the last one is padding
  const size_t image_size = image.size();
  data += image;
  data.resize((data.size() + 3) / 4 * 4);
  std::string json =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"translation":[0,0,3]}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":0}]}],)"
      R"("materials":[{"name":"paint","alphaMode":")" +
      alpha_mode +
      R"(","pbrMetallicRoughness":{"baseColorFactor":[0.25,1,0,0.5],"metallicFactor":0.75,"roughnessFactor":0.125,)"
      R"("baseColorTexture":{"index":0}}}],"textures":[{"source":0}],"images":[{"bufferView":3,"mimeType":"image/png"}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,2,0]},)"
      R"({"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"},{"bufferView":2,"componentType":5123,"count":3,"type":"SCALAR"}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24},)"
      R"({"buffer":0,"byteOffset":60,"byteLength":6},{"buffer":0,"byteOffset":68,"byteLength":)" +
      std::to_string(image_size) + "}],\"buffers\":[{\"byteLength\":" + std::to_string(data.size()) + "}]}";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string body = raw(static_cast<uint32_t>(json.size())) + "JSON" + json +
                           raw(static_cast<uint32_t>(data.size())) + std::string("BIN\0", 4) + data;
  return "glTF" + raw<uint32_t>(2) + raw(static_cast<uint32_t>(body.size() + 12)) + body;
}

// One triangle with one material, Z up.
inline std::string three_ds() {
  const auto chunk = [](uint16_t id, const std::string& data) {
    return raw(id) + raw(static_cast<uint32_t>(data.size() + 6)) + data;
  };
  const std::string name("part\0", 5);
  std::string vertices = raw<uint16_t>(3);
  for (const float f : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 0.f, 2.f}) vertices += raw(f);
  std::string faces = raw<uint16_t>(1);
  for (const uint16_t i : {0, 1, 2, 7}) faces += raw(i);
  const std::string mesh = chunk(0x4100, chunk(0x4110, vertices) + chunk(0x4120, faces));
  return chunk(0x4d4d, chunk(0x3d3d, chunk(0x4000, name + mesh)));
}

}  // namespace fire3dv::test
