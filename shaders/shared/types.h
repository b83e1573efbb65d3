// Structures that C++ writes and GLSL reads: one text for both compilers. The layout is scalar (as C++ lays them out);
// a test compares the offsets with the compiled shaders' reflection. 64-bit members come first or are aligned to 8.
#ifndef FIRE3DV_SHARED_TYPES_H
#define FIRE3DV_SHARED_TYPES_H

#ifdef __cplusplus
#include <cstdint>
#include <glm/glm.hpp>
namespace fire3dv::gpu_types {
using glm::ivec2;
using glm::mat4;
using glm::vec2;
using glm::vec3;
using glm::vec4;
using uint = uint32_t;
#define FIRE3DV_ADDRESS uint64_t
#else
#define FIRE3DV_ADDRESS uint64_t
#endif

#define FIRE3DV_NO_INDEX 0xffffffffu

// A 3x4 affine matrix by rows: the layout of Affine3x4 on the wire and of VkTransformMatrixKHR.
struct AffineRows {
  vec4 row0;
  vec4 row1;
  vec4 row2;
};

// Where the pose of one node comes from. See state::NodeDrive.
struct NodeSource {
  AffineRows body_from_node;  // world_from_node at rest when stream is FIRE3DV_NO_INDEX
  uint stream;
  uint pose_index;
};

struct StreamSource {
  FIRE3DV_ADDRESS poses;  // AffineRows[], stream_from_body
  AffineRows world_from_stream;
};

struct TextureUse {
  uint texture;  // FIRE3DV_NO_INDEX = none
  uint uv_set;
  vec4 uv_rows;  // KHR_texture_transform: u' = dot(uv_rows.xy, uv) + offset.x, v' = dot(uv_rows.zw, uv) + offset.y
  vec2 uv_offset;
};

#define FIRE3DV_MATERIAL_DOUBLE_SIDED 1u
#define FIRE3DV_MATERIAL_UNLIT 2u
#define FIRE3DV_MATERIAL_MASK 4u
#define FIRE3DV_MATERIAL_BLEND 8u
#define FIRE3DV_MATERIAL_TRANSMISSION 16u
#define FIRE3DV_MATERIAL_SHEEN 32u
#define FIRE3DV_MATERIAL_CLEARCOAT 64u

struct MaterialRecord {
  vec4 base_color;
  vec3 emissive;
  float metallic;
  float roughness;
  float normal_scale;
  float occlusion_strength;
  float alpha_cutoff;
  uint flags;
  uint extension;  // into MaterialExtensionRecord[]; FIRE3DV_NO_INDEX = core glTF alone
  TextureUse base_color_texture;
  TextureUse metallic_roughness_texture;
  TextureUse normal_texture;
  TextureUse occlusion_texture;
  TextureUse emissive_texture;
};

// What extensions of glTF add, apart, since few materials have any.
struct MaterialExtensionRecord {
  vec3 dielectric_f0;  // of KHR_materials_ior, times specular's colour
  float specular;
  vec3 sheen_color;
  float sheen_roughness;
  float clearcoat;
  float clearcoat_roughness;
  float clearcoat_normal_scale;
  float transmission;
  TextureUse specular_texture;
  TextureUse specular_color_texture;
  TextureUse clearcoat_texture;
  TextureUse clearcoat_roughness_texture;
  TextureUse clearcoat_normal_texture;
  TextureUse sheen_color_texture;
  TextureUse sheen_roughness_texture;
  TextureUse transmission_texture;
};

struct VertexRecord {
  vec3 normal;
  vec4 tangent;
  vec2 uv0;
  vec2 uv1;
  vec4 color;
};

struct PrimitiveRecord {
  uint first_index;
  uint first_vertex;
  uint material;
  vec3 mesh_center;  // sphere around the whole mesh, node space
  float mesh_radius;
};

// A primitive at a node, in the order of the scene: what clusters, ids and draws refer to.
struct PartRecord {
  uint node;
  uint primitive;
  uint flags;
};

#define FIRE3DV_PART_DOUBLE_SIDED 1u
#define FIRE3DV_PART_MASK 2u      // alpha-masked
#define FIRE3DV_PART_ON_TOP 4u    // blended, or not of triangles: drawn by the forward pass alone
#define FIRE3DV_PART_CLOSED 8u    // see scene::CasterShape
#define FIRE3DV_PART_PLANAR 16u
#define FIRE3DV_PART_DEFORMED 32u  // vertices change: bounds are not known
#define FIRE3DV_PART_NO_SHADOW 64u
#define FIRE3DV_PART_UNLIT 128u  // lines and points without normals

// scene::Cluster on the GPU; vertices and triangles are absolute.
struct ClusterRecord {
  vec3 center;
  float radius;
  vec3 cone_axis;
  float cone_cutoff;
  uint first_vertex;
  uint first_triangle;
  uint vertex_count;
  uint triangle_count;
};

// A cluster of a part. Its number, plus one and times 128, plus the triangle is the id in the visibility buffer.
struct ClusterInstance {
  uint part;
  uint cluster;
};

// Up to four of the joints that move a vertex, as indices into its skin.
struct InfluenceRecord {
  uint joints_low;   // two 16-bit indices
  uint joints_high;
  vec4 weights;
};

struct JointRecord {
  AffineRows joint_from_mesh;
  uint node;
};

// A box that moves with a joint of the skin, or with the node of the mesh where joint is FIRE3DV_NO_INDEX.
struct JointBoundsRecord {
  uint joint;
  vec3 low;
  vec3 high;
};

struct MorphDeltaRecord {
  vec3 position;
  vec3 normal;
  vec3 tangent;
};

// A primitive at a node, which has a copy of its vertices.
struct DeformRecord {
  uint node;
  uint primitive;        // of the copy
  uint rest_vertex;      // the first one of those that stay as they are
  uint posed_vertex;     // the first one of the copy
  uint vertex_count;
  uint first_source;     // of each vertex: its number in the arrays that the scene has in its own order
  uint skinned;          // 1: written in the world; 0: in the node's frame
  float sign_x;          // skinned ones: -1 where the frame that they are drawn in mirrors the world
  uint first_influence;  // FIRE3DV_NO_INDEX: moves with the node
  uint influence_sets;
  uint first_joint;
  uint first_bounds;     // of skinned ones
  uint bounds_count;
  uint first_delta;
  uint delta_stride;     // from one target to the next
  uint target_count;
  uint first_weight;
};

// What one workgroup deforms.
struct DeformGroup {
  uint record;
  uint first_vertex;
};

// From where clusters are culled and triangles drawn: the camera, or a light's map.
struct RasterView {
  mat4 clip_from_world;
  vec4 planes_world[6];  // inside where dot(xyz, p) + w >= 0
  vec4 eye_world;        // w = 1: a point; w = 0: an orthographic view, which looks along xyz
  uint width;
  uint height;
  uint first_texel;      // of the light's maps
  // For shadow maps. Orthographic: metres for each unit of depth, and the side of a texel in metres. Perspective: the
  // near distance in metres, and the side of a texel at a distance of 1 m.
  float depth_m;
  float texel_m;
};

// A list of clusters, begun with the arguments of the dispatch that draws them.
struct ClusterList {
  uint groups_x;
  uint groups_y;
  uint groups_z;
  uint count;
};

struct ViewWork {
  ClusterList solid;
  ClusterList masked;
};

// Triangles too large for one thread: cut at the view's border if need be, then into tiles.
struct LargeWork {
  ClusterList expand;  // one group for each entry of `huge`
  ClusterList tiles;   // one group for each entry of `tiles`
  uint prepared_count;
  uint lost;           // triangles for which there was no room
};

struct HugeTriangle {
  uint id;
  uint view;
};

struct PreparedTriangle {
  ivec2 a, b, c;  // 1/256 pixel; in an order that makes the area positive
  float za, zb, zc;
  uint id;
  uint view;
};

struct TileEntry {
  uint prepared;  // FIRE3DV_NO_INDEX = none
  uint tile;      // x | y << 16
};

// All that the raster shaders share for one set of views.
struct RasterSet {
  FIRE3DV_ADDRESS views;     // RasterView[]
  FIRE3DV_ADDRESS work;      // ViewWork[]
  FIRE3DV_ADDRESS lists;     // uint[view][cluster instance]: solid ones from the front, masked ones from the back
  FIRE3DV_ADDRESS large;     // LargeWork
  FIRE3DV_ADDRESS huge;      // HugeTriangle[]
  FIRE3DV_ADDRESS prepared;  // PreparedTriangle[]
  FIRE3DV_ADDRESS tiles;     // TileEntry[]
  FIRE3DV_ADDRESS target;    // uint64_t[pixel][sample] of the camera; uint[] of the lights
  uint instance_count;
  uint huge_capacity;
  uint prepared_capacity;
  uint tile_capacity;
  uint cull;                 // 0: every cluster is drawn
};

struct RasterPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS set;  // RasterSet
  uint view;
};

