// Fixture of plugin tests: a world of the AMBF API stub, the plugin loaded like in AMBF, and a receiver.
#pragma once

#include <afFramework.h>
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "protocol/transport/open.h"
#include "protocol/wire/decode.h"

namespace fire3dv::test {

inline std::string ambf_uri() {
  static int count = 0;
  return "shm://ambf-plugin-" + std::to_string(::getpid()) + "-" + std::to_string(count++);
}

// Messages received over the link.
struct AmbfRenderer {
  struct Frame {
    int64_t sim_time_ns = 0;
    uint32_t flags = 0;
    std::vector<wire::Affine3x4> poses;
  };

  explicit AmbfRenderer(const std::string& uri) {
    transport::ListenerOptions options;
    options.delivery = transport::Delivery::all;
    link = std::move(*transport::open_listener(uri, options));
  }
  void poll() {
    link->wait(std::chrono::milliseconds(1));
    link->poll([this](const transport::LinkEvent& event) {
      using Kind = transport::LinkEvent::Kind;
      if (event.kind == Kind::disconnected) ended = true;
      if (event.kind != Kind::pose && event.kind != Kind::control) return;
      const auto message = decoder.decode(event.message);
      ASSERT_TRUE(message.ok()) << message.error().message;
      if (const auto* m = std::get_if<wire::StreamDescription>(&*message)) descriptions.push_back(*m);
      if (const auto* m = std::get_if<wire::SceneEdit>(&*message)) edits[{m->node, m->property}] = m->value;
      if (const auto* m = std::get_if<wire::PoseFrameView>(&*message))
        frames.push_back({m->header.sim_time_ns, m->header.flags, {m->poses.begin(), m->poses.end()}});
      if (std::holds_alternative<wire::Goodbye>(*message)) ended = true;
    });
  }
  bool poll_until(const std::function<bool()>& done) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);  // hang limit
    while (!done() && std::chrono::steady_clock::now() < end) poll();
    return done();
  }
  // Polls until frames of this time or later have arrived.
  bool shows(double time_s) {
    return poll_until(
        [&] { return !frames.empty() && frames.back().sim_time_ns >= std::llround(time_s * 1e9); });
  }
  const std::vector<std::string>& names() const { return descriptions.back().node_names; }
  const wire::Affine3x4& pose(const std::string& name) const {
    const auto found = std::find(names().begin(), names().end(), name);
    return frames.back().poses.at(static_cast<size_t>(found - names().begin()));
  }

  std::unique_ptr<transport::ListenerLink> link;
  wire::Decoder decoder;
  std::vector<wire::StreamDescription> descriptions;
  std::map<std::pair<std::string, wire::Property>, wire::EditValue> edits;
  std::vector<Frame> frames;
  bool ended = false;
};

// Loads the plugin once per process, as AMBF does.
inline ambf::afSimulatorPlugin* create_plugin() {
  static void* const library = ::dlopen(AMBF_PLUGIN, RTLD_LAZY | RTLD_GLOBAL);
  if (!library) return nullptr;
  using Create = ambf::afSimulatorPlugin*();
  auto* const create = reinterpret_cast<Create*>(::dlsym(library, "CreatePlugin"));
  return create ? create() : nullptr;
}

class AmbfWorld {
 public:
  explicit AmbfWorld(std::string uri) : uri_(std::move(uri)) {}
  ~AmbfWorld() { end(); }
  AmbfWorld(const AmbfWorld&) = delete;
  AmbfWorld& operator=(const AmbfWorld&) = delete;

  int init(std::vector<std::string> more = {}) {
    arguments_ = {"ambf_simulator", "--launch_file", "/nowhere/launch.yaml", "--fire3dv-uri=" + uri_};
    arguments_.insert(arguments_.end(), more.begin(), more.end());
    std::vector<char*> pointers;
    for (std::string& argument : arguments_) pointers.push_back(argument.data());
    plugin_ = create_plugin();
    if (!plugin_) ADD_FAILURE() << ::dlerror();
    return plugin_ ? plugin_->init(static_cast<int>(pointers.size()), pointers.data(), &world) : -1;
  }
  void step() {
    world.time_s += 0.001;
    plugin_->physicsUpdate(0.001);
  }
  void end() {
    if (plugin_) plugin_->close();
    delete std::exchange(plugin_, nullptr);
  }
  ambf::afSimulatorPlugin* plugin() { return plugin_; }

  template <typename Object>
  Object* add(ambf::afBaseObjectMap& map, const std::string& key) {
    auto object = std::make_unique<Object>();
    object->name = key + ".name";
    if constexpr (std::is_base_of_v<ambf::afMeshObject, Object>) {
      meshes_.push_back(std::make_unique<chai3d::cMultiMesh>());
      object->m_visualMesh = meshes_.back().get();
    }
    Object* const raw = object.get();
    map[key] = raw;
    objects_.push_back(std::move(object));
    return raw;
  }
  ambf::afRigidBody* body(const std::string& key) { return add<ambf::afRigidBody>(world.bodies, key); }

  ambf::afWorld world;

 private:
  std::string uri_;
  std::vector<std::string> arguments_;
  std::vector<std::unique_ptr<ambf::afBaseObject>> objects_;
  std::vector<std::unique_ptr<chai3d::cMultiMesh>> meshes_;
  ambf::afSimulatorPlugin* plugin_ = nullptr;
};

// A transform with a different value in each element.
inline chai3d::cTransform odd_frame(double seed) {
  chai3d::cTransform frame;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) frame.m[column][row] = seed + 0.1 * column + 0.013 * row;
  }
  return frame;
}

inline void place(ambf::afBaseObject& object, double x, double y, double z) {
  object.local = chai3d::cTransform();
  object.local.m[3][0] = x;
  object.local.m[3][1] = y;
  object.local.m[3][2] = z;
}

}  // namespace fire3dv::test
