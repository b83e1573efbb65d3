#include "examples/soft_tissue/simulation.h"

#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace soft_tissue {
namespace {

constexpr int kSubsteps = 2;
constexpr float kMass_kg = 0.4f;
constexpr float kGrasp_s = 1.0f, kFirstCut_s = 2.2f, kLastCut_s = 6.0f, kRelease_s = 7.2f;
constexpr float kGraspRadius_m = 0.014f;

float ramp(float from, float to, float t) {
  const float x = std::clamp((t - from) / (to - from), 0.0f, 1.0f);
  return x * x * (3 - 2 * x);
}

btVector3 bullet(const Vec3& v) {
  return {v.x, v.y, v.z};
}
Vec3 plain(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}

// Pose of an instrument whose shaft leads away along +Z from its tip. away: direction; roll about it.
std::array<float, 12> instrument_pose(const Vec3& tip, const Vec3& away, float roll) {
  const Vec3 z = normalized(away), right = normalized(cross({0, 1, 0}, z)), up = cross(z, right);
  const Vec3 x = right * std::cos(roll) + up * std::sin(roll), y = cross(z, x);
  return {x.x, y.x, z.x, tip.x, x.y, y.y, z.y, tip.y, x.z, y.z, z.z, tip.z};
}

// A jaw turns about the x axis of the instrument, some millimetres behind the tip.
std::array<float, 12> jaw_pose(const std::array<float, 12>& m, float angle) {
  constexpr float kHinge_m = 0.02f;
  const float c = std::cos(angle), s = std::sin(angle);
  std::array<float, 12> jaw = m;
  for (size_t row = 0; row < 3; ++row) {
    const float y = m[4 * row + 1], z = m[4 * row + 2];
    jaw[4 * row + 1] = c * y + s * z;
    jaw[4 * row + 2] = -s * y + c * z;
    jaw[4 * row + 3] = m[4 * row + 3] + kHinge_m * z;
  }
  return jaw;
}

}  // namespace

struct Simulation::World {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld dynamics{&dispatcher, &broadphase, &solver, &configuration};
};

Simulation::Simulation(const Detail& detail) : detail_(detail), world_(std::make_unique<World>()) {
  world_->dynamics.setGravity({0, -2, 0});
  btSoftBodyWorldInfo& info = world_->dynamics.getWorldInfo();
  info.m_gravity = {0, -2, 0};
  for (int cut = 0; cut <= max_cut(detail_); ++cut) phantoms_.push_back(make_phantom(detail_, cut));
  make_body(0);
  move_instruments();
  place_surface();
}

Simulation::~Simulation() {
  world_->dynamics.removeSoftBody(body_.get());
}

// Nodes of the same key keep their motion; the right side of a new cut starts as the left one.
void Simulation::make_body(int cut) {
  std::map<std::array<int, 4>, std::pair<btVector3, btVector3>> before;
  if (body_) {
    for (int i = 0; i < body_->m_nodes.size(); ++i)
      before[phantom().lattice.keys[static_cast<size_t>(i)]] = {body_->m_nodes[i].m_x, body_->m_nodes[i].m_v};
    world_->dynamics.removeSoftBody(body_.get());
  }
  cut_ = cut;
  const Lattice& lattice = phantom().lattice;
  const auto count = static_cast<int>(lattice.nodes.size());
  std::vector<btVector3> places;
  for (const Vec3& node : lattice.nodes) places.push_back(bullet(node));
  const std::vector<btScalar> masses(lattice.nodes.size(), kMass_kg / static_cast<float>(count));
  body_ = std::make_unique<btSoftBody>(&world_->dynamics.getWorldInfo(), count, places.data(), masses.data());
  body_->m_materials[0]->m_kLST = 0.9f;
  for (const auto& link : lattice.links)
    body_->appendLink(static_cast<int>(link[0]), static_cast<int>(link[1]), body_->m_materials[0]);
  body_->m_cfg.piterations = 5;
  body_->m_cfg.kDP = 0.06f;
  body_->m_cfg.collisions = 0;
  for (const uint32_t node : lattice.held) body_->setMass(static_cast<int>(node), 0);
  for (int i = 0; i < count; ++i) {
    std::array<int, 4> key = lattice.keys[static_cast<size_t>(i)];
    auto known = before.find(key);
    if (known == before.end()) {
      key[3] = 0;
      known = before.find(key);
    }
    if (known == before.end()) continue;
    btSoftBody::Node& node = body_->m_nodes[i];
    node.m_x = node.m_q = known->second.first;
    node.m_v = known->second.second;
  }
  world_->dynamics.addSoftBody(body_.get());
}

