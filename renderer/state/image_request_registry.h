// Registry of the open image requests of all requesters. It has no clock and no link: callers pass the time
// in nanoseconds. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/peer_budget.h"
#include "protocol/wire/image.h"
#include "renderer/state/image_scheduler.h"

namespace fire3dv::state {

// Outputs and limits that this renderer supports; requests beyond them are refused.
struct ImageAbilities {
  uint32_t outputs = wire::kColorSrgb8;
  bool lenses = false;                              // lens distortion
  bool thin_lenses = false;                         // depth of field
  uint32_t path_samples = 0;                        // of colours; 0: their paths are not traced
  uint64_t max_pixel_bytes = wire::kMaxPixelBytes;  // of one image
  uint64_t max_open_bytes = uint64_t{1} << 30;  // limit of one requester's open requests if it has no budget
};

// For image_cost(). path_samples: of colours, 0: their paths are not traced.
ImageEffort effort_of(const wire::ImageRequest& request, uint32_t path_samples);

// True for requests that their first image closes.
inline bool is_of_one_image(const wire::ImageRequest& request) {
  return request.when == wire::ImageWhen::once || request.when == wire::ImageWhen::exactly ||
         request.when == wire::ImageWhen::batch;
}

// Bytes that the images of a request take: outputs without lists, the planes that they follow from, and the
// depth that its next image is compared with.
uint64_t drawn_bytes(const wire::ImageRequest& request);

// Open requests of each requester and their due times. It checks requests against the renderer's abilities
// and the peer's budget, and refuses the others (SPEC.md, section 13).
class ImageRequestRegistry {
 public:
  struct Refused {
    RequesterId requester = 0;
    wire::ImageRefused answer;
    std::optional<Resource> over;  // the limit of the requester's budget that was exceeded
  };
  // An image that is due now.
  struct Due {
    RequesterId requester = 0;
    wire::ImageRequest request;
    uint64_t number = 0;  // running number within the request, from 1
    uint64_t sequence = 0;
    int64_t sim_time_ns = 0;
    int64_t due_ns = 0;
    int64_t last_ns = 0;  // due_ns of its last image
  };
  // The pose frame of a stream that is shown. sequence 0: no frame yet.
  struct Shown {
    uint64_t epoch = 0;
    uint64_t sequence = 0;
    int64_t sim_time_ns = 0;
  };

  explicit ImageRequestRegistry(const ImageAbilities& abilities = {}) : abilities_(abilities) {}

  // Registers the request, or returns the refusal. The budget is charged while the request is open.
  std::optional<Refused> add(RequesterId requester, const wire::ImageRequest& request,
                             const std::shared_ptr<PeerBudget>& budget = nullptr);
  // Removes all requests of a requester whose stream ended or restarted.
  void remove_all(RequesterId requester) {
    changed(requester);
    closed_ += requests_.erase(requester);
  }
  // Closes a request that cannot be served.
  void remove(RequesterId requester, uint64_t id);

  using ShownOf = std::function<std::optional<Shown>(RequesterId)>;  // nullopt: unknown stream
  // Demands of all requesters with due images, sorted by requester. Requests that can no longer be served are
  // closed, and their refusals are appended to `refused`.
  std::vector<ImageDemand> demands(const ShownOf& shown, int64_t now_ns, std::vector<Refused>& refused);
  // Due images of one requester, those that wait longest first, grouped by size and outputs. They stay due
  // until mark_rendered() is called.
  std::vector<Due> due(RequesterId requester, const Shown& shown, int64_t now_ns) const;
  // Render cost of one image, as in demands().
  uint64_t cost(const wire::ImageRequest& request) const {
    return request.views() * image_cost(request.intrinsics.width, request.intrinsics.height,
                                        effort_of(request, abilities_.path_samples));
  }
  // Checks that device memory for the time of drawing fits the requester's budget, beside its content. Images
  // are drawn one after the other.
  Result<void> check_memory(const Due& due, uint64_t bytes) const;
  // Budget of an open request; null: it has none, or is closed.
  std::shared_ptr<PeerBudget> budget(const Due& due) const;
  // Marks an image as rendered. Does nothing if its request is closed.
  void mark_rendered(const Due& due);
  // The image was marked as rendered, but nothing was sent: it is due again. Does nothing if the requester is
  // gone or has replaced the request.
  void mark_undrawn(const Due& due);

  // Requester and id of each open request, sorted.
  std::vector<std::pair<RequesterId, uint64_t>> open() const;
  bool is_open(RequesterId requester, uint64_t id) const;
  size_t count() const;
  uint64_t closed() const { return closed_; }  // rises when requests are closed
  uint64_t refused() const { return refused_; }

 private:
  struct Entry {
    wire::ImageRequest request;
    uint64_t pixel_bytes = 0;  // drawn_bytes()
    std::shared_ptr<PeerBudget> budget;
    BudgetCharge request_charge, bytes_charge, poses_charge;
    uint64_t rendered = 0;  // number of rendered images
    uint64_t last_sequence = 0;
    int64_t last_ns = 0;
  };
  // Demand of one requester at one shown frame: a loop without news costs nothing per request.
  struct Noted {
    uint64_t epoch = 0, sequence = 0;
    ImageDemand demand;
  };
  void changed(RequesterId requester) { noted_.erase(requester); }
  std::optional<Refused> charge(RequesterId requester, const std::shared_ptr<PeerBudget>& budget,
                                Entry& entry);
  enum class Action { wait, render, render_last, overtaken };
  static Action action_now(const Entry& entry, uint64_t sequence, int64_t now_ns);
  Refused refuse(RequesterId requester, const wire::ImageRequest& request, wire::ImageRefusal reason,
                 std::string message);

  ImageAbilities abilities_;
  std::map<RequesterId, std::map<uint32_t, Entry>> requests_;  // the inner key is ImageRequest::place
  std::map<RequesterId, Noted> noted_;
  uint64_t refused_ = 0, closed_ = 0;
};

}  // namespace fire3dv::state
