#include "renderer/window/window.h"

#include <algorithm>
#include <cstdlib>

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

int windows_open = 0;  // the last one terminates GLFW

std::string glfw_error() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "unknown reason";
}

}  // namespace

Result<std::unique_ptr<Window>> Window::open(const std::string& title, VkExtent2D size, Present present) {
  const auto no_window = [] {
    return Error{"cannot open a window: " + glfw_error() +
                 "; without a display, use --headless --frames 1 --out DIR"};
  };
#ifdef GLFW_PLATFORM  // since GLFW 3.4
  // Without these variables libwayland cannot connect, and prints a line of its own.
  const bool can_have_wayland = std::getenv("WAYLAND_DISPLAY") || std::getenv("XDG_RUNTIME_DIR");
  glfwInitHint(GLFW_PLATFORM, can_have_wayland ? GLFW_ANY_PLATFORM : GLFW_PLATFORM_X11);
#endif
  if (!glfwInit()) return no_window();
  ++windows_open;
  std::unique_ptr<Window> window(new Window);
  window->present_ = present;
  glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
  // The desktop finds the icon by these names (cmake/package/desktop).
  glfwWindowHintString(GLFW_X11_CLASS_NAME, "fire3dv");
  glfwWindowHintString(GLFW_X11_INSTANCE_NAME, "fire3dv");
#ifdef GLFW_WAYLAND_APP_ID  // since GLFW 3.4
  glfwWindowHintString(GLFW_WAYLAND_APP_ID, "fire3dv");
#endif
  window->window_ = glfwCreateWindow(static_cast<int>(size.width), static_cast<int>(size.height),
                                     title.c_str(), nullptr, nullptr);
  if (!window->window_) return no_window();
  GLFWwindow* const glfw = window->window_;
  glfwSetWindowUserPointer(glfw, window.get());
  glfwGetCursorPos(glfw, &window->cursor_x_, &window->cursor_y_);
  glfwSetInputMode(glfw, GLFW_LOCK_KEY_MODS, GLFW_FALSE);
  glfwSetCursorPosCallback(glfw, [](GLFWwindow* w, double x, double y) { self(w)->on_cursor(x, y); });
  glfwSetMouseButtonCallback(glfw, [](GLFWwindow* w, int button, int action, int) {
    if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
    InputEvent event{.kind = InputEvent::Kind::button, .down = action == GLFW_PRESS};
    event.button = static_cast<Button>(button);
    self(w)->add_event(event);
  });
  glfwSetScrollCallback(glfw, [](GLFWwindow* w, double x, double y) {
    self(w)->add_event({.kind = InputEvent::Kind::wheel, .wheel = glm::vec2(x, y)});
  });
  glfwSetKeyCallback(glfw,
                     [](GLFWwindow* w, int key, int, int action, int) { self(w)->on_key(key, action); });
  glfwSetCharCallback(glfw, [](GLFWwindow* w, unsigned int text) {
    self(w)->add_event({.kind = InputEvent::Kind::text, .text = text});
  });
  glfwSetWindowFocusCallback(glfw, [](GLFWwindow* w, int focused) {
    self(w)->add_event({.kind = InputEvent::Kind::focus, .down = focused != 0});
  });
  glfwSetCursorEnterCallback(glfw, [](GLFWwindow* w, int entered) {
    if (!entered) self(w)->add_event({.kind = InputEvent::Kind::leave});
  });
  glfwSetDropCallback(glfw, [](GLFWwindow* w, int count, const char** paths) {
    self(w)->input_.dropped.assign(paths, paths + count);
    self(w)->is_active_ = true;
  });
  glfwSetFramebufferSizeCallback(
      glfw, [](GLFWwindow* w, int, int) { self(w)->stale_ = self(w)->is_active_ = true; });
  glfwSetWindowCloseCallback(glfw, [](GLFWwindow* w) { self(w)->is_active_ = true; });
  glfwSetWindowRefreshCallback(glfw, [](GLFWwindow* w) { self(w)->is_active_ = true; });
  return window;
}

Window::~Window() {
  detach();
  for (GLFWcursor* cursor : cursors_) {
    if (cursor) glfwDestroyCursor(cursor);
  }
  if (window_) glfwDestroyWindow(window_);
  if (--windows_open == 0) glfwTerminate();
}

std::vector<const char*> Window::instance_extensions() const {
  uint32_t count = 0;
  const char** names = glfwGetRequiredInstanceExtensions(&count);
  return {names, names + count};
}

Result<void> Window::attach(gpu::Instance& instance, gpu::Device& device) {
  instance_ = instance.handle();
  device_ = &device;
  if (Result<void> created = create_surface(); !created) return created;
  for (gpu::Semaphore& semaphore : acquired_) semaphore = create_semaphore(device);
  return {};
}

