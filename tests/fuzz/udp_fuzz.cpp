// Fuzz target of UDP datagrams in any order, for a session of each side and a group listener. Messages with a
// wrong hash are rejected, and buffered bytes stay within the budget.
#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "protocol/transport/core/byte_order.h"
#include "protocol/transport/udp/multicast/udp_group.h"
#include "protocol/transport/udp/udp_dtls.h"
#include "protocol/transport/udp/udp_handshake.h"
#include "protocol/transport/udp/udp_poses.h"
#include "protocol/transport/udp/udp_record.h"
#include "protocol/transport/udp/udp_session.h"
#include "tests/fuzz/target.h"

namespace fire3dv::fuzz {
namespace {

using namespace transport::udp;

constexpr uint64_t kSession = 0x1122334455667788;

// An input is a list of datagrams, each preceded by its length in two bytes (little endian).
void append(Input& input, std::span<const std::byte> datagram) {
  input.push_back(static_cast<uint8_t>(datagram.size()));
  input.push_back(static_cast<uint8_t>(datagram.size() >> 8));
  for (const std::byte byte : datagram) input.push_back(static_cast<uint8_t>(byte));
}

// One carousel round: the offer, the description, another message.
Input round_of(size_t bytes) {
  Input input;
  Session session(kSession, 0, nullptr);
  Carousel carousel(kDatagramBytes);
  carousel.describe(ControlSender::prepare(std::vector<std::byte>(bytes, std::byte{7})));
  carousel.add(ControlSender::prepare(std::vector<std::byte>(5)));
  Session::Buffer datagram{};
  session.start(datagram, Type::group);
  write_group_offer(datagram.data() + kHeaderBytes, carousel.offer());
  append(input, std::span(datagram).first(kHeaderBytes + kGroupOfferBytes));
  while (const auto fragment = carousel.next()) {
    session.start(datagram, Type::fragment);
    write_fragment_header(datagram.data() + kHeaderBytes, fragment->header);
    std::byte* const end = std::copy(fragment->data.begin(), fragment->data.end(),
                                     datagram.data() + kHeaderBytes + kFragmentHeaderBytes);
    append(input, std::span(datagram).first(static_cast<size_t>(end - datagram.data())));
  }
  return input;
}

// Frames of 1, 3 and 70 parts with two rows of parity. The second part is lost.
void append_parity(Input& input, Session& session) {
  uint64_t frame = 1;
  for (const uint32_t parts : {1u, 3u, 70u}) {
    ++frame;
    const uint32_t groups = parity_groups(parts);
    Session::Buffer datagram{};
    for (uint32_t part = 0; part < parts; ++part) {
      session.start(datagram, Type::pose);
      write_pose_header(datagram.data() + kHeaderBytes,
                        {frame, static_cast<uint16_t>(part), part + 1 == parts});
      if (part != 1) append(input, std::span(datagram).first(kHeaderBytes + kPoseHeaderBytes + 9));
    }
    for (uint32_t i = 0; i < 2 * groups; ++i) {
      session.start(datagram, Type::parity);
      write_parity_header(datagram.data() + kHeaderBytes, {frame, parts, static_cast<uint16_t>(i % groups),
                                                           static_cast<uint8_t>(i / groups)});
      append(input, std::span(datagram).first(kHeaderBytes + kParityHeaderBytes + 11));
    }
  }
}

}  // namespace

std::vector<Input> seeds() {
  std::vector<Input> inputs;
  for (const size_t bytes : {size_t{0}, size_t{10}, size_t{3000}}) {
    Input input;
    Session session(kSession, 0, nullptr);
    const std::vector<std::byte> message(bytes, std::byte{7});
    session.sender().push(ControlSender::prepare(message), SIZE_MAX);
    const auto emit = [&](std::span<const std::byte> datagram) { append(input, datagram); };
    session.emit_due(1, emit);
    session.emit_bare(Type::ping, emit);
    session.emit_number(Type::have, 3, emit);
    Session::Buffer pose{};
    session.start(pose, Type::pose);
    write_pose_header(pose.data() + kHeaderBytes, {1, 0, true});
    append(input, std::span(pose).first(kHeaderBytes + kPoseHeaderBytes + 40));
    append_parity(input, session);
    Session::Buffer ack{};
    session.start(ack, Type::ack);
    write_ack(ack.data() + kHeaderBytes, {1, 2, {5, 0, 0, 0}});
    append(input, std::span(ack).first(kHeaderBytes + kAckBytes));
    append(input, write_hello(5, 6));
    append(input, write_hello(5, 6, 9000));
    append(input, write_accept(5, kSession));
    append(input, write_accept(5, kSession, 9000));
    const auto key = PreSharedKey::from_secret(transport::Secret(std::vector<std::byte>(32, std::byte{1})));
    FIRE3DV_ASSERT(key.ok());
    const auto publisher = (*key)->connect();
    publisher->handshake({});
    for (const auto& datagram : publisher->take_outgoing()) append(input, datagram);
    inputs.push_back(std::move(input));
    inputs.push_back(round_of(bytes));
  }
  return inputs;
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv;
  using namespace fire3dv::transport::udp;
  constexpr size_t kBudget = 64 << 10;
  Session session(fuzz::kSession, 0, nullptr);
  static const ControlSender::Prepared large = ControlSender::prepare(std::vector<std::byte>(100'000));
  session.sender().push(large, SIZE_MAX);
  FrameTracker frames;
  ParityReceiver parity;
  CarouselReceiver group(kFragmentBytes);
  int64_t now = 1;
  while (size >= 2) {
    const size_t length = std::min<size_t>(data[0] | data[1] << 8, size - 2);
    std::vector<std::byte> datagram(length);
    if (length != 0) std::memcpy(datagram.data(), data + 2, length);
    data += 2 + length;
    size -= 2 + length;
    now += 1'000'000;
    const RecordDatagram records = inspect_records(datagram);
    FIRE3DV_ASSERT(records.kind != RecordDatagram::Kind::data || datagram.size() >= kRecordOverheadBytes);
    Header header;
    if (!read_header(datagram, header)) continue;
    FIRE3DV_ASSERT(records.kind == RecordDatagram::Kind::none);
    if (header.type == Type::hello && datagram.size() >= kHelloBytes) (void)read_hello(datagram);
    if (header.type == Type::accept) {
      (void)read_accept(datagram);
      (void)read_accept(datagram, 9000);
    }
    std::span<const std::byte> payload;
    if (session.receive(header, datagram, now, payload) != Session::Received::payload) continue;
    PoseHeader pose;
    if (header.type == Type::pose && read_pose_header(payload, pose)) {
      (void)frames.part(pose.frame, pose.part, pose.last);
      parity.add_part(pose.frame, pose.part, pose.last, payload.subspan(kPoseHeaderBytes));
    } else if (header.type == Type::parity) {
      (void)parity.add_parity(payload);
    }
    for (const auto& restored : parity.take_restored()) {
      FIRE3DV_ASSERT(!restored.message.empty() && restored.message.size() <= kMaxDatagramBytes);
      FIRE3DV_ASSERT(parity.has_part(restored.frame, restored.part));
      (void)frames.part(restored.frame, restored.part, restored.is_last);
    }
    FIRE3DV_ASSERT(parity.memory_bytes() <= ParityReceiver::kMaxBytes);
    if (header.type == Type::pose || header.type == Type::parity) {
      if (now % 7 == 0) parity.close_up_to(frames.newest_whole());
      continue;
    }
    GroupOffer offer;
    if (header.type == Type::group && read_group_offer(payload, offer)) (void)group.offered(offer);
    FragmentHeader fragment;
    if (header.type == Type::fragment && read_fragment_header(payload, fragment)) {
      const size_t room = kBudget - std::min(kBudget, group.buffered_bytes());
      if (group.fragment(fragment, payload.subspan(kFragmentHeaderBytes), room) ==
          CarouselReceiver::Outcome::corrupt)
        group = CarouselReceiver(kFragmentBytes);
      while (const auto message = group.take()) FIRE3DV_ASSERT(message->size() <= kBudget);
      FIRE3DV_ASSERT(group.buffered_bytes() <= kBudget);
    }
    const size_t held = session.receiver().buffered_bytes();
    const auto outcome = session.control(header.type, payload, kBudget - std::min(kBudget, held), now);
    if (outcome == ControlReceiver::Outcome::complete) (void)session.receiver().take();
    FIRE3DV_ASSERT(session.receiver().buffered_bytes() <= 4 * kBudget);
    if (outcome == ControlReceiver::Outcome::corrupt) break;
    session.emit_due(now,
                     [](std::span<const std::byte> out) { FIRE3DV_ASSERT(out.size() <= kMaxDatagramBytes); });
  }
  return 0;
}
