#include "tools/lab/mujoco_compare/renderers.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <utility>

#include "renderer/scene/gltf/load_gltf.h"

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
    return Error{"MuJoCo gave " + std::to_string(made.context_.offSamples) + " samples per pixel, not " +
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

namespace {

const std::atomic<bool> kNeverStop{false};

}  // namespace

Result<RequestedImages> RequestedImages::open(const Simulation& simulation, const std::string& uri,
                                              const ImageSpec& spec, double timeout_s) {
  // Loads the scene as the renderer does, so that instance numbers match.
  std::vector<std::string> warnings;
  const auto glb = scene_of(simulation.model(), simulation.data(), "model", warnings);
  if (!glb) return glb.error();
  const Result<scene::Scene> scene = scene::load_glb(*glb, "model");
  if (!scene) return scene.error();
  Result<Publisher> publisher = Publisher::open(simulation.model(), {.uris = {uri}});
  if (!publisher) return publisher.error();
  const Result<uint64_t> request = publisher->request_images(simulation.model(), spec);
  if (!request) return request.error();
  return RequestedImages(std::move(*publisher), InstanceLabels(simulation.model(), *scene), *request,
                         timeout_s);
}

Result<Image> RequestedImages::draw(const Simulation& simulation) {
  publisher_.jump();  // makes every call publish a frame
  const Result<bool> sent = publisher_.publish(simulation.model(), simulation.data());
  if (!sent) return sent.error();
  return publisher_.wait_image(request_, timeout_s_, kNeverStop);
}

Result<LabelledDepth> RequestedImages::labelled(const fire3dv_image& image) const {
  const fire3dv_image_plane* const instances = plane_of(image, FIRE3DV_IMAGE_INSTANCE_U32);
  const fire3dv_image_plane* const depths = plane_of(image, FIRE3DV_IMAGE_DEPTH_F32);
  if (!instances || !depths) return Error{"the image has no labels and depths"};
  if (instances->width != depths->width || instances->height != depths->height)
    return Error{"the image's labels and depths differ in size"};
  LabelledDepth found;
  found.width = depths->width;
  found.height = depths->height;
  const auto row = [](const fire3dv_image_plane& plane, uint32_t y) {
    return static_cast<const char*>(plane.data) + size_t{y} * plane.row_stride;
  };
  for (uint32_t y = 0; y < found.height; ++y) {
    for (uint32_t x = 0; x < found.width; ++x) {
      uint32_t instance = 0;
      float depth_m = 0;
      std::memcpy(&instance, row(*instances, y) + sizeof instance * x, sizeof instance);
      std::memcpy(&depth_m, row(*depths, y) + sizeof depth_m * x, sizeof depth_m);
      found.labels.push_back(labels_[instance]);
      found.depths_m.push_back(depth_m);
    }
  }
  return found;
}

std::vector<uint8_t> RequestedImages::rgb(const fire3dv_image& image) {
  std::vector<uint8_t> found;
  const fire3dv_image_plane* const color = plane_of(image, FIRE3DV_IMAGE_COLOR_SRGB8);
  for (uint32_t y = 0; color && y < color->height; ++y) {
    const auto* const row = static_cast<const uint8_t*>(color->data) + size_t{y} * color->row_stride;
    for (uint32_t x = 0; x < color->width; ++x) found.insert(found.end(), row + 4 * x, row + 4 * x + 3);
  }
  return found;
}

}  // namespace fire3dv::mujoco
