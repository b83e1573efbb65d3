#include "adapters/mujoco/compare/mujoco_renderer.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <algorithm>
#include <limits>
#include <utility>

namespace fire3dv::mujoco {

Result<EglContext> EglContext::open() {
  const auto display_of =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  if (!display_of) return Error{"this EGL opens no platforms by name: Mesa's does (libegl-mesa0)"};
  EGLDisplay display = display_of(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr))
    return Error{"EGL has no display without a surface: Mesa's does (libegl-mesa0, libgl1-mesa-dri)"};
  const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  EGLContext context = EGL_NO_CONTEXT;
  if (eglBindAPI(EGL_OPENGL_API) && eglChooseConfig(display, wanted, &config, 1, &count) && count > 0)
    context = eglCreateContext(display, config, EGL_NO_CONTEXT, nullptr);
  if (context == EGL_NO_CONTEXT || !eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
    eglTerminate(display);
    return Error{"EGL makes no OpenGL context here"};
  }
  return EglContext(display, context);
}

EglContext::~EglContext() {
  if (!display_) return;
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
  eglTerminate(display_);
}

EglContext::EglContext(EglContext&& other) noexcept
    : display_(std::exchange(other.display_, nullptr)), context_(std::exchange(other.context_, nullptr)) {}

std::string EglContext::renderer() const {
  constexpr unsigned kRenderer = 0x1F01;  // GL_RENDERER
  const auto get_string =
      reinterpret_cast<const unsigned char* (*)(unsigned)>(eglGetProcAddress("glGetString"));
  const unsigned char* const text = get_string ? get_string(kRenderer) : nullptr;
  return text ? reinterpret_cast<const char*>(text) : "unknown";
}

namespace {

constexpr int kMaxGeoms = 20000;

}  // namespace

MujocoRenderer::MujocoRenderer(const MujocoView& view, convert::MjcfModel model)
    : view_(view), model_(std::move(model)) {
  mjModel& m = *model_;
  m.vis.global.offwidth = static_cast<int>(view.width);
  m.vis.global.offheight = static_cast<int>(view.height);
  m.vis.quality.offsamples = view.samples;
  m.vis.quality.shadowsize = view.shadow_texels;
  if (view.fine) {
    m.vis.quality.numslices = 256;
    m.vis.quality.numstacks = 128;
  }
  near_m_ = static_cast<float>(m.vis.map.znear * m.stat.extent);
  far_m_ = static_cast<float>(m.vis.map.zfar * m.stat.extent);
  color_.resize(size_t{3} * view.width * view.height);
  depth_.resize(size_t{1} * view.width * view.height);
}

Result<MujocoRenderer> MujocoRenderer::open(const mjModel& model, const MujocoView& view) {
  convert::MjcfModel copy(mj_copyModel(nullptr, &model), &mj_deleteModel);
  if (!copy) return Error{"MuJoCo has no memory for a copy of the model"};
  MujocoRenderer made(view, std::move(copy));
  const mjModel& m = *made.model_;
  const int fixed = mj_name2id(&m, mjOBJ_CAMERA, view.camera.c_str());
  if (fixed < 0 && view.camera != "free camera")
    return Error{"the model has no camera \"" + view.camera + "\""};
  const Result<void> done = convert::call_mujoco([&] {
    mjv_defaultOption(&made.option_);
    std::fill(std::begin(made.option_.sitegroup), std::end(made.option_.sitegroup), mjtByte{0});
    mjv_defaultScene(&made.scene_);
    mjr_defaultContext(&made.context_);
    mjv_makeScene(&m, &made.scene_, kMaxGeoms);
    mjr_makeContext(&m, &made.context_, mjFONTSCALE_50);
    mjr_setBuffer(mjFB_OFFSCREEN, &made.context_);
    mjv_defaultFreeCamera(&m, &made.camera_);
  });
  if (!done) return Error{"MuJoCo's renderer does not start: " + done.error().message};
  made.open_ = true;
  if (made.context_.currentBuffer != mjFB_OFFSCREEN) return Error{"MuJoCo made no offscreen framebuffer"};
  if (made.context_.offSamples != view.samples)
    return Error{"MuJoCo gave " + std::to_string(made.context_.offSamples) + " samples a pixel, not " +
                 std::to_string(view.samples)};
  if (fixed >= 0) {
    made.camera_.type = mjCAMERA_FIXED;
    made.camera_.fixedcamid = fixed;
  }
  made.scene_.flags[mjRND_SHADOW] = view.shadow_texels > 0;
  made.scene_.flags[mjRND_REFLECTION] = view.reflections;
  return made;
}

