#include "base/process/failure.h"

#include <sys/resource.h>

#include <atomic>
#include <new>

namespace fire3dv {
namespace {

std::atomic<const char*> failed_activity{nullptr};

}  // namespace

Activity::~Activity() {
  const char* none = nullptr;
  if (std::uncaught_exceptions() > exceptions_) failed_activity.compare_exchange_strong(none, name_);
}

std::string describe_failure(const std::exception& failure) {
  const char* const activity = failed_activity;
  const std::string during = activity ? std::string(" while ") + activity : std::string();
  if (dynamic_cast<const std::bad_alloc*>(&failure) == nullptr) return failure.what() + during;
  rlimit limit{};
  const bool is_limited = ::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
  return "out of memory" + during +
         (is_limited ? "; raise the limit of the address space (ulimit -v, now " +
                           std::to_string(limit.rlim_cur >> 20) + " MiB)"
                     : "; free memory, or choose smaller images or a smaller scene");
}

}  // namespace fire3dv