// One draw of the forward pass.
struct DrawRecord {
  uint node;
  uint primitive;
  uint part;
};

#define FIRE3DV_LIGHT_DIRECTIONAL 0u
#define FIRE3DV_LIGHT_POINT 1u
#define FIRE3DV_LIGHT_SPOT 2u

struct LightRecord {
  vec3 color;  // linear colour times intensity: candela, or lux for a directional light
  float range_m;  // 0 = infinite
  uint type;
  uint node;  // the light stands at this node and shines along its -Z
  float cone_scale;   // KHR_lights_punctual: attenuation = clamp(cos(angle) * scale + offset, 0, 1)^2
  float cone_offset;
  float radius_m;            // point, spot: 0 = hard shadows
  float angular_radius_rad;  // directional
};

// How a light's shadow is found.
struct LightShadow {
  uint first_view;  // of the lights' RasterViews: 1, or 6 sides of a cube
  uint view_count;
  uint mask_word;   // where the mask keeps this light's result
  uint mask_shift;
  uint rays;        // 1: hard, one bit for each sample; more: soft, 8 bits for each sample
};

// A mesh in one plane, which shadow maps leave out: whether it lies between a point and a light is computed.
struct SheetRecord {
  vec4 plane_node;
  uint part;
};

#define FIRE3DV_SHADOWS_OFF 0u
#define FIRE3DV_SHADOWS_MASK 1u  // found by rays before shading
#define FIRE3DV_SHADOWS_MAP 2u
#define FIRE3DV_SHADOWS_INLINE 3u  // rays traced where the surface is shaded

