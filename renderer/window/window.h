// Application window: GLFW window, input events and Vulkan swapchain. Main thread only, as GLFW requires. No
// other file uses GLFW.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/window/present.h"
#include "renderer/window/window_input.h"

struct GLFWwindow;
struct GLFWcursor;

namespace fire3dv::sinks {

class Window {
 public:
  // Opens a window; requires a display. The error names the headless alternative.
  static Result<std::unique_ptr<Window>> open(const std::string& title, VkExtent2D size,
                                              Present present = Present::vsync);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  std::vector<const char*> instance_extensions() const;
  Result<void> attach(gpu::Instance& instance, gpu::Device& device);
  void detach();  // must precede the device's destruction

  static void poll_events();  // of all windows
  static void wait_events(double timeout_s);
  bool should_close() const;
  void keep_open();  // takes back the request to close it
  bool minimized() const;
  VkExtent2D framebuffer_extent() const;
  float scale() const;  // content scale of panels and text: 1 on a standard-density display
  WindowInput take_input();
  // True if there was input since the last call, the window's size or contents changed, it is to be closed,
  // or a key or button is held down. Independent of take_input().
  bool take_activity() { return std::exchange(is_active_, false) || held_ > 0; }
  enum class Cursor : uint8_t { arrow, text, resize_x, resize_y, hand };
  void set_cursor(Cursor cursor);
  static std::string clipboard();
  static void set_clipboard(const std::string& text);

  // Message about an unsupported presentation mode, available after the first acquire().
  std::optional<std::string> take_note() { return std::exchange(note_, std::nullopt); }

  // Called once per frame, in this order. acquire() returns false if no swapchain image is available within
  // patience_ns.
  bool acquire(uint64_t patience_ns = 100'000'000);
  // `columns` images share the window's width; each is recorded before the next is rendered.
  void record(gpu::Recorder& recorder, gpu::Image& image, uint32_t column = 0, uint32_t columns = 1);
  std::array<gpu::SemaphoreSignal, 1> waits() const;
  std::array<gpu::SemaphoreSignal, 1> signals() const;
  void present();

 private:
  Window() = default;
  Result<void> create_surface();
  bool create_swapchain();  // false: there is nothing to present to now
  VkPresentModeKHR present_mode();
  void lose_surface();
  bool is_surface_lost(VkResult result);  // then the next acquire() recreates it
  void add_event(InputEvent event);
  void on_cursor(double x, double y);
  void on_key(int key, int action);

  GLFWwindow* window_ = nullptr;
  Present present_ = Present::vsync;
  VkInstance instance_ = VK_NULL_HANDLE;
  gpu::Device* device_ = nullptr;
  VkSurfaceKHR surface_ = VK_NULL_HANDLE;
  gpu::SwapchainHandle swapchain_;
  VkExtent2D swapchain_extent_{};
  std::vector<VkImage> images_;
  std::vector<gpu::Semaphore> rendered_;  // per swapchain image: its presentation may still wait on it
  // kFramesInFlight + 1: an image is acquired before its frame waits for the last use of its slot.
  std::array<gpu::Semaphore, gpu::kFramesInFlight + 1> acquired_;
  uint32_t acquire_slot_ = 0;
  uint32_t image_index_ = 0;
  bool stale_ = true;
  uint32_t surfaces_lost_ = 0;  // consecutive
  std::optional<std::string> note_;
  WindowInput input_;
  bool is_active_ = true;
  int held_ = 0;  // keys and buttons
  std::array<GLFWcursor*, 5> cursors_{};
  Cursor cursor_ = Cursor::arrow;
  double cursor_x_ = 0, cursor_y_ = 0;  // of the last event, in screen coordinates
};

}  // namespace fire3dv::sinks
