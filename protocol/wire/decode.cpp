#include "protocol/wire/decode.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>

#include "fire3dv_generated.h"
#include "protocol/wire/check.h"
#include "protocol/wire/decode_tables.h"

namespace fire3dv::wire {
namespace {

// Verifier limits. The deepest table is the clock in the description in the message, or the value of an edit;
// a message has three tables. Fields of later minor versions are not followed and need no reserve.
constexpr flatbuffers::uoffset_t kMaxDepth = 4;
constexpr flatbuffers::uoffset_t kMaxTables = 4;
constexpr size_t kSmallestMessage = 12;  // root offset, identifier, vtable offset of the root table
constexpr size_t kLargestMessage = size_t{1} << 30;  // FlatBuffers is limited to 2 GiB
constexpr size_t kAlignment = 16;
constexpr size_t kMaxRetainedBytes = 1 << 20;

using Strings = flatbuffers::Vector<flatbuffers::Offset<flatbuffers::String>>;

std::string_view view(const flatbuffers::String* text) {
  return text ? std::string_view(text->c_str(), text->size()) : std::string_view();
}

std::span<const Affine3x4> view(const flatbuffers::Vector<const fbs::Affine3x4*>* poses) {
  if (!poses) return {};
  return {reinterpret_cast<const Affine3x4*>(poses->Data()), poses->size()};
}

// Rejects names that are longer in total than their message: list entries may share one long string, and a
// small message must not expand to a large one.
Result<void> read_names(std::string_view field, const Strings* list, size_t message_bytes,
                        const DecodeLimits& limits, std::vector<std::string>& names) {
  if (!list) return {};
  if (list->size() > limits.max_nodes) {
    return Error{std::string(field) + " holds " + std::to_string(list->size()) + " names; at most " +
                 std::to_string(limits.max_nodes) + " are allowed"};
  }
  size_t total_bytes = 0;
  for (const flatbuffers::String* name : *list) total_bytes += name->size();
  if (total_bytes > message_bytes) {
    return Error{std::string(field) + " is longer than the message that holds it: its names overlap"};
  }
  names.reserve(list->size());
  for (const flatbuffers::String* name : *list) names.emplace_back(view(name));
  return {};
}

// Unknown statuses of later minor versions count as refused.
WelcomeStatus read_status(uint8_t status) {
  return status <= static_cast<uint8_t>(WelcomeStatus::bad_key) ? static_cast<WelcomeStatus>(status)
                                                                : WelcomeStatus::refused;
}

Result<Message> read(const fbs::StreamDescription& table, size_t message_bytes, const DecodeLimits& limits) {
  StreamDescription result;
  result.protocol_major = table.protocol_major();
  result.protocol_minor = table.protocol_minor();
  result.epoch = table.epoch();
  result.adapter_name = view(table.adapter_name());
  const Result<void> names = read_names("StreamDescription.node_names", table.node_names(), message_bytes,
                                        limits, result.node_names);
  if (!names.ok()) return names.error();
  if (const fbs::Affine3x4d* matrix = table.world_from_stream()) {
    std::memcpy(result.world_from_stream.m.data(), matrix, sizeof(Affine3x4d));
  }
  const std::span<const Affine3x4> body_from_node = view(table.body_from_node());
  result.body_from_node.assign(body_from_node.begin(), body_from_node.end());
  result.nominal_rate_hz = table.nominal_rate_hz();
  result.scene_uri = view(table.scene_uri());
  if (const fbs::ClockInfo* clock = table.clock()) {
    result.clock.boot_id = view(clock->boot_id());
    result.clock.monotonic_at_open_ns = clock->monotonic_at_open_ns();
    result.clock.realtime_at_open_ns = clock->realtime_at_open_ns();
    result.clock.sim_seconds_per_second = clock->sim_seconds_per_second();
  }
  const Result<void> good = check(result, limits);
  if (!good.ok()) return good.error();
  return Message(std::move(result));
}

Result<Message> read(const fbs::PoseFrame& table, const DecodeLimits& limits) {
  PoseFrameView result;
  result.header = {table.epoch(),           table.sequence(),      table.sim_time_ns(),
                   table.publish_time_ns(), table.scene_version(), table.flags()};
  result.node_count = table.node_count();
  result.first_node = table.first_node();
  result.poses = view(table.poses());
  if (const auto* indices = table.node_indices()) {
    if (indices->size() == 0)
      return Error{"PoseFrame.node_indices is empty; a partial frame names at least one node"};
    result.node_indices = {indices->data(), indices->size()};
  }
  const Result<void> good = check(result, limits);
  if (!good.ok()) return good.error();
  return Message(result);
}

Result<Message> read(const fbs::Welcome& table, size_t message_bytes, const DecodeLimits& limits) {
  Welcome result;
  result.status = read_status(static_cast<uint8_t>(table.status()));
  result.protocol_major = table.protocol_major();
  result.protocol_minor = table.protocol_minor();
  result.epoch = table.epoch();
  result.renderer_name = view(table.renderer_name());
  result.message = view(table.message());
  Result<void> names = read_names("Welcome.unmatched_names", table.unmatched_names(), message_bytes, limits,
                                  result.unmatched_names);
  if (!names.ok()) return names.error();
  names = read_names("Welcome.conflicting_names", table.conflicting_names(), message_bytes, limits,
                     result.conflicting_names);
  if (!names.ok()) return names.error();
  const Result<void> good = check(result, limits);
  if (!good.ok()) return good.error();
  return Message(std::move(result));
}

Result<Message> read(const fbs::Status& table, size_t message_bytes, const DecodeLimits& limits) {
  Status result;
  result.epoch = table.epoch();
  result.message = view(table.message());
  const Result<void> names = read_names("Status.contested_names", table.contested_names(), message_bytes,
                                        limits, result.contested_names);
  if (!names.ok()) return names.error();
  const Result<void> good = check(result, limits);
  if (!good.ok()) return good.error();
  return Message(std::move(result));
}

// Description of another major version: shared fields only.
Result<Message> read_shared(const fbs::AnyDescription& table, const DecodeLimits& limits) {
  StreamDescription result;
  result.protocol_major = table.protocol_major();
  result.protocol_minor = table.protocol_minor();
  result.epoch = table.epoch();
  result.adapter_name = view(table.adapter_name());
  const Result<void> good = check(result, limits);
  if (!good.ok()) return good.error();
  return Message(std::move(result));
}

Result<Message> read_shared(const fbs::AnyWelcome& table) {
  Welcome result;
  result.status = read_status(table.status());
  result.protocol_major = table.protocol_major();
  result.protocol_minor = table.protocol_minor();
  result.epoch = table.epoch();
  return Message(std::move(result));
}

}  // namespace

struct Decoder::Impl {
  explicit Impl(DecodeLimits limits_in) : limits(limits_in) {}

