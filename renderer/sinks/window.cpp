#include "renderer/sinks/window.h"

#include <algorithm>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace fire3dv::sinks {
namespace {

Window* self(GLFWwindow* window) {
  return static_cast<Window*>(glfwGetWindowUserPointer(window));
}

gpu::Semaphore create_semaphore(gpu::Device& device) {
  VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
  VkSemaphore semaphore = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateSemaphore(device.handle(), &info, nullptr, &semaphore));
  return gpu::Semaphore(device, semaphore);
}

std::string glfw_error() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "unknown reason";
}

}  // namespace

Result<std::unique_ptr<Window>> Window::open(const std::string& title, VkExtent2D size) {
  if (!glfwInit()) {
    return Error{"cannot open a window: " + glfw_error() + "; without a display, use --headless --out DIR"};
  }
  std::unique_ptr<Window> window(new Window);
  glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
  window->window_ = glfwCreateWindow(static_cast<int>(size.width), static_cast<int>(size.height),
                                     title.c_str(), nullptr, nullptr);
  if (!window->window_) {
    return Error{"cannot open a window: " + glfw_error() + "; without a display, use --headless --out DIR"};
  }
  glfwSetWindowUserPointer(window->window_, window.get());
  glfwGetCursorPos(window->window_, &window->cursor_x_, &window->cursor_y_);
  glfwSetCursorPosCallback(window->window_,
                           [](GLFWwindow* w, double x, double y) { self(w)->on_cursor(x, y); });
  glfwSetScrollCallback(window->window_, [](GLFWwindow* w, double, double y) {
    self(w)->input_.scroll += static_cast<float>(y);
  });
  glfwSetFramebufferSizeCallback(window->window_, [](GLFWwindow* w, int, int) { self(w)->stale_ = true; });
  glfwSetKeyCallback(window->window_, [](GLFWwindow* w, int key, int, int action, int) {
    if (action != GLFW_PRESS) return;
    if (key >= GLFW_KEY_1 && key <= GLFW_KEY_9)
      self(w)->input_.camera = static_cast<size_t>(key - GLFW_KEY_1);
    if (key == GLFW_KEY_F) self(w)->input_.frame_all = true;
    if (key == GLFW_KEY_ESCAPE) glfwSetWindowShouldClose(w, GLFW_TRUE);
  });
  return window;
}

Window::~Window() {
  detach();
  if (window_) glfwDestroyWindow(window_);
  glfwTerminate();
}

std::vector<const char*> Window::instance_extensions() const {
  uint32_t count = 0;
  const char** names = glfwGetRequiredInstanceExtensions(&count);
  return {names, names + count};
}

Result<void> Window::attach(gpu::Instance& instance, gpu::Device& device) {
  instance_ = instance.handle();
  device_ = &device;
  if (glfwCreateWindowSurface(instance_, window_, nullptr, &surface_) != VK_SUCCESS) {
    return Error{"cannot draw to the window with Vulkan: " + glfw_error() + "; use --headless"};
  }
  VkBool32 supported = VK_FALSE;
  vkGetPhysicalDeviceSurfaceSupportKHR(device.physical(), device.queue_family(), surface_, &supported);
  if (!supported) {
    return Error{device.report().name +
                 " cannot present to this display; choose another with --device, or --headless"};
  }
  for (gpu::Semaphore& semaphore : acquired_) semaphore = create_semaphore(device);
  return {};
}

void Window::detach() {
  if (!device_) return;
  device_->wait(device_->last_submitted());
  vkQueueWaitIdle(
      device_->queue());  // presentations have no other sign of being over; this is the end of the window
  rendered_.clear();
  for (gpu::Semaphore& semaphore : acquired_) semaphore.reset();
  // The surface must outlive the swapchain, so this one object is not left to retirement.
  if (swapchain_) {
    swapchain_.reset();
    device_->retire_all_now();
  }
  if (surface_) vkDestroySurfaceKHR(instance_, surface_, nullptr);
  surface_ = VK_NULL_HANDLE;
  device_ = nullptr;
}

