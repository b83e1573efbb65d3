#include "adapters/gazebo/world/entities.h"

#include <cmath>
#include <utility>

namespace fire3dv::gazebo {
namespace {

constexpr size_t kMaxEntities = 200'000;
constexpr double kMaxCoordinate = 1e9;  // metres

using convert::SdfEntity;

bool is_coordinate(double x) {
  return std::isfinite(x) && std::abs(x) <= kMaxCoordinate;
}

// Own names of entities, without those of their parents.
class Reader {
 public:
  Reader(std::vector<Entity>& entities, size_t& count) : entities_(entities), count_(count) {}

  void model(const pb::Model& model, size_t parent) {
    const size_t self = add(model.id(), SdfEntity::model, model.name(), parent, model.pose());
    if (self == kNoParent) return;
    for (const pb::Link& of_model : model.link()) link(of_model, self);
    for (const pb::Model& nested : model.model()) this->model(nested, self);
  }
  void light(const pb::Light& light, size_t parent) {
    const size_t self = add(light.id(), SdfEntity::light, light.name(), parent, light.pose());
    if (self != kNoParent) entities_[self].light = &light;
  }

 private:
  void link(const pb::Link& link, size_t parent) {
    const size_t self = add(link.id(), SdfEntity::link, link.name(), parent, link.pose());
    if (self == kNoParent) return;
    for (const pb::Visual& visual : link.visual()) {
      const size_t shown = add(visual.id(), SdfEntity::visual, visual.name(), self, visual.pose());
      if (shown != kNoParent) entities_[shown].visual = &visual;
    }
    for (const pb::Light& of_link : link.light()) light(of_link, self);
    for (const pb::Sensor& sensor : link.sensor()) {
      if (!is_camera(sensor)) continue;
      const size_t camera = add(sensor.id(), SdfEntity::sensor, sensor.name(), self, sensor.pose());
      if (camera != kNoParent) entities_[camera].sensor = &sensor;
    }
  }
  size_t add(uint32_t id, SdfEntity kind, const std::string& name, size_t parent, const pb::Pose& pose) {
    if (++count_ > kMaxEntities) return kNoParent;
    entities_.push_back({.id = id,
                         .kind = kind,
                         .name = name,
                         .parent = parent,
                         .pose = rigid_pose(pose).value_or(RigidPose())});
    return entities_.size() - 1;
  }

  std::vector<Entity>& entities_;
  size_t& count_;
};

void clear_state(pb::Light& light) {
  light.clear_id();
  light.clear_pose();
}

void clear_state(pb::Model& model) {
  model.clear_id();
  model.clear_pose();
  for (pb::Link& link : *model.mutable_link()) {
    link.clear_id();
    link.clear_pose();
    for (pb::Visual& visual : *link.mutable_visual()) visual.clear_id();
    for (pb::Light& light : *link.mutable_light()) clear_state(light);
    for (pb::Sensor& sensor : *link.mutable_sensor()) sensor.clear_id();
  }
  for (pb::Model& nested : *model.mutable_model()) clear_state(nested);
}

}  // namespace

bool is_camera(const pb::Sensor& sensor) {
  return sensor.has_camera() && sensor.type().find("camera") != std::string::npos;
}

std::optional<RigidPose> rigid_pose(const pb::Pose& pose) {
  RigidPose rigid;
  rigid.translation = {pose.position().x(), pose.position().y(), pose.position().z()};
  for (int i = 0; i < 3; ++i)
    if (!is_coordinate(rigid.translation[i])) return std::nullopt;
  if (!pose.has_orientation()) return rigid;
  const pb::Quaternion& q = pose.orientation();
  const double length = std::sqrt(q.x() * q.x() + q.y() * q.y() + q.z() * q.z() + q.w() * q.w());
  if (!std::isfinite(length) || length < 1e-6) return std::nullopt;
  rigid.rotation = glm::dquat(q.w() / length, q.x() / length, q.y() / length, q.z() / length);
  return rigid;
}

RigidPose operator*(const RigidPose& a, const RigidPose& b) {
  return {a.translation + a.rotation * b.translation, a.rotation * b.rotation};
}

std::vector<TopLevel> read_entities(const pb::Scene& scene, std::vector<std::string>& warnings) {
  std::vector<TopLevel> items;
  size_t count = 0;
  const auto finish = [&](const std::shared_ptr<pb::Scene>& message, std::string digest) {
    TopLevel item;
    Reader reader(item.entities, count);
    for (const pb::Model& model : message->model()) reader.model(model, kNoParent);
    for (const pb::Light& light : message->light()) reader.light(light, kNoParent);
    item.message = message;
    item.digest = std::move(digest);
    // Equal digests stand for equal entities.
    if (count > kMaxEntities) item.digest += "the first " + std::to_string(item.entities.size());
    if (!item.entities.empty()) items.push_back(std::move(item));
  };
  for (const pb::Model& model : scene.model()) {
    if (count > kMaxEntities) break;
    auto message = std::make_shared<pb::Scene>();
    *message->add_model() = model;
    pb::Model shape = model;
    clear_state(shape);
    finish(message, "m" + shape.SerializeAsString());
  }
  for (const pb::Light& light : scene.light()) {
    if (count > kMaxEntities) break;
    auto message = std::make_shared<pb::Scene>();
    *message->add_light() = light;
    pb::Light shape = light;
    clear_state(shape);
    finish(message, "l" + shape.SerializeAsString());
  }
  if (count > kMaxEntities)
    warnings.push_back("the world has more than " + std::to_string(kMaxEntities) +
                       " entities: the rest is left out");
  return items;
}

void name_entities(const std::vector<TopLevel*>& items, convert::SdfNames& names) {
  // Scoped names of all entities, as if they were unique.
  std::vector<std::vector<std::string>> scoped(items.size());
  for (size_t i = 0; i < items.size(); ++i) {
    for (const Entity& entity : items[i]->entities) {
      const std::string parent = entity.parent == kNoParent ? std::string() : scoped[i][entity.parent];
      scoped[i].push_back(printable_text(convert::scoped_sdf_name(parent, entity.name, entity.kind), 1024));
    }
  }
  for (const SdfEntity kind :
       {SdfEntity::model, SdfEntity::link, SdfEntity::visual, SdfEntity::light, SdfEntity::sensor}) {
    for (size_t i = 0; i < items.size(); ++i) {
      for (size_t k = 0; k < items[i]->entities.size(); ++k) {
        Entity& entity = items[i]->entities[k];
        if (entity.kind == kind) entity.node = entity.name = names.take(scoped[i][k], kind);
      }
    }
  }
}

std::string own_name(const Entity& entity) {
  const size_t slash = entity.name.rfind('/');
  return slash == std::string::npos ? entity.name : entity.name.substr(slash + 1);
}

void place_below(TopLevel& item, const std::string& added_node) {
  constexpr size_t kMaxBytes = 1024;  // of a name in a stream
  item.added_node = added_node;
  const std::string root = convert::escaped_sdf_name(added_node) + "/" + kAssetRoot;
  for (Entity& entity : item.entities) {
    const std::string& parent = entity.parent == kNoParent ? root : item.entities[entity.parent].node;
    entity.node = parent.empty() ? "" : parent + "/" + convert::escaped_sdf_name(own_name(entity));
    if (entity.node.size() > kMaxBytes) entity.node.clear();
  }
}

}  // namespace fire3dv::gazebo
