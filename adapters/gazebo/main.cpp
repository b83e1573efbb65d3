// Gazebo adapter: fire3dv-gazebo --to URI publishes a running Gazebo world to renderers.

#include <exception>
#include <new>
#include <string>
#include <utility>

#include "adapters/gazebo/options.h"
#include "base/log.h"
#include "base/process/stop_signals.h"

namespace fire3dv::gazebo {
namespace {

// Names in `text` are untrusted: one line each.
void log_line(const std::string& text) {
  print_log_line("fire3dv-gazebo", printable_text(text, 4096));
}

Result<void> run(Options options) {
  install_stop_signals();
  Result<std::unique_ptr<Node>> node = Node::open(options.node);
  if (!node) return node.error();
  Result<Publisher> publisher = Publisher::open(options.uris, options.security, options.stream_name);
  if (!publisher) return publisher.error();
  Session session(std::move(*node), std::move(*publisher), std::move(options.resource_folders),
                  std::move(options.session), log_line);
  Result<void> done = session.run(stop_requested);
  session.log_totals();
  return done;
}

}  // namespace
}  // namespace fire3dv::gazebo

int main(int argc, char** argv) {
  using namespace fire3dv::gazebo;
  int exit_code = 0;
  auto options = parse_options(argc, argv, &exit_code);
  if (!options) return exit_code;
  try {
    const fire3dv::Result<void> done = run(std::move(*options));
    if (done) return 0;
    log_line(fire3dv::error_line(done.error().message));
  } catch (const std::bad_alloc&) {
    log_line("error: the world does not fit into memory");
  } catch (const std::exception& fault) {  // thrown by a library
    log_line(fire3dv::error_line(fault.what()));
  }
  return 1;
}
