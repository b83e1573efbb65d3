// A window that shows finished images: GLFW for the window and its input, a swapchain for the images. Used
// from the main thread only, as GLFW wants it. No other file touches GLFW.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/gpu/frame_ring.h"

struct GLFWwindow;

namespace fire3dv::sinks {

// What the user did since the last call of Window::take_input().
struct WindowInput {
  glm::vec2 orbit_px{0}, pan_px{0};
  float scroll = 0;
  glm::vec3 fly{0};              // -1, 0 or 1 along the camera's x, y, z while keys are held
  std::optional<size_t> camera;  // number key
  bool frame_all = false;
};

class Window {
 public:
  // Opens the window; needs a display. The error says what to do without one.
  static Result<std::unique_ptr<Window>> open(const std::string& title, VkExtent2D size);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  std::vector<const char*> instance_extensions() const;
  Result<void> attach(gpu::Instance& instance, gpu::Device& device);
  void detach();  // before the device goes

  void poll_events();
  void wait_events(double timeout_s);
  bool should_close() const;
  bool minimized() const;
  VkExtent2D framebuffer_extent() const;
  WindowInput take_input();
  void set_title(const std::string& title);

  // Once per frame, in this order. acquire() returns false when there is nothing to draw on now.
  bool acquire();
  void record(gpu::Recorder& recorder, gpu::Image& image);
  std::array<gpu::SemaphoreSignal, 1> waits() const;
  std::array<gpu::SemaphoreSignal, 1> signals() const;
  void present();

 private:
  Window() = default;
  bool create_swapchain();  // false: there is no room to show anything now
  void on_cursor(double x, double y);

  GLFWwindow* window_ = nullptr;
  VkInstance instance_ = VK_NULL_HANDLE;
  gpu::Device* device_ = nullptr;
  VkSurfaceKHR surface_ = VK_NULL_HANDLE;
  gpu::SwapchainHandle swapchain_;
  VkExtent2D swapchain_extent_{};
  std::vector<VkImage> images_;
  std::vector<gpu::Semaphore> rendered_;  // per swapchain image: its presentation may still wait on it
  // One more than frames in flight: an image is acquired before its frame waits for the slot's last one.
  std::array<gpu::Semaphore, gpu::kFramesInFlight + 1> acquired_;
  uint32_t acquire_slot_ = 0;
  uint32_t image_index_ = 0;
  bool stale_ = true;
  WindowInput input_;
  double cursor_x_ = 0, cursor_y_ = 0;
};

}  // namespace fire3dv::sinks
