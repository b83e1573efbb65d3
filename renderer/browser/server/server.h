// Server of the live view: a web page over HTTP, and a WebSocket for each viewer of it. It has threads of its
// own; the frame loop hands images over and takes messages, and never waits for a viewer.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/transport/http/access_rules.h"
#include "protocol/transport/open.h"
#include "renderer/browser/server/access.h"
#include "renderer/browser/server/message.h"

namespace fire3dv::serve {

using ViewerId = uint64_t;  // never reused

struct ServerLimits {
  size_t max_viewers = 16;
  size_t max_connections = 64;           // including those of viewers
  std::chrono::seconds handshake{5};     // TLS, request header, and the token of a viewer
  std::chrono::seconds idle{30};         // without an answer to pings
  size_t max_queued_bytes = 16u << 20;   // to one viewer; a slower one is disconnected
  size_t max_pending_messages = 256;     // of one viewer; reading pauses until the frame loop took them
  double max_messages_per_second = 500;  // of one viewer; reading pauses beyond
};

struct ServerOptions {
  std::string at;                         // HOST:PORT, port 0 for any free port
  bool insecure = false;                  // allows addresses other than loopback without TLS
  transport::TlsListenerOptions tls;      // HTTPS if it names a certificate
  std::filesystem::path token_file;       // empty: tokens of this run only
  transport::http::AccessOptions access;  // whose pages may connect, beside the server's own
  ServerLimits limits;
};

struct Event {
  enum class Kind : uint8_t { joined, left, message };
  Kind kind = Kind::message;
  ViewerId viewer = 0;
  Access access = Access::none;
  ClientMessage message;
};

// Image to encode and send. header.codec: h264 becomes vp8 or jpeg, and vp8 becomes jpeg, where the system
// has no encoder for it, or a side of the image is odd.
struct Image {
  ImageHeader header;
  bool needs_key = false;      // video: the viewer has no earlier image
  bool may_be_vp8 = false;     // instead of H.264
  int quality = 80;            // of JPEG
  std::vector<uint8_t> rgba8;  // top row first
};

// Encoded images of one codec, since the start.
struct EncodeTotals {
  uint64_t images = 0, bytes = 0;
  double seconds = 0;  // of the encoder's thread
};

// All functions are called on one thread, that of the frame loop, and return at once.
class Server {
 public:
  static Result<std::unique_ptr<Server>> open(const ServerOptions& options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  // Address of the page with a token in its fragment, which browsers do not send. A secret: for the user
  // only.
  std::string link(Access access) const;
  std::string address() const;  // "http://HOST:PORT"

  // Events since the last call, in the order of each viewer.
  std::vector<Event> take_events();
  // Makes take_events() report all connected viewers as joined, for another frame loop.
  void report_viewers_again();
  size_t viewers() const;
  EncodeTotals encode_totals(Codec codec) const;

  // Sends JSON text. Nothing happens if the viewer has left.
  void send(ViewerId viewer, std::string text);
  // Encodes and sends an image. One that waits for the encoder is replaced by a newer one of its viewer.
  void send_image(ViewerId viewer, Image&& image);

 private:
  struct State;
  explicit Server(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace fire3dv::serve
