// Receiver of streams: decodes messages of all links, binds streams to scene nodes and replies to adapters.
// It handles each peer's messages for a time slice per poll and defers the others. Owns the listeners.
// More than 60 members: turns, identities and replies of a peer end with its connection, in one place.
#pragma once

#include <array>
#include <chrono>
#include <deque>
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
#include "renderer/streams/image_request_queue.h"
#include "renderer/streams/playout_options.h"
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

class StreamReceiver final : public ImageReplies {
 public:
  // lockstep: listeners deliver every frame, and poll() stops after the first displayable one. budgets: for
  // peers whose link has none; null: a pool with the default limits.
  StreamReceiver(state::PoseState& poses, bool lockstep, const PlayOptions& play = {},
                 std::shared_ptr<BudgetPool> budgets = nullptr);

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
  void set_clock(Clock clock) { clock_ = std::move(clock); }

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
  // Borrowed; null (default): image requests are refused.
  void set_image_handler(ImageRequestHandler* handler) { image_handler_ = handler; }
  uint64_t refused_image_requests() const { return refused_image_requests_; }
  // ImageReplies (image_requests.cpp).
  std::optional<Shown> shown(state::RequesterId requester) const override;
  void refuse_image(state::RequesterId requester, const wire::ImageRefused& refused, bool is_logged) override;
  bool send_image(state::RequesterId requester, const wire::ImageFrame& frame,
                  const transport::ListenerLink::FillPixels& fill) override;

  // Called for a new scene: notifies adapters whose bindings have changed.
  void notify_bindings();

  // Log messages since the last call: connections, ends and refusals, with reasons.
  std::vector<std::string> take_log_messages();
  // Number of deferred messages of all peers.
  size_t deferred_messages() const;
  size_t active_streams() const { return stream_of_peer_.size(); }
  bool had_streams() const { return had_streams_; }
  // False while a replay stands: then streams without frames are not reported.
  void expect_frames(bool expected) {
    if (expected && !expects_frames_) expects_since_ns_ = now_ns_;
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
  using Peer = std::pair<size_t, transport::PeerId>;  // listener index and its peer
  // Limit of events per second.
  struct RateLimit {
    int64_t since_ns = 0;
    uint32_t used = 0;
    bool take(int64_t now_ns, uint32_t per_second);
  };
  // Message deferred to a later poll.
  struct DeferredMessage {
    uint64_t number = 0;  // order of arrival over all peers
    transport::LinkEvent::Kind kind{};
    wire::Bytes message;
    std::string text;
    int64_t received_ns = 0;
    bool is_dropped = false;  // replaced by a newer pose
    size_t bytes() const;
  };
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
    std::deque<DeferredMessage> deferred;
    std::vector<uint64_t> deferred_poses;  // numbers
    BudgetCharge charge;                   // for `deferred`
    uint64_t poll = 0;                     // poll that spent_ns refers to
    int64_t spent_ns = 0;
    int64_t control_ns = 0;          // of control messages and their scene edits, until the next throttling
    int64_t throttled_until_ns = 0;  // no message is handled before
    int64_t last_message_ns = 0;
    std::optional<EpochConflict> conflict;
    std::string host;                 // see StreamAdmission
    bool is_awaiting_stream = false;  // its description waits for the admission of its host
    bool is_paused = false;           // its link stores further messages
    uint64_t refused_epoch = 0;       // epoch that lost its conflict
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
  void store(Peer peer, PeerState& state, const transport::LinkEvent& event);
  void put_back(Peer peer, const transport::LinkEvent& event);
  static void release(PeerState& state, size_t bytes);
  void drop_deferred_poses(Peer peer, PeerState& state);
  void count_overtaken(Peer peer, uint64_t poses);
  bool is_whole_frame(std::span<const std::byte> message);
  bool is_ready(const PeerState& state) const {
    return !state.deferred.empty() && !state.conflict && (lockstep_ || now_ns_ >= state.throttled_until_ns);
  }
  bool has_time(PeerState& state);
  void add_control_time(PeerState& state, int64_t ns);
  bool handle_next(Peer peer);
  bool handle_deferred();
  // Pauses the links of peers with deferred messages, which applies back pressure to the sender.
  void pause_deferred_peers();
  bool handle_in_order();
  bool handle_timed(Peer peer, PeerState& state, const transport::LinkEvent& event);
  bool handle(Peer peer, const transport::LinkEvent& event);
  bool receive_frame(Peer peer, const wire::PoseFrameView& frame, int64_t received_ns);
  void send_clock_pings(int64_t now_ns);
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
  void route_image_request(Peer peer, const wire::ImageRequest& request);
  void send_refusal(Peer peer, const wire::ImageRefused& refused);
  const std::pair<const Peer, PeerStream>* find_requester(state::RequesterId requester) const;
  void end_stream(Peer peer, const std::string& reason);
  // Same as end_stream(), but reserves the slot for a grace time; returns the slot. passes_nodes: a stream of
  // the same name gets its nodes meanwhile.
  uint64_t suspend_stream(Peer peer, const std::string& reason, bool passes_nodes);
  void drop_stream(Peer peer, const std::string& reason);
  void reply(Peer peer, const wire::Bytes& message);
  void reject(Peer peer, Refusal refusal, const std::string& reason);
  // Attributed to the peer whose message is being handled, if any.
  void log(std::string text);

  state::PoseState& poses_;
  const scene::Scene* scene_ = nullptr;
  bool lockstep_;
  PlayOptions play_;
  std::shared_ptr<BudgetPool> budgets_;
  Clock clock_;
  int64_t now_ns_ = 0;  // last reading of clock_
  std::vector<std::unique_ptr<transport::ListenerLink>> listeners_;
  Watcher watcher_;
  wire::Decoder decoder_;
  std::map<Peer, PeerState> peers_;
  std::vector<Peer> turns_;  // scratch memory of handle_deferred()
  Peer last_turn_{};
  StreamAdmission admission_;
  uint64_t polls_ = 0, last_number_ = 0;
  std::map<Peer, PeerStream> stream_of_peer_;
  std::vector<SuspendedStream> suspended_;
  std::optional<Peer> handled_peer_;
  std::vector<std::string> log_messages_;
  RateLimit total_log_limit_;
  uint32_t suppressed_logs_ = 0;
  bool had_streams_ = false;
  bool expects_frames_ = true;
  int64_t expects_since_ns_ = std::numeric_limits<int64_t>::min() / 2;
  int64_t conditions_at_ns_ = 0;  // last look at them
  std::array<uint64_t, kRefusalCount> refusals_{};
  ImageRequestHandler* image_handler_ = nullptr;
  uint64_t refused_image_requests_ = 0;
  std::map<state::RequesterId, Peer> peer_of_requester_;
  state::RequesterId last_requester_ = 0;
};

}  // namespace fire3dv::app
