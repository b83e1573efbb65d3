#include "renderer/gpu/device/vk.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "renderer/gpu/device/driver_files.h"
#include "renderer/gpu/loader/vulkan_loader.h"
#include "renderer/gpu/mask/device_mask.h"

namespace fire3dv::gpu {

const char* result_name(VkResult result) {
  switch (result) {
    case VK_SUCCESS:
      return "success";
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      return "out of host memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return "out of device memory";
    case VK_ERROR_INITIALIZATION_FAILED:
      return "initialisation failed";
    case VK_ERROR_DEVICE_LOST:
      return "device lost";
    case VK_ERROR_LAYER_NOT_PRESENT:
      return "layer not present";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
      return "extension not present";
    case VK_ERROR_FEATURE_NOT_PRESENT:
      return "feature not present";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
      return "incompatible driver";
    case VK_ERROR_SURFACE_LOST_KHR:
      return "surface lost";
    case VK_ERROR_OUT_OF_DATE_KHR:
      return "swapchain out of date";
    default:
      return "error";
  }
}

namespace {

// Shortens "vkCreateBuffer(device, ...)" to the function name for users.
std::string describe(VkResult code, const char* call) {
  const std::string text = call;
  const char* const remedy = code == VK_ERROR_DEVICE_LOST
                                 ? "; the GPU was reset or is gone: start it again, and "
                                   "look into the system's log where that comes back"
                                 : "";
  return text.substr(0, text.find('(')) + ": " + result_name(code) + " (" + std::to_string(code) + ")" +
         remedy;
}

// Known false validation messages. Every other message of core or synchronisation validation fails its test.
struct ValidationException {
  std::string_view message_id;
  std::string_view layer_version;
  std::string_view reason;
};

constexpr std::array<ValidationException, 0> kValidationExceptions{};

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

bool layer_present(const char* name) {
  uint32_t count = 0;
  vkEnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  vkEnumerateInstanceLayerProperties(&count, layers.data());
  return std::any_of(layers.begin(), layers.end(),
                     [&](const VkLayerProperties& layer) { return std::strcmp(layer.layerName, name) == 0; });
}

}  // namespace

VulkanFailure::VulkanFailure(VkResult code, const char* call)
    : std::runtime_error(describe(code, call)), result(code) {}

Result<std::unique_ptr<Instance>> Instance::create(const InstanceOptions& options) {
  if (const std::string& fault = vulkan_loader().fault; !fault.empty())
    return Error{"there is no usable Vulkan loader (" + fault + "): install libvulkan1 and a Vulkan driver"};
  uint32_t loader_version = VK_API_VERSION_1_0;
  vkEnumerateInstanceVersion(&loader_version);
  if (loader_version < VK_API_VERSION_1_3) {
    return Error{"the Vulkan loader is older than 1.3: install a newer libvulkan1"};
  }
  if (options.validation && !layer_present(kValidationLayer)) {
    return Error{std::string("validation was asked for but ") + kValidationLayer +
                 " is not installed: install vulkan-validationlayers or leave out --validation"};
  }

  if (const Result<DeviceMask>& mask = environment_mask(); !mask) return mask.error();
  std::unique_ptr<Instance> instance(new Instance);
  std::vector<const char*> extensions = options.window_extensions;
  std::vector<const char*> layers;

  VkDebugUtilsMessengerCreateInfoEXT messenger{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  messenger.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  messenger.pfnUserCallback = on_message;
  messenger.pUserData = instance.get();

  const VkValidationFeatureEnableEXT enabled[] = {
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  VkValidationFeaturesEXT validation{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT};
  validation.enabledValidationFeatureCount = 1;
  validation.pEnabledValidationFeatures = enabled;
  validation.pNext = &messenger;  // also reports errors in vkCreateInstance itself

  VkApplicationInfo app{VK_STRUCTURE_TYPE_APPLICATION_INFO};
  app.pApplicationName = "FIRE-3DV";
  app.pEngineName = "FIRE-3DV";
  app.apiVersion = VK_API_VERSION_1_3;

  VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  info.pApplicationInfo = &app;
  if (options.validation) {
    layers.push_back(kValidationLayer);
    extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    info.pNext = &validation;
  }
  info.enabledLayerCount = static_cast<uint32_t>(layers.size());
  info.ppEnabledLayerNames = layers.data();
  info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  if (VkResult result = vkCreateInstance(&info, nullptr, &instance->handle_); result != VK_SUCCESS) {
    return Error{std::string("cannot create a Vulkan instance: ") + result_name(result) +
                 "; if no driver is installed, " +
                 driver_advice([](const char* name) { return std::getenv(name); })};
  }

  if (options.validation) {
    auto create_messenger = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance->handle_, "vkCreateDebugUtilsMessengerEXT"));
    FIRE3DV_VK(create_messenger(instance->handle_, &messenger, nullptr, &instance->messenger_));
  }
  return instance;
}

Instance::~Instance() {
  if (messenger_) {
    auto destroy_messenger = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(handle_, "vkDestroyDebugUtilsMessengerEXT"));
    destroy_messenger(handle_, messenger_, nullptr);
  }
  if (handle_) vkDestroyInstance(handle_, nullptr);
}

VkBool32 Instance::on_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                              const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
  const std::string_view id = data->pMessageIdName ? data->pMessageIdName : "";
  for (const ValidationException& exception : kValidationExceptions) {
    if (id == exception.message_id) return VK_FALSE;
  }
  static_cast<Instance*>(user)->validation_messages_++;
  std::fprintf(stderr, "fire3dv: error: Vulkan validation: %s\n", data->pMessage);
  return VK_FALSE;
}

}  // namespace fire3dv::gpu
