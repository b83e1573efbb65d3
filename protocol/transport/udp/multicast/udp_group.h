// Data carousel for multicast groups, which have no back channel: the sender repeats all control messages in
// rounds, and a receiver reassembles them from any starting point. No I/O and no clock.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "protocol/transport/udp/udp_control.h"

namespace fire3dv::transport::udp {

// Range of repeated messages: the description and those later messages that are still repeated.
struct GroupOffer {
  uint32_t description = 0;  // message number; 0: none yet
  uint32_t first = 1;        // first > last: no message but the description
  uint32_t last = 0;
  uint16_t datagram_bytes = 0;
};
constexpr size_t kGroupOfferBytes = 16;
constexpr uint32_t kMaxGroupMessages = 8192;
void write_group_offer(std::byte* to, const GroupOffer& offer);
// Returns false if the offer is truncated or inconsistent.
bool read_group_offer(std::span<const std::byte> payload, GroupOffer& offer);

class Carousel {
 public:
  // max_number: renumbers from 1 after this message number, since numbers have 32 bits.
  explicit Carousel(size_t datagram_bytes, uint32_t max_number = uint32_t{1} << 31);

  // Replaces all earlier messages.
  void describe(ControlSender::Prepared description);
  // Returns false if older messages were dropped for lack of room: later joiners do not receive them.
  bool add(ControlSender::Prepared message);
  // Replaces the message of the same key. A message that is being sent is completed first, so that receivers
  // see some value however fast a key changes. Returns false, without a change, if a limit is exceeded.
  // dropped: set if messages without a key were dropped for lack of room.
  bool put(uint64_t key, ControlSender::Prepared message, bool* dropped = nullptr);

  GroupOffer offer() const;
  // True if the offer has changed or a round has begun since the last call.
  bool consume_offer_change() { return std::exchange(offer_changed_, false); }
  // True if messages were renumbered since the last call: the sender must start a new session.
  bool consume_renumbering() { return std::exchange(renumbered_, false); }

  // Returns the next fragment, or nothing at the end of the round.
  std::optional<ControlSender::Fragment> next();
  bool round_is_over() const { return at_message_ == messages_.size(); }
  void start_round();

 private:
  struct Message {
    SharedBytes bytes;
    FragmentHeader header;
    std::optional<uint64_t> key;
    bool replaced = false;  // replaced by a newer value; retired when its last fragment is sent
    // Empties the message and retains its number, so that numbers stay contiguous.
    void retire();
    bool is_retired() const { return replaced && bytes->empty(); }
  };
  void append(Message message);
  void retire(size_t at);
  void drop_retired();
  void renumber_keyed();
  void renumber_if_exhausted();
  bool make_room();
  Message cut(ControlSender::Prepared message);

  size_t datagram_bytes_, piece_bytes_;
  uint32_t max_number_;
  std::deque<Message> messages_;  // the first is the description
  size_t bytes_ = 0;              // of messages without a key, except the description
  size_t keyed_bytes_ = 0;
  std::map<uint64_t, uint32_t> number_of_key_;
  uint32_t last_number_ = 0;
  size_t at_message_ = 0;
  uint32_t at_piece_ = 0;
  SharedBytes last_bytes_;  // keeps the last fragment of a retired message alive
  bool offer_changed_ = false, renumbered_ = false;
};

class CarouselReceiver {
 public:
  enum class Outcome { ignored, accepted, corrupt };

  explicit CarouselReceiver(size_t piece_bytes) : piece_bytes_(piece_bytes) {}

  // Processes an offer. Returns the number of messages that this receiver has lost for good.
  uint32_t offered(const GroupOffer& offer);
  // `budget`: bytes that this receiver may still allocate.
  Outcome fragment(const FragmentHeader& header, std::span<const std::byte> data, size_t budget);
  // Returns the next complete message in order: the description first.
  std::optional<std::vector<std::byte>> take();

  bool described() const { return next_ > description_ && description_ != 0; }
  size_t buffered_bytes() const { return buffered_bytes_; }

 private:
  struct Building {
    FragmentHeader header;
    std::map<uint32_t, std::vector<std::byte>> pieces;  // allocated for received fragments only
  };
  void discard_before(uint32_t number);

  size_t piece_bytes_;
  uint32_t description_ = 0;
  uint32_t next_ = 0;  // number of the next message to deliver
  std::map<uint32_t, Building> building_;
  size_t buffered_bytes_ = 0;
};

}  // namespace fire3dv::transport::udp
