// Parity datagrams of pose frames: how many a publisher sends, and the restoration of lost parts by a
// listener. See protocol/SPEC-transport.md, section 3.7. No I/O; the caller passes the time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "base/open_frames.h"
#include "protocol/transport/udp/erasure/erasure_code.h"
#include "protocol/transport/udp/udp_session.h"

namespace fire3dv::transport::udp {

constexpr size_t kParityHeaderBytes = 16;
struct ParityHeader {
  uint64_t frame = 0;
  uint32_t parts = 0;  // of the frame
  uint16_t group = 0;
  uint8_t row = 0;  // parity symbol of the group
};
void write_parity_header(std::byte* to, const ParityHeader& header);
// Returns false if the header is truncated or impossible.
bool read_parity_header(std::span<const std::byte> payload, ParityHeader& header);

// Parts of a frame are dealt to its groups in turn, so that a burst of losses spreads over all of them.
constexpr uint32_t kMaxFrameParts = 65536;
constexpr uint32_t parity_groups(uint32_t parts) {
  return static_cast<uint32_t>((parts + kMaxDataSymbols - 1) / kMaxDataSymbols);
}
constexpr size_t parts_of_group(uint32_t parts, uint32_t group) {
  const uint32_t groups = parity_groups(parts);
  return (parts - group + groups - 1) / groups;
}

// Loss of datagrams, by the reports of the last four seconds.
class LossMeter {
 public:
  void report(const Receipt& receipt, int64_t now_ns);
  // Upper estimate of the probability of loss; 0 if nothing was lost.
  double loss() const { return loss_; }
  bool has_reports() const { return !reports_.empty(); }

 private:
  struct Report {
    Receipt receipt;
    int64_t at_ns = 0;
  };
  double loss_since(int64_t begin_ns) const;

  std::deque<Report> reports_;
  double loss_ = 0;
};

// Number of parity symbols of a publisher's groups.
class ParityRate {
 public:
  // needs_reports: nothing is sent before the listener has reported. False for multicast groups, whose
  // publishers get no reports.
  explicit ParityRate(std::optional<uint8_t> percent, bool needs_reports = true)
      : percent_(percent), needs_reports_(needs_reports) {}

  void start_session() { meter_ = {}; }
  void report(const Receipt& receipt, int64_t now_ns);
  // True if frames may have parity now.
  bool is_on() const;
  // Parity symbols of the next group with this many data symbols.
  size_t symbols(size_t data_symbols);

 private:
  std::optional<uint8_t> percent_;  // of datagrams; nothing: by the measured loss
  bool needs_reports_;
  LossMeter meter_;
  double fraction_left_ = 0;                             // fixed percentage: symbols owed to later groups
  std::array<uint8_t, kMaxDataSymbols + 1> for_loss_{};  // by data symbols, for the measured loss
  double planned_loss_ = 0;                              // loss that for_loss_ is valid for
};

// Least number of parity symbols with which a group is restored often enough at this loss.
size_t parity_symbols_for(size_t data_symbols, double loss);

// Restores lost parts of frames. Bounded memory; the oldest frames are dropped first.
class ParityReceiver {
 public:
  // Limit of all stored parts and parity symbols.
  static constexpr size_t kMaxBytes = size_t{8} << 20;

  struct Restored {
    uint64_t frame = 0;
    uint16_t part = 0;
    bool is_last = false;
    std::vector<std::byte> message;
  };

  // Stores a received part. Nothing is stored while the publisher sends no parity.
  void add_part(uint64_t frame, uint16_t part, bool is_last, std::span<const std::byte> message);
  // Stores a parity datagram. Returns false if it is malformed or contradicts others.
  bool add_parity(std::span<const std::byte> payload);
  // Parts that were restored since the last call.
  std::vector<Restored> take_restored() { return std::exchange(restored_, {}); }

  // True if this part was received or restored.
  bool has_part(uint64_t frame, uint16_t part) const;
  void close_up_to(uint64_t frame);
  void clear();
  size_t memory_bytes() const { return bytes_; }

 private:
  struct Group {
    uint64_t data_seen = 0, rows_seen = 0;  // bit masks
    size_t symbol_bytes = 0;
    bool is_done = false;                              // complete, restored or contradictory
    std::vector<std::vector<std::byte>> data, parity;  // symbols; empty: absent
  };
  struct OpenFrame {
    uint64_t sequence = 0;
    uint32_t parts = 0;  // 0: unknown yet
    size_t bytes = 0;
    std::vector<std::pair<uint16_t, std::vector<std::byte>>>
        parts_before;  // received before `parts` is known
    std::vector<Group> groups;
    void clear() { *this = {}; }
  };
  OpenFrame* open(uint64_t frame);
  bool store(OpenFrame& frame, size_t bytes);
  bool place(OpenFrame& frame, uint16_t part, std::vector<std::byte> message);
  bool set_parts(OpenFrame& frame, uint32_t parts);
  void restore(OpenFrame& frame, uint32_t group_index);
  void drop(OpenFrame& frame);

  static constexpr size_t kMaxFrames = 64;
  static constexpr uint64_t kActiveFrames = 256;  // frames without parity until parts are no longer stored
  OpenFrames<OpenFrame, kMaxFrames> frames_;
  std::vector<Restored> restored_;
  uint64_t last_parity_frame_ = 0, closed_ = 0;
  size_t bytes_ = 0;
};

}  // namespace fire3dv::transport::udp
