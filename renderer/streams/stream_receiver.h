// Receiver of streams: decodes messages of all links, binds streams to scene nodes and replies to adapters.
// Owns the listeners.
// More than 60 members: identities and replies of a peer end with its connection, in one place.
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"
#include "renderer/state/pose_state.h"
#include "renderer/state/stream_timing.h"
#include "renderer/streams/frame_loss_monitor.h"
#include "renderer/streams/image_router.h"
#include "renderer/streams/input_router.h"
#include "renderer/streams/message_scheduler.h"
#include "renderer/streams/playout_options.h"
#include "renderer/streams/receiver_log.h"
#include "renderer/streams/stream_admission.h"

namespace fire3dv::app {

// Reasons for rejecting a complete message.
enum class Refusal : uint8_t {
  unreadable,          // invalid message or values
  before_description,  // pose frame without a stream description
  wrong_way,           // message that only renderers send
  version,             // another major version of the protocol
};
constexpr size_t kRefusalCount = 4;
const char* refusal_name(Refusal refusal);

class StreamReceiver {
 public:
  // lockstep: listeners deliver every frame, and poll() stops after the first displayable one. budgets: for
  // peers whose link has none; null: a pool with the default limits.
  StreamReceiver(state::PoseState& poses, bool lockstep, const PlayOptions& play = {},
                 std::shared_ptr<BudgetPool> budgets = nullptr);
  StreamReceiver(const StreamReceiver&) = delete;

  void add(std::unique_ptr<transport::ListenerLink> listener);
  // Called for every event on arrival. Listeners are numbered in the order of add().
  using Watcher = std::function<void(size_t listener, const transport::LinkEvent& event)>;
  void watch(Watcher watcher) { watcher_ = std::move(watcher); }
  // See ListenerLink::end_arrivals().
  void end_arrivals() {
    for (const auto& listener : listeners_) listener->end_arrivals();
  }

  // Clock of time slices, grace times and rates, in ns; default: monotonic clock. For tests.
  using Clock = std::function<int64_t()>;
  void set_clock(Clock clock) { clock_.read_ns = std::move(clock); }

  // Handles arrived messages. Returns true if there is a new pose frame to show. Never blocks.
  bool poll();
  // Waits for messages, at most this long.
  void wait(std::chrono::nanoseconds timeout);
  // Overrides the playout options of one stream. Not in lockstep.
  void play(uint64_t epoch, bool interpolate, std::optional<int64_t> delay_ns);
  // Acknowledges these frames to their adapters: an image of them is finished.
  void acknowledge(const std::vector<state::FrameTag>& shown);

  // Charges the time that a stream's scene edits took to its peer, as that of messages.
  void add_edit_time(state::StreamId stream, int64_t ns);

  // Tells a stream that one of its scene edits has no effect, and why. Streams that have ended are ignored.
  void report_ineffective_edit(state::StreamId stream, const std::string& reason);

  // Tells a stream how its content is drawn. Streams that have ended are ignored.
  void report_drawing(state::StreamId stream, const std::string& text);

  // The displayed scene, borrowed, whose nodes are named to streams that match none; null (default): none
  // are.
  void set_scene(const scene::Scene* scene) { scene_ = scene; }
  // Image requests of streams.
  ImageRouter& images() { return images_; }
  const ImageRouter& images() const { return images_; }
  // Events of people to streams.
  InputRouter& inputs() { return inputs_; }
  const InputRouter& inputs() const { return inputs_; }

  // Called for a new scene: notifies adapters whose bindings have changed.
  void notify_bindings();

  // Log messages since the last call: connections, ends and refusals, with reasons.
  std::vector<std::string> take_log_messages() { return log_.take(); }
  // Number of deferred messages of all peers.
  size_t deferred_messages() const { return scheduler_.deferred_messages(); }
  size_t active_streams() const { return stream_of_peer_.size(); }
  bool had_streams() const { return had_streams_; }
  // False while a replay stands: then streams without frames are not reported.
  void expect_frames(bool expected) {
    if (expected && !expects_frames_) expects_since_ns_ = clock_.now_ns;
    expects_frames_ = expected;
  }
  uint64_t rejected_messages() const;

  // State for metrics and panels.
  struct LinkReport {
    std::string uri;
    transport::LinkStats stats;
  };
  std::vector<LinkReport> links() const;
  const std::array<uint64_t, kRefusalCount>& refusals() const { return refusals_; }
  struct Report {
    state::StreamId id = 0;
    std::string listener;  // URI of its listener
    state::ClockOffset::Source clock{};
    std::shared_ptr<const PeerBudget> budget;  // budget of its peer; null before the first charge
    uint64_t overtaken = 0;  // pose messages that newer ones replaced before they were handled
  };
  std::vector<Report> report() const;
  // Publish time on the local clock; nothing if the publisher's clock offset is unknown.
  std::optional<int64_t> published_ns(uint64_t epoch, uint64_t publish_time_ns) const;

