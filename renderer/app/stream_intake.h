// Receiver of streams: decodes messages of all links, binds streams to the scene and answers adapters. Peers
// take turns: a peer's messages are handled for one time slice per poll, and the rest in the next polls. Owns
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
#include "renderer/app/play_options.h"
#include "renderer/state/clock_offset.h"
#include "renderer/state/image_book.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

// Why a whole message was turned away.
enum class Refusal : uint8_t {
  unreadable,          // no message, or values that are not allowed
  before_description,  // a pose frame of nobody knows what
  wrong_way,           // what only renderers send
  version,             // another major version of the protocol
};
constexpr size_t kRefusalCount = 4;
const char* refusal_name(Refusal refusal);

class StreamIntake {
 public:
  // lockstep: the listeners deliver every frame, and poll() stops after the first that is to be shown.
  // budgets: of peers whose link has none of its own; null: a pool with the default limits.
  StreamIntake(state::PoseState& poses, bool lockstep, const PlayOptions& play = {},
               std::shared_ptr<BudgetPool> budgets = nullptr);

  void add(std::unique_ptr<transport::ListenerLink> listener);
  // Sees all that comes, when it comes. Listeners have numbers, in the order in which they were added.
  using Watcher = std::function<void(size_t listener, const transport::LinkEvent& event)>;
  void watch(Watcher watcher) { watcher_ = std::move(watcher); }

  // Source of the time of slices, grace times and rates, in ns; by default the monotonic clock. For tests.
  using Clock = std::function<int64_t()>;
  void set_clock(Clock clock) { clock_ = std::move(clock); }

  // Takes what has arrived. Returns true when there is a new pose frame to show. Never waits.
  bool poll();
  // Waits until there may be something, at most this long.
  void wait(std::chrono::nanoseconds timeout);
  // How this stream is shown in time from now on, instead of what the options say. Not in lockstep.
  void play(uint64_t epoch, bool interpolate, std::optional<int64_t> delay_ns);
  // Tells the adapters of these streams that an image of these frames is finished.
  void acknowledge(const std::vector<state::FrameTag>& shown);

  // Images that adapters ask for (stream_images.cpp). Without an offer they are told that none are made.
  void offer_images(const state::ImageAbilities& abilities) { images_ = state::ImageBook(abilities); }
  // Streams with images that are due of the frames shown now. Refuses requests that cannot be met any more.
  std::vector<state::ImageDemand> image_demands(int64_t now_ns);
  // Due images of one of them; they stay due until image_made().
  std::vector<state::ImageBook::Due> due_images(state::ImageBook::Asker asker, int64_t now_ns) const;
  void image_made(const state::ImageBook::Due& due) { images_->made(due); }
  // Charges device time to the stream's peer.
  void add_render_time(state::ImageBook::Asker asker, int64_t ns);
  void refuse_image(const state::ImageBook::Due& due, wire::ImageRefusal reason, const std::string& why);
  // False: it is lost, since the asker takes images too slowly or is gone.
  bool send_image(state::ImageBook::Asker asker, const wire::ImageFrame& frame,
                  const transport::ListenerLink::FillPixels& fill);
  wire::Affine3x4d world_from_stream(state::ImageBook::Asker asker) const;
  // Asker and id of each, in their order.
  std::vector<std::pair<state::ImageBook::Asker, uint64_t>> image_requests() const {
    return images_ ? images_->open() : std::vector<std::pair<state::ImageBook::Asker, uint64_t>>();
  }
  size_t open_image_requests() const { return images_ ? images_->count() : 0; }
  uint64_t refused_image_requests() const { return refused_image_requests_; }

  // Another scene is shown: tells the adapters whose names have other nodes now.
  void tell_bindings();

  // Sentences for the user since the last call: who came, went, or was refused, and why.
  std::vector<std::string> take_notes();
  // Messages that wait for a later poll, of all peers.
  size_t waiting_messages() const;
  size_t active_streams() const { return stream_of_peer_.size(); }
  bool had_streams() const { return had_streams_; }
  uint64_t rejected_messages() const;

  // For those who watch the renderer.
  struct LinkReport {
    std::string uri;
    transport::LinkStats stats;
  };
  std::vector<LinkReport> links() const;
  const std::array<uint64_t, kRefusalCount>& refusals() const { return refusals_; }
  struct Report {
    state::StreamId id = 0;
    std::string listener;  // its URI
    state::ClockOffset::Source clock{};
    std::shared_ptr<const PeerBudget> budget;  // of its peer; null before the first charge
  };
  std::vector<Report> report() const;
  // When a frame was published, on our clock; nothing while the publisher's is not known.
  std::optional<int64_t> published_ns(uint64_t epoch, uint64_t publish_time_ns) const;

