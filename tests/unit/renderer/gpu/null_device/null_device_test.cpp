// Pipelines against the properties of GPUs that are not there: Mesa's RADV compiles for any generation of AMD
// GPUs without hardware (RADV_FORCE_FAMILY). Creates a pipeline of every shader that the device could use.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <map>
#include <memory>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/gpu/device/device_features.h"
#include "renderer/gpu/device/device_report.h"
#include "renderer/gpu/device/vk.h"
#include "shaders/embedded.h"
#include "tests/unit/renderer/gpu/null_device/spirv_module.h"

namespace fire3dv::test {
namespace {

// What a device needs for shaders with a SPIR-V capability. An unlisted capability is a failure: decide here
// whether it is required (DeviceFeatures::missing_required) or optional.
bool has_capability(uint32_t capability, const gpu::DeviceReport& report,
                    const VkPhysicalDeviceFeatures& core) {
  switch (capability) {
    case 1:     // Shader
    case 11:    // Int64
    case 50:    // ImageQuery
    case 51:    // DerivativeControl
    case 61:    // GroupNonUniform
    case 63:    // GroupNonUniformArithmetic
    case 64:    // GroupNonUniformBallot
    case 5301:  // ShaderNonUniform
    case 5302:  // RuntimeDescriptorArray
    case 5307:  // SampledImageArrayNonUniformIndexing
    case 5347:  // PhysicalStorageBufferAddresses
      return true;
    case 2:  // Geometry: the number of a primitive in fragment shaders
      return core.geometryShader;
    case 12:  // Int64Atomics
      return report.int64_atomics;
    case 27:  // StorageImageMultisample
      return report.multisample_storage;
    case 35:  // SampleRateShading
    case 52:  // InterpolationFunction
      return core.sampleRateShading;
    case 4447:  // SampleMaskPostDepthCoverage
      return report.visible_coverage;
    case 4472:  // RayQueryKHR
      return report.ray_query;
    case 4479:  // RayTracingKHR
      return report.ray_tracing_pipeline;
    default:
      ADD_FAILURE() << "SPIR-V capability " << capability << " is not in the list above";
      return false;
  }
}

// A device of the forced family, with the features that the renderer enables.
class NullDevice {
 public:
  NullDevice(const char* family, const char* compiler_options) {
    ::setenv("RADV_FORCE_FAMILY", family, 1);
    ::setenv("RADV_PERFTEST", compiler_options, 1);
    ::setenv("MESA_SHADER_CACHE_DISABLE", "1", 1);
    Result<std::unique_ptr<gpu::Instance>> instance = gpu::Instance::create({});
    if (!instance) {
      ADD_FAILURE() << instance.error().message;
      return;
    }
    instance_ = std::move(*instance);
    const std::vector<gpu::DeviceReport> reports = gpu::report_devices(instance_->handle());
    if (reports.size() != 1 || !reports[0].usable()) {
      ADD_FAILURE() << family << ": " << (reports.empty() ? "no device" : gpu::describe(reports[0]));
      return;
    }
    report_ = reports[0];
    EXPECT_NE(report_.name.find("Null hardware"), std::string::npos)
        << report_.name << ": set VK_DRIVER_FILES to RADV's";
    uint32_t count = 1;
    vkEnumeratePhysicalDevices(instance_->handle(), &count, &physical_);
    features_.query(physical_);
    std::vector<const char*> extensions;
    const float priority = 1;
    VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, features_.enable_chain(extensions)};
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    EXPECT_EQ(vkCreateDevice(physical_, &info, nullptr, &device_), VK_SUCCESS) << family;
    if (!device_) return;
    create_ray_pipelines_ = reinterpret_cast<PFN_vkCreateRayTracingPipelinesKHR>(
        vkGetDeviceProcAddr(device_, "vkCreateRayTracingPipelinesKHR"));
  }
  ~NullDevice() {
    if (device_) vkDestroyDevice(device_, nullptr);
  }
  NullDevice(const NullDevice&) = delete;
  NullDevice& operator=(const NullDevice&) = delete;

  explicit operator bool() const { return device_ != VK_NULL_HANDLE; }
  VkDevice handle() const { return device_; }
  const gpu::DeviceReport& report() const { return report_; }

  bool can_use(const SpirvModule& module) const {
    bool can = true;
    for (const uint32_t capability : module.capabilities)
      can = has_capability(capability, report_, features_.core.features) && can;
    return can;
  }

  VkResult create(VkRayTracingPipelineCreateInfoKHR& info, VkPipeline& pipeline) const {
    return create_ray_pipelines_(device_, VK_NULL_HANDLE, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline);
  }

