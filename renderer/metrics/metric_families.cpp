#include "renderer/metrics/metric_families.h"

#include <dirent.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <set>

#include "protocol/wire/check.h"

namespace fire3dv::metrics {

namespace {

std::string number(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  char text[64];
  // std::to_chars is independent of the locale, unlike printf. Fixed notation is easier to read for people.
  const bool plain = value == 0 || (std::abs(value) > 1e-9 && std::abs(value) < 1e15);
  const auto [end, error] = std::to_chars(text, text + sizeof text, value,
                                          plain ? std::chars_format::fixed : std::chars_format::scientific);
  return std::string(text, error == std::errc() ? end : text);
}

void append_escaped(std::string& to, std::string_view text) {
  for (const char c : text) {
    if (c == '\\' || c == '"') to += '\\';
    if (c == '\n')
      to += "\\n";
    else
      to += c;
  }
}

}  // namespace

void Histogram::add(double seconds) {
  if (!(seconds >= 0)) return;  // NaN, or a clock that ran backwards
  const auto bound = std::lower_bound(kUpperBounds_s.begin(), kUpperBounds_s.end(), seconds);
  ++buckets_[static_cast<size_t>(bound - kUpperBounds_s.begin())];
  ++count_;
  sum_s_ += seconds;
}

uint64_t Histogram::count_up_to(size_t bound) const {
  uint64_t count = 0;
  for (size_t i = 0; i <= bound; ++i) count += buckets_[i];
  return count;
}

void Exposition::family(std::string_view name, std::string_view type, std::string_view help) {
  family_ = name;
  text_.append("# HELP ").append(name).append(" ").append(help).append("\n# TYPE ");
  text_.append(name).append(" ").append(type).append("\n");
}

void Exposition::line(std::string_view suffix, Labels labels, const Label* more, std::string_view value) {
  text_.append(family_).append(suffix);
  char before = '{';
  const auto append = [&](const Label& label) {
    text_ += std::exchange(before, ',');
    text_.append(label.first).append("=\"");
    append_escaped(text_, label.second);
    text_ += '"';
  };
  for (const Label& label : labels) append(label);
  if (more != nullptr) append(*more);
  if (before == ',') text_ += '}';
  text_.append(" ").append(value).append("\n");
}

void Exposition::sample(std::initializer_list<Label> labels, double value) {
  line("", labels, nullptr, number(value));
}

void Exposition::sample(std::initializer_list<Label> labels, uint64_t value) {
  line("", labels, nullptr, std::to_string(value));
}

void Exposition::histogram(std::initializer_list<Label> labels, const Histogram& histogram) {
  for (size_t i = 0; i < Histogram::kUpperBounds_s.size(); ++i) {
    const std::string bound = number(Histogram::kUpperBounds_s[i]);
    const Label le{"le", bound};
    line("_bucket", labels, &le, std::to_string(histogram.count_up_to(i)));
  }
  const Label le{"le", "+Inf"};
  line("_bucket", labels, &le, std::to_string(histogram.count()));
  summary(labels, histogram.count(), histogram.sum_s());
}

void Exposition::summary(std::initializer_list<Label> labels, uint64_t count, double sum) {
  line("_sum", labels, nullptr, number(sum));
  line("_count", labels, nullptr, std::to_string(count));
}

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

namespace {

// Largest used fraction of a limit; peers with refusals rank above all others.
double rank_of(const PeerUse& peer, const PeerLimits& limits) {
  double rank = 0;
  for (size_t i = 0; i < kResourceCount; ++i) {
    if (peer.refused[i] > 0) rank = std::max(rank, 1.0);
    if (limits.per_peer[i] > 0)
      rank = std::max(rank, static_cast<double>(peer.used[i]) / static_cast<double>(limits.per_peer[i]));
  }
  return rank;
}

void keep_largest(std::vector<PeerUse>& peers, const PeerLimits& limits) {
  if (peers.size() <= kMaxListedPeers) return;
  std::vector<std::pair<double, size_t>> order;
  for (size_t i = 0; i < peers.size(); ++i) order.emplace_back(-rank_of(peers[i], limits), i);
  std::ranges::sort(order);
  order.resize(kMaxListedPeers);
  std::vector<PeerUse> largest;
  for (const auto& [rank, i] : order) largest.push_back(std::move(peers[i]));
  peers = std::move(largest);
}

// Makes names unique: two samples of a family must not have the same labels.
void name_apart(std::vector<PeerUse>& peers) {
  std::set<std::string> names;
  for (PeerUse& peer : peers) {
    const std::string name = wire::printable(peer.peer);
    peer.peer = name;
    for (uint32_t number = 2; !names.insert(peer.peer).second; ++number)
      peer.peer = name + " #" + std::to_string(number);
  }
}

}  // namespace

void write_peer_use(Exposition& page, const PeerLimits& limits, std::vector<PeerUse> peers) {
  page.family("fire3dv_peers", "gauge", "Peers that have a budget.");
  page.sample({}, uint64_t{peers.size()});
  page.family("fire3dv_peer_limit", "gauge", "Limit of one peer, in bytes or objects.");
  for (const ResourceInfo& resource : resource_table())
    page.sample({{"resource", resource.name}}, limits.of(resource.resource));
  keep_largest(peers, limits);
  name_apart(peers);
  page.family("fire3dv_peer_use", "gauge",
              "Resources that the renderer holds for a peer, in bytes or objects.");
  for (const PeerUse& peer : peers) {
    for (size_t i = 0; i < kResourceCount; ++i)
      page.sample({{"peer", peer.peer}, {"stream", peer.stream}, {"resource", resource_table()[i].name}},
                  peer.used[i]);
  }
  page.family("fire3dv_peer_refusals_total", "counter", "Values and objects refused by a limit.");
  for (const PeerUse& peer : peers) {
    for (size_t i = 0; i < kResourceCount; ++i)
      page.sample({{"peer", peer.peer}, {"resource", resource_table()[i].name}}, peer.refused[i]);
  }
}

}  // namespace fire3dv::metrics