// A pixel's rays that are to be traced, of one word of its mask.
struct RayEntry {
  uint pixel;
  uint word;
  uint wanted;  // bits as in the mask; of a soft light the lowest one of each sample
};

struct RayList {
  uint width;  // of vkCmdTraceRaysIndirectKHR: entries
  uint height;
  uint depth;
  uint groups_x;  // of vkCmdDispatchIndirect
  uint groups_y;
  uint groups_z;
  uint rays;      // counted for the statistics
};

// What every shader of a frame may need; one per frame.
struct Globals {
  FIRE3DV_ADDRESS world_from_node;  // AffineRows[]
  FIRE3DV_ADDRESS first_primitive_of_node;  // uint[]
  FIRE3DV_ADDRESS draws;            // DrawRecord[]
  FIRE3DV_ADDRESS primitives;       // PrimitiveRecord[]
  FIRE3DV_ADDRESS materials;        // MaterialRecord[]
  FIRE3DV_ADDRESS material_extensions;  // MaterialExtensionRecord[]
  FIRE3DV_ADDRESS lights;           // LightRecord[]
  FIRE3DV_ADDRESS positions;        // vec3[], node space
  FIRE3DV_ADDRESS vertices;         // VertexRecord[]
  FIRE3DV_ADDRESS indices;          // uint[]
  FIRE3DV_ADDRESS parts;            // PartRecord[]
  FIRE3DV_ADDRESS clusters;         // ClusterRecord[]
  FIRE3DV_ADDRESS cluster_triangles;   // uint[], scene::ClusteredGeometry::triangles
  FIRE3DV_ADDRESS cluster_instances;   // ClusterInstance[]
  FIRE3DV_ADDRESS light_shadows;    // LightShadow[], as lights
  FIRE3DV_ADDRESS light_views;      // RasterView[]
  FIRE3DV_ADDRESS shadow_maps;      // uint[]: of each view, nearest depths at texels' middles, then outer ones
  FIRE3DV_ADDRESS shadow_mask;      // uint[pixel][mask_words]
  FIRE3DV_ADDRESS sheets;           // SheetRecord[]
  mat4 clip_from_world;
  vec3 eye_world;
  vec4 near_window;  // passes::NearWindow: middle and radius
  vec4 near_plane;
  uint light_count;
  float environment_intensity;      // factor on what the environment's images hold
  vec2 environment_turn;            // cosine and sine of its rotation about +Y
  vec3 background;                  // where nothing is, unless the surroundings show; linear
  float background_lod;             // of the environment's picture, so that its texels are a pixel large; < 0: background
  vec3 world_from_ndc_x;            // the direction of the ray through a pixel is x * ndc.x + y * ndc.y + origin
  vec3 world_from_ndc_y;
  vec3 world_from_ndc_origin;
  uint shadows;                     // FIRE3DV_SHADOWS_*
  uint width;                       // of the image
  uint height;
  uint mask_words;
  uint sheet_count;
  uint part_count;
};

