#include "renderer/doctor/device_probes.h"

#include <dlfcn.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <stdexcept>
#include <vector>

#include "base/words.h"
#include "renderer/gpu/acceleration.h"
#include "renderer/gpu/device/device.h"
#include "renderer/gpu/loader/vulkan_loader.h"
#include "renderer/gpu/loader_commands.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/gpu/selection/cuda_devices.h"
#include "renderer/gpu/selection/device_choice.h"

namespace fire3dv::doctor {
namespace {

constexpr VkExtent2D kExtent{64, 64};

template <typename T>
T value_or_throw(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

struct OpenDevice {
  std::unique_ptr<gpu::Instance> instance;
  std::unique_ptr<gpu::Device> device;
};

OpenDevice open_device(uint32_t index) {
  OpenDevice open;
  open.instance = value_or_throw(gpu::Instance::create({}));
  open.device = value_or_throw(gpu::Device::create(*open.instance, index, false));
  return open;
}

nlohmann::json to_json(const gpu::DeviceReport& report) {
  return {{"index", report.index},         {"name", report.name},
          {"driver", report.driver},       {"type", gpu::type_name(report.type)},
          {"uuid", report.uuid},           {"pci_address", report.pci_address},
          {"vendor_id", report.vendor_id}, {"missing", report.missing},
          {"ray_query", report.ray_query}, {"ray_tracing_pipeline", report.ray_tracing_pipeline}};
}

// Buffer that holds the results of the probe's two rays.
void expect_hits(const gpu::Buffer& hits, const char* method) {
  std::array<uint32_t, 2> values{};
  std::memcpy(values.data(), hits.mapped, sizeof(values));
  if (values[0] != 1 || values[1] != 0)
    throw std::runtime_error(std::string("the result of ") + method + " is wrong");
}

// Top-level structure with one instance of one triangle at z = 1.
struct TriangleScene {
  gpu::Buffer positions, indices, instances;
  std::vector<gpu::AccelerationStructure> mesh;
  gpu::TopLevels top;
};

TriangleScene build_scene(gpu::Device& device) {
  TriangleScene scene;
  gpu::LoaderCommands loader(device);
  const VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                   VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
  scene.positions =
      gpu::upload_array(device, loader, std::vector<float>{-1, -1, 1, 1, -1, 1, 0, 1, 1}, usage);
  scene.indices = gpu::upload_array(device, loader, std::vector<uint32_t>{0, 1, 2}, usage);
  loader.finish();
  const std::vector<std::vector<gpu::TriangleGeometry>> meshes{{{.positions = scene.positions.address,
                                                                 .indices = scene.indices.address,
                                                                 .vertex_count = 3,
                                                                 .triangle_count = 1}}};
  gpu::BlasBuildReport report;
  scene.mesh = gpu::MeshBuilds(device, meshes, {&scene.positions, &scene.indices}).finish(report);

  VkAccelerationStructureInstanceKHR instance{};
  for (int axis = 0; axis < 3; ++axis) instance.transform.matrix[axis][axis] = 1;
  instance.mask = 0xff;
  instance.flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR;
  instance.accelerationStructureReference = scene.mesh[0].address;
  scene.instances =
      gpu::upload_array(device, loader, std::vector<VkAccelerationStructureInstanceKHR>{instance}, usage);
  scene.top = gpu::TopLevels(device, 1, 1, gpu::Rays::few);
  loader.recorder().pass(
      "tlas",
      {gpu::Use(scene.instances, gpu::access::build_input),
       gpu::Use(scene.mesh[0].storage, gpu::access::build_read),
       gpu::Use(scene.top.storage(), gpu::access::build_write),
       gpu::Use(scene.top.scratch(), gpu::access::build_write)},
      [&](VkCommandBuffer commands) { scene.top.record_build(commands, scene.instances.address, 1); });
  loader.finish();
  return scene;
}

struct RayPush {
  VkDeviceAddress top_level, hits;
};

}  // namespace

nlohmann::json probe_loader() {
  const gpu::VulkanLoader& loader = gpu::vulkan_loader();
  if (!loader.fault.empty()) throw std::runtime_error(loader.fault);
  uint32_t version = VK_API_VERSION_1_0;
  vkEnumerateInstanceVersion(&version);
  return {{"version", version}, {"file", loader.file}};
}

nlohmann::json probe_library(const std::string& library) {
  void* const driver = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!driver) {
    const char* const reason = ::dlerror();
    throw std::runtime_error(reason ? reason : "dlopen failed");
  }
  // Vulkan's interface of loaders and drivers: version 5 is that of loaders for Vulkan 1.1 and newer.
  using Negotiate = VkResult (*)(uint32_t * version);
  uint32_t version = 5;
  if (void* const negotiate = ::dlsym(driver, "vk_icdNegotiateLoaderICDInterfaceVersion"))
    reinterpret_cast<Negotiate>(negotiate)(&version);
  void* find = ::dlsym(driver, "vk_icdGetInstanceProcAddr");
  if (!find) find = ::dlsym(driver, "vkGetInstanceProcAddr");
  if (find && reinterpret_cast<PFN_vkGetInstanceProcAddr>(find)(nullptr, "vkCreateInstance")) return true;
  std::vector<std::string> missing;
  for (const char* name : {"libEGL.so.1", "libGLdispatch.so.0", "libX11.so.6", "libXext.so.6"}) {
    if (!::dlopen(name, RTLD_NOW | RTLD_LOCAL)) missing.emplace_back(name);
  }
  const bool is_of_nvidia = library.find("_nvidia.so") != std::string::npos;
  throw std::runtime_error("it has no vkCreateInstance" +
                           (is_of_nvidia && !missing.empty() ? " without " + joined(missing) : ""));
}

nlohmann::json probe_devices() {
  const std::unique_ptr<gpu::Instance> instance = value_or_throw(gpu::Instance::create({}));
  const std::vector<gpu::DeviceReport> reports = gpu::report_devices(instance->handle());
  nlohmann::json devices = nlohmann::json::array();
  for (const gpu::DeviceReport& report : reports) devices.push_back(to_json(report));
  const Result<gpu::DeviceChoice> choice = gpu::choose_device(reports, "", gpu::host_facts());
  return {{"devices", devices}, {"chosen", choice ? nlohmann::json(choice->index) : nlohmann::json()}};
}

nlohmann::json probe_driver(const std::string& manifest) {
  for (const char* name : {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"}) ::setenv(name, manifest.c_str(), 1);
  ::unsetenv("VK_ADD_DRIVER_FILES");
  const std::unique_ptr<gpu::Instance> instance = value_or_throw(gpu::Instance::create({}));
  return gpu::report_devices(instance->handle()).size();
}

nlohmann::json probe_read_back(uint32_t index) {
  const OpenDevice open = open_device(index);
  gpu::Device& device = *open.device;
  gpu::Image image = gpu::create_image(
      device,
      {.extent = kExtent, .usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
  constexpr std::array<uint8_t, 4> kColor{255, 0, 255, 0};
  constexpr size_t kBytes = size_t{kExtent.width} * kExtent.height * 4;
  gpu::Buffer pixels = gpu::create_buffer(device, kBytes, 0, gpu::Memory::readback);
  gpu::LoaderCommands loader(device);
  loader.recorder().pass(
      "clear", {gpu::Use(image, gpu::access::transfer_write, true)}, [&](VkCommandBuffer commands) {
        const VkClearColorValue value{{1, 0, 1, 0}};
        const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        vkCmdClearColorImage(commands, image.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &value, 1, &range);
      });
  loader.download_level(image, 0, pixels, 0);
  loader.recorder().transition({gpu::Use(pixels, gpu::access::host_read)});
  loader.finish();
  for (size_t at = 0; at < kBytes; at += kColor.size()) {
    if (std::memcmp(pixels.mapped + at, kColor.data(), kColor.size()) != 0)
      throw std::runtime_error("pixel " + std::to_string(at / kColor.size()) + " has a wrong colour");
  }
  return true;
}

nlohmann::json probe_ray(uint32_t index) {
  const OpenDevice open = open_device(index);
  gpu::Device& device = *open.device;
  const TriangleScene scene = build_scene(device);
  gpu::PipelineLayout layout = gpu::create_pipeline_layout(device, {});
  gpu::Buffer hits =
      gpu::create_buffer(device, 64, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::readback);
  const RayPush push{scene.top.address(0), hits.address};
  gpu::LoaderCommands loader(device);
  const auto trace = [&](const char* method, const gpu::Access& writes, VkPipelineBindPoint point,
                         VkPipeline pipeline, const std::function<void(VkCommandBuffer)>& dispatch) {
    std::memset(hits.mapped, 0xff, 64);
    loader.recorder().pass("probe", {gpu::Use(hits, writes)}, [&](VkCommandBuffer commands) {
      gpu::wait_for(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
      vkCmdBindPipeline(commands, point, pipeline);
      vkCmdPushConstants(commands, layout.get(), VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
      dispatch(commands);
    });
    loader.recorder().transition({gpu::Use(hits, gpu::access::host_read)});
    loader.finish();
    expect_hits(hits, method);
  };
  if (device.report().ray_query) {
    const gpu::Pipeline pipeline = gpu::create_compute_pipeline(device, layout.get(), "probe_ray.comp");
    trace("ray query", gpu::access::compute_write, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get(),
          [](VkCommandBuffer commands) { vkCmdDispatch(commands, 1, 1, 1); });
  }
  if (device.report().ray_tracing_pipeline) {
    const gpu::RayPipeline pipeline(device, layout.get(), "probe_ray.rgen", "trace.rmiss", "probe_ray.rahit");
    const gpu::Buffer arguments =
        gpu::upload_array(device, loader, std::vector<VkTraceRaysIndirectCommandKHR>{{1, 1, 1}},
                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
    loader.finish();
    trace("the ray-tracing pipeline", gpu::access::ray_write, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR,
          pipeline.get(), [&](VkCommandBuffer commands) { pipeline.trace(commands, arguments.address); });
  }
  return true;
}

nlohmann::json probe_cuda() {
  constexpr const char* kLibrary = "libcuda.so.1";
  if (!::dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL)) return nullptr;
  const gpu::CudaDevices cuda = gpu::read_cuda_devices(kLibrary);
  if (!cuda.failure.empty()) throw std::runtime_error(cuda.failure);
  nlohmann::json devices = nlohmann::json::array();
  for (const gpu::CudaDevice& device : cuda.devices)
    devices.push_back({{"name", device.name}, {"uuid", device.uuid}, {"mig", device.is_mig}});
  return devices;
}

}  // namespace fire3dv::doctor