 private:
  std::unique_ptr<gpu::Instance> instance_;
  gpu::DeviceReport report_;
  gpu::DeviceFeatures features_;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  PFN_vkCreateRayTracingPipelinesKHR create_ray_pipelines_ = nullptr;
};

// Values of the boolean specialisation constants.
enum class Constants { defaults, all_false, all_true };

// The shaders of one pipeline, its layout, and the pipeline.
class TestPipeline {
 public:
  TestPipeline(const NullDevice& device, const std::vector<std::string>& shaders, Constants constants)
      : device_(device), names_(shaders) {
    values_.reserve(shaders.size() * 64);
    std::map<uint32_t, std::vector<VkDescriptorSetLayoutBinding>> sets;
    modules_.resize(shaders.size());
    specializations_.resize(shaders.size());
    entries_.resize(shaders.size());
    for (size_t i = 0; i < shaders.size(); ++i) {
      const std::span<const uint32_t> code = shaders::embedded(shaders[i]);
      FIRE3DV_ASSERT(!code.empty());
      const SpirvModule module = read_spirv(code);
      add_stage(i, code, module, constants);
      for (const auto& [place, type] : module.descriptors) add_binding(sets[place.first], place.second, type);
    }
    create_layout(sets);
  }
  ~TestPipeline() {
    vkDestroyPipeline(device_.handle(), pipeline_, nullptr);
    vkDestroyPipelineLayout(device_.handle(), layout_, nullptr);
    for (VkDescriptorSetLayout set : set_layouts_)
      vkDestroyDescriptorSetLayout(device_.handle(), set, nullptr);
    for (VkShaderModule module : modules_) vkDestroyShaderModule(device_.handle(), module, nullptr);
  }
  TestPipeline(const TestPipeline&) = delete;
  TestPipeline& operator=(const TestPipeline&) = delete;

  void create_compute() {
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.stage = stages_[0];
    info.layout = layout_;
    check(vkCreateComputePipelines(device_.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_));
  }

