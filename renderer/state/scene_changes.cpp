// Scene edits of streams within PoseState. They are collected here and handed to the owner of the scene.
#include <algorithm>

#include "renderer/state/pose_state.h"

namespace fire3dv::state {

bool PoseState::apply(StreamId id, wire::SceneEdit&& edit) {
  if (id >= streams_.size() || !streams_[id].active) return false;
  if (edit.epoch != streams_[id].epoch) return count_edit(id, StreamEdits::Outcome::stale);
  const StreamEdits::Outcome outcome = receive_states_[id].edits.add(std::move(edit));
  if (outcome == StreamEdits::Outcome::refused)
    refuse(id, receive_states_[id].edits.refused_resource(), receive_states_[id].edits.refusal());
  return count_edit(id, outcome);
}

bool PoseState::apply(StreamId id, const wire::UnknownEdit& edit) {
  if (id >= streams_.size() || !streams_[id].active) return false;
  if (edit.epoch != streams_[id].epoch) return count_edit(id, StreamEdits::Outcome::stale);
  return count_edit(id, receive_states_[id].edits.skip(edit.version));
}

bool PoseState::count_edit(StreamId id, StreamEdits::Outcome outcome) {
  switch (outcome) {
    case StreamEdits::Outcome::taken:
      ++streams_[id].edits_received;
      break;
    case StreamEdits::Outcome::stale:
      ++streams_[id].edits_stale;
      return false;
    case StreamEdits::Outcome::refused:
      ++streams_[id].edits_refused;
      break;
  }
  return release_held(id);
}

bool PoseState::finish_edit(StreamId id, uint64_t epoch, uint64_t version) {
  if (id >= streams_.size() || !streams_[id].active || streams_[id].epoch != epoch) return false;
  receive_states_[id].edits.finish(version);
  return release_held(id);
}

std::vector<SceneChanges> PoseState::take_scene_changes() {
  std::vector<SceneChanges> changes;
  changes.swap(ended_);
  const auto first = static_cast<std::ptrdiff_t>(changes.size());
  for (StreamId id = 0; id < streams_.size(); ++id) {
    if (!streams_[id].active || !receive_states_[id].edits.has_news()) continue;
    StreamEdits::Taken taken = receive_states_[id].edits.take();
    changes.push_back({id, streams_[id].epoch, receive_states_[id].order, false, std::move(taken.edits),
                       receive_states_[id].budget, std::move(taken.charges)});
  }
  std::sort(changes.begin() + first, changes.end(),
            [](const SceneChanges& a, const SceneChanges& b) { return a.age < b.age; });
  return changes;
}

}  // namespace fire3dv::state