Result<void> Window::create_surface() {
  if (glfwCreateWindowSurface(instance_, window_, nullptr, &surface_) != VK_SUCCESS) {
    return Error{"cannot draw to the window with Vulkan: " + glfw_error() + "; use --headless"};
  }
  VkBool32 supported = VK_FALSE;
  vkGetPhysicalDeviceSurfaceSupportKHR(device_->physical(), device_->queue_family(), surface_, &supported);
  if (!supported) {
    return Error{device_->report().name +
                 " cannot present to this display; choose another with --device, or --headless"};
  }
  return {};
}

void Window::detach() {
  if (!device_) return;
  lose_surface();
  for (gpu::Semaphore& semaphore : acquired_) semaphore.reset();
  device_ = nullptr;
}

void Window::lose_surface() {
  device_->wait(device_->last_submitted());
  vkQueueWaitIdle(device_->queue());  // presentations have no fence; not called per frame
  rendered_.clear();
  images_.clear();
  // The surface must outlive the swapchain, so the swapchain is destroyed now instead of retired.
  if (swapchain_) {
    swapchain_.reset();
    device_->retire_all_now();
  }
  if (surface_) vkDestroySurfaceKHR(instance_, surface_, nullptr);
  surface_ = VK_NULL_HANDLE;
  stale_ = true;
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
void Window::keep_open() {
  glfwSetWindowShouldClose(window_, GLFW_FALSE);
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

float Window::scale() const {
  float x = 1, y = 1;
  glfwGetWindowContentScale(window_, &x, &y);
  return std::clamp(std::max(x, y), 0.5f, 8.0f);
}

// Cursor positions are in screen coordinates, which differ from pixels on some displays.
void Window::add_event(InputEvent event) {
  is_active_ = true;
  const bool is_press = event.kind == InputEvent::Kind::button || event.kind == InputEvent::Kind::key;
  if (is_press && !event.repeated) held_ = std::max(held_ + (event.down ? 1 : -1), 0);
  if (event.kind == InputEvent::Kind::focus && !event.down) held_ = 0;  // releases go elsewhere
  int width = 0, height = 0;
  glfwGetWindowSize(window_, &width, &height);
  const VkExtent2D extent = framebuffer_extent();
  if (width > 0 && height > 0)
    event.cursor_px = glm::vec2(cursor_x_ * extent.width / width, cursor_y_ * extent.height / height);
  const auto held = [&](int left, int right) {
    return glfwGetKey(window_, left) == GLFW_PRESS || glfwGetKey(window_, right) == GLFW_PRESS;
  };
  event.modifiers = {
      held(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT), held(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL),
      held(GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT), held(GLFW_KEY_LEFT_SUPER, GLFW_KEY_RIGHT_SUPER)};
  input_.events.push_back(event);
}

// Stores the position of the event instead of the current one: frames may be slow.
void Window::on_cursor(double x, double y) {
  cursor_x_ = x;
  cursor_y_ = y;
  add_event({});
}

void Window::on_key(int key, int action) {
  add_event({.kind = InputEvent::Kind::key,
             .key = key_of(key),
             .down = action != GLFW_RELEASE,
             .repeated = action == GLFW_REPEAT});
}

WindowInput Window::take_input() {
  input_.scale = scale();
  return std::exchange(input_, {});
}

void Window::set_cursor(Cursor cursor) {
  if (cursor == cursor_) return;
  cursor_ = cursor;
  constexpr std::array kShapes = {GLFW_ARROW_CURSOR, GLFW_IBEAM_CURSOR, GLFW_HRESIZE_CURSOR,
                                  GLFW_VRESIZE_CURSOR, GLFW_HAND_CURSOR};
  GLFWcursor*& made = cursors_[static_cast<size_t>(cursor)];
  if (!made) made = glfwCreateStandardCursor(kShapes[static_cast<size_t>(cursor)]);
  glfwSetCursor(window_, made);
}

std::string Window::clipboard() {
  const char* const text = glfwGetClipboardString(nullptr);
  return text ? text : "";
}

void Window::set_clipboard(const std::string& text) {
  glfwSetClipboardString(nullptr, text.c_str());
}

VkPresentModeKHR Window::present_mode() {
  if (present_ == Present::vsync) return VK_PRESENT_MODE_FIFO_KHR;
  const bool mailbox = present_ == Present::mailbox;
  const VkPresentModeKHR wanted = mailbox ? VK_PRESENT_MODE_MAILBOX_KHR : VK_PRESENT_MODE_IMMEDIATE_KHR;
  uint32_t count = 0;
  vkGetPhysicalDeviceSurfacePresentModesKHR(device_->physical(), surface_, &count, nullptr);
  std::vector<VkPresentModeKHR> modes(count);
  vkGetPhysicalDeviceSurfacePresentModesKHR(device_->physical(), surface_, &count, modes.data());
  modes.resize(count);
  if (std::find(modes.begin(), modes.end(), wanted) != modes.end()) return wanted;
  note_ = std::string("this display has no --present ") + (mailbox ? "mailbox" : "immediate") +
          "; images are shown in step with it";
  present_ = Present::vsync;
  return VK_PRESENT_MODE_FIFO_KHR;
}

bool Window::create_swapchain() {
  VkSurfaceCapabilitiesKHR capabilities{};
  const VkResult found =
      vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_->physical(), surface_, &capabilities);
  if (is_surface_lost(found)) return false;
  gpu::check(found, "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
  VkExtent2D extent = capabilities.currentExtent;
  if (extent.width == UINT32_MAX) extent = framebuffer_extent();  // the swapchain defines the surface size
  extent.width =
      std::clamp(extent.width, capabilities.minImageExtent.width, capabilities.maxImageExtent.width);
  extent.height =
      std::clamp(extent.height, capabilities.minImageExtent.height, capabilities.maxImageExtent.height);
  if (extent.width == 0 || extent.height == 0) return false;  // minimised since the last check

  uint32_t count = 0;
  vkGetPhysicalDeviceSurfaceFormatsKHR(device_->physical(), surface_, &count, nullptr);
  std::vector<VkSurfaceFormatKHR> formats(count);
  vkGetPhysicalDeviceSurfaceFormatsKHR(device_->physical(), surface_, &count, formats.data());
  VkSurfaceFormatKHR format = formats.front();
  for (const VkSurfaceFormatKHR& candidate : formats) {
    // UNORM, not SRGB: the image is sRGB-encoded already.
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
  info.presentMode = present_mode();
  info.clipped = VK_TRUE;
  info.oldSwapchain = old.get();
  VkSwapchainKHR swapchain = VK_NULL_HANDLE;
  const VkResult created = vkCreateSwapchainKHR(device_->handle(), &info, nullptr, &swapchain);
  if (is_surface_lost(created)) return false;
  gpu::check(created, "vkCreateSwapchainKHR");
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

// Times out, since a hidden window may get no image and a display may lose its surface; adapters must not
// wait.
bool Window::acquire(uint64_t patience_ns) {
  if (minimized()) return false;
  if (surfaces_lost_ > 0 && surface_ == VK_NULL_HANDLE) {
    if (Result<void> created = create_surface(); !created) {
      gpu::check(VK_ERROR_SURFACE_LOST_KHR, created.error().message.c_str());
    }
  }
  if (stale_ && !create_swapchain()) return false;
  const uint32_t slot = (acquire_slot_ + 1) % static_cast<uint32_t>(acquired_.size());
  const VkResult result = vkAcquireNextImageKHR(device_->handle(), swapchain_.get(), patience_ns,
                                                acquired_[slot].get(), VK_NULL_HANDLE, &image_index_);
  if (result == VK_TIMEOUT || result == VK_NOT_READY) return false;
  if (result == VK_ERROR_OUT_OF_DATE_KHR) {
    stale_ = true;
    return false;
  }
  if (is_surface_lost(result)) return false;
  gpu::check(result, "vkAcquireNextImageKHR");
  surfaces_lost_ = 0;
  acquire_slot_ = slot;
  if (result == VK_SUBOPTIMAL_KHR) stale_ = true;
  return true;
}

void Window::record(gpu::Recorder& recorder, gpu::Image& image, uint32_t column, uint32_t columns) {
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
    if (column == 0) {
      barrier(0, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
              VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    }
    // vkCmdBlitImage instead of a copy, since it converts the channel order.
    VkImageBlit blit{};
    blit.srcSubresource = blit.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    blit.srcOffsets[1] = {static_cast<int32_t>(image.extent.width), static_cast<int32_t>(image.extent.height),
                          1};
    blit.dstOffsets[0] = {static_cast<int32_t>(swapchain_extent_.width * column / columns), 0, 0};
    blit.dstOffsets[1] = {static_cast<int32_t>(swapchain_extent_.width * (column + 1) / columns),
                          static_cast<int32_t>(swapchain_extent_.height), 1};
    vkCmdBlitImage(commands, image.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, images_[image_index_],
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &blit, VK_FILTER_NEAREST);
    if (column + 1 == columns) {
      barrier(VK_ACCESS_2_TRANSFER_WRITE_BIT, 0, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
              VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
    }
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
  } else if (!is_surface_lost(result)) {
    gpu::check(result, "vkQueuePresentKHR");
  }
}

// Recreates a lost surface; fails if each new surface is lost, too.
bool Window::is_surface_lost(VkResult result) {
  if (result != VK_ERROR_SURFACE_LOST_KHR) return false;
  constexpr uint32_t kMaxInARow = 10;
  if (++surfaces_lost_ > kMaxInARow) gpu::check(result, "the window's surface");
  lose_surface();
  return true;
}

}  // namespace fire3dv::sinks
