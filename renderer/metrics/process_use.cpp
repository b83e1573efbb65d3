#include "renderer/metrics/process_use.h"

#include <dirent.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <memory>

namespace fire3dv::metrics {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
  void operator()(DIR* folder) const { ::closedir(folder); }
};

struct Memory {
  uint64_t virtual_bytes = 0, resident_bytes = 0;
};

Memory memory_use() {
  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen("/proc/self/statm", "re"));
  unsigned long virtual_pages = 0, resident_pages = 0;
  if (!file || std::fscanf(file.get(), "%lu %lu", &virtual_pages, &resident_pages) != 2) return {};
  const auto page_bytes = static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
  return {virtual_pages * page_bytes, resident_pages * page_bytes};
}

uint64_t open_files() {
  const std::unique_ptr<DIR, CloseFile> folder(::opendir("/proc/self/fd"));
  uint64_t count = 0;
  if (!folder) return count;
  while (const dirent* entry = ::readdir(folder.get())) count += entry->d_name[0] != '.';
  return count == 0 ? 0 : count - 1;  // the folder's own descriptor is open, too
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

}  // namespace

uint64_t resident_bytes() {
  return memory_use().resident_bytes;
}

void write_process_use(Exposition& exposition) {
  const Memory memory = memory_use();
  rusage use{};
  ::getrusage(RUSAGE_SELF, &use);
  exposition.family("process_resident_memory_bytes", "gauge", "Memory of this process that is in RAM.");
  exposition.sample({}, memory.resident_bytes);
  exposition.family("process_virtual_memory_bytes", "gauge", "Addresses that this process has mapped.");
  exposition.sample({}, memory.virtual_bytes);
  exposition.family("process_cpu_seconds_total", "counter", "Processor time of all threads.");
  exposition.sample({}, seconds(use.ru_utime) + seconds(use.ru_stime));
  exposition.family("process_open_fds", "gauge", "Open file descriptors.");
  exposition.sample({}, open_files());
}

}  // namespace fire3dv::metrics
