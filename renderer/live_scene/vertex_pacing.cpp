#include "renderer/live_scene/vertex_pacing.h"

#include <algorithm>
#include <variant>

namespace fire3dv::app {
namespace {

constexpr double kUnmeasuredNsPerVertex = 50;
constexpr size_t kMaxUpdatesInFlight = 64;
constexpr size_t kMaxNames = 65'536;  // of nodes of a stream
constexpr double kMaxWaitNs = 2e9;    // so that a wrong measurement cannot hold an update for longer

void smooth(double& average, double sample) {
  average = average > 0 ? 0.75 * average + 0.25 * sample : sample;
}

uint64_t vertices_of(const wire::SceneEdit& edit) {
  const auto* const vertices = std::get_if<wire::Vertices>(&edit.value);
  return vertices ? vertices->positions.size() : 0;
}

}  // namespace

std::vector<uint64_t> VertexPacing::hold(state::SceneChanges& change, bool others_active, int64_t now_ns) {
  std::vector<uint64_t> waiting;
  if (change.ended) {
    streams_.erase(change.age);
    return waiting;
  }
  const auto known = streams_.find(change.age);
  if (known == streams_.end()) return waiting;
  Stream& stream = known->second;
  const bool is_due = !others_active || now_ns >= stream.next_ns;
  size_t kept = 0;
  for (size_t i = 0; i < change.edits.size(); ++i) {
    wire::SceneEdit& edit = change.edits[i];
    const bool is_of_vertices = edit.property == wire::Property::vertices;
    // A newer value, whether it is applied, waits or clears the vertices, takes the place of one that waits.
    if (is_of_vertices && stream.held.erase(edit.node) > 0) {
      ++skipped_;
      stream.has_skipped = true;
    }
    if (is_of_vertices && vertices_of(edit) > 0 && !is_due && stream.shown.contains(edit.node)) {
      waiting.push_back(edit.version);
      BudgetCharge charge = i < change.charges.size() ? std::move(change.charges[i]) : BudgetCharge();
      std::string node = edit.node;
      stream.held.insert_or_assign(std::move(node), Held{std::move(edit), std::move(charge)});
      continue;
    }
    if (kept != i) {
      change.edits[kept] = std::move(edit);
      if (i < change.charges.size()) change.charges[kept] = std::move(change.charges[i]);
    }
    ++kept;
  }
  change.edits.resize(kept);
  if (change.charges.size() > kept) change.charges.resize(kept);
  return waiting;
}

std::vector<state::SceneChanges> VertexPacing::take_due(bool others_active, int64_t now_ns) {
  std::vector<state::SceneChanges> due;
  for (auto& [age, stream] : streams_) {
    if (stream.held.empty() || (others_active && now_ns < stream.next_ns)) continue;
    state::SceneChanges& change = due.emplace_back();
    change.stream = stream.head.stream;
    change.epoch = stream.head.epoch;
    change.age = age;
    change.budget = stream.head.budget;
    for (auto& [node, held] : stream.held) {
      change.edits.push_back(std::move(held.edit));
      change.charges.push_back(std::move(held.charge));
    }
    stream.held.clear();
  }
  return due;
}

void VertexPacing::applied(const state::SceneChanges& change, int64_t now_ns) {
  uint64_t vertices = 0;
  for (const wire::SceneEdit& edit : change.edits) vertices += vertices_of(edit);
  if (vertices == 0) return;
  Stream& stream = streams_[change.age];
  stream.head.stream = change.stream;
  stream.head.epoch = change.epoch;
  stream.head.budget = change.budget;
  for (const wire::SceneEdit& edit : change.edits) {
    if (vertices_of(edit) == 0) continue;
    if (stream.shown.size() >= kMaxNames) stream.shown.clear();
    stream.shown.insert(edit.node);
  }
  unseen_vertices_ += vertices;
  const double each_ns = ns_per_vertex_ > 0 ? ns_per_vertex_ : kUnmeasuredNsPerVertex;
  const double rest_ns = std::max((1 + kRest) * each_ns * static_cast<double>(vertices), 1e9 / kMaxPerSecond);
  stream.next_ns = now_ns + static_cast<int64_t>(std::min(rest_ns, kMaxWaitNs));
}

void VertexPacing::frame_recorded(uint64_t frame_index) {
  if (unseen_vertices_ == 0) return;
  updates_.push_back({frame_index, std::exchange(unseen_vertices_, 0)});
  if (updates_.size() > kMaxUpdatesInFlight) updates_.pop_front();
}

void VertexPacing::frame_finished(uint64_t frame_index, double ms) {
  while (!updates_.empty() && updates_.front().frame_index < frame_index) updates_.pop_front();
  if (updates_.empty() || updates_.front().frame_index != frame_index) return;
  smooth(ns_per_vertex_, ms * 1e6 / static_cast<double>(updates_.front().vertices));
  updates_.pop_front();
}

bool VertexPacing::take_notice(uint64_t age) {
  const auto stream = streams_.find(age);
  if (stream == streams_.end() || !stream->second.has_skipped) return false;
  return !std::exchange(stream->second.is_reported, true);
}

}  // namespace fire3dv::app
