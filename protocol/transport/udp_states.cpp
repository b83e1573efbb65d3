#include "protocol/transport/udp_states.h"

#include <cstring>

#include "protocol/transport/byte_order.h"

namespace fire3dv::transport::udp {
namespace {

constexpr size_t kRecordHeaderBytes = 8;
constexpr size_t kBundleBytes = 64 << 10;  // about what is on its way at a time; soon copied and hashed

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
  // Only what is left of this batch: next() would begin another one.
  while (batches_.in_batch()) {
    const KeyedState& more = *batches_.next(states);
    const size_t before = several.empty() ? bundle.bytes->size() : several.size();
    if (before + more.message->size() > kBundleBytes) break;
    if (several.empty()) several.assign(bundle.bytes->begin(), bundle.bytes->end());
    several.insert(several.end(), more.message->begin(), more.message->end());
    batches_.pop();
  }
  if (!several.empty()) {
    bundle.hash = fnv1a_64(several);
    bundle.bytes = std::make_shared<const wire::Bytes>(std::move(several));
  }
  sender.push(std::move(bundle), kMaxControlBytes);
}

std::optional<std::vector<std::vector<std::byte>>> open_bundle(std::span<const std::byte> bundle) {
  std::vector<std::vector<std::byte>> messages;
  while (!bundle.empty()) {
    if (bundle.size() < kRecordHeaderBytes) return {};
    const size_t bytes = get_le<uint32_t>(bundle.data());
    bundle = bundle.subspan(kRecordHeaderBytes);
    if (bytes > bundle.size()) return {};
    messages.emplace_back(bundle.begin(), bundle.begin() + static_cast<std::ptrdiff_t>(bytes));
    bundle = bundle.subspan(bytes);
  }
  return messages;
}

}  // namespace fire3dv::transport::udp
