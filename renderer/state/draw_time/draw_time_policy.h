// Drawing time of peers: the cost of each peer's content, and the budget that hides the most expensive
// content while it slows down the images of others. Costs are estimates in work (draw_work.h), scaled to the
// measured time of images. It has no clock, no scene and no device; callers pass the time in nanoseconds. Not
// thread-safe. Semantics: docs/design/budgets.md, "Content of peers".
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/peer_budget.h"
#include "renderer/state/draw_time/draw_work.h"

namespace fire3dv::state {

struct DrawTimeSettings {
  // Images of others may take this many times as long as without the content of a peer. 0: content is never
  // hidden.
  double factor = 2;
  bool is_software = false;  // device: its initial costs of work are higher
};
// Value of --peer-limit draw-time=VALUE: a factor of at least 1, or "off".
Result<double> parse_draw_time_factor(std::string_view text);

class DrawTimePolicy {
 public:
  using Peer = const PeerBudget*;  // identity only

  struct Content {
    Peer peer = nullptr;
    DrawWork markers, meshes;
  };
  // One submission of images. Images of one kind have the same requester and size.
  struct Image {
    uint64_t kind = 0;
    uint64_t pixels = 0;
    Peer requester = nullptr;      // whose own content does not count; null: the renderer's own image
    std::vector<Content> content;  // of each peer, hidden content included
  };
  struct Measured {
    int64_t total_ns = 0;
    int64_t markers_ns = 0;  // the part of the passes that draw markers alone
  };

  explicit DrawTimePolicy(const DrawTimeSettings& settings) : settings_(settings) {}

  // Peers with streams. With fewer than two, nothing is measured and nothing is hidden. Others are forgotten.
  // Returns true if hidden content returns.
  bool set_peers(std::span<const Peer> peers);
  bool is_active() const { return accounts_.size() > 1; }
  bool limits() const { return is_active() && settings_.factor != 0; }

  // Before an image is drawn: hides content whose estimate is far beyond the budget, and shows content again
  // that fits. Returns true if it changed what is hidden.
  bool plan(const Image& image, int64_t now_ns);
  // After an image was drawn, with its visible content alone. Returns true if it hid content.
  bool add(const Image& image, const Measured& measured, int64_t now_ns);
  // An image, or the preparation of new content, was abandoned after this time. Hides the most expensive
  // content. Returns true if there was any.
  bool add_abandoned(const Image& image, int64_t elapsed_ns, int64_t now_ns);
  // Before new meshes are uploaded: true if drawing them in such images, or building the acceleration
  // structures of their `rebuilt` triangles, would keep others waiting. The content is hidden then.
  bool refuse_meshes(Peer peer, const DrawWork& meshes, std::span<const Image> images, int64_t now_ns);

  bool is_hidden(Peer peer) const;
  bool hides_any() const { return hidden_count_ > 0; }
  uint64_t revision() const { return revision_; }  // rises with each change of what is hidden
  // Time after which an image with peers' content should be abandoned; nullopt: never.
  std::optional<int64_t> abandon_after_ns(const Image& image) const;

  struct Report {
    Peer peer = nullptr;
    double seconds = 0;  // spent on its content since it connected
    double share = 0;    // of the drawing time of the last seconds; 0 to 1
    bool is_hidden = false;
  };
  std::vector<Report> report() const;

  // Changes since the last call, for the log and for the peers.
  struct Notice {
    Peer peer = nullptr;
    enum class Kind : uint8_t { expensive, hidden, shown } kind = Kind::expensive;
    std::string text;  // without the name of the peer
  };
  std::vector<Notice> take_notices();

 private:
  struct Account {
    double seconds = 0;
    double recent_ns = 0;  // decays
    bool is_hidden = false, is_reported = false, is_seen = false;
    int64_t hidden_ns = 0;            // since when
    int64_t content_ns = 0;           // time of the last image that has content of it, hidden or not
    int64_t unfit_ns = 0;             // time of the last image that it would have slowed down too much
    int64_t interval_ns = 0;          // before it may return; 0: never hidden
    std::optional<int64_t> shown_ns;  // of its return
    double correction = 1;            // measured cost by estimated cost, when it was hidden
    double expected_ns = 0;           // of the last image
    uint32_t over_count = 0;          // images in a row that took too long because of it
    int64_t over_ns = 0;              // time of these images
  };
  struct Kind {
    double base_ns = 0;  // without meshes and markers of peers; 0: unknown
    int64_t seen_ns = 0;
  };
  struct Cost {
    Peer peer = nullptr;
    double ns = 0;
  };

  double ns_of(const DrawWork& work, double scale) const;
  double expected_ns(const Content& content) const;
  double plain_ns(uint64_t pixels) const;
  double base_ns(const Image& image) const;
  double limit_ns(const Image& image) const;
  std::vector<Cost> costs_of(const Image& image, const Measured& measured, int64_t now_ns);
  void hide(Account& account, Peer peer, const std::string& why, int64_t now_ns);
  void show(Account& account, Peer peer, const std::string& why);
  void note_share(Peer peer, Account& account, const Cost& cost, const Measured& measured);
  void drop_old_kinds(int64_t now_ns);

  DrawTimeSettings settings_;
  std::map<Peer, Account> accounts_;
  std::map<uint64_t, Kind> kinds_;
  double recent_total_ns_ = 0;
  int64_t recent_at_ns_ = 0;
  double marker_scale_ = 1, mesh_scale_ = 1;  // measured time by estimated time
  size_t hidden_count_ = 0;
  uint64_t revision_ = 0;
  std::vector<Notice> notices_;
};

}  // namespace fire3dv::state