// Nodes near the closing jaws follow them from now on.
void Simulation::grasp(const Vec3& tip) {
  grasped_.clear();
  is_holding_ = true;
  for (int i = 0; i < body_->m_nodes.size(); ++i) {
    const Vec3 from_tip = plain(body_->m_nodes[i].m_x) - tip;
    if (dot(from_tip, from_tip) < kGraspRadius_m * kGraspRadius_m)
      grasped_.push_back({phantom().lattice.keys[static_cast<size_t>(i)], from_tip});
  }
}

void Simulation::move_instruments() {
  const auto t = static_cast<float>(std::fmod(time_s(), kRun_s));
  // The grasper takes the rim of the right half, lifts it, and pulls it aside as the cut opens.
  const Vec3 rim = top_point(0.28f, 0.72f);
  const float reach = ramp(0, 0.9f, t), lift = ramp(1.2f, 2.6f, t), pull = ramp(2.2f, 6.2f, t),
              leave = ramp(kRelease_s, 8, t);
  tip_ = rim + Vec3{0.05f, 0.05f, 0.08f} * (1 - reach) + Vec3{0.006f, 0.016f, 0.006f} * (lift * (1 - leave)) +
         Vec3{0.026f, 0.010f, 0.002f} * (pull * (1 - leave)) + Vec3{0.05f, 0.05f, 0.08f} * leave;
  const float open =
      0.42f * (1 - ramp(0.9f, 1.05f, t)) + 0.42f * ramp(kRelease_s - 0.1f, kRelease_s + 0.1f, t);
  instruments_.grasper = instrument_pose(tip_, {0.55f, 0.62f, 0.6f}, 0.5f);
  instruments_.upper_jaw = jaw_pose(instruments_.grasper, open + 0.05f);
  instruments_.lower_jaw = jaw_pose(instruments_.grasper, -open - 0.05f);
  // The blade goes from the rim inwards, and away.
  const float depth = static_cast<float>(max_cut(detail_)) * ramp(kFirstCut_s, kLastCut_s, t);
  const float near = ramp(1.2f, kFirstCut_s, t) * (1 - ramp(kLastCut_s, kLastCut_s + 0.9f, t));
  const Vec3 end = cut_end(detail_, depth) + Vec3{0, 0.004f * std::sin(25 * t), 0.004f};
  instruments_.blade =
      instrument_pose(end + Vec3{-0.05f, 0.07f, 0.04f} * (1 - near), {-0.35f, 0.75f, 0.45f}, 0);
  const bool holds = t >= kGrasp_s && t < kRelease_s;
  if (holds && !is_holding_) grasp(tip_);
  if (!holds) {
    grasped_.clear();
    is_holding_ = false;
  }
  if (t >= kFirstCut_s) {
    if (const int cut = static_cast<int>(depth); cut > cut_) make_body(cut);
  } else if (cut_ != 0) {  // the next run
    make_body(0);
  }
}

