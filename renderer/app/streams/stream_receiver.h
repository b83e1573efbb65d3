// Receiver of streams: decodes messages of all links, binds streams to scene nodes and answers adapters.
// Handles each peer's messages for one time slice per poll, in turns; the rest waits for later polls. Owns
// the listeners.
#pragma once

#include <array>
#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"
#include "renderer/app/options/play_options.h"
#include "renderer/state/image_requests.h"
#include "renderer/state/playout/clock_offset.h"
#include "renderer/state/pose_state.h"

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

  void add(std::unique_ptr<transport::ListenerLink> listener);
  // Called for every event on arrival. Listeners are numbered in the order of add().
  using Watcher = std::function<void(size_t listener, const transport::LinkEvent& event)>;
  void watch(Watcher watcher) { watcher_ = std::move(watcher); }

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

  // Image requests (stream_images.cpp). Without an offer, requests are refused.
  void offer_images(const state::ImageAbilities& abilities) {
    images_ = state::ImageRequestRegistry(abilities);
  }
  // Streams with due images of the current frames. Refuses requests that can no longer be met.
  std::vector<state::ImageDemand> image_demands(int64_t now_ns);
  // Due images of one stream; they stay due until image_made().
  std::vector<state::ImageRequestRegistry::Due> due_images(state::ImageRequestRegistry::Asker asker,
                                                           int64_t now_ns) const;
  void image_made(const state::ImageRequestRegistry::Due& due) { images_->made(due); }
  // Charges the time that a stream's scene edits took to its peer, as that of messages.
  void add_edit_time(state::StreamId stream, int64_t ns);
  // Charges device time to the stream's peer.
  void add_render_time(state::ImageRequestRegistry::Asker asker, int64_t ns);
  void refuse_image(const state::ImageRequestRegistry::Due& due, wire::ImageRefusal reason,
                    const std::string& why);
  // Returns false if the image is lost, since the receiver is too slow or disconnected.
  bool send_image(state::ImageRequestRegistry::Asker asker, const wire::ImageFrame& frame,
                  const transport::ListenerLink::FillPixels& fill);
  wire::Affine3x4d world_from_stream(state::ImageRequestRegistry::Asker asker) const;
  // Asker and id of each request, sorted.
  std::vector<std::pair<state::ImageRequestRegistry::Asker, uint64_t>> image_requests() const {
    return images_ ? images_->open() : std::vector<std::pair<state::ImageRequestRegistry::Asker, uint64_t>>();
  }
  size_t open_image_requests() const { return images_ ? images_->count() : 0; }
  uint64_t refused_image_requests() const { return refused_image_requests_; }

  // Called for a new scene: notifies adapters whose bindings have changed.
  void notify_bindings();

  // Messages to the user since the last call: connections, ends and refusals, with reasons.
  std::vector<std::string> take_notes();
  // Number of messages of all peers that wait for a later poll.
  size_t waiting_messages() const;
  size_t active_streams() const { return stream_of_peer_.size(); }
  bool had_streams() const { return had_streams_; }
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
  };
  std::vector<Report> report() const;
  // Publish time on the local clock; nothing if the publisher's clock offset is unknown.
  std::optional<int64_t> published_ns(uint64_t epoch, uint64_t publish_time_ns) const;

 private:
  using Peer = std::pair<size_t, transport::PeerId>;  // listener index and its peer
  // Rate limit: events per second.
  struct Allowance {
    int64_t since_ns = 0;
    uint32_t used = 0;
    bool take(int64_t now_ns, uint32_t per_second);
  };
  // Message deferred to a later poll.
  struct Waiting {
    uint64_t number = 0;  // order of arrival over all peers
    transport::LinkEvent::Kind kind{};
    wire::Bytes message;
    std::string text;
    int64_t received_ns = 0;
    bool is_dropped = false;  // replaced by a newer pose
    size_t bytes() const;
  };
  // A description for a stream that another connection already publishes. Decided after the older connection
  // had time to answer.
  struct EpochConflict {
    Peer older;
    uint64_t epoch = 0;
    bool may_be_same = false;  // same listener and name
    int64_t asked_ns = 0, decide_ns = 0;
  };
  struct PeerState {
    std::shared_ptr<PeerBudget> budget;
    std::deque<Waiting> waiting;
    std::vector<uint64_t> waiting_poses;  // numbers
    BudgetCharge charge;                  // for `waiting`
    uint64_t poll = 0;                    // poll that spent_ns refers to
    int64_t spent_ns = 0;
    int64_t unrested_ns = 0;     // of control messages since the last poll, and of their scene edits
    int64_t rests_until_ns = 0;  // after these
    int64_t heard_ns = 0;        // last message
    std::optional<EpochConflict> contest;
    bool is_paused = false;      // its link stores further messages
    uint64_t refused_epoch = 0;  // epoch that lost its contest
    int64_t refused_ns = 0;
    uint32_t rejected = 0;
    uint64_t answered_poll = 0;  // poll of the last reply to an unreadable message
    uint32_t refusals_told = 0;  // bits by resource
    Allowance notes;
  };
  // Stream with a lost link, whose slot is reserved.
  struct Left {
    size_t listener = 0;
    uint64_t epoch = 0;
    std::string name;
    uint64_t place = 0;
    int64_t until_ns = 0;
    Peer borrower{};              // stream that temporarily has the slot or its nodes
    uint64_t borrower_epoch = 0;  // 0: none
    bool lent_nodes = false;      // only the nodes are lent; the slot stays reserved
  };
  struct PeerStream {
    state::StreamId id;
    uint64_t epoch;
    std::string name;
    uint64_t acked_sequence = 0;
    uint64_t conflicts_told = 0, unmatched_told = 0;  // revisions of the last Welcome
    uint64_t contests_told = 0;                       // revision of the last Status
    Allowance reports;
    bool interpolated = false;
    std::optional<int64_t> delay_ns;  // fixed delay, if any
    state::ClockOffset clock;
    uint64_t pings = 0;  // number of pings sent; also the last ping's id
    int64_t next_ping_ns = 0;
    bool lost_told = false;
    state::ImageRequestRegistry::Asker asker = 0;
    BudgetCharge description_bytes, names;
  };

  // Budget of a connected peer.
  std::shared_ptr<PeerBudget> budget_of(Peer peer);

  bool receive(Peer peer, const transport::LinkEvent& event);
  void store(Peer peer, PeerState& state, const transport::LinkEvent& event);
  void put_back(Peer peer, const transport::LinkEvent& event);
  static void release(PeerState& state, size_t bytes);
  static void drop_waiting_poses(PeerState& state);
  bool is_whole_frame(std::span<const std::byte> message);
  bool is_ready(const PeerState& state) const {
    return !state.waiting.empty() && !state.contest && (lockstep_ || now_ns_ >= state.rests_until_ns);
  }
  bool has_time(PeerState& state);
  void add_control_time(PeerState& state, int64_t ns);
  bool handle_next(Peer peer);
  bool handle_waiting();
  // Pauses the links of peers with deferred messages, which applies back pressure to the sender.
  void pause_waiting_peers();
  bool handle_in_order();
  bool handle_timed(Peer peer, PeerState& state, const transport::LinkEvent& event);
  bool handle(Peer peer, const transport::LinkEvent& event);
  bool take(Peer peer, const wire::PoseFrameView& frame, int64_t received_ns);
  void send_clock_pings(int64_t now_ns);
  void report_conditions();
  // Returns false if undecided; the message must be handled again.
  bool describe(Peer peer, const wire::StreamDescription& description);
  void accept(Peer peer, const wire::StreamDescription& description, uint64_t place);
  void refuse_version(Peer peer, const wire::StreamDescription& description);
  void refuse_description(Peer peer, uint64_t epoch, wire::WelcomeStatus status, const std::string& reason);
  void begin_conflict(Peer peer, const wire::StreamDescription& description, Peer older);
  void resolve_conflicts();
  void begin_stream(Peer peer, const wire::StreamDescription& description);
  uint64_t borrow_place(Peer peer, const wire::StreamDescription& description);
  void lend_nodes(Left& left);
  void report_refusals();
  void welcome(Peer peer, PeerStream& stream);
  void report_bindings(bool scene_is_new);
  void send_status(Peer peer, PeerStream& stream, const std::string& message);
  void ask_for_image(Peer peer, const wire::ImageRequest& request);
  void send_refusal(Peer peer, const wire::ImageRefused& refused);
  const std::pair<const Peer, PeerStream>* find_asker(state::ImageRequestRegistry::Asker asker) const;
  std::optional<state::ImageRequestRegistry::Shown> shown_of(state::ImageRequestRegistry::Asker asker) const;
  void end_stream(Peer peer, const std::string& reason);
  // Same as end_stream(), but reserves the slot for a grace time; returns the slot. lends: a stream of the
  // same name gets its nodes meanwhile.
  uint64_t suspend_stream(Peer peer, const std::string& reason, bool lends);
  void drop_stream(Peer peer, const std::string& reason);
  void reply(Peer peer, const wire::Bytes& message);
  void reject(Peer peer, Refusal refusal, const std::string& reason);
  // Attributed to the peer whose message is being handled, if any.
  void note(std::string text);

  state::PoseState& poses_;
  bool lockstep_;
  PlayOptions play_;
  std::shared_ptr<BudgetPool> budgets_;
  Clock clock_;
  int64_t now_ns_ = 0;  // last reading of clock_
  std::vector<std::unique_ptr<transport::ListenerLink>> listeners_;
  Watcher watcher_;
  wire::Decoder decoder_;
  std::map<Peer, PeerState> peers_;
  std::vector<Peer> turns_;  // scratch memory of handle_waiting()
  Peer last_turn_{};
  uint64_t polls_ = 0, last_number_ = 0;
  std::map<Peer, PeerStream> stream_of_peer_;
  std::vector<Left> left_;
  std::optional<Peer> handled_peer_;
  std::vector<std::string> notes_;
  Allowance all_notes_;
  uint32_t notes_left_out_ = 0;
  bool had_streams_ = false;
  std::array<uint64_t, kRefusalCount> refusals_{};
  std::optional<state::ImageRequestRegistry> images_;
  uint64_t refused_image_requests_ = 0;
  std::map<state::ImageRequestRegistry::Asker, Peer> peer_of_asker_;
  state::ImageRequestRegistry::Asker last_asker_ = 0;
};

}  // namespace fire3dv::app
