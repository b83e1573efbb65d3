// A current OpenGL context without a window or a display, for MuJoCo's renderer.
#pragma once

#include <string>

#include "protocol/error.h"

namespace fire3dv::mujoco {

class EglContext {
 public:
  // On Mesa's surfaceless platform: a GPU's driver where Mesa has one, else its software renderer.
  static Result<EglContext> open();
  ~EglContext();
  EglContext(EglContext&& other) noexcept;
  EglContext& operator=(EglContext&&) = delete;

  // What draws, as OpenGL calls it.
  std::string renderer() const;

 private:
  EglContext(void* display, void* context) : display_(display), context_(context) {}
  void* display_;
  void* context_;
};

}  // namespace fire3dv::mujoco
