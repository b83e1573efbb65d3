#include "protocol/transport/udp/udp_control.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "protocol/transport/core/byte_order.h"

namespace fire3dv::transport::udp {
namespace {

constexpr uint32_t kLeastWindow = 4;
constexpr uint32_t kMaxWindow = 128;  // half the span of an acknowledgment
constexpr int64_t kLeastRepeatNs = 20'000'000;
constexpr int64_t kMaxRepeatNs = 1'000'000'000;

}  // namespace

uint32_t fragments_of(size_t message_bytes, size_t piece_bytes) {
  return static_cast<uint32_t>(std::max<size_t>(1, (message_bytes + piece_bytes - 1) / piece_bytes));
}

size_t fragment_size(const FragmentHeader& header, size_t piece_bytes) {
  const size_t start = size_t{header.index} * piece_bytes;
  return std::min(piece_bytes, header.message_bytes - start);
}

ControlSender::Prepared ControlSender::prepare(std::span<const std::byte> message) {
  return {share(message), fnv1a_64(message)};
}

std::optional<uint32_t> ControlSender::push(Prepared message, size_t max_queued_bytes) {
  const size_t bytes = message.bytes->size();
  if (bytes > kMaxControlBytes || queued_bytes_ > max_queued_bytes) return {};
  Message queued;
  queued.bytes = std::move(message.bytes);
  queued.header.message = ++last_number_;
  queued.header.count = fragments_of(bytes, piece_bytes_);
  queued.header.message_bytes = static_cast<uint32_t>(bytes);
  queued.header.hash = message.hash;
  queued_bytes_ += bytes;
  messages_.push_back(std::move(queued));
  if (messages_.size() == 1) begin();
  return last_number_;
}

void ControlSender::begin() {
  sent_.fill(Sent{});
  first_missing_ = 0;
  highest_acknowledged_ = 0;
  repeat_after_ns_ = std::clamp(3 * round_trip_ns_, kLeastRepeatNs, kMaxRepeatNs);
}

// A fragment is retransmitted after its timeout, or soon after three later ones were acknowledged (fast
// retransmit).
bool ControlSender::due(uint32_t index, int64_t now_ns) {
  const Sent& piece = sent(index);
  if (piece.acknowledged) return false;
  if (piece.at_ns == 0) return true;
  const int64_t waited_ns = now_ns - piece.at_ns;
  if (highest_acknowledged_ > index + 3 && waited_ns > round_trip_ns_ + round_trip_ns_ / 4) return true;
  if (waited_ns < repeat_after_ns_) return false;
  if (now_ns - last_backoff_ns_ >= repeat_after_ns_) {  // once for all fragments that time out together
    last_backoff_ns_ = now_ns;
    window_ = std::max(kLeastWindow, window_ / 2);
    repeat_after_ns_ = std::min(repeat_after_ns_ * 3 / 2, kMaxRepeatNs);
  }
  return true;
}

std::optional<ControlSender::Fragment> ControlSender::next(int64_t now_ns) {
  if (messages_.empty()) return {};
  Message& message = messages_.front();
  const uint32_t end = std::min<uint32_t>(message.header.count, first_missing_ + window_);
  for (uint32_t i = first_missing_; i < end; ++i) {
    if (!due(i, now_ns)) continue;
    sent(i).repeated = sent(i).at_ns != 0;
    sent(i).at_ns = now_ns;
    Fragment fragment;
    fragment.header = message.header;
    fragment.header.index = i;
    fragment.data = std::span<const std::byte>(*message.bytes)
                        .subspan(size_t{i} * piece_bytes_, fragment_size(fragment.header, piece_bytes_));
    return fragment;
  }
  return {};
}

void ControlSender::acknowledge(const Ack& ack, int64_t now_ns) {
  if (messages_.empty() || ack.message != messages_.front().header.message) return;
  const uint32_t count = messages_.front().header.count;
  uint32_t newly = 0;
  const auto mark = [&](uint32_t index) {
    Sent& piece = sent(index);
    if (piece.acknowledged || piece.at_ns == 0) return;  // ignores acknowledgments of unsent fragments
    piece.acknowledged = true;
    highest_acknowledged_ = std::max(highest_acknowledged_, index + 1);
    ++newly;
    if (!piece.repeated) round_trip_ns_ += (std::max<int64_t>(now_ns - piece.at_ns, 0) - round_trip_ns_) / 8;
  };
  // No fragment beyond this window has been sent.
  const uint32_t end = std::min(count, first_missing_ + kAckWindow);
  const uint32_t below = std::min(ack.first_missing, end);
  for (uint32_t i = first_missing_; i < below; ++i) mark(i);
  for (uint32_t i = 0; i < kAckWindow && ack.first_missing < count; ++i) {
    const uint64_t index = uint64_t{ack.first_missing} + 1 + i;
    if (index >= first_missing_ && index < end && (ack.beyond[i / 64] >> (i % 64) & 1) != 0)
      mark(static_cast<uint32_t>(index));
  }
  while (first_missing_ < count && sent(first_missing_).acknowledged) sent(first_missing_++) = {};
  if (newly != 0) {
    window_ = std::min(kMaxWindow, window_ + newly);
    repeat_after_ns_ = std::clamp(3 * round_trip_ns_, kLeastRepeatNs, kMaxRepeatNs);
  }
  if (first_missing_ < count) return;
  last_acknowledged_ = ack.message;
  queued_bytes_ -= messages_.front().bytes->size();
  messages_.pop_front();
  if (!messages_.empty()) begin();
}

ControlReceiver::Outcome ControlReceiver::fragment(const FragmentHeader& header,
                                                   std::span<const std::byte> data, size_t budget) {
  if (header.message == last_complete_)
    return Outcome::accepted;  // its acknowledgment was lost; acknowledges it again
  if (header.message != last_complete_ + 1) return Outcome::ignored;
  if (header_.message == 0) {
    if (header.message_bytes > max_message_bytes_ ||
        header.count != fragments_of(header.message_bytes, piece_bytes_))
      return Outcome::corrupt;
    header_ = header;
    first_missing_ = 0;
    hash_ = kFnvBasis;
  } else if (header.count != header_.count || header.message_bytes != header_.message_bytes ||
             header.hash != header_.hash) {
    return Outcome::corrupt;
  }
  if (data.size() != fragment_size(header, piece_bytes_)) return Outcome::corrupt;
  if (header.index > first_missing_ + kAckWindow) return Outcome::ignored;
  if (header.index < first_missing_ || (header.index < received_.size() && received_[header.index]))
    return Outcome::accepted;
  // Allocates for received bytes only, never for the length that a header claims.
  const size_t start = size_t{header.index} * piece_bytes_;
  const size_t end = start + data.size();
  if (end > bytes_.size()) {
    const size_t capacity = std::max(bytes_.capacity(), end);
    if (capacity > bytes_.capacity() && end - bytes_.size() > budget) return Outcome::ignored;
    bytes_.resize(end);
  }
  if (header.index >= received_.size()) received_.resize(header.index + 1);
  if (!data.empty()) std::memcpy(bytes_.data() + start, data.data(), data.size());
  received_[header.index] = true;
  for (; first_missing_ < received_.size() && received_[first_missing_]; ++first_missing_) {
    FragmentHeader piece = header_;
    piece.index = first_missing_;
    hash_ = fnv1a_64(std::span<const std::byte>(bytes_).subspan(size_t{first_missing_} * piece_bytes_,
                                                                fragment_size(piece, piece_bytes_)),
                     hash_);
  }
  if (first_missing_ < header_.count) return Outcome::accepted;
  if (hash_ != header_.hash) return Outcome::corrupt;
  last_complete_ = header_.message;
  last_complete_count_ = header_.count;
  header_ = {};
  received_.clear();
  return Outcome::complete;
}

std::vector<std::byte> ControlReceiver::take() {
  return std::exchange(bytes_, {});
}

std::optional<Ack> ControlReceiver::ack() const {
  Ack ack;
  if (header_.message == 0) {
    if (last_complete_ == 0) return {};
    ack.message = last_complete_;
    ack.first_missing = last_complete_count_;
    return ack;
  }
  ack.message = header_.message;
  ack.first_missing = first_missing_;
  for (uint32_t i = 0; i < kAckWindow; ++i) {
    const size_t index = size_t{first_missing_} + 1 + i;
    if (index < received_.size() && received_[index]) ack.beyond[i / 64] |= uint64_t{1} << (i % 64);
  }
  return ack;
}

namespace {

constexpr size_t kStateHeaderBytes = 8;
constexpr size_t kBundleBytes = 64 << 10;  // about one window of fragments; cheap to copy and hash

// Length of the first record's message, or nothing if the record is invalid.
std::optional<size_t> first_message_bytes(std::span<const std::byte> bundle) {
  if (bundle.size() < kStateHeaderBytes) return {};
  const size_t bytes = get_le<uint32_t>(bundle.data());
  if (bytes < kLeastStateBytes || bytes > bundle.size() - kStateHeaderBytes) return {};
  return bytes;
}

}  // namespace

KeyedState make_record(const wire::Bytes& message) {
  auto record = std::make_shared<wire::Bytes>(kStateHeaderBytes + message.size());
  put_le<uint32_t>(record->data(), static_cast<uint32_t>(message.size()));
  put_le<uint32_t>(record->data() + 4, 0);
  if (!message.empty()) std::memcpy(record->data() + kStateHeaderBytes, message.data(), message.size());
  const uint64_t hash = fnv1a_64(*record);
  return {0, std::move(record), hash};
}

void StateSender::feed(ControlSender& sender, const KeyedStates& states) {
  if (!sender.idle()) return;
  const KeyedState* first = batches_.next(states);
  if (first == nullptr) return;
  ControlSender::Prepared bundle{first->message, first->hash};
  batches_.pop();
  std::vector<std::byte> several;
  size_t records = 1;
  // Stops at the end of the batch, since next() would begin another one.
  while (records < kMaxBundleRecords && batches_.in_batch()) {
    const KeyedState& more = *batches_.next(states);
    const size_t before = several.empty() ? bundle.bytes->size() : several.size();
    if (before + more.message->size() > kBundleBytes) break;
    if (several.empty()) several.assign(bundle.bytes->begin(), bundle.bytes->end());
    several.insert(several.end(), more.message->begin(), more.message->end());
    batches_.pop();
    ++records;
  }
  if (!several.empty()) {
    bundle.hash = fnv1a_64(several);
    bundle.bytes = std::make_shared<const wire::Bytes>(std::move(several));
  }
  sender.push(std::move(bundle), kMaxControlBytes);
}

std::optional<std::vector<std::vector<std::byte>>> open_bundle(std::span<const std::byte> bundle) {
  // Validates all records before copying any.
  size_t records = 0;
  for (std::span<const std::byte> rest = bundle; !rest.empty(); ++records) {
    const auto bytes = first_message_bytes(rest);
    if (!bytes || records == kMaxBundleRecords) return {};
    rest = rest.subspan(kStateHeaderBytes + *bytes);
  }
  std::vector<std::vector<std::byte>> messages;
  messages.reserve(records);
  while (!bundle.empty()) {
    const std::span<const std::byte> message =
        bundle.subspan(kStateHeaderBytes, *first_message_bytes(bundle));
    messages.emplace_back(message.begin(), message.end());
    bundle = bundle.subspan(kStateHeaderBytes + message.size());
  }
  return messages;
}

}  // namespace fire3dv::transport::udp
