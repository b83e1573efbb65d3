// AMBF simulator plugin: the only file that includes AMBF headers. It supports 2.0 and 3.0 with the same
// source. physicsUpdate runs on AMBF's physics thread after each step, with and without a window. Poses are
// products of local frames along the parent chain: AMBF updates global frames late, and only while it draws.
#include <afFramework.h>

#include <atomic>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "adapters/ambf/log.h"
#include "adapters/ambf/session.h"
#include "base/clock.h"

namespace {

using namespace fire3dv::ambf;

constexpr int kMaxParents = 64;  // beyond this, the parent chain is a cycle

std::atomic<bool> running{false};  // one session per process, since signal handlers are per process

static_assert(sizeof(chai3d::cTransform::m) == sizeof(Transform::m), "both are 4x4 doubles, columns first");

Transform local_frame(ambf::afBaseObject& object) {
  const chai3d::cTransform local = object.getLocalTransform();
  Transform frame;
  std::memcpy(frame.m, local.m, sizeof frame.m);
  return frame;
}

Transform world_from(ambf::afBaseObject& object) {
  Transform frame = local_frame(object);
  ambf::afBaseObject* parent = object.getParentObject();
  for (int i = 0; parent && i < kMaxParents; ++i, parent = parent->getParentObject())
    frame = local_frame(*parent) * frame;
  return frame;
}

// Object at the time of the last description.
struct DescribedObject {
  ambf::afBaseObject* object;
  std::string key;
  Kind kind;
};

class Plugin : public ambf::afSimulatorPlugin {
 public:
  int init(int argc, char** argv, const ambf::afWorldPtr world) override {
    m_worldPtr = world;
    guarded([&] { start({argv, argv + argc}); });
    if (ours_ && !session_) {
      running = false;
      ours_ = false;
    }
    return session_ ? ambf::SUCCESS : ambf::ERROR;
  }

  void physicsUpdate(double) override { publish(); }

  // Publishes camera motion while physics is paused.
  void graphicsUpdate() override {
    if (m_worldPtr->isPhysicsPaused()) publish();
  }

  void reset() override {
    if (session_) session_->jump();
  }

  bool close() override {
    if (!session_) return true;
    session_.reset();
    ours_ = false;
    running = false;
    return true;
  }

 private:
  void start(const std::vector<std::string>& arguments) {
    if (running.exchange(true)) {
      log_line("the plugin is loaded already, perhaps by the launch file; give the one several URIs");
      return;
    }
    ours_ = true;
    auto started = Session::start(arguments, ambf::afSystemPaths::getRootPath(), m_worldPtr->isHeadless());
    if (started.ok()) {
      session_ = std::move(*started);
    } else {
      log_line(started.error().message + "; AMBF continues without it");
    }
  }

  // Catches exceptions such as bad_alloc, since AMBF's callers cannot.
  template <typename Work>
  void guarded(Work&& work) {
    try {
      work();
    } catch (const std::exception& error) {
      if (!logged_) log_line(std::string("a frame is left out: ") + error.what());
      logged_ = true;
    }
  }

  void publish() {
    const int64_t now = fire3dv::monotonic_ns();
    if (!session_ || !session_->begin_turn(now)) return;
    guarded([&] { publish_turn(now); });
    session_->end_turn();
  }

  void publish_turn(int64_t now) {
    if (!is_as_described()) describe();
    for (size_t i = 0; i < known_.size(); ++i) {
      session_->set_pose(i, world_from(*known_[i].object));
      send_appearance(i);
    }
    if (!soft_bodies_.empty() && session_->vertices_due(now)) publish_vertices();
    session_->publish(m_worldPtr->getSimulationTime(), now);
  }

  template <typename Visit>
  void for_each_map(Visit&& visit) {
    visit(Kind::rigid_body, *m_worldPtr->getRigidBodyMap());
    visit(Kind::ghost_object, *m_worldPtr->getGhostObjectMap());
    visit(Kind::light, *m_worldPtr->getLightMap());
    visit(Kind::camera, *m_worldPtr->getCameraMap());
    visit(Kind::soft_body, *m_worldPtr->getSoftBodyMap());
  }

  // Compares all objects with the last description, since AMBF does not signal additions and removals.
  bool is_as_described() {
    size_t i = 0;
    bool same = described_;
    for_each_map([&](Kind, const ambf::afBaseObjectMap& objects) {
      for (const auto& [key, object] : objects) {
        same = same && i < known_.size() && known_[i].object == object && known_[i].key == key;
        ++i;
      }
    });
    return same && i == known_.size();
  }