MujocoRenderer::~MujocoRenderer() {
  if (!open_) return;
  mjr_freeContext(&context_);
  mjv_freeScene(&scene_);
}

MujocoRenderer::MujocoRenderer(MujocoRenderer&& other) noexcept
    : view_(std::move(other.view_)),
      model_(std::move(other.model_)),
      open_(std::exchange(other.open_, false)),
      near_m_(other.near_m_),
      far_m_(other.far_m_),
      camera_(other.camera_),
      option_(other.option_),
      scene_(other.scene_),
      context_(other.context_),
      color_(std::move(other.color_)),
      depth_(std::move(other.depth_)) {}

Result<void> MujocoRenderer::draw(const mjData& data, bool labels) {
  return convert::call_mujoco([&] {
    scene_.flags[mjRND_SEGMENT] = labels;
    scene_.flags[mjRND_IDCOLOR] = labels;
    const mjrRect view{0, 0, static_cast<int>(view_.width), static_cast<int>(view_.height)};
    // The function takes non-const data but does not modify it.
    mjv_updateScene(model_.get(), const_cast<mjData*>(&data), &option_, nullptr, &camera_, mjCAT_ALL,
                    &scene_);
    mjr_render(view, &scene_, &context_);
    mjr_readPixels(color_.data(), labels ? nullptr : depth_.data(), view, &context_);
  });
}

Result<void> MujocoRenderer::draw_color_and_depth(const mjData& data) {
  return draw(data, false);
}

Result<void> MujocoRenderer::draw_labels(const mjData& data) {
  return draw(data, true);
}

std::vector<uint8_t> MujocoRenderer::upright_color() const {
  std::vector<uint8_t> upright;
  const size_t row = size_t{3} * view_.width;
  for (size_t y = view_.height; y-- > 0;)
    upright.insert(upright.end(), color_.begin() + static_cast<std::ptrdiff_t>(y * row),
                   color_.begin() + static_cast<std::ptrdiff_t>((y + 1) * row));
  return upright;
}

std::vector<uint32_t> MujocoRenderer::labels() const {
  std::vector<uint32_t> known(static_cast<size_t>(scene_.ngeom) + 1, kNoLabel);
  for (int i = 0; i < scene_.ngeom; ++i) {
    const mjvGeom& geom = scene_.geoms[i];
    if (geom.segid >= 0 && geom.segid < scene_.ngeom)
      known[static_cast<size_t>(geom.segid) + 1] = label_of(geom.objtype, geom.objid);
  }
  const std::vector<uint8_t> color = upright_color();
  std::vector<uint32_t> labels;
  for (size_t i = 0; i < color.size(); i += 3) {
    const uint32_t id =
        color[i] | static_cast<uint32_t>(color[i + 1]) << 8 | static_cast<uint32_t>(color[i + 2]) << 16;
    labels.push_back(id < known.size() ? known[id] : kNoLabel);
  }
  return labels;
}

std::vector<float> MujocoRenderer::depths_m() const {
  std::vector<float> depths;
  for (size_t y = view_.height; y-- > 0;) {
    for (size_t x = 0; x < view_.width; ++x) {
      const float stored = depth_[y * view_.width + x];
      depths.push_back(stored >= 1 ? std::numeric_limits<float>::infinity()
                                   : near_m_ * far_m_ / (far_m_ - stored * (far_m_ - near_m_)));
    }
  }
  return depths;
}

}  // namespace fire3dv::mujoco
