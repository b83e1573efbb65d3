// Acceleration structures: one bottom level per mesh, built once and compacted; one top level, rebuilt every
// frame from instances that a shader has written.
#pragma once

#include <span>
#include <thread>
#include <vector>

#include "renderer/gpu/loader_commands.h"
#include "renderer/gpu/resources.h"

namespace fire3dv::gpu {

struct AccelerationStructure {
  Buffer storage;
  AccelerationHandle handle;
  VkDeviceAddress address = 0;
};

// Whether rays are traced to boxes around a few triangles each, which a shader then meets one by one, where a
// mesh's are all opaque and keep their shape: llvmpipe makes a tree of the order in which it is given things,
// whatever that is, and writes 104 bytes for each.
bool traces_to_boxes(const Device& device);

constexpr VkDeviceSize kBoxStride = 32;

// One geometry of triangles: 3 float32 positions per vertex, uint32 indices relative to the first vertex. Or
// of boxes.
struct TriangleGeometry {
  VkDeviceAddress positions = 0;  // of the first vertex
  VkDeviceAddress indices = 0;    // of the first index
  uint32_t vertex_count = 0;
  uint32_t triangle_count = 0;
  bool opaque = true;  // false: rays stop for a look at alpha
  // Each kBoxStride after the one before, and begins with its VkAabbPositionsKHR. 0: triangles.
  VkDeviceAddress boxes = 0;
  uint32_t box_count = 0;
};

// Geometry descriptions of one mesh, with the arrays that Vulkan's build call points to. Whoever moves it
// points info.pGeometries at `geometries` again.
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

// The bottom levels of a scene's meshes, built while other things are uploaded.
class MeshBuilds {
 public:
  // meshes[i]: the geometries of one mesh. inputs: the buffers that the geometries point into, filled by what
  // has been submitted; they must live until finish(). Submits without waiting.
  MeshBuilds(Device& device, std::span<const std::vector<TriangleGeometry>> meshes,
             std::vector<Buffer*> inputs);

  // Waits, and makes them compact where that pays. One structure for each mesh; a null address for one
  // without triangles. Once.
  std::vector<AccelerationStructure> finish(BlasBuildReport& report);

 private:
  void create(std::span<const std::vector<TriangleGeometry>> meshes);
  void record(size_t build);
  void compact(BlasBuildReport& report);

  Device& device_;
  std::vector<Buffer*> inputs_;
  LoaderCommands loader_;
  std::vector<AccelerationStructure> built_;  // of each mesh
  std::vector<MeshBuild> builds_;             // of those with triangles
  std::vector<uint32_t> mesh_of_build_;
  Buffer scratch_;
  QueryPool compact_sizes_;  // of each build
  std::jthread touching_;    // what is built into; after it in order of destruction
};

// What a structure that is built for each frame is best at: it takes less time to build, or rays less to
// trace.
enum class Rays : uint8_t { few, many };

class TopLevel {
 public:
  TopLevel() = default;
  TopLevel(Device& device, uint32_t max_instances, Rays rays);

  VkAccelerationStructureKHR handle() const { return structure_.handle.get(); }
  Buffer& storage() { return structure_.storage; }
  Buffer& scratch() { return scratch_; }
  // The caller declares storage() and scratch() as build_write and the instances as build_input.
  void record_build(VkCommandBuffer commands, VkDeviceAddress instances, uint32_t count) const;

 private:
  Device* device_ = nullptr;
  Rays rays_ = Rays::many;
  AccelerationStructure structure_;
  Buffer scratch_;
  VkDeviceAddress scratch_address_ = 0;
};

}  // namespace fire3dv::gpu
