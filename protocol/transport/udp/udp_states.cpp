#include "protocol/transport/udp/udp_states.h"

#include <cstring>

#include "protocol/transport/core/byte_order.h"

namespace fire3dv::transport::udp {
namespace {

constexpr size_t kRecordHeaderBytes = 8;
constexpr size_t kBundleBytes = 64 << 10;  // about one window of fragments; cheap to copy and hash

// Length of the first record's message, or nothing if the record is invalid.
std::optional<size_t> first_message_bytes(std::span<const std::byte> bundle) {
  if (bundle.size() < kRecordHeaderBytes) return {};
  const size_t bytes = get_le<uint32_t>(bundle.data());
  if (bytes < kLeastStateBytes || bytes > bundle.size() - kRecordHeaderBytes) return {};
  return bytes;
}

}  // namespace

KeyedState make_record(const wire::Bytes& message) {
  auto record = std::make_shared<wire::Bytes>(kRecordHeaderBytes + message.size());
  put_le<uint32_t>(record->data(), static_cast<uint32_t>(message.size()));
  put_le<uint32_t>(record->data() + 4, 0);
  if (!message.empty()) std::memcpy(record->data() + kRecordHeaderBytes, message.data(), message.size());
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
    rest = rest.subspan(kRecordHeaderBytes + *bytes);
  }
  std::vector<std::vector<std::byte>> messages;
  messages.reserve(records);
  while (!bundle.empty()) {
    const std::span<const std::byte> message =
        bundle.subspan(kRecordHeaderBytes, *first_message_bytes(bundle));
    messages.emplace_back(message.begin(), message.end());
    bundle = bundle.subspan(kRecordHeaderBytes + message.size());
  }
  return messages;
}

}  // namespace fire3dv::transport::udp
