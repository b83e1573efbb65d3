// Registry of image requests: open requests of each asker (a stream) and their due times. It checks requests
// against the renderer's abilities and the peer's budget, and refuses the others (SPEC.md, section 13). It
// has no clock and no link: callers pass the time in nanoseconds. Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/base/peer_budget.h"
#include "protocol/wire/image.h"
#include "renderer/state/image_scheduler.h"

namespace fire3dv::state {

// Outputs and limits that this renderer supports; requests beyond them are refused.
struct ImageAbilities {
  uint32_t outputs = wire::kColorSrgb8;
  bool lenses = false;
  uint64_t most_pixel_bytes = wire::kMostPixelBytes;  // of one image
  uint64_t most_asked_bytes = uint64_t{1} << 30;  // limit of one asker's open requests if it has no budget
};

class ImageRequestRegistry {
 public:
  using Asker = uint64_t;  // the caller's identifier of a stream

  struct Refused {
    Asker asker = 0;
    wire::ImageRefused answer;
    std::optional<Resource> over;  // the limit of the asker's budget that was exceeded
  };
  // An image that is due now.
  struct Due {
    Asker asker = 0;
    wire::ImageRequest request;
    uint64_t number = 0;  // running number within the request, from 1
    uint64_t sequence = 0;
    int64_t sim_time_ns = 0;
    int64_t due_ns = 0;
  };
  // The pose frame of a stream that is shown. sequence 0: no frame yet.
  struct Shown {
    uint64_t epoch = 0;
    uint64_t sequence = 0;
    int64_t sim_time_ns = 0;
  };

  explicit ImageRequestRegistry(const ImageAbilities& abilities = {}) : abilities_(abilities) {}

  // Registers the request, or returns the refusal. The budget is charged while the request is open.
  std::optional<Refused> ask(Asker asker, const wire::ImageRequest& request,
                             const std::shared_ptr<PeerBudget>& budget = nullptr);
  // Removes all requests of an asker whose stream ended or restarted.
  void forget(Asker asker) { requests_.erase(asker); }
  // Closes a request that cannot be served.
  void drop(Asker asker, uint64_t id);

  using ShownOf = std::function<std::optional<Shown>(Asker)>;  // nullopt: unknown stream
  // Demands of all askers with due images, sorted by asker. Requests that can no longer be served are closed,
  // and their refusals are appended to `refused`.
  std::vector<ImageDemand> demands(const ShownOf& shown, int64_t now_ns, std::vector<Refused>& refused);
  // Due images of one asker, grouped by size and outputs. They stay due until made() is called.
  std::vector<Due> due(Asker asker, const Shown& shown, int64_t now_ns) const;
  // Marks an image as rendered. Does nothing if its request is closed.
  void made(const Due& due);

  // Asker and id of each open request, sorted.
  std::vector<std::pair<Asker, uint64_t>> open() const;
  size_t count() const;
  uint64_t refused() const { return refused_; }

 private:
  struct Entry {
    wire::ImageRequest request;
    uint64_t pixel_bytes = 0;  // bytes of one image without boxes
    BudgetCharge request_charge, bytes_charge;
    uint64_t made = 0;  // number of rendered images
    uint64_t last_sequence = 0;
    int64_t last_ns = 0;
  };
  std::optional<Refused> charge(Asker asker, const std::shared_ptr<PeerBudget>& budget, Entry& entry);
  enum class Answer { wait, make, make_last, overtaken };
  static Answer answer_now(const Entry& entry, uint64_t sequence, int64_t now_ns);
  Refused refuse(Asker asker, const wire::ImageRequest& request, wire::ImageRefusal reason,
                 std::string message);

  ImageAbilities abilities_;
  std::map<Asker, std::map<uint32_t, Entry>> requests_;  // the inner key is ImageRequest::place
  uint64_t refused_ = 0;
};

}  // namespace fire3dv::state
