// Start of threads: a failure names the thread and the limits that may be reached.
#pragma once

#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

namespace fire3dv {

// name: of the thread's task, such as "recording".
std::string thread_failure_text(const std::string& name, const std::error_code& reason);

// Throws std::runtime_error with that text.
template <typename Thread = std::thread, typename... Arguments>
Thread start_thread(const std::string& name, Arguments&&... arguments) {
  try {
    return Thread(std::forward<Arguments>(arguments)...);
  } catch (const std::system_error& failure) {
    throw std::runtime_error(thread_failure_text(name, failure.code()));
  }
}

}  // namespace fire3dv