struct TransformsPush {
  FIRE3DV_ADDRESS sources;          // NodeSource[]
  FIRE3DV_ADDRESS streams;          // StreamSource[]
  FIRE3DV_ADDRESS world_from_node;  // AffineRows[], written
  FIRE3DV_ADDRESS instance_of_node; // uint[]
  FIRE3DV_ADDRESS instances;        // VkAccelerationStructureInstanceKHR[], transforms written; 0 = none
  uint node_count;
};

struct DeformPush {
  FIRE3DV_ADDRESS records;          // DeformRecord[]
  FIRE3DV_ADDRESS groups;           // DeformGroup[]
  FIRE3DV_ADDRESS sources;          // uint[]
  FIRE3DV_ADDRESS influences;       // InfluenceRecord[]
  FIRE3DV_ADDRESS joints;           // JointRecord[]
  FIRE3DV_ADDRESS joint_bounds;     // JointBoundsRecord[]
  FIRE3DV_ADDRESS deltas;           // MorphDeltaRecord[]
  FIRE3DV_ADDRESS weights;          // float[]
  FIRE3DV_ADDRESS world_from_node;  // AffineRows[]
  FIRE3DV_ADDRESS positions;        // vec3[], read and written
  FIRE3DV_ADDRESS vertices;         // VertexRecord[], read and written
  FIRE3DV_ADDRESS primitives;       // PrimitiveRecord[], spheres written
  uint group_count;                 // of workgroups
};

// One step of the preparation of the surroundings.
struct EnvironmentPush {
  uint size;        // of the level that is written, in texels
  uint samples;
  float roughness;  // perceptual
  float lod;        // of what is read
};

struct ForwardPush {
  FIRE3DV_ADDRESS globals;
};

#define FIRE3DV_TONE_MAP_REINHARD 0u
#define FIRE3DV_TONE_MAP_NONE 1u
#define FIRE3DV_TONE_MAP_ACES 2u
#define FIRE3DV_TONE_MAP_NEUTRAL 3u

struct PostPush {
  uint width;
  uint height;
  uint samples;
  float exposure;
  uint tone_map;
};

struct LightViewsPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS wanted;  // LightViewWanted[]
  FIRE3DV_ADDRESS views;   // RasterView[], written
};

// A light's view before it is fitted to what there is to see.
struct LightViewWanted {
  uint light;
  uint side;         // of a cube; FIRE3DV_NO_INDEX = not of a cube
  uint size;         // texels along each side
  uint first_texel;
  float half_angle_rad;  // spot
};

struct ShadowPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS list;        // RayList
  FIRE3DV_ADDRESS entries;     // RayEntry[]
  uint hybrid;                 // 0: every ray is traced
};

struct ShadePush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  float exposure;
  uint tone_map;
};

struct VisibleDepthPush {
  FIRE3DV_ADDRESS visibility;
  uint width;
};

struct FxaaPush {
  uint width;
  uint height;
};

#ifdef __cplusplus
static_assert(sizeof(PostPush) <= 128 && sizeof(TransformsPush) <= 128 && sizeof(DeformPush) <= 128);
}  // namespace fire3dv::gpu_types
#endif
#endif
