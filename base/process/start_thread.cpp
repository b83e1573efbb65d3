#include "base/process/start_thread.h"

#include <sys/resource.h>

namespace fire3dv {

std::string thread_failure_text(const std::string& name, const std::error_code& reason) {
  rlimit limit{};
  std::string text = "the " + name + " thread cannot be started: " + reason.message();
  if (reason != std::errc::resource_unavailable_try_again || ::getrlimit(RLIMIT_NPROC, &limit) != 0)
    return text;
  const std::string now = limit.rlim_cur == RLIM_INFINITY ? "unlimited" : std::to_string(limit.rlim_cur);
  return text + "; raise the limit of processes and threads (ulimit -u, now " + now +
         "; TasksMax= of a service, pids.max of a container), or end other programs";
}

}  // namespace fire3dv
