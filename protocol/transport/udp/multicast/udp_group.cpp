#include "protocol/transport/udp/multicast/udp_group.h"

#include <algorithm>
#include <utility>

#include "protocol/transport/core/byte_order.h"

namespace fire3dv::transport::udp {
namespace {

constexpr size_t kMaxRepeatedBytes = 4 << 20;
constexpr size_t kMaxRetired = 64;  // each costs one datagram per round
constexpr size_t kMaxKeys = kMaxGroupMessages / 2;
// Memory of a fragment with its container overhead.
constexpr size_t cost_of(size_t piece_bytes) {
  return piece_bytes + 128;
}

}  // namespace

void write_group_offer(std::byte* to, const GroupOffer& offer) {
  put_le<uint32_t>(to, offer.description);
  put_le<uint32_t>(to + 4, offer.first);
  put_le<uint32_t>(to + 8, offer.last);
  put_le<uint16_t>(to + 12, offer.datagram_bytes);
  put_le<uint16_t>(to + 14, 0);
}

bool read_group_offer(std::span<const std::byte> payload, GroupOffer& offer) {
  if (payload.size() < kGroupOfferBytes) return false;
  offer.description = get_le<uint32_t>(payload.data());
  offer.first = get_le<uint32_t>(payload.data() + 4);
  offer.last = get_le<uint32_t>(payload.data() + 8);
  offer.datagram_bytes = get_le<uint16_t>(payload.data() + 12);
  return offer.datagram_bytes >= kLeastDatagramBytes && offer.datagram_bytes <= kMaxDatagramBytes &&
         offer.first > offer.description && offer.last >= offer.first - 1 &&
         offer.last - (offer.first - 1) <= kMaxGroupMessages;
}

// --- the sender

Carousel::Carousel(size_t datagram_bytes, uint32_t max_number)
    : datagram_bytes_(datagram_bytes),
      piece_bytes_(fragment_bytes_of(datagram_bytes)),
      max_number_(max_number) {}

Carousel::Message Carousel::cut(ControlSender::Prepared message) {
  Message cut;
  cut.header.message = ++last_number_;
  cut.header.count = fragments_of(message.bytes->size(), piece_bytes_);
  cut.header.message_bytes = static_cast<uint32_t>(message.bytes->size());
  cut.header.hash = message.hash;
  cut.bytes = std::move(message.bytes);
  return cut;
}

// Renumbers all messages from 1, without the retired ones. A key that changes a thousand times a second
// exhausts the numbers in weeks.
void Carousel::renumber_if_exhausted() {
  if (last_number_ < max_number_) return;
  std::erase_if(messages_, [](const Message& message) { return message.replaced; });
  last_number_ = 0;
  for (Message& message : messages_) {
    message.header.message = ++last_number_;
    if (message.key) number_of_key_[*message.key] = last_number_;
  }
  renumbered_ = true;
  start_round();
}

void Carousel::describe(ControlSender::Prepared description) {
  renumber_if_exhausted();
  messages_.clear();
  number_of_key_.clear();
  bytes_ = keyed_bytes_ = 0;
  messages_.push_back(cut(std::move(description)));
  start_round();
}

void Carousel::Message::retire() {
  replaced = true;
  key.reset();
  bytes = std::make_shared<const wire::Bytes>();
  header.count = 1;
  header.message_bytes = 0;
  header.hash = kFnvBasis;
}

void Carousel::append(Message message) {
  messages_.push_back(std::move(message));
  offer_changed_ = true;
}

void Carousel::retire(size_t at) {
  messages_[at].retire();
  if (at == at_message_) at_piece_ = 0;
}

void Carousel::drop_retired() {
  while (messages_.size() > 1 && messages_[1].is_retired()) {
    messages_.erase(messages_.begin() + 1);
    if (at_message_ == 1) at_piece_ = 0;
    if (at_message_ > 1) --at_message_;
  }
}

// Gives all keyed messages new numbers, in the same order: a receiver that joined in between must not get an
// older state after a newer one.
void Carousel::renumber_keyed() {
  const size_t end = messages_.size();
  for (size_t at = 1; at < end; ++at) {
    if (messages_[at].key) {
      Message again = messages_[at];
      again.header.message = number_of_key_[*again.key] = ++last_number_;
      append(std::move(again));
    }
    if (messages_[at].key || messages_[at].replaced) retire(at);
  }
  drop_retired();
}

// Enforces the limits. Returns false if messages without a key were dropped, the oldest first.
bool Carousel::make_room() {
  drop_retired();
  if (messages_.size() > kMaxGroupMessages) renumber_keyed();
  bool none_dropped = true;
  for (size_t at = 1; at + 1 < messages_.size();) {
    if (messages_.size() <= kMaxGroupMessages && bytes_ <= kMaxRepeatedBytes) break;
    const Message& message = messages_[at];
    if (message.key || message.replaced) {
      ++at;
      continue;
    }
    bytes_ -= message.bytes->size();
    none_dropped = false;
    retire(at);
    drop_retired();
    at = 1;
  }
  return none_dropped;
}

bool Carousel::add(ControlSender::Prepared message) {
  if (messages_.empty() || message.bytes->empty()) return true;  // no description yet, or an empty message
  renumber_if_exhausted();
  bytes_ += message.bytes->size();
  append(cut(std::move(message)));
  return make_room();
}

bool Carousel::put(uint64_t key, ControlSender::Prepared message, bool* dropped) {
  if (messages_.empty()) return true;
  renumber_if_exhausted();
  const auto known = number_of_key_.find(key);
  size_t others_bytes = keyed_bytes_;
  if (known != number_of_key_.end()) {
    // Numbers are contiguous.
    const size_t at = 1 + known->second - messages_[1].header.message;
    Message& replaced = messages_[at];
    others_bytes -= replaced.bytes->size();
    if (others_bytes + message.bytes->size() > kMaxControlBytes) return false;
    replaced.key.reset();
    replaced.replaced = true;
    if (at != at_message_ || at_piece_ == 0) retire(at);
  } else if (number_of_key_.size() == kMaxKeys || others_bytes + message.bytes->size() > kMaxControlBytes) {
    return false;
  }
  keyed_bytes_ = others_bytes + message.bytes->size();
  Message keyed = cut(std::move(message));
  keyed.key = key;
  number_of_key_[key] = keyed.header.message;
  append(std::move(keyed));
  const bool none_dropped = make_room();
  if (dropped) *dropped = !none_dropped;
  return true;
}

GroupOffer Carousel::offer() const {
  GroupOffer offer;
  offer.datagram_bytes = static_cast<uint16_t>(datagram_bytes_);
  if (messages_.empty()) return offer;
  offer.description = messages_.front().header.message;
  offer.last = messages_.back().header.message;
  offer.first = messages_.size() > 1 ? messages_[1].header.message : offer.last + 1;
  return offer;
}

std::optional<ControlSender::Fragment> Carousel::next() {
  if (round_is_over()) return {};
  Message& message = messages_[at_message_];
  ControlSender::Fragment fragment{message.header, {}};
  fragment.header.index = at_piece_;
  fragment.data =
      std::span<const std::byte>(*message.bytes)
          .subspan(size_t{at_piece_} * piece_bytes_, fragment_size(fragment.header, piece_bytes_));
  if (++at_piece_ == message.header.count) {
    if (message.replaced) {
      last_bytes_ = std::move(message.bytes);
      message.retire();
    }
    at_piece_ = 0;
    ++at_message_;
  }
  return fragment;
}

void Carousel::start_round() {
  at_message_ = 0;
  at_piece_ = 0;
  // Counts the retired messages that renumbering would remove.
  size_t retired = 0;
  for (size_t at = 1; at < messages_.size() && (messages_[at].key || messages_[at].is_retired()); ++at)
    retired += messages_[at].is_retired();
  if (retired > kMaxRetired + 2 * number_of_key_.size()) renumber_keyed();
  offer_changed_ = true;
}

// --- the receiver

void CarouselReceiver::discard_before(uint32_t number) {
  while (!building_.empty() && building_.begin()->first < number) {
    for (const auto& [index, piece] : building_.begin()->second.pieces)
      buffered_bytes_ -= cost_of(piece.size());
    building_.erase(building_.begin());
  }
}

uint32_t CarouselReceiver::offered(const GroupOffer& offer) {
  if (offer.description == 0 || offer.description < description_)
    return 0;                              // late offer of an earlier description
  if (offer.description > description_) {  // replaces all earlier messages
    description_ = offer.description;
    next_ = std::max(next_, description_);
    discard_before(next_);
  }
  // The description is always repeated; later messages may have been dropped.
  if (!described() || next_ >= offer.first) return 0;
  // A new receiver gets all valid messages and loses none.
  const uint32_t gone = next_ == description_ + 1 ? 0 : offer.first - next_;
  next_ = offer.first;
  discard_before(next_);
  return gone;
}

CarouselReceiver::Outcome CarouselReceiver::fragment(const FragmentHeader& header,
                                                     std::span<const std::byte> data, size_t budget) {
  if (description_ == 0) return Outcome::ignored;
  if (header.message < next_) return Outcome::accepted;  // already delivered; the carousel repeats it
  if (header.message - next_ > 2 * kMaxGroupMessages) return Outcome::ignored;
  if (header.message_bytes > kMaxControlBytes ||
      header.count != fragments_of(header.message_bytes, piece_bytes_) || header.index >= header.count ||
      data.size() != fragment_size(header, piece_bytes_))
    return Outcome::corrupt;
  const auto known = building_.find(header.message);
  if (known != building_.end()) {
    const FragmentHeader& before = known->second.header;
    if (before.message_bytes == 0) return Outcome::accepted;  // replaced; a late fragment of the old value
    if (header.message_bytes != 0) {
      if (header.message_bytes != before.message_bytes || header.hash != before.hash) return Outcome::corrupt;
      if (known->second.pieces.contains(header.index)) return Outcome::accepted;
    } else {  // retired: a newer message has its key
      for (const auto& [index, piece] : known->second.pieces) buffered_bytes_ -= cost_of(piece.size());
      known->second.pieces.clear();
    }
  }
  if (cost_of(data.size()) > budget) return Outcome::ignored;
  Building& building = known != building_.end() ? known->second : building_[header.message];
  building.header = header;
  building.pieces.emplace(header.index, std::vector<std::byte>(data.begin(), data.end()));
  buffered_bytes_ += cost_of(data.size());
  if (building.pieces.size() < header.count) return Outcome::accepted;
  uint64_t hash = kFnvBasis;
  for (const auto& [index, piece] : building.pieces) hash = fnv1a_64(piece, hash);
  return hash == header.hash ? Outcome::accepted : Outcome::corrupt;
}

std::optional<std::vector<std::byte>> CarouselReceiver::take() {
  while (true) {
    const auto found = building_.find(next_);
    if (found == building_.end() || found->second.pieces.size() < found->second.header.count) return {};
    std::vector<std::byte> message;
    message.reserve(found->second.header.message_bytes);
    for (const auto& [index, piece] : found->second.pieces)
      message.insert(message.end(), piece.begin(), piece.end());
    discard_before(++next_);
    if (!message.empty() || next_ == description_ + 1) return message;
  }
}

}  // namespace fire3dv::transport::udp
