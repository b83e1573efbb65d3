// Current OpenGL context without window or display (EGL), for MuJoCo's renderer. Owned by one thread.
#pragma once

#include <string>

#include "protocol/base/error.h"

namespace fire3dv::mujoco {

class EglContext {
 public:
  // Uses Mesa's surfaceless platform: a hardware driver where Mesa has one, else its software renderer.
  static Result<EglContext> open();
  ~EglContext();
  EglContext(EglContext&& other) noexcept;
  EglContext& operator=(EglContext&&) = delete;

  // Returns GL_RENDERER.
  std::string renderer() const;

 private:
  EglContext(void* display, void* context) : display_(display), context_(context) {}
  void* display_;
  void* context_;
};

}  // namespace fire3dv::mujoco
