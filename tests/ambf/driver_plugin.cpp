// AMBF plugin that drives joints and records ground-truth poses, for tests/ambf/against_ambf.py. It writes
// the file named by FIRE3DV_AMBF_RECORD at 1 kHz. The file starts with one line of JSON with the keys. Each
// step is an i64 simulation time in ns and, for each key, a row-major 3x4 matrix (12 floats, rounded from
// doubles).
#include <afFramework.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <ratio>
#include <string>
#include <vector>

namespace {

constexpr size_t kMostBytes = 200u << 20;

class Driver : public ambf::afSimulatorPlugin {
 public:
  int init(int argc, char** argv, const ambf::afWorldPtr world) override {
    m_worldPtr = world;
    const char* const name = std::getenv("FIRE3DV_AMBF_RECORD");
    if (name) file_.open(name, std::ios::binary);
    const char* const timed = std::getenv("FIRE3DV_AMBF_TIMED");
    if (timed && !load(timed, argc, argv)) return ambf::ERROR;
    return !name || file_ ? ambf::SUCCESS : ambf::ERROR;
  }

  void physicsUpdate(double dt) override {
    const double now_s = m_worldPtr->getSimulationTime();
    if (file_.is_open()) record(now_s);
    move(now_s);
    if (!timed_) return;
    const auto begin = std::chrono::steady_clock::now();
    timed_->physicsUpdate(dt);
    const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begin;
    if (steps_us_.size() < steps_us_.capacity()) steps_us_.push_back(took.count());
  }

  bool close() override {
    file_.close();
    if (!timed_) return true;
    timed_->close();
    std::sort(steps_us_.begin(), steps_us_.end());
    const size_t n = steps_us_.size();
    if (n > 0)
      std::fprintf(stderr, "steps: %zu, half below %.2f us, 99 %% below %.2f us, longest %.2f us\n", n,
                   steps_us_[n / 2], steps_us_[n * 99 / 100], steps_us_.back());
    return true;
  }

 private:
  bool load(const char* file, int argc, char** argv) {
    void* const library = ::dlopen(file, RTLD_LAZY);
    void* const create = library ? ::dlsym(library, "CreatePlugin") : nullptr;
    if (!create) return false;
    timed_ = reinterpret_cast<ambf::afSimulatorPlugin* (*)()>(create)();
    steps_us_.reserve(100'000);
    return timed_->init(argc, argv, m_worldPtr) >= 1;
  }

  // Moves both arms of the Surgical Robotics Challenge, so that their tools work in front of the camera. Each
  // joint oscillates about its rest position with its own period. The second arm is the mirrored one.
  void move(double now_s) {
    struct Place {
      const char* joint;
      double place, swing;
    };
    static constexpr Place kPlaces[] = {{"base link", -0.4, 0.1},        {"yaw link-pitch", 0.1, 0.06},
                                        {"pitch end link", 0.225, 0.01}, {"main insertion link", -1.64, 0.3},
                                        {"tool roll link", -0.37, 0.3},  {"tool pitch link", -0.11, 0.3},
                                        {"tool yaw link", 0.25, 0.2}};
    double phase = 0;
    for (const auto& [key, object] : *m_worldPtr->getJointMap()) {
      phase += 0.7;
      if (key.find("/psm") == std::string::npos) continue;
      for (const Place& place : kPlaces) {
        if (key.find(std::string("JOINT ") + place.joint) == std::string::npos) continue;
        const bool mirrored =
            key.find("/psm1") != std::string::npos && (&place == &kPlaces[0] || &place == &kPlaces[3]);
        double command =
            (mirrored ? -place.place : place.place) + place.swing * std::sin(1.3 * now_s + phase);
        static_cast<ambf::afJoint*>(object)->commandPosition(command);
        break;
      }
    }
  }

  void record(double now_s) {
    for (const auto& [name, model] : *m_worldPtr->getModelMap()) model->updateGlobalPose();
    std::vector<ambf::afBaseObject*> objects;
    std::string keys;
    for (auto* const map : {m_worldPtr->getRigidBodyMap(), m_worldPtr->getGhostObjectMap(),
                            m_worldPtr->getLightMap(), m_worldPtr->getCameraMap()}) {
      for (const auto& [key, object] : *map) {
        objects.push_back(object);
        keys += (keys.empty() ? "[\"" : "\", \"") + key;
      }
    }
    if (written_ == 0) {
      file_ << keys << "\"]\n";
      count_ = objects.size();
    }
    if (objects.size() != count_ || written_ > kMostBytes) return;
    const int64_t now_ns = std::llround(now_s * 1e9);
    write(&now_ns, sizeof now_ns);
    for (ambf::afBaseObject* const object : objects) {
      const chai3d::cTransform frame = object->getGlobalTransform();
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) {
          const auto element = static_cast<float>(frame.m[column][row]);
          write(&element, sizeof element);
        }
      }
    }
  }

  void write(const void* data, size_t count) {
    file_.write(static_cast<const char*>(data), static_cast<std::streamsize>(count));
    written_ += count;
  }

  ambf::afSimulatorPlugin* timed_ = nullptr;
  std::vector<double> steps_us_;
  std::ofstream file_;
  size_t written_ = 0;
  size_t count_ = 0;
};

}  // namespace

extern "C" __attribute__((visibility("default"))) ambf::afSimulatorPlugin* CreatePlugin() {
  return new Driver();
}