void Window::poll_events() {
  glfwPollEvents();
}
void Window::wait_events(double timeout_s) {
  glfwWaitEventsTimeout(timeout_s);
}
bool Window::should_close() const {
  return glfwWindowShouldClose(window_);
}
void Window::set_title(const std::string& title) {
  glfwSetWindowTitle(window_, title.c_str());
}

VkExtent2D Window::framebuffer_extent() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  return {static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
}

bool Window::minimized() const {
  const VkExtent2D extent = framebuffer_extent();
  return extent.width == 0 || extent.height == 0 || glfwGetWindowAttrib(window_, GLFW_ICONIFIED);
}

void Window::on_cursor(double x, double y) {
  const glm::vec2 moved(x - cursor_x_, y - cursor_y_);
  cursor_x_ = x;
  cursor_y_ = y;
  const bool left = glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS;
  const bool right = glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_RIGHT) == GLFW_PRESS;
  const bool middle = glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_MIDDLE) == GLFW_PRESS;
  const bool shift = glfwGetKey(window_, GLFW_KEY_LEFT_SHIFT) == GLFW_PRESS;
  if (right || middle || (left && shift)) {
    input_.pan_px += moved;
  } else if (left) {
    input_.orbit_px += moved;
  }
}

WindowInput Window::take_input() {
  auto axis = [&](int plus, int minus) {
    return static_cast<float>(glfwGetKey(window_, plus) == GLFW_PRESS) -
           static_cast<float>(glfwGetKey(window_, minus) == GLFW_PRESS);
  };
  input_.fly = {axis(GLFW_KEY_D, GLFW_KEY_A), axis(GLFW_KEY_E, GLFW_KEY_Q), axis(GLFW_KEY_S, GLFW_KEY_W)};
  return std::exchange(input_, {});
}

bool Window::create_swapchain() {
  VkSurfaceCapabilitiesKHR capabilities{};
  FIRE3DV_VK(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_->physical(), surface_, &capabilities));
  VkExtent2D extent = capabilities.currentExtent;
  if (extent.width == UINT32_MAX) extent = framebuffer_extent();  // the surface takes the swapchain's size
  extent.width =
      std::clamp(extent.width, capabilities.minImageExtent.width, capabilities.maxImageExtent.width);
  extent.height =
      std::clamp(extent.height, capabilities.minImageExtent.height, capabilities.maxImageExtent.height);
  if (extent.width == 0 || extent.height == 0) return false;  // minimised just now

  uint32_t count = 0;
  vkGetPhysicalDeviceSurfaceFormatsKHR(device_->physical(), surface_, &count, nullptr);
  std::vector<VkSurfaceFormatKHR> formats(count);
  vkGetPhysicalDeviceSurfaceFormatsKHR(device_->physical(), surface_, &count, formats.data());
  VkSurfaceFormatKHR format = formats.front();
  for (const VkSurfaceFormatKHR& candidate : formats) {
    // The image is encoded already, so the format must not encode it again.
    if (candidate.format == VK_FORMAT_B8G8R8A8_UNORM || candidate.format == VK_FORMAT_R8G8B8A8_UNORM) {
      format = candidate;
      break;
    }
  }

  gpu::SwapchainHandle old = std::move(swapchain_);
  VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
  info.surface = surface_;
  info.minImageCount = capabilities.maxImageCount
                           ? std::min(capabilities.minImageCount + 1, capabilities.maxImageCount)
                           : capabilities.minImageCount + 1;
  info.imageFormat = format.format;
  info.imageColorSpace = format.colorSpace;
  info.imageExtent = extent;
  info.imageArrayLayers = 1;
  info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  info.preTransform = capabilities.currentTransform;
  info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
  info.presentMode = VK_PRESENT_MODE_FIFO_KHR;
  info.clipped = VK_TRUE;
  info.oldSwapchain = old.get();
  VkSwapchainKHR swapchain = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateSwapchainKHR(device_->handle(), &info, nullptr, &swapchain));
  swapchain_ = gpu::SwapchainHandle(*device_, swapchain);
  swapchain_extent_ = extent;

  FIRE3DV_VK(vkGetSwapchainImagesKHR(device_->handle(), swapchain, &count, nullptr));
  images_.resize(count);
  FIRE3DV_VK(vkGetSwapchainImagesKHR(device_->handle(), swapchain, &count, images_.data()));
  rendered_.clear();
  for (uint32_t i = 0; i < count; ++i) rendered_.push_back(create_semaphore(*device_));
  stale_ = false;
  return true;
}

