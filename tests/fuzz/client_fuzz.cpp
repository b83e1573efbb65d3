// Fuzz target of the client library: a hostile renderer at the other end of shm://, tcp://, tls:// and
// udp://. It answers requests with lies, damaged messages and floods. Invariants: an image that reaches the
// program is the requested one, its planes are readable, and the stream publishes on.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <map>
#include <memory>
#include <string>

#include "base/error.h"
#include "fire3dv/client.hpp"
#include "fire3dv/input.h"
#include "protocol/transport/open.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/encode.h"
#include "tests/fuzz/choices.h"
#include "tests/fuzz/target.h"
#include "tests/support/certificates.h"

namespace fire3dv::fuzz {
namespace {

constexpr int kSteps = 12;
const std::vector<Pose> kPoses(1, Pose{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});

// One stream, and the renderer's end of its link.
class Session {
 public:
  Session(const std::string& scheme, const transport::ListenerOptions& options, const Security& security)
      : is_udp_(scheme == "udp"), is_network_(scheme != "shm") {
    const std::string at =
        scheme == "shm" ? "shm://client-fuzz-" + std::to_string(::getpid()) : scheme + "://127.0.0.1:0";
    auto opened = transport::open_listener(at, options);
    FIRE3DV_ASSERT(opened.ok());
    link_ = std::move(*opened);
    stream_ = std::make_unique<Stream>(link_->uri(), "fuzz", security);
    stream_->describe({"node"});
    declare("gain", FIRE3DV_INPUT_SLIDER);
    declare("drag", FIRE3DV_INPUT_DRAG);
    for (int i = 0; i < 20'000 && epoch_ == 0; ++i) {
      link_->wait(std::chrono::milliseconds(1));
      listen();
    }
    FIRE3DV_ASSERT(epoch_ != 0);
  }

  void run(std::span<const uint8_t> input) {
    Choices choices(input);
    for (int step = 0; step < kSteps; ++step) {
      if (choices.one_in(40)) stream_->describe({"node"});
      stream_->publish(std::chrono::nanoseconds(++published_), kPoses);
      if (!is_udp_) request(choices);
      listen();
      const uint64_t messages = 1 + choices.below(4);
      for (uint64_t i = 0; i < messages; ++i) choices.one_in(3) ? send_control(choices) : send_image(choices);
      read(choices);
    }
    for (const auto& [id, wanted] : open_) stream_->cancel_image(id);
    open_.clear();
  }

 private:
  struct Wanted {
    uint32_t width, height, outputs;
    int32_t when;
  };

  void declare(const char* name, int kind) {
    fire3dv_input input{};
    input.struct_size = sizeof input;
    input.kind = kind;
    input.maximum = 1;
    FIRE3DV_ASSERT(fire3dv_declare_input(stream_->get(), name, &input) == FIRE3DV_OK);
  }

  void request(Choices& choices) {
    fire3dv_image_request request{};
    request.width = static_cast<uint32_t>(choices.one_of({1, 7, 16}));
    request.height = static_cast<uint32_t>(choices.one_of({1, 5, 16}));
    request.fx = request.fy = 10;
    request.lens = choices.one_in(4) ? FIRE3DV_LENS_PLUMB_BOB : FIRE3DV_LENS_NONE;
    request.outputs = static_cast<uint32_t>(choices.one_of({1, 4, 8, 5, 129, 511}));
    request.when = static_cast<int32_t>(choices.one_of({FIRE3DV_IMAGE_ONCE, FIRE3DV_IMAGE_EVERY_NTH}));
    if (open_.size() > 6) return;
    const uint64_t id = stream_->request_image(request);
    open_[id] = {request.width, request.height, request.outputs, request.when};
  }

  void listen() {
    if (is_network_) link_->wait(std::chrono::milliseconds(1));
    link_->poll([this](const transport::LinkEvent& event) {
      if (event.kind == transport::LinkEvent::Kind::connected) peer_ = event.peer;
      if (event.message.empty()) return;
      const auto message = decoder_.decode(event.message);
      if (!message) return;
      if (const auto* told = std::get_if<wire::StreamDescription>(&*message)) {
        epoch_ = told->epoch;
        asked_.clear();
      }
      if (const auto* asked = std::get_if<wire::ImageRequest>(&*message)) asked_[asked->place] = *asked;
    });
  }

  wire::Bytes damaged(Choices& choices, wire::Bytes message) {
    for (uint64_t i = choices.one_in(3) ? 1 + choices.below(4) : 0; i > 0 && !message.empty(); --i)
      message[choices.below(message.size())] = static_cast<std::byte>(choices.number());
    return message;
  }

