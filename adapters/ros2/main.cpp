// Adapter for ROS 2: fire3dv-ros2 --to URI publishes the transforms and the robot of a ROS 2 system to
// renderers.

#include <dds/ddsrt/log.h>

#include <cstdlib>
#include <exception>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "adapters/ros2/bridge.h"
#include "adapters/ros2/limited_log.h"
#include "adapters/ros2/options.h"
#include "base/log.h"
#include "base/process/stop_signals.h"

namespace fire3dv::ros2 {
namespace {

// Cyclone's own messages, mostly about the network and its configuration.
void log_dds_message(void*, const dds_log_data_t* data) {
  const std::string_view text(data->message, data->size);
  const size_t end = text.find_last_not_of('\n');
  log_line(warning("DDS: " + std::string(text.substr(0, end == text.npos ? 0 : end + 1))));
}

Result<void> run(Options&& options) {
  install_stop_signals();
  dds_set_log_sink(&log_dds_message, nullptr);
  Result<DomainSettings> settings =
      domain_settings([](const char* name) { return std::getenv(name); }, options.domain_id);
  if (!settings) return settings.error();
  Result<std::unique_ptr<Bridge>> bridge = Bridge::open(std::move(options), std::move(*settings));
  if (!bridge) return bridge.error();
  return (*bridge)->run(stop_requested);
}

}  // namespace
}  // namespace fire3dv::ros2

int main(int argc, char** argv) {
  using namespace fire3dv;
  std::variant<ros2::Options, int> options = ros2::parse_options(argc, argv);
  if (const int* exit_code = std::get_if<int>(&options)) return *exit_code;
  try {
    const Result<void> done = ros2::run(std::move(std::get<ros2::Options>(options)));
    if (done) return 0;
    ros2::log_line(error_line(done.error().message));
  } catch (const std::exception& fault) {  // out of memory
    ros2::log_line(error_line(fault.what()));
  }
  return 1;
}
