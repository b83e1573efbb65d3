// AMBF plugin that records AMBF's own images, for tests/ambf/compare_pictures.py. Needs a window. After some
// seconds it pauses the physics. The first camera then renders all objects, and each object alone, to
// NUMBER.ppm in the folder named by FIRE3DV_AMBF_PICTURES. pictures.json holds the size, the camera, and the
// name and pose of each moving object. At the end stderr gets AMBF's frame rate with and without physics;
// with the folder "-" the plugin measures the frame rate only.
#include <GL/glew.h>
#include <afFramework.h>
#include <pthread.h>
#include <time.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kMoveS = 6, kPausedS = 6, kSettleS = 2;

class Pictures : public ambf::afSimulatorPlugin {
 public:
  int init(int, char**, const ambf::afWorldPtr world) override {
    m_worldPtr = world;
    const char* const folder = std::getenv("FIRE3DV_AMBF_PICTURES");
    folder_ = folder ? folder : "";
    begin_ = Clock::now();
    return folder && !world->getCameraMap()->empty() ? ambf::SUCCESS : ambf::ERROR;
  }

  void physicsUpdate(double) override {
    if (!physics_known_.exchange(true)) pthread_getcpuclockid(pthread_self(), &physics_clock_);
  }

  void graphicsUpdate() override {
    const double now_s = std::chrono::duration<double>(Clock::now() - begin_).count();
    if (now_s > kSettleS && now_s < kMoveS) running_.frame(drawing_cpu_ms());
    if (now_s > kMoveS + kSettleS && now_s < kMoveS + kPausedS) paused_.frame(drawing_cpu_ms());
    if (now_s > kMoveS) m_worldPtr->pausePhysics(true);
    if (now_s < kMoveS + kPausedS || done_) return;
    done_ = true;
    if (folder_ != "-") take_all();
    std::fprintf(stderr, "pictures: %.2f a second of %.1f ms with physics, %.2f of %.1f ms without\n",
                 running_.frames / (kMoveS - kSettleS), running_.cpu_ms(),
                 paused_.frames / (kPausedS - kSettleS), paused_.cpu_ms());
    std::fflush(stderr);
    std::quick_exit(0);
  }

 private:
  // Frame count and total time of frames that lie entirely within an interval.
  struct Span {
    int frames = 0;
    double first_ms = 0, last_ms = 0;
    void frame(double now_ms) {
      if (frames++ == 0) first_ms = now_ms;
      last_ms = now_ms;
    }
    double cpu_ms() const { return frames > 1 ? (last_ms - first_ms) / (frames - 1) : 0; }
  };

  static double clock_ms(clockid_t clock) {
    timespec time{};
    clock_gettime(clock, &time);
    return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
  }
  double drawing_cpu_ms() const {
    return clock_ms(CLOCK_PROCESS_CPUTIME_ID) - (physics_known_ ? clock_ms(physics_clock_) : 0);
  }

  void take_all() {
    auto* const camera = static_cast<ambf::afCamera*>(m_worldPtr->getCameraMap()->begin()->second);
    m_worldPtr->getChaiWorld()->m_backgroundColor.set(1, 0, 1);  // a colour that no body has
    for (auto* const label :
         {camera->m_graphicsDynamicsFreqLabel, camera->m_wallSimTimeLabel, camera->m_devicesModesLabel,
          camera->m_deviceButtonLabel, camera->m_controllingDeviceLabel})
      label->setShowEnabled(false);
    m_worldPtr->updateSceneObjects();

    std::ostringstream json;
    json << "{\"width\": " << camera->m_width << ", \"height\": " << camera->m_height << ", \"camera\": \""
         << m_worldPtr->getCameraMap()->begin()->first << "\", \"objects\": [";
    std::vector<ambf::afInertialObject*> shown;
    size_t number = 0;
    for (auto* const map : {m_worldPtr->getRigidBodyMap(), m_worldPtr->getGhostObjectMap(),
                            m_worldPtr->getLightMap(), m_worldPtr->getCameraMap()}) {
      for (const auto& [key, object] : *map) {
        ambf::afInertialObject* const solid =
            map == m_worldPtr->getRigidBodyMap()     ? static_cast<ambf::afRigidBody*>(object)
            : map == m_worldPtr->getGhostObjectMap() ? static_cast<ambf::afGhostObject*>(object)
                                                     : static_cast<ambf::afInertialObject*>(nullptr);
        const bool drawn = solid && solid->m_visualMesh && solid->m_visualMesh->getShowEnabled();
        if (drawn) shown.push_back(solid);
        json << (number++ ? ",\n" : "\n") << "{\"key\": \"" << key << "\", \"kind\": " << kind_of(map)
             << ", \"drawn\": " << (drawn ? "true" : "false") << ", \"pose\": " << pose_of(*object) << "}";
      }
    }
    json << "]}\n";
    take(*camera, "all");
    for (auto* const solid : shown) solid->m_visualMesh->setShowEnabled(false);
    take(*camera, "none");
    for (size_t i = 0; i < shown.size(); ++i) {
      shown[i]->m_visualMesh->setShowEnabled(true);
      take(*camera, std::to_string(i));
      shown[i]->m_visualMesh->setShowEnabled(false);
    }
    std::ofstream(folder_ + "/pictures.json") << json.str();
  }

  int kind_of(const ambf::afBaseObjectMap* map) {
    return map == m_worldPtr->getRigidBodyMap()     ? 0
           : map == m_worldPtr->getGhostObjectMap() ? 1
           : map == m_worldPtr->getLightMap()       ? 2
                                                    : 3;
  }

  static std::string pose_of(ambf::afBaseObject& object) {
    const chai3d::cTransform frame = object.getGlobalTransform();
    std::string text = "[";
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        char number[40];
        std::snprintf(number, sizeof number, "%s%.17g", row + column ? ", " : "", frame.m[column][row]);
        text += number;
      }
    }
    return text + "]";
  }

  void take(ambf::afCamera& camera, const std::string& name) {
    const int width = camera.m_width, height = camera.m_height;
    for (int i = 0; i < 2; ++i) camera.getInternalCamera()->renderView(width, height);
    glFinish();
    std::vector<unsigned char> pixels(static_cast<size_t>(width) * static_cast<size_t>(height) * 3);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadBuffer(GL_BACK);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
    std::ofstream file(folder_ + "/" + name + ".ppm", std::ios::binary);
    file << "P6\n" << width << " " << height << "\n255\n";
    const size_t row = static_cast<size_t>(width) * 3;
    for (size_t y = static_cast<size_t>(height); y-- > 0;)
      file.write(reinterpret_cast<const char*>(&pixels[y * row]), static_cast<std::streamsize>(row));
  }

  std::string folder_;
  Clock::time_point begin_;
  Span running_, paused_;
  std::atomic<bool> physics_known_{false};
  clockid_t physics_clock_{};
  bool done_ = false;
};

}  // namespace

extern "C" __attribute__((visibility("default"))) ambf::afSimulatorPlugin* CreatePlugin() {
  return new Pictures();
}