  void send_control(Choices& choices) {
    const uint64_t epoch = choices.one_in(8) ? choices.number() | 1 : epoch_;
    const uint64_t id = asked_.empty() ? 1 : choices.any_of(asked_).second.id;
    const std::string text(choices.one_of<size_t>({0, 5, 600, 60000}), choices.one_of({'a', '\x1b', '%'}));
    wire::Bytes message;
    switch (choices.below(6)) {
      case 0: {
        wire::Welcome welcome;
        welcome.epoch = epoch;
        welcome.protocol_major = static_cast<uint16_t>(choices.one_of({1, 2, 65535}));
        welcome.renderer_name = "fuzz";
        welcome.message = text;
        welcome.unmatched_names.assign(choices.below(300), "name");
        message = wire::encode(welcome);
        break;
      }
      case 1:
        message = wire::encode(wire::Ack{epoch, choices.one_of<uint64_t>({0, 1, published_, UINT64_MAX})});
        break;
      case 2: {
        wire::Status status;
        status.epoch = epoch;
        status.message = "this stream " + text;
        message = wire::encode(status);
        break;
      }
      case 3:
        message = wire::encode(wire::Ping{choices.number(), choices.number()});
        break;
      case 4: {
        wire::InputEvent event;
        event.epoch = epoch;
        event.source = 1 + choices.below(100);
        event.sequence = choices.one_in(4) ? choices.number() : ++events_;
        event.viewer = static_cast<uint32_t>(choices.below(3));
        event.input = choices.one_of({"gain", "drag", "other"});
        event.action = static_cast<wire::InputAction>(choices.below(wire::kInputActionCount));
        event.value = choices.one_of({0.0, 1.0, 1e300});
        event.node = static_cast<uint32_t>(choices.one_of({0, 1, 1 << 30}));
        event.text = text;
        message = wire::encode(event);
        break;
      }
      default:
        // A refused request is over; the program hears of it once.
        message = wire::encode(wire::ImageRefused{epoch, id, wire::ImageRefusal::too_many, text});
    }
    link_->send(peer_, damaged(choices, std::move(message)));
  }

  void send_image(Choices& choices) {
    if (asked_.empty()) return;
    const wire::ImageRequest& asked = choices.any_of(asked_).second;
    wire::ImageFrame frame;
    frame.request = asked.id;
    frame.number = choices.one_of<uint64_t>({1, published_, UINT64_MAX});
    frame.epoch = asked.epoch;
    frame.sequence = choices.one_in(6) ? choices.number() : asked.sequence + choices.below(2);
    frame.intrinsics = asked.intrinsics;
    if (choices.one_in(6)) frame.intrinsics.width = static_cast<uint32_t>(choices.one_of({1, 64, 8192}));
    if (choices.one_in(6)) frame.intrinsics.height = static_cast<uint32_t>(choices.one_of({1, 64, 8192}));
    if (choices.one_in(8)) frame.intrinsics.lens.model = wire::LensModel(choices.below(256));
    const uint32_t outputs =
        choices.one_in(6) ? static_cast<uint32_t>(choices.below(wire::kAllImageOutputs + 1)) : asked.outputs;
    for (uint32_t bit = 0; bit < wire::kImageOutputCount; ++bit) {
      if ((outputs >> bit & 1) == 0) continue;
      const wire::ImageOutputInfo& info = wire::info_at(bit);
      wire::ImagePlane plane{bit, info.format, frame.intrinsics.width, frame.intrinsics.height, 0, 0, 0};
      if (info.is_boxes) {
        plane.width = static_cast<uint32_t>(choices.below(3));
        plane.height = 1;
      }
      plane.row_stride = info.element_bytes * plane.width;
      if (choices.one_in(12)) plane.row_stride = static_cast<uint32_t>(choices.number());
      plane.offset = choices.one_in(12) ? choices.number() & ~uint64_t{63} : frame.pixel_bytes;
      plane.bytes = uint64_t{plane.row_stride} * plane.height;
      frame.pixel_bytes += (plane.bytes + 63) / 64 * 64;
      frame.planes.push_back(plane);
    }
    const uint64_t sent = std::min<uint64_t>(choices.one_in(8) ? 64 : frame.pixel_bytes, 1 << 16);
    const int fill = static_cast<int>(choices.below(3));
    link_->send_image(peer_, choices.one_in(16) ? asked.id + 1 : asked.id,
                      damaged(choices, wire::encode(frame)), sent,
                      [&](std::span<std::byte> pixels) { std::memset(pixels.data(), fill, pixels.size()); });
  }

