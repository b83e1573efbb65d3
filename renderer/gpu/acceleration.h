// Acceleration structures: one compacted bottom-level structure per mesh, built once; one per deformed mesh,
// refitted; and one top-level structure per world, rebuilt every frame from instances that a shader has
// written.
#pragma once

#include <span>
#include <thread>
#include <vector>

#include "renderer/gpu/device/resources.h"
#include "renderer/gpu/loader_commands.h"

namespace fire3dv::gpu {

struct AccelerationStructure {
  Buffer storage;
  AccelerationHandle handle;
  VkDeviceAddress address = 0;
};

// True where a mesh's structure holds boxes around a few triangles each, and a shader intersects those
// triangles itself. Only opaque meshes of constant shape use boxes. Reason: llvmpipe builds its tree in input
// order and writes 104 bytes for each primitive.
bool traces_to_boxes(const Device& device);

constexpr VkDeviceSize kBoxStride = 32;

// One geometry of a bottom-level structure: triangles with 3 float32 positions per vertex and uint32 indices
// relative to the first vertex, or boxes.
struct TriangleGeometry {
  VkDeviceAddress positions = 0;  // of the first vertex
  VkDeviceAddress indices = 0;    // of the first index
  uint32_t vertex_count = 0;
  uint32_t triangle_count = 0;
  bool opaque = true;  // false: the any-hit test reads alpha
  // Boxes at a stride of kBoxStride; each record begins with its VkAabbPositionsKHR. 0: triangles.
  VkDeviceAddress boxes = 0;
  uint32_t box_count = 0;
};

// Geometry descriptions of one mesh and the arrays that Vulkan's build call points to. After a move, the
// caller sets info.pGeometries to `geometries` again.
struct MeshBuild {
  std::vector<VkAccelerationStructureGeometryKHR> geometries;
  std::vector<VkAccelerationStructureBuildRangeInfoKHR> ranges;
  VkAccelerationStructureBuildGeometryInfoKHR info{
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR};
  VkAccelerationStructureBuildSizesInfoKHR sizes{
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
};
MeshBuild describe_mesh(Device& device, const std::vector<TriangleGeometry>& mesh,
                        VkBuildAccelerationStructureFlagsKHR flags);

struct BlasBuildReport {
  VkDeviceSize bytes_built = 0;
  VkDeviceSize bytes_compacted = 0;
};

// Builder of all bottom-level structures of a scene; the builds overlap with other uploads.
class MeshBuilds {
 public:
  // meshes[i]: geometries of one mesh. inputs: buffers that the geometries point into, filled by commands
  // submitted earlier; they must live until finish(). Submits without waiting.
  MeshBuilds(Device& device, std::span<const std::vector<TriangleGeometry>> meshes,
             std::vector<Buffer*> inputs);

  // Waits and compacts the structures where that pays. Returns one structure per mesh, with a null address
  // for a mesh without triangles. Call it once.
  std::vector<AccelerationStructure> finish(BlasBuildReport& report);

 private:
  void create(std::span<const std::vector<TriangleGeometry>> meshes);
  void record(size_t build);
  void compact(BlasBuildReport& report);

  Device& device_;
  std::vector<Buffer*> inputs_;
  LoaderCommands loader_;
  std::vector<AccelerationStructure> built_;  // per mesh
  std::vector<MeshBuild> builds_;             // only meshes with triangles
  std::vector<uint32_t> mesh_of_build_;
  Buffer scratch_;
  QueryPool compact_sizes_;  // per build
  std::jthread touching_;    // pre-faults built_; must be destroyed before it
};

// Build preference of a per-frame structure. few: fast build. many: fast trace.
enum class Rays : uint8_t { few, many };

// Top-level structures of the worlds of a scene, in one allocation.
class TopLevels {
 public:
  TopLevels() = default;
  TopLevels(Device& device, uint32_t worlds, uint32_t max_instances, Rays rays);

  VkDeviceAddress address(uint32_t world) const { return structures_[world].address; }
  bool empty() const { return structures_.empty(); }
  Buffer& storage() { return storage_; }
  Buffer& scratch() { return scratch_; }
  // instances: those of each world, `count` of them, follow those of the world before. The caller declares
  // storage() and scratch() as build_write and the instances as build_input.
  void record_build(VkCommandBuffer commands, VkDeviceAddress instances, uint32_t count) const;

 private:
  struct Structure {
    AccelerationHandle handle;
    VkDeviceAddress address = 0;
  };
  Device* device_ = nullptr;
  Rays rays_ = Rays::many;
  std::vector<Structure> structures_;  // by world
  Buffer storage_, scratch_;           // separate ranges, so that all builds run in parallel
  VkDeviceAddress scratch_address_ = 0;
  VkDeviceSize scratch_stride_ = 0;
};

// Bottom-level acceleration structures of deformed meshes. The first frame builds them, later frames update
// them; an update keeps the tree and refits its boxes.
class DeformedLevels {
 public:
  DeformedLevels() = default;
  // A mesh without triangles has no structure.
  DeformedLevels(Device& device, const std::vector<std::vector<TriangleGeometry>>& meshes);

  bool empty() const { return builds_.empty(); }
  VkDeviceAddress address(size_t mesh) const { return addresses_[mesh]; }  // 0: no structure
  Buffer& storage() { return storage_; }
  Buffer& scratch() { return scratch_; }
  // Records the build or the update of all structures. The caller declares storage() and scratch() as
  // build_write and the geometries' buffers as build_input.
  void record(VkCommandBuffer commands);

 private:
  Device* device_ = nullptr;
  Buffer storage_, scratch_;  // separate ranges per mesh, so that all builds run in parallel
  std::vector<AccelerationHandle> handles_;
  std::vector<VkDeviceAddress> addresses_;
  std::vector<MeshBuild> builds_;
  bool built_ = false;
};

}  // namespace fire3dv::gpu
