// Impairment relay program: fire3dv-impair FROM TO simulates a bad network between two programs. Publishers
// connect to FROM, the renderer listens on TO.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <thread>

#include "protocol/base/clock.h"
#include "protocol/base/command_line.h"
#include "tools/lab/impair/relay.h"
#include "tools/lab/impair/schedule.h"

namespace {

volatile std::sig_atomic_t stop_requested = 0;
volatile std::sig_atomic_t taken_down = 0;  // toggled by a signal

constexpr int kUsageError = 2;

// Options in percent and milliseconds.
struct Words {
  double loss_percent = 0, duplicate_percent = 0, reorder_percent = 0;
  double delay_ms = 0, jitter_ms = 0, stall_ms = 500;
  std::vector<std::string> down;
};

void add_options(CLI::App& app, Words& words, fire3dv::impair::Impairment& impairment) {
  const auto percent = fire3dv::number_between(0, 100), milliseconds = fire3dv::number_between(0, 60'000);
  app.add_option("--loss", words.loss_percent, "percent of datagrams that vanish")->check(percent);
  app.add_option("--duplicate", words.duplicate_percent, "percent of datagrams that come twice")
      ->check(percent);
  app.add_option("--reorder", words.reorder_percent,
                 "percent of datagrams that overtake others, by coming without delay")
      ->check(percent);
  app.add_option("--delay", words.delay_ms, "milliseconds, each way")->check(milliseconds);
  app.add_option("--jitter", words.jitter_ms, "milliseconds by which the delay varies, evenly, either way")
      ->check(milliseconds);
  app.add_option("--rate", impairment.bits_per_second, "bits a second, each way; 0: no limit")
      ->check(CLI::Range(uint64_t{0}, uint64_t{1'000'000'000'000}).description(""));
  app.add_option("--stall-after", impairment.stall_after_bytes,
                 "streams: mean bytes, each way, between stalls; 0: none")
      ->check(CLI::Range(uint64_t{0}, uint64_t{1'000'000'000'000}).description(""));
  app.add_option("--stall-for", words.stall_ms, "streams: milliseconds of a stall")
      ->check(milliseconds)
      ->capture_default_str();
  app.add_option("--reset-after", impairment.reset_after_bytes,
                 "streams: mean bytes, of either way, after which a connection is reset; 0: never")
      ->check(CLI::Range(uint64_t{0}, uint64_t{1'000'000'000'000}).description(""));
  app.add_option("--down", words.down,
                 "AT:FOR, in seconds: when nothing passes, and for how long; may be given several times. The "
                 "signal USR1 "
                 "takes the link down, too, until USR2")
      ->allow_extra_args(false);
  app.add_option("--seed", impairment.seed, "of all chances")
      ->check(CLI::Range(uint64_t{0}, UINT64_MAX).description(""))
      ->capture_default_str();
}

void say_counts(const std::string& uri, const fire3dv::impair::RelayCounts& counts) {
  const auto number = [](uint64_t value) { return static_cast<unsigned long long>(value); };
  if (uri.starts_with("udp"))
    std::printf("passed %llu, lost %llu, duplicated %llu, reordered %llu\n", number(counts.passed),
                number(counts.lost), number(counts.duplicated), number(counts.reordered));
  else
    std::printf("connections %llu, bytes %llu, stalls %llu, resets %llu\n", number(counts.connections),
                number(counts.bytes), number(counts.stalls), number(counts.resets));
}

}  // namespace

int main(int argc, char** argv) {
  using namespace fire3dv;
  CLI::App app{"Passes datagrams or streams on and makes a bad network of the way, in both directions alike.",
               "fire3dv-impair"};
  std::string from, to;
  impair::Impairment impairment;
  Words words;
  bool insecure = false;
  app.add_option("from", from, "where to listen: udp://HOST:PORT, tcp://HOST:PORT or tls://HOST:PORT")
      ->required();
  app.add_option("to", to, "where to pass it on, by its address in digits")->required();
  add_options(app, words, impairment);
  app.add_flag("--insecure", insecure, "listen on addresses other than loopback: anyone there reaches TO");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageError;
  }
  impairment.loss = words.loss_percent / 100;
  impairment.duplicate = words.duplicate_percent / 100;
  impairment.reorder = words.reorder_percent / 100;
  impairment.delay_ns = static_cast<int64_t>(words.delay_ms * 1e6);
  impairment.jitter_ns = static_cast<int64_t>(words.jitter_ms * 1e6);
  impairment.stall_ns = static_cast<int64_t>(words.stall_ms * 1e6);
  std::vector<impair::Outage> outages;
  for (const std::string& text : words.down) {
    const auto outage = impair::parse_outage(text);
    if (!outage) {
      std::cerr << "fire3dv-impair: --down " << text << ": must be AT:FOR in seconds, such as 5:2.5\n";
      return kUsageError;
    }
    outages.push_back(*outage);
  }
  std::signal(SIGINT, [](int) { stop_requested = 1; });
  std::signal(SIGTERM, [](int) { stop_requested = 1; });
  std::signal(SIGUSR1, [](int) { taken_down = 1; });
  std::signal(SIGUSR2, [](int) { taken_down = 0; });

  impairment.down = impair::is_down(outages, 0);
  auto relay = impair::open_relay(from, to, impairment, insecure);
  if (!relay) {
    std::cerr << "fire3dv-impair: " << relay.error().message << '\n';
    return 1;
  }
  std::cerr << "fire3dv-impair: " << (*relay)->uri() << " to " << to << '\n';
  const int64_t started_ns = fire3dv::monotonic_ns();
  while (!stop_requested) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const bool down = taken_down || impair::is_down(outages, fire3dv::monotonic_ns() - started_ns);
    if (down == impairment.down) continue;
    impairment.down = down;
    (*relay)->set(impairment);
    std::cerr << "fire3dv-impair: the link is " << (down ? "down" : "up") << '\n';
  }
  say_counts((*relay)->uri(), (*relay)->counts());
  return 0;
}