  void describe() {
    described_ = false;  // until the description is complete
    known_.clear();
    std::vector<Object> objects;
    for_each_map([&](Kind kind, const ambf::afBaseObjectMap& map) {
      for (const auto& [key, object] : map) {
        known_.push_back({object, key, kind});
        objects.push_back({kind, key, object->getQualifiedName()});
      }
    });
    session_->describe(std::move(objects));

    soft_bodies_.clear();
    std::vector<SoftMesh> meshes;
    for (const auto& [key, object] : *m_worldPtr->getSoftBodyMap()) {
      auto* const soft = static_cast<ambf::afSoftBody*>(object);
      soft_bodies_.push_back(soft);
      const bool by_key = session_->names() == Options::Names::key;
      meshes.push_back(mesh_of(by_key ? key : object->getQualifiedName(), *soft));
    }
    session_->set_soft_bodies(meshes);
    described_ = true;
  }

  // Sends visibility and camera intrinsics of an object.
  void send_appearance(size_t i) {
    const DescribedObject& known = known_[i];
    if (known.kind == Kind::rigid_body || known.kind == Kind::ghost_object) {
      const chai3d::cMultiMesh* const mesh =
          known.kind == Kind::rigid_body ? static_cast<ambf::afRigidBody*>(known.object)->m_visualMesh
                                         : static_cast<ambf::afGhostObject*>(known.object)->m_visualMesh;
      if (mesh) session_->set_shown(i, mesh->getShowEnabled());
    } else if (known.kind == Kind::camera) {
      auto* const camera = static_cast<ambf::afCamera*>(known.object);
      chai3d::cCamera* const inner = camera->getInternalCamera();
      if (inner && !camera->isOrthographic())
        session_->set_intrinsics(
            i, {camera->getFieldViewAngle(), inner->getNearClippingPlane(), inner->getFarClippingPlane(),
                camera->m_stereoMode != chai3d::C_STEREO_DISABLED});
    }
  }

  // Copies vertex positions of a soft body; Bullet keeps them in the world frame.
  static void positions_of(const ambf::afSoftBody& soft, std::vector<float>& positions) {
    const auto& nodes = soft.m_bulletSoftBody->m_nodes;
    positions.resize(static_cast<size_t>(nodes.size()) * 3);
    for (int i = 0; i < nodes.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis)
        positions[static_cast<size_t>(i) * 3 + static_cast<size_t>(axis)] =
            static_cast<float>(nodes[i].m_x[axis]);
    }
  }

  static SoftMesh mesh_of(const std::string& name, const ambf::afSoftBody& soft) {
    SoftMesh mesh;
    mesh.name = name;
    if (!soft.m_bulletSoftBody || soft.m_bulletSoftBody->m_nodes.size() == 0) return mesh;
    positions_of(soft, mesh.positions);
    const auto* const first = &soft.m_bulletSoftBody->m_nodes[0];
    const auto& faces = soft.m_bulletSoftBody->m_faces;
    for (int face = 0; face < faces.size(); ++face) {
      for (const auto* const node : faces[face].m_n)
        mesh.triangles.push_back(static_cast<uint32_t>(node - first));
    }
    if (soft.m_visualMesh && soft.m_visualMesh->getNumMeshes() > 0) {
      const auto& color = soft.m_visualMesh->getMesh(0)->m_material->m_diffuse;
      mesh.color_srgb = {color.getR(), color.getG(), color.getB(), color.getA()};
    }
    return mesh;
  }

  void publish_vertices() {
    for (size_t i = 0; i < soft_bodies_.size(); ++i) {
      if (!session_->has_soft_body(i) || !soft_bodies_[i]->m_bulletSoftBody) continue;
      positions_of(*soft_bodies_[i], vertices_);
      if (!vertices_.empty()) session_->set_vertices(i, vertices_);
    }
  }

  std::unique_ptr<Session> session_;
  std::vector<DescribedObject> known_;
  std::vector<ambf::afSoftBody*> soft_bodies_;
  std::vector<float> vertices_;
  bool ours_ = false;  // this plugin owns `running`
  bool described_ = false;
  bool logged_ = false;
};

}  // namespace

// The only exported symbol of this library.
extern "C" __attribute__((visibility("default"))) ambf::afSimulatorPlugin* CreatePlugin() {
  return new Plugin();
}