  enum class Source { copied, in_place };
  Result<Message> decode(std::span<const std::byte> bytes, Source source);

  std::optional<ImageRequestName> refused_request;

 private:
  struct FreeAligned {
    void operator()(std::byte* memory) const { ::operator delete[](memory, std::align_val_t(kAlignment)); }
  };

  DecodeLimits limits;
  std::unique_ptr<std::byte[], FreeAligned> copy_;
  size_t capacity_ = 0;
  std::span<const std::byte> bytes_;  // of the current message

  std::span<const std::byte> copy(std::span<const std::byte> bytes);
  Result<Message> read_message();

  // Returns null if the bytes are not a message with that root. Verifies the whole structure on each call,
  // independent of earlier readers.
  template <typename Root>
  const Root* verified() const {
    const auto* data = reinterpret_cast<const uint8_t*>(bytes_.data());
    flatbuffers::Verifier::Options options;
    options.max_depth = kMaxDepth;
    options.max_tables = kMaxTables;
    flatbuffers::Verifier verifier(data, bytes_.size(), options);
    return verifier.VerifyBuffer<Root>(fbs::MessageIdentifier()) ? flatbuffers::GetRoot<Root>(data) : nullptr;
  }
};

std::span<const std::byte> Decoder::Impl::copy(std::span<const std::byte> bytes) {
  if (bytes.size() > capacity_) {
    const size_t wanted =
        bytes.size() + bytes.size() / 4;  // 25% reserve: slightly growing frames do not reallocate each time
    copy_.reset(static_cast<std::byte*>(::operator new[](wanted, std::align_val_t(kAlignment))));
    capacity_ = wanted;
  }
  std::memcpy(copy_.get(), bytes.data(), bytes.size());
  return {copy_.get(), bytes.size()};
}

Result<Message> Decoder::Impl::read_message() {
  const fbs::AnyMessage* any = verified<fbs::AnyMessage>();
  if (!any) return Error{"Message.body_type cannot be read: the bytes are not a FlatBuffer, or were cut"};
  const auto type = static_cast<fbs::Body>(any->body_type());

  if (type == fbs::Body::StreamDescription) {
    const auto* message = verified<fbs::AnyDescriptionMessage>();
    if (!message || !message->body())
      return Error{"StreamDescription is damaged: its fields point outside the message"};
    if (message->body()->protocol_major() != kProtocolMajor) return read_shared(*message->body(), limits);
  } else if (type == fbs::Body::Welcome) {
    const auto* message = verified<fbs::AnyWelcomeMessage>();
    if (!message || !message->body())
      return Error{"Welcome is damaged: its fields point outside the message"};
    if (message->body()->protocol_major() != kProtocolMajor) return read_shared(*message->body());
  } else if (type > fbs::Body::MAX || (type != fbs::Body::NONE && *fbs::EnumNameBody(type) == '\0')) {
    return Message(UnknownMessage{any->body_type()});
  }

  if (type == fbs::Body::NONE) return Error{"Message.body_type is 0: the message has no body"};
  const fbs::Message* message = verified<fbs::Message>();
  const char* name = fbs::EnumNameBody(type);
  if (!message) return Error{std::string(name) + " is damaged: its fields point outside the message"};
  if (!message->body()) return Error{"Message.body is missing: a " + std::string(name) + " was announced"};
  switch (type) {
    case fbs::Body::StreamDescription:
      return read(*message->body_as_StreamDescription(), bytes_.size(), limits);
    case fbs::Body::PoseFrame:
      return read(*message->body_as_PoseFrame(), limits);
    case fbs::Body::Welcome:
      return read(*message->body_as_Welcome(), bytes_.size(), limits);
    case fbs::Body::Status:
      return read(*message->body_as_Status(), bytes_.size(), limits);
    case fbs::Body::Ack: {
      const fbs::Ack& ack = *message->body_as_Ack();
      return Message(Ack{ack.epoch(), ack.sequence()});
    }
    case fbs::Body::Ping: {
      const fbs::Ping& ping = *message->body_as_Ping();
      return Message(Ping{ping.id(), ping.sender_time_ns()});
    }
    case fbs::Body::Pong: {
      const fbs::Pong& pong = *message->body_as_Pong();
      return Message(Pong{pong.id(), pong.ping_sender_time_ns(), pong.answer_time_ns()});
    }
    case fbs::Body::Goodbye:
      return Message(Goodbye{message->body_as_Goodbye()->epoch()});
    case fbs::Body::SceneEdit:
      return read_scene_edit(*message->body_as_SceneEdit(), bytes_.size(), limits);
    case fbs::Body::ImageRequest: {
      const fbs::ImageRequest& request = *message->body_as_ImageRequest();
      Result<Message> read = read_image_request(request, limits);
      if (!read) refused_request = ImageRequestName{request.epoch(), request.id()};
      return read;
    }
    case fbs::Body::ImageFrame:
      return read_image_frame(*message->body_as_ImageFrame(), limits);
    case fbs::Body::ImageRefused:
      return read_image_refused(*message->body_as_ImageRefused(), limits);
    case fbs::Body::InputEvent:
      return read_input_event(*message->body_as_InputEvent(), limits);
    case fbs::Body::NONE:
      break;
  }
  std::abort();  // unreachable: every type up to Body::MAX has a case above
}

Result<Message> Decoder::Impl::decode(std::span<const std::byte> bytes, Source source) {
  refused_request.reset();
  const size_t limit = std::min(limits.max_message_bytes, kLargestMessage);
  if (bytes.size() > limit) {
    return Error{"Message has " + std::to_string(bytes.size()) + " bytes; at most " + std::to_string(limit) +
                 " are allowed"};
  }
  if (bytes.size() < kSmallestMessage) {
    return Error{"Message has " + std::to_string(bytes.size()) + " bytes; the smallest has " +
                 std::to_string(kSmallestMessage)};
  }
  if (std::memcmp(bytes.data() + 4, fbs::MessageIdentifier(), 4) != 0) {
    return Error{"Message identifier is not F3DV: this is not FIRE-3DV traffic"};
  }
  const bool is_aligned = reinterpret_cast<uintptr_t>(bytes.data()) % kAlignment == 0;
  bytes_ = source == Source::in_place && is_aligned ? bytes : copy(bytes);
  Result<Message> message = read_message();
  // An invalid message must not make the renderer retain a large buffer.
  if (!message.ok() && capacity_ > kMaxRetainedBytes) {
    copy_.reset();
    capacity_ = 0;
  }
  return message;
}

Decoder::Decoder(DecodeLimits limits) : impl_(std::make_unique<Impl>(limits)) {}
Decoder::~Decoder() = default;
Decoder::Decoder(Decoder&&) noexcept = default;
Decoder& Decoder::operator=(Decoder&&) noexcept = default;

Result<Message> Decoder::decode(std::span<const std::byte> bytes) {
  return impl_->decode(bytes, Impl::Source::copied);
}

Result<Message> Decoder::decode_in_place(std::span<const std::byte> bytes) {
  return impl_->decode(bytes, Impl::Source::in_place);
}

const std::optional<ImageRequestName>& Decoder::refused_request() const {
  return impl_->refused_request;
}

}  // namespace fire3dv::wire