 private:
  using Peer = std::pair<size_t, transport::PeerId>;  // listener and its peer
  // At most so many events in one second.
  struct Allowance {
    int64_t since_ns = 0;
    uint32_t used = 0;
    bool take(int64_t now_ns, uint32_t per_second);
  };
  // A message that waits for a later poll.
  struct Waiting {
    uint64_t number = 0;  // rises with arrival, over all peers
    transport::LinkEvent::Kind kind{};
    wire::Bytes message;
    std::string text;
    int64_t received_ns = 0;
    bool is_dropped = false;  // a newer pose took its place
    size_t bytes() const;
  };
  // A description whose stream another connection publishes already: decided when that one has had time to
  // answer.
  struct Contest {
    Peer older;
    uint64_t epoch = 0;
    bool may_be_same = false;  // same listener and name
    int64_t asked_ns = 0, decide_ns = 0;
  };
  struct PeerState {
    std::shared_ptr<PeerBudget> budget;
    std::deque<Waiting> waiting;
    std::vector<uint64_t> waiting_poses;  // numbers
    BudgetCharge charge;                  // of what waits
    uint64_t poll = 0;                    // of which spent_ns is
    int64_t spent_ns = 0;
    int64_t rests_until_ns = 0;  // after a long message
    int64_t heard_ns = 0;        // last message
    std::optional<Contest> contest;
    bool is_paused = false;      // its link keeps further messages
    uint64_t refused_epoch = 0;  // that lost its contest
    int64_t refused_ns = 0;
    uint32_t rejected = 0;
    uint64_t answered_poll = 0;  // poll in which an unreadable message of it was answered last
    uint32_t refusals_told = 0;  // bits of resources
    Allowance notes;
  };
  // A stream whose link was lost: it may return to its place.
  struct Left {
    size_t listener = 0;
    uint64_t epoch = 0;
    std::string name;
    uint64_t place = 0;
    int64_t until_ns = 0;
    Peer borrower{};              // a stream of that name that has the place, or its nodes, meanwhile
    uint64_t borrower_epoch = 0;  // 0: none has
    bool lent_nodes = false;      // the place is reserved still
  };
  struct PeerStream {
    state::StreamId id;
    uint64_t epoch;
    std::string name;
    uint64_t acked_sequence = 0;
    uint64_t conflicts_told = 0, unmatched_told = 0;  // revisions as of the last Welcome
    uint64_t contests_told = 0;                       // as of the last Status
    Allowance reports;
    bool interpolated = false;
    std::optional<int64_t> delay_ns;  // where it is fixed
    state::ClockOffset clock;
    uint64_t pings = 0;  // asked so far, which are their ids
    int64_t next_ping_ns = 0;
    bool lost_told = false;
    state::ImageBook::Asker asker = 0;
    BudgetCharge description_bytes, names;
  };

  // The budget of a peer that is connected.
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
  bool handle_next(Peer peer);
  bool handle_waiting();
  // A peer whose messages wait here sends no more from its link, which holds the sender back.
  void pause_waiting_peers();
  bool handle_in_order();
  bool handle_timed(Peer peer, PeerState& state, const transport::LinkEvent& event);
  bool handle(Peer peer, const transport::LinkEvent& event);
  bool take(Peer peer, const wire::PoseFrameView& frame, int64_t received_ns);
  void ask_for_time(int64_t now_ns);
  void tell_conditions();
  // False: decided later; the message is to be handled again then.
  bool describe(Peer peer, const wire::StreamDescription& description);
  void accept(Peer peer, const wire::StreamDescription& description, uint64_t place);
  void refuse_version(Peer peer, const wire::StreamDescription& description);
  void refuse_description(Peer peer, uint64_t epoch, wire::WelcomeStatus status, const std::string& reason);
  void begin_contest(Peer peer, const wire::StreamDescription& description, Peer older);
  void decide_contests();
  void begin_stream(Peer peer, const wire::StreamDescription& description);
  uint64_t borrow_place(Peer peer, const wire::StreamDescription& description);
  void lend_nodes(Left& left);
  void report_refusals();
  void welcome(Peer peer, PeerStream& stream);
  void report_bindings(bool scene_is_new);
  void send_status(Peer peer, PeerStream& stream, const std::string& message);
  void ask_for_image(Peer peer, const wire::ImageRequest& request);
  void tell_refused(Peer peer, const wire::ImageRefused& refused);
  const std::pair<const Peer, PeerStream>* find_asker(state::ImageBook::Asker asker) const;
  std::optional<state::ImageBook::Shown> shown_of(state::ImageBook::Asker asker) const;
  void end_stream(Peer peer, const std::string& reason);
  // As end_stream(), but its place is reserved for a grace time; returns it. lends: a stream of the same name
  // that is there gets its nodes meanwhile.
  uint64_t suspend_stream(Peer peer, const std::string& reason, bool lends);
  void drop_stream(Peer peer, const std::string& reason);
  void reply(Peer peer, const wire::Bytes& message);
  void reject(Peer peer, Refusal refusal, const std::string& reason);
  // Of the peer whose message is handled, if one is.
  void note(std::string text);

  state::PoseState& poses_;
  bool lockstep_;
  PlayOptions play_;
  std::shared_ptr<BudgetPool> budgets_;
  Clock clock_;
  int64_t now_ns_ = 0;  // the last reading of the clock
  std::vector<std::unique_ptr<transport::ListenerLink>> listeners_;
  Watcher watcher_;
  wire::Decoder decoder_;
  std::map<Peer, PeerState> peers_;
  std::vector<Peer> turns_;  // memory of handle_waiting()
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
  std::optional<state::ImageBook> images_;
  uint64_t refused_image_requests_ = 0;
  std::map<state::ImageBook::Asker, Peer> peer_of_asker_;
  state::ImageBook::Asker last_asker_ = 0;
};

}  // namespace fire3dv::app