void Simulation::step() {
  ++steps_;
  move_instruments();
  std::map<std::array<int, 4>, int> numbers;
  for (size_t i = 0; i < phantom().lattice.keys.size(); ++i)
    numbers[phantom().lattice.keys[i]] = static_cast<int>(i);
  for (int substep = 0; substep < kSubsteps; ++substep) {
    for (const uint32_t node : phantom().lattice.held) body_->m_nodes[static_cast<int>(node)].m_v.setZero();
    for (const Grasped& held : grasped_) {
      const auto found = numbers.find(held.key);
      if (found == numbers.end()) continue;
      btSoftBody::Node& node = body_->m_nodes[found->second];
      body_->setMass(found->second, 0);
      const btVector3 wanted = bullet(tip_ + held.from_tip);
      node.m_x = node.m_q = node.m_x.lerp(wanted, substep + 1 == kSubsteps ? 1.0f : 0.5f);
      node.m_v.setZero();
    }
    world_->dynamics.stepSimulation(static_cast<btScalar>(1 / (kRate_hz * kSubsteps)), 0);
    rest_on_pad();
  }
  if (grasped_.empty()) {  // what was held is free again
    const btScalar mass = kMass_kg / static_cast<float>(body_->m_nodes.size());
    std::vector<bool> is_held(phantom().lattice.nodes.size());
    for (const uint32_t node : phantom().lattice.held) is_held[node] = true;
    for (int i = 0; i < body_->m_nodes.size(); ++i)
      if (body_->m_nodes[i].m_im == 0 && !is_held[static_cast<size_t>(i)]) body_->setMass(i, mass);
  }
  place_surface();
}

// It lies in a mould of its own shape: nodes sink by no more than a millimetre, and stick there.
void Simulation::rest_on_pad() {
  for (int i = 0; i < body_->m_nodes.size(); ++i) {
    const float least = phantom().lattice.nodes[static_cast<size_t>(i)].y - 0.001f;
    btSoftBody::Node& node = body_->m_nodes[i];
    if (node.m_x.y() >= least) continue;
    node.m_x.setY(least);
    node.m_v *= 0.5f;
  }
}

// Trilinear in the cell.
void Simulation::place_surface() {
  positions_.clear();
  const auto place = [&](const std::vector<Anchor>& anchors) {
    for (const Anchor& anchor : anchors) {
      btVector3 sum(0, 0, 0);
      for (uint32_t corner = 0; corner < 8; ++corner) {
        float weight = 1;
        for (uint32_t axis = 0; axis < 3; ++axis)
          weight *= corner >> axis & 1 ? anchor.place[axis] : 1 - anchor.place[axis];
        sum += weight * body_->m_nodes[static_cast<int>(anchor.nodes[corner])].m_x;
      }
      positions_.insert(positions_.end(), {sum.x(), sum.y(), sum.z()});
    }
  };
  place(phantom().surface.outside_anchors);
  place(phantom().surface.inside_anchors);
  find_normals();
}

// Sums of the triangles' normals by area, over the vertices that share one.
void Simulation::find_normals() {
  const Surface& surface = phantom().surface;
  std::vector<Vec3> sums(surface.normal_groups.size());
  const auto position = [&](uint32_t v) {
    return Vec3{positions_[3 * v], positions_[3 * v + 1], positions_[3 * v + 2]};
  };
  uint32_t first = 0;
  for (const examples::Mesh* mesh : {&surface.outside, &surface.inside}) {
    for (size_t i = 0; i + 2 < mesh->indices.size(); i += 3) {
      const uint32_t corner[] = {first + mesh->indices[i], first + mesh->indices[i + 1],
                                 first + mesh->indices[i + 2]};
      const Vec3 a = position(corner[0]);
      const Vec3 area = cross(position(corner[1]) - a, position(corner[2]) - a);
      for (const uint32_t v : corner) sums[surface.normal_groups[v]] = sums[surface.normal_groups[v]] + area;
    }
    first += static_cast<uint32_t>(mesh->vertices.size());
  }
  normals_.clear();
  for (const uint32_t group : surface.normal_groups) {
    const Vec3& sum = sums[group];
    const Vec3 normal = dot(sum, sum) > 0 ? normalized(sum) : Vec3{0, 1, 0};
    normals_.insert(normals_.end(), {normal.x, normal.y, normal.z});
  }
}

}  // namespace soft_tissue
