#include "tools/lab/ros2_bench/reader_process.h"

#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "adapters/ros2/dds/topics.h"

extern char** environ;

namespace fire3dv::ros2 {
namespace {

// The reader's process: takes messages until its standard input ends, then prints "COUNT MEDIAN_MS P99_MS".
template <typename Message>
int read_all(const std::string& topic) {
  const auto participant = open_participant();
  auto reader = take(Reader<Message>::open(*participant, topic, Profile::image));
  std::vector<double> delays_ms;
  bool has_matched = false;
  const Entity waitset(dds_create_waitset(participant->get()));
  const Entity has_data(dds_create_readcondition(reader.get(), DDS_ANY_STATE));
  dds_waitset_attach(waitset.get(), has_data.get(), 0);
  while (true) {
    dds_waitset_wait(waitset.get(), nullptr, 0, DDS_MSECS(20));
    reader.take([&](const Message& message, const dds_sample_info_t&) {
      const int64_t sent = message.header.stamp.sec * int64_t{1'000'000'000} + message.header.stamp.nanosec;
      delays_ms.push_back(static_cast<double>(now_ns() - sent) * 1e-6);
    });
    dds_subscription_matched_status_t matched{};
    dds_get_subscription_matched_status(reader.get(), &matched);
    if (matched.current_count > 0 && !std::exchange(has_matched, true)) {
      std::puts("matched");
      std::fflush(stdout);
    }
    pollfd input{STDIN_FILENO, POLLIN, 0};
    char byte;
    if (::poll(&input, 1, 0) > 0 && ::read(STDIN_FILENO, &byte, 1) <= 0) break;
  }
  const double median = quantile(delays_ms, 0.5), p99 = quantile(delays_ms, 0.99);
  std::printf("%zu %.3f %.3f\n", delays_ms.size(), median, p99);
  return 0;
}

}  // namespace

void fail(const std::string& what) {
  std::fprintf(stderr, "fire3dv-ros2-bench: error: %s\n", what.c_str());
  std::exit(1);
}

int64_t now_ns() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return time.tv_sec * int64_t{1'000'000'000} + time.tv_nsec;
}

std::unique_ptr<Participant> open_participant() {
  return take(Participant::open(take(domain_settings([](const char* name) { return std::getenv(name); }))));
}

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
}

ReaderProcess::ReaderProcess(const std::string& topic, bool compressed) {
  int input[2], output[2];
  if (pipe(input) != 0 || pipe(output) != 0) fail("no pipe");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output[1], STDOUT_FILENO);
  for (const int fd : {input[0], input[1], output[0], output[1]})
    posix_spawn_file_actions_addclose(&actions, fd);
  std::string name = "fire3dv-ros2-bench", option = compressed ? "--read-compressed" : "--read",
              value = topic;
  char* const arguments[] = {name.data(), option.data(), value.data(), nullptr};
  if (posix_spawn(&process_, "/proc/self/exe", &actions, nullptr, arguments, environ) != 0) fail("no reader");
  posix_spawn_file_actions_destroy(&actions);
  close(input[0]);
  close(output[1]);
  input_ = input[1];
  output_.reset(fdopen(output[0], "r"));
}

void ReaderProcess::wait_matched() {
  if (line() != "matched\n") fail("the reader has found no writer");
}
ReaderProcess::Figures ReaderProcess::finish() {
  close(input_);
  Figures figures;
  if (std::sscanf(line().c_str(), "%zu %lf %lf", &figures.count, &figures.median_ms, &figures.p99_ms) != 3)
    fail("the reader has ended early");
  waitpid(process_, nullptr, 0);
  return figures;
}

std::string ReaderProcess::line() {
  char text[256];
  return std::fgets(text, sizeof text, output_.get()) ? text : "";
}

int read_messages(const std::string& topic, bool compressed) {
  return compressed ? read_all<CompressedImageMessage>(topic) : read_all<ImageMessage>(topic);
}

}  // namespace fire3dv::ros2
