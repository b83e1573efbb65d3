// Which images simulators have asked for, and when each is due. Pure bookkeeping: knows neither links nor
// cameras nor Vulkan, and time only as it is told. SPEC section 13 is normative.
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
#include "renderer/state/image_turns.h"

namespace fire3dv::state {

// What a renderer makes. What is asked for beyond it is refused.
struct ImageAbilities {
  uint32_t outputs = wire::kColorSrgb8;
  bool lenses = false;
  uint64_t most_pixel_bytes = wire::kMostPixelBytes;  // of one image
  uint64_t most_asked_bytes = uint64_t{1} << 30;      // of one asker's requests, where it has no budget
};

class ImageBook {
 public:
  using Asker = uint64_t;  // the caller's number for a stream

  struct Refused {
    Asker asker = 0;
    wire::ImageRefused answer;
    std::optional<Resource> over;  // limit of the asker's budget that refuses it
  };
  // An image to be made now.
  struct Due {
    Asker asker = 0;
    wire::ImageRequest request;
    uint64_t number = 0;  // of the request's images
    uint64_t sequence = 0;
    int64_t sim_time_ns = 0;
    int64_t due_ns = 0;
  };
  // Of a stream, what is shown of it; sequence 0: no frame of it yet.
  struct Shown {
    uint64_t epoch = 0;
    uint64_t sequence = 0;
    int64_t sim_time_ns = 0;
  };

  explicit ImageBook(const ImageAbilities& abilities = {}) : abilities_(abilities) {}

  // Takes the request on, or says why not. The budget is charged for as long as the request is open.
  std::optional<Refused> ask(Asker asker, const wire::ImageRequest& request,
                             const std::shared_ptr<PeerBudget>& budget = nullptr);
  // The stream has ended, or began anew.
  void forget(Asker asker) { requests_.erase(asker); }
  // The request cannot be served: it is over.
  void drop(Asker asker, uint64_t id);

  using ShownOf = std::function<std::optional<Shown>(Asker)>;  // none for an unknown stream
  // Askers with images that are due, in their order. Requests that cannot be met any more are closed, and
  // their answers are appended to `refused`.
  std::vector<ImageDemand> demands(const ShownOf& shown, int64_t now_ns, std::vector<Refused>& refused);
  // Images of one asker that are due, those of one size and kind together. They stay due until made().
  std::vector<Due> due(Asker asker, const Shown& shown, int64_t now_ns) const;
  // The image is drawn. No effect when its request is not open any more.
  void made(const Due& due);

  // Asker and id of each request that is open, in their order.
  std::vector<std::pair<Asker, uint64_t>> open() const;
  size_t count() const;
  uint64_t refused() const { return refused_; }

 private:
  struct Entry {
    wire::ImageRequest request;
    uint64_t pixel_bytes = 0;  // of an image, without boxes
    BudgetCharge request_charge, bytes_charge;
    uint64_t made = 0;  // images
    uint64_t last_sequence = 0;
    int64_t last_ns = 0;
  };
  std::optional<Refused> charge(Asker asker, const std::shared_ptr<PeerBudget>& budget, Entry& entry);
  enum class Answer { wait, make, make_last, overtaken };
  static Answer answer_now(const Entry& entry, uint64_t sequence, int64_t now_ns);
  Refused refuse(Asker asker, const wire::ImageRequest& request, wire::ImageRefusal reason,
                 std::string message);

  ImageAbilities abilities_;
  std::map<Asker, std::map<uint32_t, Entry>> requests_;  // by place
  uint64_t refused_ = 0;
};

}  // namespace fire3dv::state
