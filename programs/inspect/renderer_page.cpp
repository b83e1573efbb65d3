#include "programs/inspect/renderer_page.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>

#include "base/clock.h"
#include "base/numbers.h"
#include "base/text.h"
#include "base/unique_fd.h"
#include "base/words.h"
#include "protocol/transport/core/address.h"

namespace fire3dv::inspect {
namespace {

constexpr int64_t kPatienceNs = 5'000'000'000;
constexpr size_t kMaxPageBytes = size_t{16} << 20;
constexpr size_t kMaxDrawnStreams = 4096;

struct Sample {
  std::string family;
  std::map<std::string, std::string> labels;
  double value = 0;
};

// A sample with labels; nullopt: another line.
std::optional<Sample> read_sample(std::string_view line) {
  const size_t open = line.find('{');
  if (line.starts_with('#') || open == std::string_view::npos) return std::nullopt;
  Sample sample{.family = std::string(line.substr(0, open))};
  size_t at = open + 1;
  while (at < line.size() && line[at] != '}') {
    const size_t equals = line.find("=\"", at);
    if (equals == std::string_view::npos) return std::nullopt;
    std::string& value = sample.labels[std::string(line.substr(at, equals - at))];
    for (at = equals + 2; at < line.size() && line[at] != '"'; ++at) {
      if (line[at] == '\\' && ++at == line.size()) return std::nullopt;
      value += line[at - 1] == '\\' && line[at] == 'n' ? '\n' : line[at];
    }
    ++at;
    if (at < line.size() && line[at] == ',') ++at;
  }
  if (at >= line.size()) return std::nullopt;
  const std::optional<double> value = parse_number<double>(trimmed(line.substr(at + 1)));
  if (!value) return std::nullopt;
  sample.value = *value;
  return sample;
}

// Waits for events of a socket until the time; false: in vain.
bool wait_for(int socket, short events, int64_t end_ns) {
  pollfd wanted{socket, events, 0};
  const int64_t left_ms = (end_ns - monotonic_ns()) / 1'000'000;
  return left_ms > 0 && ::poll(&wanted, 1, static_cast<int>(left_ms)) == 1;
}

Result<UniqueFd> connect_to(const transport::Uri& uri, int64_t end_ns) {
  transport::Lookup lookup(uri);
  while (!lookup.done() && monotonic_ns() < end_ns) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  std::string reason = lookup.done() ? lookup.problem() : "the name server does not answer";
  if (!lookup.done()) return Error{reason};
  for (const transport::Address& address : lookup.addresses()) {
    UniqueFd fd(::socket(address.family(), SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    int error = 0;
    socklen_t length = sizeof error;
    if (::connect(fd.get(), address.get(), address.length) == 0) return fd;
    if (errno != EINPROGRESS) {
      error = errno;
    } else if (!wait_for(fd.get(), POLLOUT, end_ns)) {
      error = ETIMEDOUT;
    } else {
      ::getsockopt(fd.get(), SOL_SOCKET, SO_ERROR, &error, &length);
    }
    if (error == 0) return fd;
    reason = std::strerror(error);
  }
  return Error{reason};
}

}  // namespace

std::vector<DrawnStream> read_page(std::string_view page) {
  std::map<std::string, DrawnStream> streams;
  for (size_t begin = 0; begin < page.size();) {
    const size_t end = std::min(page.find('\n', begin), page.size());
    const std::optional<Sample> sample = read_sample(page.substr(begin, end - begin));
    begin = end + 1;
    if (!sample || !sample->family.starts_with("fire3dv_stream_") || !sample->labels.contains("stream"))
      continue;
    const std::string& number = sample->labels.at("stream");
    if (streams.size() >= kMaxDrawnStreams && !streams.contains(number)) continue;
    DrawnStream& stream = streams[number];
    stream.number = number;
    const auto label = [&](const char* name) {
      const auto found = sample->labels.find(name);
      return found == sample->labels.end() ? std::string() : found->second;
    };
    if (sample->family == "fire3dv_stream_info") {
      stream.name = label("name");
      stream.listener = label("listener");
    }
    if (sample->family == "fire3dv_stream_drawing_seconds_total") stream.drawing_seconds = sample->value;
    if (sample->family == "fire3dv_stream_drawing_share") stream.drawing_share = sample->value;
    if (sample->family == "fire3dv_stream_content_hidden") stream.is_hidden = sample->value != 0;
  }
  std::vector<DrawnStream> list;
  for (auto& [number, stream] : streams) list.push_back(std::move(stream));
  std::ranges::sort(
      list, [](const DrawnStream& a, const DrawnStream& b) { return a.drawing_seconds > b.drawing_seconds; });
  return list;
}

Result<std::string> fetch_page(const std::string& url) {
  constexpr std::string_view kScheme = "http://";
  const std::string_view after = std::string_view(url).substr(kScheme.size());
  const std::string host(after.substr(0, after.find('/')));
  const auto uri = transport::parse_uri("tcp://" + host);
  if (!uri) return Error{url + ": name the page of a renderer's --metrics: http://HOST:PORT"};
  const auto failed = [&](const std::string& reason) {
    return Error{url + ": " + reason + "; start the renderer with --metrics " + host};
  };
  const int64_t end_ns = monotonic_ns() + kPatienceNs;
  Result<UniqueFd> socket = connect_to(*uri, end_ns);
  if (!socket) return failed(socket.error().message);
  const std::string request = "GET /metrics HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n";
  if (::send(socket->get(), request.data(), request.size(), MSG_NOSIGNAL) !=
      static_cast<ssize_t>(request.size()))
    return failed("the request cannot be sent");
  std::string answer;
  char bytes[16'384];
  while (wait_for(socket->get(), POLLIN, end_ns)) {
    const ssize_t count = ::recv(socket->get(), bytes, sizeof bytes, 0);
    if (count == 0) break;
    if (count < 0) return failed(std::strerror(errno));
    answer.append(bytes, static_cast<size_t>(count));
    if (answer.size() > kMaxPageBytes) return failed("the page is too large");
  }
  const size_t body = answer.find("\r\n\r\n");
  if (body == std::string::npos) return failed("no answer came");
  if (!answer.starts_with("HTTP/1.1 200"))
    return failed("it answers " + printable_text(answer.substr(0, answer.find('\r')), 80));
  return answer.substr(body + 4);
}

std::string text_of(const std::string& url, const std::vector<DrawnStream>& streams) {
  std::string text =
      url + ": " + std::to_string(streams.size()) + (streams.size() == 1 ? " stream\n" : " streams\n");
  for (const DrawnStream& stream : streams) {
    char line[128];
    std::snprintf(line, sizeof line, "%.1f s of drawing time, %.0f %% now%s", stream.drawing_seconds,
                  100 * stream.drawing_share, stream.is_hidden ? ", content hidden: it takes too much" : "");
    text += "  stream " + stream.number + " " + quote(stream.name) + " at " +
            printable_text(stream.listener, 256) + ": " + line + "\n";
  }
  return text;
}

std::string json_of(const std::string& url, const std::vector<DrawnStream>& streams) {
  nlohmann::json list = nlohmann::json::array();
  for (const DrawnStream& stream : streams)
    list.push_back({{"stream", stream.number},
                    {"name", printable_text(stream.name, 256)},
                    {"listener", printable_text(stream.listener, 256)},
                    {"drawing_seconds", stream.drawing_seconds},
                    {"drawing_share", stream.drawing_share},
                    {"content_hidden", stream.is_hidden}});
  return nlohmann::json{{"renderer", url}, {"streams", list}}.dump() + "\n";
}

}  // namespace fire3dv::inspect
