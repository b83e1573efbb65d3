// Against the real AMBF: a plugin that moves what it can and writes down where AMBF itself says that
// everything is, for tests/ambf/against_ambf.py to compare with what our plugin's stream says. Everything at
// 1 kHz, as doubles that were cut to floats, into the file that FIRE3DV_AMBF_RECORD names: a line of JSON
// with the keys, then for each step an i64 of simulation time in ns and 12 floats for each key, rows first.
#include <afFramework.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace {

constexpr size_t kMostBytes = 200u << 20;

class Driver : public ambf::afSimulatorPlugin {
 public:
  int init(int, char**, const ambf::afWorldPtr world) override {
    m_worldPtr = world;
    const char* const name = std::getenv("FIRE3DV_AMBF_RECORD");
    if (!name) return ambf::ERROR;
    file_.open(name, std::ios::binary);
    return file_ ? ambf::SUCCESS : ambf::ERROR;
  }

  void physicsUpdate(double) override {
    const double now_s = m_worldPtr->getSimulationTime();
    record(now_s);
    move(now_s);
  }

  bool close() override {
    file_.close();
    return true;
  }

 private:
  // Both arms, joint by joint in other time; instruments go in and out a little where turns are meant in
  // metres.
  void move(double now_s) {
    double phase = 0;
    for (const auto& [key, object] : *m_worldPtr->getJointMap()) {
      phase += 0.7;
      const bool slides = key.find("main insertion link") != std::string::npos &&
                          key.find("pitch end link") != std::string::npos;
      double command = slides ? 0.12 + 0.02 * std::sin(now_s + phase) : 0.25 * std::sin(1.3 * now_s + phase);
      if (key.find("/psm") != std::string::npos)
        static_cast<ambf::afJoint*>(object)->commandPosition(command);
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

  std::ofstream file_;
  size_t written_ = 0;
  size_t count_ = 0;
};

}  // namespace

extern "C" __attribute__((visibility("default"))) ambf::afSimulatorPlugin* CreatePlugin() {
  return new Driver();
}
