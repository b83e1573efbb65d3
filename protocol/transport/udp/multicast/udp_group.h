// Control messages to a multicast group, from which nothing comes back: the sender goes round and round
// through what a joiner has to know, the receiver puts it together wherever it began to listen. Nothing here
// does I/O or looks at a clock.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "protocol/transport/udp/udp_control.h"

namespace fire3dv::transport::udp {

// What is on offer: the description, and of the messages that followed it those that are still repeated.
struct GroupOffer {
  uint32_t description = 0;  // its number; 0: none yet
  uint32_t first = 1;        // first > last: no message beside the description
  uint32_t last = 0;
  uint16_t datagram_bytes = 0;
};
constexpr size_t kGroupOfferBytes = 16;
constexpr uint32_t kMostGroupMessages = 8192;
void write_group_offer(std::byte* to, const GroupOffer& offer);
// False when it is cut short or contradicts itself.
bool read_group_offer(std::span<const std::byte> payload, GroupOffer& offer);

class Carousel {
 public:
  // numbers_before_anew: how many numbers are used before they begin anew, since they have 32 bits.
  explicit Carousel(size_t datagram_bytes, uint32_t numbers_before_anew = uint32_t{1} << 31);

  // Replaces all that was said before.
  void describe(ControlSender::Prepared description);
  // False when the oldest had to go for it: who joins from now on does not hear of that.
  bool add(ControlSender::Prepared message);
  // A message that replaces the one of the same key, but for one that is on its way just now: however fast a
  // key changes, receivers see something of it. False when there are too many, or too large ones: nothing has
  // changed.
  // dropped: messages without a key had to go for it.
  bool put(uint64_t key, ControlSender::Prepared message, bool* dropped = nullptr);

  GroupOffer offer() const;
  // The offer has changed, or a round has begun, since the last call.
  bool take_news() { return std::exchange(news_, false); }
  // Numbers have begun anew since the last call: who has heard the ones before must take this for another
  // session.
  bool take_begun_anew() { return std::exchange(begun_anew_, false); }

  // The next piece; nothing once all have been sent in this round.
  std::optional<ControlSender::Fragment> next();
  bool round_is_over() const { return at_message_ == messages_.size(); }
  void start_round();

 private:
  struct Message {
    SharedBytes bytes;
    FragmentHeader header;
    std::optional<uint64_t> key;
    bool replaced = false;  // while it is on its way; retired from then on
    // Its number stays, with nothing in it, so that those before and behind it are still in a row.
    void retire();
    bool is_retired() const { return replaced && bytes->empty(); }
  };
  void append(Message message);
  void retire(size_t at);
  void drop_retired();
  void number_anew();
  void begin_anew_if_used_up();
  bool make_room();
  Message cut(ControlSender::Prepared message);

  size_t datagram_bytes_, piece_bytes_;
  uint32_t numbers_before_anew_;
  std::deque<Message> messages_;  // the first is the description
  size_t bytes_ = 0;              // of those without a key, but the description
  size_t keyed_bytes_ = 0;
  std::map<uint64_t, uint32_t> number_of_key_;
  uint32_t last_number_ = 0;
  size_t at_message_ = 0;
  uint32_t at_piece_ = 0;
  SharedBytes handed_out_;  // of a piece whose message was retired with it
  bool news_ = false, begun_anew_ = false;
};

class CarouselReceiver {
 public:
  enum class Outcome { ignored, kept, corrupt };

  explicit CarouselReceiver(size_t piece_bytes) : piece_bytes_(piece_bytes) {}

  // How many messages are gone for good that this receiver had yet to get.
  uint32_t offered(const GroupOffer& offer);
  // `budget` is what this receiver may still allocate.
  Outcome fragment(const FragmentHeader& header, std::span<const std::byte> data, size_t budget);
  // The next message in order, once it is whole: the description first.
  std::optional<std::vector<std::byte>> take();

  bool described() const { return next_ > description_ && description_ != 0; }
  size_t held_bytes() const { return held_bytes_; }

 private:
  struct Building {
    FragmentHeader header;
    std::map<uint32_t, std::vector<std::byte>> pieces;  // memory follows what came
  };
  void forget_before(uint32_t number);

  size_t piece_bytes_;
  uint32_t description_ = 0;
  uint32_t next_ = 0;  // the number of the next message to hand on
  std::map<uint32_t, Building> building_;
  size_t held_bytes_ = 0;
};

}  // namespace fire3dv::transport::udp