 private:
  using Peer = LinkPeer;
  // A description for a stream that another connection already publishes. Decided after the older connection
  // had time to answer a ping.
  struct EpochConflict {
    Peer older;
    uint64_t epoch = 0;
    bool may_be_same = false;  // same listener and name
    int64_t pinged_ns = 0, decide_ns = 0;
  };
  struct PeerState {
    std::shared_ptr<PeerBudget> budget;
    int64_t last_message_ns = 0;
    std::optional<EpochConflict> conflict;
    std::string host;            // see StreamAdmission
    uint64_t refused_epoch = 0;  // epoch that lost its conflict
    int64_t refused_ns = 0;
    uint32_t rejected = 0;
    uint64_t answered_poll = 0;      // poll of the last reply to an unreadable message
    uint32_t reported_refusals = 0;  // bits by resource
    RateLimit log_limit;
  };
  // Stream with a lost link, whose slot and nodes are reserved for a grace time. A restarted publisher may
  // use them meanwhile: its successor.
  struct SuspendedStream {
    size_t listener = 0;
    uint64_t epoch = 0;
    std::string name;
    uint64_t reservation = 0;  // of PoseState
    int64_t until_ns = 0;
    Peer successor{};
    uint64_t successor_epoch = 0;  // 0: none
    bool has_nodes_only = false;   // the successor has the nodes; the slot stays reserved
  };
  // Published stream. Identities: the peer is a connection; the epoch names a run, but several connections
  // may claim it; `id` is a slot of PoseState that is reused; `requester` is unique to this run on this
  // connection.
  struct PeerStream {
    state::StreamId id;
    uint64_t epoch;
    std::string name;
    uint64_t acked_sequence = 0;
    uint64_t reported_conflicting = 0, reported_unmatched = 0;  // revisions of the last Welcome
    uint64_t reported_contested = 0;                            // revision of the last Status
    bool checked_poses = false;                                 // of its first frame, see report_poses()
    std::vector<std::string> advice;                            // to be sent; without its subject
    RateLimit reports;
    bool interpolated = false;
    std::optional<int64_t> delay_ns;  // fixed delay, if any
    state::ClockOffset clock;
    uint64_t pings = 0;  // number of pings sent; also the last ping's id
    int64_t next_ping_ns = 0;
    bool reported_lost = false, reported_waiting = false;
    FrameLossMonitor losses;
    uint64_t overtaken = 0;  // see Report
    state::RequesterId requester = 0;
    BudgetCharge description_bytes, names;
  };

  // Budget of a connected peer.
  std::shared_ptr<PeerBudget> budget_of(Peer peer);

  bool receive(Peer peer, const transport::LinkEvent& event);
  void count_overtaken(Peer peer, uint64_t poses);
  bool handle(Peer peer, const transport::LinkEvent& event);
  bool receive_frame(Peer peer, const wire::PoseFrameView& frame, int64_t received_ns);
  void send_clock_pings();
  void report_conditions();
  void report_losses(Peer peer, PeerStream& stream);
  // Returns false if undecided; the message must be handled again.
  bool handle_description(Peer peer, const wire::StreamDescription& description);
  bool admit(Peer peer, const wire::StreamDescription& description);
  void accept_stream(Peer peer, const wire::StreamDescription& description, uint64_t reservation);
  void refuse_version(Peer peer, const wire::StreamDescription& description);
  void refuse_description(Peer peer, uint64_t epoch, wire::WelcomeStatus status, const std::string& reason);
  void begin_conflict(Peer peer, const wire::StreamDescription& description, Peer older);
  void resolve_conflicts();
  void begin_stream(Peer peer, const wire::StreamDescription& description);
  uint64_t claim_slot_of_suspended(Peer peer, const wire::StreamDescription& description);
  void pass_nodes_to_successor(SuspendedStream& suspended);
  void report_poses();
  void send_advice(Peer peer, PeerStream& stream);
  void send_advice_to(state::StreamId id, std::string&& advice);
  void report_refusals();
  void welcome(Peer peer, PeerStream& stream);
  void report_bindings(bool scene_is_new);
  void send_status(Peer peer, PeerStream& stream, const std::string& message);
  void end_stream(Peer peer, const std::string& reason);
  // Same as end_stream(), but reserves the slot for a grace time; returns the slot. passes_nodes: a stream of
  // the same name gets its nodes meanwhile.
  uint64_t suspend_stream(Peer peer, const std::string& reason, bool passes_nodes);
  void drop_stream(Peer peer, const std::string& reason);
  void reply(Peer peer, const wire::Bytes& message);
  std::optional<Peer> peer_of(uint64_t epoch) const;
  void reject(Peer peer, Refusal refusal, const std::string& reason);
  // Attributed to the peer whose message is being handled, if any.
  void log(std::string text);

  state::PoseState& poses_;
  const scene::Scene* scene_ = nullptr;
  bool lockstep_;
  PlayOptions play_;
  std::shared_ptr<BudgetPool> budgets_;
  PollClock clock_;
  std::vector<std::unique_ptr<transport::ListenerLink>> listeners_;
  Watcher watcher_;
  wire::Decoder decoder_;
  std::map<Peer, PeerState> peers_;
  MessageScheduler scheduler_;
  StreamAdmission admission_;
  uint64_t poll_ = 0;
  std::map<Peer, PeerStream> stream_of_peer_;
  std::vector<SuspendedStream> suspended_;
  std::optional<Peer> handled_peer_;
  ReceiverLog log_;
  bool had_streams_ = false;
  bool expects_frames_ = true;
  int64_t expects_since_ns_ = std::numeric_limits<int64_t>::min() / 2;
  int64_t conditions_at_ns_ = 0;  // last look at them
  std::array<uint64_t, kRefusalCount> refusals_{};
  ImageRouter images_;
  InputRouter inputs_;
};

}  // namespace fire3dv::app
