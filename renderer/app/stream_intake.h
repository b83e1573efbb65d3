// From links to pose state: decodes what arrives, binds streams, answers adapters. It owns the listeners.
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
  // What is due of what is shown now; whoever asked for what cannot be met any more is told.
  std::vector<state::ImageBook::Due> take_due_images(int64_t now_ns);
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
  };
  std::vector<Report> report() const;
  // When a frame was published, on our clock; nothing while the publisher's is not known.
  std::optional<int64_t> published_ns(uint64_t epoch, uint64_t publish_time_ns) const;

 private:
  using Peer = std::pair<size_t, transport::PeerId>;  // listener and its peer
  struct Held {
    Peer peer;
    transport::LinkEvent::Kind kind;
    wire::Bytes message;
    std::string text;
    int64_t received_ns = 0;
  };
  struct PeerStream {
    state::StreamId id;
    uint64_t epoch;
    std::string name;
    uint64_t acked_sequence = 0;
    std::vector<std::string> conflicts_told, unmatched_told;  // as of the last Welcome
    std::vector<std::string> contests_told;                   // as of the last Status
    bool interpolated = false;
    std::optional<int64_t> delay_ns;  // where it is fixed
    state::ClockOffset clock;
    uint64_t pings = 0;  // asked so far, which are their ids
    int64_t next_ping_ns = 0;
    bool lost_told = false;
    state::ImageBook::Asker asker = 0;
  };

  // The budget of a peer that is connected.
  std::shared_ptr<PeerBudget> budget_of(Peer peer);

  bool handle(Peer peer, transport::LinkEvent::Kind kind, std::span<const std::byte> message,
              std::string_view text, int64_t received_ns);
  void ask_for_time(int64_t now_ns);
  void tell_conditions();
  void describe(Peer peer, const wire::StreamDescription& description);
  void welcome(Peer peer, PeerStream& stream);
  void tell_contests();
  void ask_for_image(Peer peer, const wire::ImageRequest& request);
  void tell_refused(Peer peer, const wire::ImageRefused& refused);
  const std::pair<const Peer, PeerStream>* find_asker(state::ImageBook::Asker asker) const;
  void end_stream(Peer peer, const std::string& reason);
  void reply(Peer peer, const wire::Bytes& message);
  void reject(Peer peer, Refusal refusal, const std::string& reason);
  void note(std::string text);

  state::PoseState& poses_;
  bool lockstep_;
  PlayOptions play_;
  std::shared_ptr<BudgetPool> budgets_;
  std::map<Peer, std::shared_ptr<PeerBudget>> budget_of_peer_;
  std::vector<std::unique_ptr<transport::ListenerLink>> listeners_;
  Watcher watcher_;
  wire::Decoder decoder_;
  std::deque<Held> held_;  // lockstep: what has arrived after the frame that is shown
  std::map<Peer, PeerStream> stream_of_peer_;
  std::map<Peer, uint32_t> rejected_of_peer_;
  std::vector<std::string> notes_;
  std::chrono::steady_clock::time_point notes_since_{};
  uint32_t notes_this_second_ = 0, notes_left_out_ = 0;
  bool had_streams_ = false;
  std::array<uint64_t, kRefusalCount> refusals_{};
  std::optional<state::ImageBook> images_;
  uint64_t refused_image_requests_ = 0;
  std::map<state::ImageBook::Asker, Peer> peer_of_asker_;
  state::ImageBook::Asker last_asker_ = 0;
};

}  // namespace fire3dv::app
