// A window that shows finished images: GLFW for the window and its input, a swapchain for the images. Used
// from the main thread only, as GLFW wants it. No other file touches GLFW.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/error.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/sinks/window_input.h"

struct GLFWwindow;
struct GLFWcursor;

namespace fire3dv::sinks {

// When a finished image is shown.
enum class Present : uint8_t {
  vsync,      // at the display's pace: each image, in its turn
  mailbox,    // at the display's pace: the newest image
  immediate,  // at once, which may tear
};

class Window {
 public:
  // Opens the window; needs a display. The error says what to do without one.
  static Result<std::unique_ptr<Window>> open(const std::string& title, VkExtent2D size,
                                              Present present = Present::vsync);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  std::vector<const char*> instance_extensions() const;
  Result<void> attach(gpu::Instance& instance, gpu::Device& device);
  void detach();  // before the device goes

  static void poll_events();  // of all windows
  static void wait_events(double timeout_s);
  bool should_close() const;
  bool minimized() const;
  VkExtent2D framebuffer_extent() const;
  float scale() const;  // of panels and texts: pixels for one of a display of usual density
  WindowInput take_input();
  void set_title(const std::string& title);
  enum class Cursor : uint8_t { arrow, text, resize_x, resize_y, hand };
  void set_cursor(Cursor cursor);
  static std::string clipboard();
  static void set_clipboard(const std::string& text);

  // What the window can do of what was wanted, after the first acquire(); a sentence where that is less.
  std::optional<std::string> take_note() { return std::exchange(note_, std::nullopt); }

  // Once per frame, in this order. acquire() returns false when there is nothing to draw on now; it waits so
  // long for that to change.
  bool acquire(uint64_t patience_ns = 100'000'000);
  // Several images share the window's width evenly; each is recorded before the next one is drawn.
  void record(gpu::Recorder& recorder, gpu::Image& image, uint32_t column = 0, uint32_t columns = 1);
  std::array<gpu::SemaphoreSignal, 1> waits() const;
  std::array<gpu::SemaphoreSignal, 1> signals() const;
  void present();

 private:
  Window() = default;
  Result<void> create_surface();
  bool create_swapchain();  // false: there is no room to show anything now
  VkPresentModeKHR present_mode();
  void lose_surface();
  bool is_surface_lost(VkResult result);  // then a new one is made with the next acquire()
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
  // One more than frames in flight: an image is acquired before its frame waits for the slot's last one.
  std::array<gpu::Semaphore, gpu::kFramesInFlight + 1> acquired_;
  uint32_t acquire_slot_ = 0;
  uint32_t image_index_ = 0;
  bool stale_ = true;
  uint32_t surfaces_lost_ = 0;  // in a row
  std::optional<std::string> note_;
  WindowInput input_;
  std::array<GLFWcursor*, 5> cursors_{};
  Cursor cursor_ = Cursor::arrow;
  double cursor_x_ = 0, cursor_y_ = 0;  // of the last event, in the display's coordinates
};

}  // namespace fire3dv::sinks
