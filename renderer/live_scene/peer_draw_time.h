// Drawing time of peers in the displayed scene: estimates the content of each peer for the views that are
// drawn, hands measured times to the policy, and hides in the scene what the policy hides. Independent of
// Vulkan. Single-threaded.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/live_scene/live_scene.h"
#include "renderer/state/draw_time/draw_time_policy.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

class PeerDrawTime {
 public:
  using Policy = state::DrawTimePolicy;
  // Borrows scene and poses. now_ns: clock, for tests; default: the monotonic one.
  PeerDrawTime(LiveScene& scene, const state::PoseState& poses, const state::DrawTimeSettings& settings,
               std::function<int64_t()> now_ns = {});

  // Once in a turn of the frame loop: peers come and go. Stores costs in their budgets now and then.
  void poll();
  bool is_active() const { return policy_.is_active(); }
  // True while costly work of a peer may be given up for others.
  bool limits() const { return policy_.limits(); }

  // First view of a submission that is about to be recorded.
  struct View {
    uint64_t kind = 0;  // views of one kind have the same requester and size
    uint64_t pixels = 0;
    std::optional<uint64_t> requester_epoch;  // of a stream; nullopt: the renderer's own image
    state::WorkView view;
    bool markers = false;  // LiveScene::show_markers() was called for it
  };
  // Returns true if other content is visible than before: the caller shows markers again.
  bool begin_image(const View& view);
  // The submission has this number, and so many such images.
  void submitted(uint64_t submission, double images = 1);
  void finished(uint64_t submission, const Policy::Measured& measured);
  // The submission of the last image, or the preparation of new content, was abandoned.
  void abandoned(int64_t elapsed_ns);
  // Limit of the submission that begins; nullopt: none.
  std::optional<int64_t> abandon_after_ns() const;

  // Log messages since the last call.
  std::vector<std::string> take_log_messages() { return std::exchange(log_messages_, {}); }
  // The same for the streams that the messages are about.
  std::vector<std::pair<state::StreamId, std::string>> take_messages_to_streams() {
    return std::exchange(messages_to_streams_, {});
  }

 private:
  struct MeshNode {
    uint32_t node = 0, mesh = 0;
    uint64_t triangles = 0;
  };
  struct Cached {
    uint64_t updates = 0, revision = 0;
    int64_t at_ns = 0;
    View view;
    std::vector<Policy::Content> content;
  };
  struct Replaced {
    std::shared_ptr<const scene::ReplacedVertices> vertices;
    int64_t changed_ns = 0;
  };

  using Meshes = std::map<Policy::Peer, std::vector<MeshNode>>;
  static Meshes meshes_below(const scene::Scene& scene, const std::vector<LiveScene::PeerRoot>& roots);
  bool has_content(Policy::Peer peer) const;
  void find_meshes();
  const std::vector<Policy::Content>& content_of(const View& view, int64_t now_ns);
  void add_markers(const View& view, std::map<Policy::Peer, Policy::Content>& content) const;
  void add_meshes(const View& view, int64_t now_ns, std::map<Policy::Peer, Policy::Content>& content);
  std::set<const PeerBudget*> admit(const scene::LoadedScene& next,
                                    const std::vector<LiveScene::PeerRoot>& roots);
  bool apply();
  void store_costs();
  void report_notices();
  const PeerBudget* peer_of_epoch(uint64_t epoch) const;

  LiveScene& scene_;
  const state::PoseState& poses_;
  const std::function<int64_t()> now_ns_;
  Policy policy_;
  uint64_t applied_revision_ = 0;
  int64_t stored_ns_ = 0;
  bool has_costs_ = false;             // stored
  std::optional<uint64_t> meshes_of_;  // LiveScene::replaced() of meshes_
  Meshes meshes_;
  std::map<Policy::Peer, state::DrawWork>
      refused_;  // meshes that are not uploaded, until the peer changes them
  std::map<uint32_t, Replaced> replaced_;
  std::map<uint64_t, Cached> cached_;  // by kind
  std::optional<Policy::Image> image_;
  std::deque<std::pair<uint64_t, Policy::Image>> submissions_;
  std::vector<std::string> log_messages_;
  std::vector<std::pair<state::StreamId, std::string>> messages_to_streams_;
};

}  // namespace fire3dv::app
