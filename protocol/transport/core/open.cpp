#include "protocol/transport/open.h"

#include <exception>

#include "protocol/transport/core/address.h"
#include "protocol/transport/core/link_factories.h"

namespace fire3dv::transport {
namespace {

// Converts exceptions of libraries (memory, threads) to errors.
template <typename Link, typename Open>
Result<std::unique_ptr<Link>> without_exceptions(std::string_view uri, Open open) {
  try {
    return open();
  } catch (const std::exception& exception) {
    return Error{std::string(uri) + ": cannot be opened: " + exception.what()};
  }
}

}  // namespace

Result<void> check_uri(std::string_view uri) {
  const Result<Uri> parsed = parse_uri(uri);
  if (!parsed) return parsed.error();
  return {};
}

Result<std::unique_ptr<PublisherLink>> open_publisher(std::string_view text,
                                                      const PublisherOptions& options) {
  return without_exceptions<PublisherLink>(text, [&]() -> Result<std::unique_ptr<PublisherLink>> {
    const Result<Uri> uri = parse_uri(text);
    if (!uri) return uri.error();
    if (uri->scheme == Uri::Scheme::shm) return shm::make_publisher(uri->name, options);
    if (uri->port == 0)
      return Error{std::string(text) + ": port 0 is for listeners; name the renderer's port"};
    if (uri->scheme == Uri::Scheme::udp) return udp::make_publisher(*uri, options);
    return tcp::make_publisher(*uri, options);
  });
}

Result<std::unique_ptr<ListenerLink>> open_listener(std::string_view text, const ListenerOptions& options) {
  return without_exceptions<ListenerLink>(text, [&]() -> Result<std::unique_ptr<ListenerLink>> {
    const Result<Uri> uri = parse_uri(text);
    if (!uri) return uri.error();
    if (uri->scheme == Uri::Scheme::shm) return shm::make_listener(uri->name, options);
    if (options.max_peers == 0) return Error{std::string(text) + ": max_peers is 0; allow at least one"};
    if (uri->scheme == Uri::Scheme::udp) return udp::make_listener(*uri, options);
    return tcp::make_listener(*uri, options);
  });
}

}  // namespace fire3dv::transport
