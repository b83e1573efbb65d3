#include "adapters/ambf/links.h"

#include <cmath>

#include "adapters/ambf/log.h"

namespace fire3dv::ambf {
namespace {

// Rotates Z up to Y up (protocol/SPEC.md).
constexpr double kWorldFromStream[12] = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0};

constexpr size_t kMaxLoggedErrors =
    50;  // bounds the set: messages may contain numbers that change at each step

const char* file(const std::string& name) {
  return name.empty() ? nullptr : name.c_str();
}

}  // namespace

Result<void> Links::open(const Options& options) {
  std::string failed;
  for (const std::string& uri : options.uris) {
    fire3dv_options link{};
    link.struct_size = sizeof link;
    link.adapter_name = "ambf";
    link.key_file = file(options.key_file);
    link.tls_ca_file = file(options.tls_ca_file);
    link.tls_certificate_file = file(options.tls_certificate_file);
    link.tls_key_file = file(options.tls_key_file);
    fire3dv_stream* const stream = fire3dv_open(uri.c_str(), &link);
    if (stream) {
      links_.push_back({uri, std::unique_ptr<fire3dv_stream, Close>(stream), {}, {}});
    } else {
      failed += (failed.empty() ? "" : "; ") + uri + ": " + fire3dv_last_error();
    }
  }
  if (!failed.empty()) return Error{failed};
  return {};
}

void Links::describe(const std::vector<std::string>& names, double rate_hz) {
  std::vector<const char*> pointers;
  pointers.reserve(names.size());
  for (const std::string& name : names) pointers.push_back(name.c_str());
  fire3dv_description description{};
  description.struct_size = sizeof description;
  description.node_names = pointers.data();
  description.node_count = pointers.size();
  description.world_from_stream = kWorldFromStream;
  description.nominal_rate_hz = rate_hz;
  for (Link& link : links_) check_result(link, fire3dv_describe(link.stream.get(), &description));
}

void Links::publish(double sim_time_s, const std::vector<float>& poses, uint32_t flags) {
  const int64_t sim_time_ns = std::llround(sim_time_s * 1e9);
  for (Link& link : links_)
    check_result(link,
                 fire3dv_publish(link.stream.get(), sim_time_ns, poses.data(), poses.size() / 12, flags));
}

void Links::edit(const std::function<int(fire3dv_stream*)>& call) {
  for (Link& link : links_) check_result(link, call(link.stream.get()));
}

void Links::poll() {
  for (Link& link : links_) check_result(link, fire3dv_poll(link.stream.get(), nullptr));
}

void Links::log_answers() {
  for (Link& link : links_) {
    fire3dv_status status{};
    status.struct_size = sizeof status;
    check_result(link, fire3dv_poll(link.stream.get(), &status));
    if (link.answer == status.welcome_message) continue;
    link.answer = status.welcome_message;
    if (!link.answer.empty()) log_line(link.uri + ": " + link.answer);
  }
}

void Links::close() {
  links_.clear();
}

void Links::check_result(Link& link, int code) {
  if (code == FIRE3DV_OK) return;
  const char* const sentence = fire3dv_last_error();
  if (link.logged.size() >= kMaxLoggedErrors || link.logged.contains(sentence)) return;
  link.logged.insert(sentence);
  log_line(link.uri + ": " + sentence +
           (link.logged.size() == kMaxLoggedErrors ? "; further errors are not logged" : ""));
}

}  // namespace fire3dv::ambf