  // What a program does: it reads the size that it has requested.
  void use(const fire3dv_image& image) {
    const auto found = open_.find(image.request);
    FIRE3DV_ASSERT(found != open_.end());
    const Wanted& wanted = found->second;
    FIRE3DV_ASSERT(image.width == wanted.width && image.height == wanted.height);
    FIRE3DV_ASSERT(image.sequence <= stream_->poll().sequence);
    uint32_t outputs = 0, sum = 0;
    for (size_t i = 0; i < image.plane_count; ++i) {
      const fire3dv_image_plane& plane = image.planes[i];
      outputs |= plane.output;
      for (uint64_t at = 0; at < uint64_t{plane.row_stride} * plane.height; ++at)
        sum += static_cast<const uint8_t*>(plane.data)[at];
    }
    FIRE3DV_ASSERT(outputs == wanted.outputs);
    if (const fire3dv_image_plane* const color = plane_of(image, FIRE3DV_IMAGE_COLOR_SRGB8))
      FIRE3DV_ASSERT(color->row_stride >= 4 * wanted.width && color->height == wanted.height);
    read_bytes_ = sum;
    if (wanted.when == FIRE3DV_IMAGE_ONCE) open_.erase(found);
  }

  void read(Choices& choices) {
    const uint64_t id = choices.one_in(2) || open_.empty() ? 0 : choices.any_of(open_).first;
    // Over a network the messages may arrive in a later step.
    uint32_t timeout_ms = is_network_ && !is_udp_ ? 1 : 0;
    for (int code = FIRE3DV_OK; code == FIRE3DV_OK || code == FIRE3DV_ERROR_REFUSED; timeout_ms = 0) {
      fire3dv_image* raw = nullptr;
      code = fire3dv_wait_image(stream_->get(), id, timeout_ms, &raw);
      const Image image(raw);
      FIRE3DV_ASSERT((code == FIRE3DV_OK) == (raw != nullptr));
      if (raw) use(*image);
    }
    fire3dv_event event{};
    event.struct_size = sizeof event;
    while (fire3dv_poll_events(stream_->get(), &event, 1) == 1) {
      const bool is_gain = std::string(event.input) == "gain";
      FIRE3DV_ASSERT(is_gain || std::string(event.input) == "drag");
      FIRE3DV_ASSERT(is_gain ? event.value >= 0 && event.value <= 1 : event.node == 0);
      FIRE3DV_ASSERT(::strnlen(event.text, sizeof event.text) < sizeof event.text);
    }
    const fire3dv_status status = stream_->poll();
    FIRE3DV_ASSERT(::strnlen(status.welcome_message, sizeof status.welcome_message) <
                   sizeof status.welcome_message);
    // Refused requests and those that a description has ended.
    std::erase_if(open_, [&](const auto& entry) {
      fire3dv_image* raw = nullptr;
      const int code = fire3dv_wait_image(stream_->get(), entry.first, 0, &raw);
      if (raw) use_later_.push_back(Image(raw));
      return code == FIRE3DV_ERROR_REFUSED || code == FIRE3DV_ERROR_ARGUMENT;
    });
    for (const Image& image : use_later_) use(*image);
    use_later_.clear();
  }

  const bool is_udp_, is_network_;
  std::unique_ptr<transport::ListenerLink> link_;
  std::unique_ptr<Stream> stream_;
  transport::PeerId peer_ = 0;
  wire::Decoder decoder_;
  uint64_t epoch_ = 0, published_ = 0, events_ = 0;
  std::map<uint32_t, wire::ImageRequest> asked_;  // by place, as the renderer knows them
  std::map<uint64_t, Wanted> open_;               // by id, as the program knows them
  std::vector<Image> use_later_;
  volatile uint32_t read_bytes_ = 0;
};

Session& session_of(const std::string& scheme) {
  static const test::Credentials credentials;
  static const auto authority = credentials.authority("authority");
  static const auto server = credentials.identity("server", "IP:127.0.0.1", authority);
  static std::map<std::string, std::unique_ptr<Session>> sessions;
  std::unique_ptr<Session>& session = sessions[scheme];
  if (session) return *session;
  transport::ListenerOptions options;
  Security security;
  if (scheme == "tls") {
    options.tls.certificate_file = server.certificate_file;
    options.tls.key_file = server.key_file;
    security.tls_ca_file = authority.certificate_file;
  }
  session = std::make_unique<Session>(scheme, options, security);
  return *session;
}

}  // namespace

std::vector<Input> seeds() {
  std::vector<Input> inputs;
  for (uint8_t scheme = 0; scheme < 8; ++scheme)
    for (uint8_t i = 0; i < 4; ++i) inputs.push_back({scheme, i});
  return inputs;
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv::fuzz;
  // Shared memory needs no other thread, so that most inputs use it.
  constexpr const char* kSchemes[] = {"tcp", "tls", "udp", "shm", "shm", "shm", "shm", "shm"};
  session_of(kSchemes[size == 0 ? 3 : data[0] % 8]).run({data, size});
  return 0;
}