bool Window::acquire() {
  if (minimized()) return false;
  if (stale_ && !create_swapchain()) return false;
  const uint32_t slot = (acquire_slot_ + 1) % static_cast<uint32_t>(acquired_.size());
  constexpr uint64_t kPatienceNs =
      100'000'000;  // a hidden window may get no image; adapters must not wait for it
  const VkResult result = vkAcquireNextImageKHR(device_->handle(), swapchain_.get(), kPatienceNs,
                                                acquired_[slot].get(), VK_NULL_HANDLE, &image_index_);
  if (result == VK_TIMEOUT || result == VK_NOT_READY) return false;
  if (result == VK_ERROR_OUT_OF_DATE_KHR) {
    stale_ = true;
    return false;
  }
  gpu::check(result, "vkAcquireNextImageKHR");
  acquire_slot_ = slot;
  if (result == VK_SUBOPTIMAL_KHR) stale_ = true;
  return true;
}

void Window::record(gpu::Recorder& recorder, gpu::Image& image) {
  recorder.pass("window", {gpu::Use(image, gpu::access::transfer_read)}, [&](VkCommandBuffer commands) {
    auto barrier = [&](VkAccessFlags2 src, VkAccessFlags2 dst, VkImageLayout from, VkImageLayout to) {
      VkImageMemoryBarrier2 b{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
      b.srcStageMask = b.dstStageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
      b.srcAccessMask = src;
      b.dstAccessMask = dst;
      b.oldLayout = from;
      b.newLayout = to;
      b.srcQueueFamilyIndex = b.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
      b.image = images_[image_index_];
      b.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
      VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
      info.imageMemoryBarrierCount = 1;
      info.pImageMemoryBarriers = &b;
      vkCmdPipelineBarrier2(commands, &info);
    };
    barrier(0, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
            VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    // A blit and not a copy: it converts the order of the channels.
    VkImageBlit blit{};
    blit.srcSubresource = blit.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    blit.srcOffsets[1] = {static_cast<int32_t>(image.extent.width), static_cast<int32_t>(image.extent.height),
                          1};
    blit.dstOffsets[1] = {static_cast<int32_t>(swapchain_extent_.width),
                          static_cast<int32_t>(swapchain_extent_.height), 1};
    vkCmdBlitImage(commands, image.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, images_[image_index_],
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &blit, VK_FILTER_NEAREST);
    barrier(VK_ACCESS_2_TRANSFER_WRITE_BIT, 0, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
            VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
  });
}

std::array<gpu::SemaphoreSignal, 1> Window::waits() const {
  return {{{acquired_[acquire_slot_].get(), VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT}}};
}

std::array<gpu::SemaphoreSignal, 1> Window::signals() const {
  return {{{rendered_[image_index_].get(), VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT}}};
}

void Window::present() {
  const VkSemaphore rendered = rendered_[image_index_].get();
  const VkSwapchainKHR swapchain = swapchain_.get();
  VkPresentInfoKHR info{VK_STRUCTURE_TYPE_PRESENT_INFO_KHR};
  info.waitSemaphoreCount = 1;
  info.pWaitSemaphores = &rendered;
  info.swapchainCount = 1;
  info.pSwapchains = &swapchain;
  info.pImageIndices = &image_index_;
  const VkResult result = vkQueuePresentKHR(device_->queue(), &info);
  if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_SUBOPTIMAL_KHR) {
    stale_ = true;
  } else {
    gpu::check(result, "vkQueuePresentKHR");
  }
}

}  // namespace fire3dv::sinks
