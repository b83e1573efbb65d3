// Channels of streams in a recording: three channels per stream, identified by their metadata
// (protocol/SPEC-record.md), and the schemas of their messages.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace fire3dv::record {

enum class Role { control, poses, snapshot };
constexpr std::array<Role, 3> kRoles{Role::control, Role::poses, Role::snapshot};

inline std::string_view role_name(Role role) {
  constexpr std::string_view kNames[] = {"control", "poses", "snapshot"};
  return kNames[static_cast<size_t>(role)];
}

inline const std::string kRoleKey = "fire3dv.role";
inline const std::string kStreamKey = "fire3dv.stream";
constexpr std::string_view kMessageSchema = "fire3dv.wire.fbs.Message";
constexpr std::string_view kEncoding = "flatbuffer";

// Compiled FlatBuffers schemas (reflection.Schema buffers), embedded in recordings for readers without this
// project.
std::span<const std::byte> message_schema();       // protocol/schema/fire3dv.fbs
std::span<const std::byte> transforms_schema();    // protocol/schema/foxglove/frame_transforms.fbs
std::span<const std::byte> scene_update_schema();  // protocol/schema/foxglove/scene_update.fbs
std::span<const std::byte> point_cloud_schema();   // protocol/schema/foxglove/point_cloud.fbs

}  // namespace fire3dv::record