  void create_graphics(VkSampleCountFlagBits samples) {
    VkPipelineVertexInputStateCreateInfo vertex_input{
        VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineInputAssemblyStateCreateInfo assembly{
        VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.lineWidth = 1;
    VkPipelineMultisampleStateCreateInfo multisample{
        VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    multisample.rasterizationSamples = samples;
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth.depthTestEnable = depth.depthWriteEnable = VK_TRUE;
    depth.depthCompareOp = VK_COMPARE_OP_GREATER_OR_EQUAL;
    VkPipelineColorBlendAttachmentState attachment{};
    attachment.colorWriteMask = 15;
    VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    blend.attachmentCount = 1;
    blend.pAttachments = &attachment;
    const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR,
                                     VK_DYNAMIC_STATE_CULL_MODE, VK_DYNAMIC_STATE_FRONT_FACE};
    VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
    dynamic.dynamicStateCount = std::size(states);
    dynamic.pDynamicStates = states;
    const VkFormat format = VK_FORMAT_R16G16B16A16_SFLOAT;
    VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
    rendering.colorAttachmentCount = 1;
    rendering.pColorAttachmentFormats = &format;
    rendering.depthAttachmentFormat = VK_FORMAT_D32_SFLOAT;
    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &rendering};
    info.stageCount = static_cast<uint32_t>(stages_.size());
    info.pStages = stages_.data();
    info.pVertexInputState = &vertex_input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &multisample;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blend;
    info.pDynamicState = &dynamic;
    info.layout = layout_;
    check(vkCreateGraphicsPipelines(device_.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_));
  }

  // Stages: ray generation, miss, any-hit and, optional, closest-hit.
  void create_ray_tracing() {
    std::vector<VkRayTracingShaderGroupCreateInfoKHR> groups(3);
    for (uint32_t i = 0; i < 3; ++i) {
      groups[i] = {VK_STRUCTURE_TYPE_RAY_TRACING_SHADER_GROUP_CREATE_INFO_KHR};
      groups[i].type = i < 2 ? VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR
                             : VK_RAY_TRACING_SHADER_GROUP_TYPE_TRIANGLES_HIT_GROUP_KHR;
      groups[i].generalShader = i < 2 ? i : VK_SHADER_UNUSED_KHR;
      groups[i].anyHitShader = i < 2 ? VK_SHADER_UNUSED_KHR : 2;
      groups[i].closestHitShader = i == 2 && stages_.size() > 3 ? 3 : VK_SHADER_UNUSED_KHR;
      groups[i].intersectionShader = VK_SHADER_UNUSED_KHR;
    }
    VkRayTracingPipelineCreateInfoKHR info{VK_STRUCTURE_TYPE_RAY_TRACING_PIPELINE_CREATE_INFO_KHR};
    info.stageCount = static_cast<uint32_t>(stages_.size());
    info.pStages = stages_.data();
    info.groupCount = static_cast<uint32_t>(groups.size());
    info.pGroups = groups.data();
    info.maxPipelineRayRecursionDepth = 1;
    info.layout = layout_;
    check(device_.create(info, pipeline_));
  }

 private:
  void check(VkResult result) const {
    EXPECT_EQ(result, VK_SUCCESS) << device_.report().name << ": " << names_[0] << ", " << names_.back();
  }

  void add_stage(size_t i, std::span<const uint32_t> code, const SpirvModule& module, Constants constants) {
    VkShaderModuleCreateInfo module_info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    module_info.codeSize = code.size_bytes();
    module_info.pCode = code.data();
    EXPECT_EQ(vkCreateShaderModule(device_.handle(), &module_info, nullptr, &modules_[i]), VK_SUCCESS);
    const auto first = static_cast<uint32_t>(values_.size());
    for (const auto& [id, value] : module.booleans) {
      entries_[i].push_back({id, static_cast<uint32_t>(values_.size() - first) * 4, 4});
      values_.push_back(constants == Constants::defaults ? value : constants == Constants::all_true);
    }
    FIRE3DV_ASSERT(values_.size() <= values_.capacity());
    specializations_[i] = {static_cast<uint32_t>(entries_[i].size()), entries_[i].data(),
                           (values_.size() - first) * 4, values_.data() + first};
    VkPipelineShaderStageCreateInfo stage{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    stage.stage = module.stage;
    stage.module = modules_[i];
    stage.pName = "main";
    stage.pSpecializationInfo = &specializations_[i];
    stages_.push_back(stage);
  }

  static void add_binding(std::vector<VkDescriptorSetLayoutBinding>& bindings, uint32_t binding,
                          VkDescriptorType type) {
    for (const VkDescriptorSetLayoutBinding& known : bindings) {
      if (known.binding != binding) continue;
      EXPECT_EQ(known.descriptorType, type);
      return;
    }
    const uint32_t count = type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER ? 64 : 1;
    bindings.push_back({binding, type, count, VK_SHADER_STAGE_ALL, nullptr});
  }

  void create_layout(std::map<uint32_t, std::vector<VkDescriptorSetLayoutBinding>>& sets) {
    const uint32_t count = sets.empty() ? 0 : sets.rbegin()->first + 1;
    EXPECT_LE(count, 4u) << names_[0] << ": the guaranteed minimum of maxBoundDescriptorSets";
    for (uint32_t set = 0; set < count; ++set) {
      VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
      info.bindingCount = static_cast<uint32_t>(sets[set].size());
      info.pBindings = sets[set].data();
      set_layouts_.emplace_back();
      EXPECT_EQ(vkCreateDescriptorSetLayout(device_.handle(), &info, nullptr, &set_layouts_.back()),
                VK_SUCCESS);
    }
    const VkPushConstantRange range{VK_SHADER_STAGE_ALL, 0, 128};
    VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    info.setLayoutCount = count;
    info.pSetLayouts = set_layouts_.data();
    info.pushConstantRangeCount = 1;
    info.pPushConstantRanges = &range;
    EXPECT_EQ(vkCreatePipelineLayout(device_.handle(), &info, nullptr, &layout_), VK_SUCCESS);
  }

  const NullDevice& device_;
  std::vector<std::string> names_;
  std::vector<VkShaderModule> modules_;
  std::vector<uint32_t> values_;
  std::vector<std::vector<VkSpecializationMapEntry>> entries_;
  std::vector<VkSpecializationInfo> specializations_;
  std::vector<VkPipelineShaderStageCreateInfo> stages_;
  std::vector<VkDescriptorSetLayout> set_layouts_;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
};

// The vertex shader that a fragment shader is drawn with; see GraphicsPipelineInfo in renderer/passes.
std::string vertex_shader_of(const std::string& fragment) {
  const bool in_layers = fragment.find("_layers") != std::string::npos;
  if (fragment.starts_with("marker")) return in_layers ? "marker_layers.vert" : "marker.vert";
  if (fragment.starts_with("layer_keys")) return "forward_layers.vert";
  if (fragment.starts_with("forward") || fragment.starts_with("depth_mask"))
    return in_layers ? "forward_layers.vert" : "forward.vert";
  return "background.vert";
}

// Number of pipelines of one shader, 0 where the device cannot use it. Vertex and hit shaders come with the
// others.
int create_pipelines(const NullDevice& device, const std::string& name, Constants constants) {
  const size_t dot = name.rfind('.');
  const std::string ending = name.substr(dot);
  std::vector<std::string> shaders{name};
  if (ending == ".frag") {
    shaders = {vertex_shader_of(name), name};
  } else if (ending == ".rgen") {
    const std::string family = name.starts_with("trace")  ? "trace"
                               : name.starts_with("path") ? "path"
                                                          : "ray_effects";
    shaders = {name, family + ".rmiss", family + ".rahit"};
    if (family != "trace") shaders.push_back(family + ".rchit");
  } else if (ending != ".comp" || name.ends_with("_cpu.comp")) {
    return 0;
  }
  for (const std::string& shader : shaders) {
    if (!device.can_use(read_spirv(shaders::embedded(shader)))) return 0;
  }
  TestPipeline pipeline(device, shaders, constants);
  if (ending == ".comp") {
    pipeline.create_compute();
  } else if (ending == ".rgen") {
    pipeline.create_ray_tracing();
  } else {
    pipeline.create_graphics(name.find("_1") == std::string::npos ? VK_SAMPLE_COUNT_4_BIT
                                                                  : VK_SAMPLE_COUNT_1_BIT);
  }
  return 1;
}

struct Generation {
  const char* family;
  const char* compiler_options;
  Constants constants;
  int pipelines;  // at least so many: fewer, and shaders are refused that this generation could use
};

void PrintTo(const Generation& generation, std::ostream* out) {
  *out << generation.family << " " << generation.compiler_options;
}

class NullDevices : public testing::TestWithParam<Generation> {};
TEST_P(NullDevices, EveryPipelineIsCreated) {
  const auto& [family, compiler_options, constants, pipelines] = GetParam();
  const NullDevice device(family, compiler_options);
  if (!device) return;
  int created = 0;
  for (const std::string_view name : shaders::names())
    created += create_pipelines(device, std::string(name), constants);
  EXPECT_GE(created, pipelines) << "the table of docs/devices.md has these numbers, too";
  std::printf("%s %s: %d pipelines\n", device.report().name.c_str(), compiler_options, created);
}

std::string test_name(const testing::TestParamInfo<Generation>& info) {
  return std::string(info.param.family) + (*info.param.compiler_options ? "_32" : "_64") +
         (info.param.constants == Constants::all_true    ? "_true"
          : info.param.constants == Constants::all_false ? "_false"
                                                         : "");
}

// RADV compiles compute shaders for subgroups of 64 lanes unless it is told otherwise. GCN has 64 always.
constexpr const char* kLanes64 = "";
constexpr const char* kLanes32 = "cswave32,gewave32,pswave32,rtwave32";
INSTANTIATE_TEST_SUITE_P(Quick, NullDevices,
                         testing::Values(Generation{"polaris10", kLanes64, Constants::defaults, 120}),
                         test_name);
INSTANTIATE_TEST_SUITE_P(Long, NullDevices,
                         testing::Values(Generation{"bonaire", kLanes64, Constants::defaults, 120},
                                         Generation{"polaris10", kLanes64, Constants::all_true, 120},
                                         Generation{"polaris10", kLanes64, Constants::all_false, 120},
                                         Generation{"raven", kLanes64, Constants::defaults, 120},
                                         Generation{"navi10", kLanes32, Constants::defaults, 132},
                                         Generation{"navi21", kLanes64, Constants::defaults, 162},
                                         Generation{"navi21", kLanes32, Constants::all_true, 162},
                                         Generation{"navi31", kLanes32, Constants::defaults, 162},
                                         Generation{"gfx1150", kLanes64, Constants::defaults, 162},
                                         Generation{"gfx1201", kLanes32, Constants::defaults, 162}),
                         test_name);

// Vulkan 1.0 guarantees these limits, so that no device needs a fallback.
TEST(ShaderLimits, GuaranteedMinimaSuffice) {
  for (const std::string_view name : shaders::names()) {
    const SpirvModule module = read_spirv(shaders::embedded(name));
    EXPECT_LE(module.shared_bytes, 16384u) << name;
    EXPECT_LE(module.push_constant_bytes, 128u) << name;
    EXPECT_LE(module.threads, 256u) << name << ": DeviceReport requires workgroups of so many threads";
    uint32_t storage_images = 0;
    for (const auto& [place, type] : module.descriptors)
      storage_images += type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    EXPECT_LE(storage_images, 4u) << name;
    if (module.stage == VK_SHADER_STAGE_COMPUTE_BIT) {
      EXPECT_GT(module.threads, 0u) << name;
    }
  }
}

}  // namespace
}  // namespace fire3dv::test
