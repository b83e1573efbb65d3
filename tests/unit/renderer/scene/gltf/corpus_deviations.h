// Deviations of the loader from the glTF validator's reports in the public collections, with reasons.
#pragma once

#include <array>

namespace fire3dv::scene {

struct Deviation {
  const char* file;
  const char* reason;
};

// Invalid by the report, but loaded.
inline constexpr const char* kSkins =
    "joints stand where their nodes stand, whatever their roots, and weights are brought to a sum of 1";
inline constexpr const char* kIdle =
    "skins, weights and channels for what is not there move nothing; of two channels for one target one "
    "plays";
inline constexpr const char* kEmpty = "an empty list or object asks for nothing";
inline constexpr const char* kUnread =
    "nothing that is drawn refers to the faulty object, so that it is not read";
inline constexpr const char* kBounds =
    "bounds that accessors claim are not believed: they are found from the values";
inline constexpr const char* kMediaType =
    "media types are not looked at: data is what follows the comma, images are known by their first bytes";
inline constexpr const char* kChunks =
    "chunks are found by their lengths, aligned or not, and a byte order mark before JSON is passed over";
inline constexpr const char* kRestart =
    "the index names a vertex that is there, and lists have no primitive restart";
inline constexpr const char* kNoData =
    "channels and bind matrices of accessors without bytes are left out with a warning";
inline constexpr const char* kNotRoot =
    "a listed node that is no root is shown once, below its parent, with a warning";
inline constexpr const char* kLeftOut =
    "it belongs to an extension that is not supported and left out with a warning";
inline constexpr const char* kNoVariants = "a file without material variants has its default materials";
inline constexpr const char* kMeaningless =
    "an extension in a place where it means nothing, or that no list declares, changes nothing else";
inline constexpr const char* kAttributes =
    "unknown attributes are not read, missing coordinates are zero, and integers are converted as they say";
inline constexpr const char* kValues = "colours are brought into their range, directions and signs put right";
inline constexpr const char* kMatrix = "a node with a matrix as well as parts is placed by the matrix";

inline constexpr std::array<Deviation, 73> kLoadedThoughFaulty{{
    {"gltf-validator-corpus/base/data/animation_data/quaternion_non_unit_values.gltf", kNoData},
    {"gltf-validator-corpus/base/data/animation/sampler_output_format_invalid.gltf", kNoData},
    {"gltf-validator-corpus/base/data/skin/ibm_invalid_format.gltf", kNoData},
    {"gltf-asset-generator/Animation_Skin/Animation_Skin_06.gltf", kSkins},
    {"gltf-validator-corpus/base/data/skin/no_common_root.gltf", kSkins},
    {"gltf-validator-corpus/base/data/skin/skeleton_invalid.gltf", kSkins},
    {"khronos-sample-models/RiggedFigure/glTF-Binary/RiggedFigure.glb", kSkins},
    {"gltf-validator-corpus/base/data/animation/channel_duplicate_targets.gltf", kIdle},
    {"gltf-validator-corpus/base/data/animation/channel_node_no_morphs.gltf", kIdle},
    {"gltf-validator-corpus/base/data/node/skin_with_no_mesh.gltf", kIdle},
    {"gltf-validator-corpus/base/data/node/weights_with_no_mesh.gltf", kIdle},
    {"gltf-validator-corpus/base/data/animation/empty_array.gltf", kEmpty},
    {"gltf-validator-corpus/base/data/buffer/empty_array.gltf", kEmpty},
    {"gltf-validator-corpus/base/data/material/empty_array.gltf", kEmpty},
    {"gltf-validator-corpus/base/data/mesh/empty_array.gltf", kEmpty},
    {"gltf-validator-corpus/base/data/node/empty_children_array.gltf", kEmpty},
    {"gltf-validator-corpus/base/data/scene/empty_nodes_array.gltf", kEmpty},
    {"gltf-validator-corpus/base/data/skin/empty_array.gltf", kEmpty},
    {"gltf-validator-corpus/ext/KHR_lights_punctual/data/light/empty_lights_array.gltf", kEmpty},
    {"gltf-validator-corpus/ext/KHR_lights_punctual/data/light/empty_object.gltf", kEmpty},
    {"gltf-validator-corpus/base/data/accessor/alignment.gltf", kUnread},
    {"gltf-validator-corpus/base/data/accessor/invalid_sparse_count_and_stride.gltf", kUnread},
    {"gltf-validator-corpus/base/data/accessor/small_stride.gltf", kUnread},
    {"gltf-validator-corpus/base/data/buffer/zero_bytelength.gltf", kUnread},
    {"gltf-validator-corpus/base/data/buffer_view/invalid_stride_wrong_target.gltf", kUnread},
    {"gltf-validator-corpus/base/data/image/buffer_view_bytestride.gltf", kUnread},
    {"gltf-validator-corpus/base/data/image/empty_object.gltf", kUnread},
    {"gltf-validator-corpus/base/data/accessor_data/out_of_range_elements_float.gltf", kBounds},
    {"gltf-validator-corpus/base/data/accessor_data/out_of_range_elements_sint8.gltf", kBounds},
    {"gltf-validator-corpus/base/data/accessor_data/out_of_range_elements_uint32.gltf", kBounds},
    {"gltf-validator-corpus/base/data/animation/sampler_input_no_bounds.gltf", kBounds},
    {"gltf-validator-corpus/base/data/buffer/invalid_uri_data.gltf", kMediaType},
    {"gltf-validator-corpus/base/data/image/invalid_data_uri_mime_type.gltf", kMediaType},
    {"gltf-validator-corpus/base/data/image/missing_mime_type_buffer_view.gltf", kMediaType},
    {"gltf-validator-corpus/ext/EXT_texture_webp/data/texture/invalid_image_mime_type.gltf", kMediaType},
    {"gltf-validator-corpus/base/data/glb/bom.glb", kChunks},
    {"gltf-validator-corpus/base/data/glb/unaligned_chunk.glb", kChunks},
    {"gltf-validator-corpus/base/data/json/bom.gltf", kChunks},
    {"gltf-asset-generator/Negative/Mesh_PrimitiveRestart/Mesh_PrimitiveRestart_00.gltf", kRestart},
    {"gltf-asset-generator/Negative/Mesh_PrimitiveRestart/Mesh_PrimitiveRestart_02.gltf", kRestart},
    {"gltf-asset-generator/Negative/Mesh_PrimitiveRestart/Mesh_PrimitiveRestart_04.gltf", kRestart},
    {"gltf-asset-generator/Negative/Mesh_PrimitiveRestart/Mesh_PrimitiveRestart_06.gltf", kRestart},
    {"gltf-asset-generator/Negative/Mesh_PrimitiveRestart/Mesh_PrimitiveRestart_08.gltf", kRestart},
    {"gltf-asset-generator/Negative/Mesh_PrimitiveRestart/Mesh_PrimitiveRestart_10.gltf", kRestart},
    {"gltf-asset-generator/Negative/Mesh_PrimitiveRestart/Mesh_PrimitiveRestart_12.gltf", kRestart},
    {"bevy/AlienCake/cakeBirthday.glb", kNotRoot},
    {"bevy/AlienCake/tile.glb", kNotRoot},
    {"gltf-validator-corpus/base/data/root/extensions_non_objects.gltf", kLeftOut},
    {"gltf-validator-corpus/ext/KHR_animation_pointer/data/animation/channel/target/"
     "invalid_channel_target_node.gltf",
     kLeftOut},
    {"gltf-validator-corpus/ext/KHR_animation_pointer/data/animation/channel/target/"
     "invalid_channel_target_path.gltf",
     kLeftOut},
    {"gltf-validator-corpus/ext/KHR_animation_pointer/data/animation/channel/target/"
     "invalid_pointer_syntax.gltf",
     kLeftOut},
    {"gltf-validator-corpus/ext/KHR_animation_pointer/data/animation/channel/target/missing_pointer.gltf",
     kLeftOut},
    {"gltf-validator-corpus/ext/KHR_animation_pointer/data/animation/channel/target/"
     "unexpected_extension.gltf",
     kLeftOut},
    {"gltf-validator-corpus/ext/KHR_materials_variants/data/variant/empty_array.gltf", kNoVariants},
    {"gltf-validator-corpus/ext/KHR_materials_variants/data/variant/empty_object.gltf", kNoVariants},
    {"gltf-validator-corpus/ext/KHR_materials_volume/data/material/out_of_range.gltf", kLeftOut},
    {"gltf-validator-corpus/ext/KHR_materials_volume/data/material/unexpected_extension.gltf", kLeftOut},
    {"gltf-validator-corpus/ext/KHR_node_visibility/data/node/unexpected_extension.gltf", kMeaningless},
    {"gltf-validator-corpus/base/data/root/duplicate_extension_entry.gltf", kMeaningless},
    {"gltf-validator-corpus/ext/EXT_texture_webp/data/texture/undeclared_extension.gltf", kMeaningless},
    {"gltf-validator-corpus/ext/EXT_texture_webp/data/texture/unexpected_extension.gltf", kMeaningless},
    {"gltf-validator-corpus/ext/KHR_mesh_quantization/data/primitive/non_required.gltf", kMeaningless},
    {"gltf-validator-corpus/ext/KHR_mesh_quantization/data/primitive/unexpected_extension.gltf",
     kMeaningless},
    {"gltf-validator-corpus/ext/KHR_texture_transform/data/textureInfo/unexpected_extension.gltf",
     kMeaningless},
    {"tinygltf-regression/Cube-texture-ext/Cube-textransform.gltf", kMeaningless},
    {"gltf-validator-corpus/base/data/mesh/accessor_attribute_uint32.gltf", kAttributes},
    {"gltf-validator-corpus/base/data/mesh/invalid_attribute.gltf", kAttributes},
    {"gltf-validator-corpus/base/data/mesh/invalid_indexed_attribute.gltf", kAttributes},
    {"gltf-validator-corpus/base/data/mesh/uv.gltf", kAttributes},
    {"gltf-validator-corpus/ext/KHR_texture_transform/data/textureInfo/uv_sets.gltf", kAttributes},
    {"gltf-validator-corpus/base/data/mesh_data/colors_non_clamped.gltf", kValues},
    {"gltf-validator-corpus/base/data/mesh_data/normals_tangents_non_unit_invalid_sign.gltf", kValues},
    {"gltf-validator-corpus/base/data/node/matrix_trs.gltf", kMatrix},
}};

// Valid by the report, but refused.
inline constexpr std::array<Deviation, 4> kRefusedThoughValid{{
    {"gltf-validator-corpus/base/data/asset/min_version_valid.gltf", "it asks for a version later than 2.0"},
    {"gltf-validator-corpus/base/data/buffer/non_relative_uri.gltf", "it asks for bytes from the network"},
    {"gltf-validator-corpus/base/data/root/named_objects.gltf",
     "what it draws lies in a buffer without bytes"},
    {"gltf-validator-corpus/base/data/root/unused_objects.gltf",
     "what it draws lies in a buffer without bytes"},
}};

}  // namespace fire3dv::scene
