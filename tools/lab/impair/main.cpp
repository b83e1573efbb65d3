// Impairment relay program: fire3dv-impair FROM TO simulates a bad network between two programs. Publishers
// connect to FROM, the renderer listens on TO.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <thread>

#include "base/clock.h"
#include "base/command_line.h"
#include "tools/lab/impair/impairment.h"
#include "tools/lab/impair/relay.h"

namespace {

volatile std::sig_atomic_t stop_requested = 0;
volatile std::sig_atomic_t link_down = 0;  // toggled by a signal

constexpr int kUsageError = 2;

// Options in percent and milliseconds.
struct Settings {
  double loss_percent = 0, duplicate_percent = 0, reorder_percent = 0;
  double delay_ms = 0, jitter_ms = 0, stall_ms = 500;
  std::vector<std::string> down;
};

void add_options(CLI::App& app, Settings& settings, fire3dv::impair::Impairment& impairment) {
  const auto percent = fire3dv::number_between(0, 100), milliseconds = fire3dv::number_between(0, 60'000);
  const CLI::Validator amount = fire3dv::in_range(uint64_t{0}, uint64_t{1'000'000'000'000});
  fire3dv::OptionGroup datagrams(app, "Datagrams"), streams(app, "Streams"), both(app, "Both");
  datagrams.add("--loss", settings.loss_percent, "PERCENT", "datagrams that are lost")->check(percent);
  datagrams.add("--duplicate", settings.duplicate_percent, "PERCENT", "datagrams that arrive twice")
      ->check(percent);
  datagrams.add("--reorder", settings.reorder_percent, "PERCENT", "datagrams that pass without delay")
      ->check(percent);
  datagrams.add("--mtu", impairment.mtu, "BYTES", "length above which datagrams are lost; 0: none")
      ->check(fire3dv::in_range(size_t{0}, size_t{65'535}));
  streams
      .add("--stall-after", impairment.stall_after_bytes, "BYTES",
           "mean bytes between stalls, each way; 0: none")
      ->check(amount);
  streams.add("--stall-for", settings.stall_ms, "MS", "duration of a stall")->check(milliseconds);
  streams
      .add("--reset-after", impairment.reset_after_bytes, "BYTES",
           "mean bytes before a connection is reset; 0: never")
      ->check(amount);
  both.add("--delay", settings.delay_ms, "MS", "delay, each way")->check(milliseconds);
  both.add("--jitter", settings.jitter_ms, "MS", "uniform variation of the delay, plus or minus")
      ->check(milliseconds);
  both.add("--rate", impairment.bits_per_second, "BITS", "bits per second, each way; 0: no limit")
      ->check(amount);
  both.add_repeatable("--down", settings.down, "AT:FOR",
                      "outage: seconds after the start, and its length; repeatable");
  both.add("--seed", impairment.seed, "N", "random seed")->check(fire3dv::in_range(uint64_t{0}, UINT64_MAX));
}

void print_counts(const std::string& uri, const fire3dv::impair::RelayCounts& counts) {
  const auto number = [](uint64_t value) { return static_cast<unsigned long long>(value); };
  if (uri.starts_with("udp"))
    std::printf("passed %llu of %llu bytes, lost %llu, duplicated %llu, reordered %llu\n",
                number(counts.passed), number(counts.passed_bytes), number(counts.lost),
                number(counts.duplicated), number(counts.reordered));
  else
    std::printf("connections %llu, bytes %llu, stalls %llu, resets %llu\n", number(counts.connections),
                number(counts.bytes), number(counts.stalls), number(counts.resets));
}

}  // namespace

int main(int argc, char** argv) {
  using namespace fire3dv;
  CLI::App app{"Relays datagrams or streams and emulates a bad network, in both directions alike.",
               "fire3dv-impair"};
  set_help(app, "FROM TO [OPTIONS]");
  set_program_flags(app);
  app.footer("SIGUSR1 takes the link down, SIGUSR2 up again. Details: man fire3dv-impair.");
  std::string from, to;
  impair::Impairment impairment;
  Settings settings;
  bool insecure = false;
  app.add_option("from", from, "URI to listen at: udp, tcp or tls://HOST:PORT")->required();
  app.add_option("to", to, "URI to relay to, with a numeric address")->required();
  add_options(app, settings, impairment);
  app.add_flag("--insecure", insecure, "listen beyond loopback; anyone there reaches TO");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageError;
  }
  impairment.loss = settings.loss_percent / 100;
  impairment.duplicate = settings.duplicate_percent / 100;
  impairment.reorder = settings.reorder_percent / 100;
  impairment.delay_ns = static_cast<int64_t>(settings.delay_ms * 1e6);
  impairment.jitter_ns = static_cast<int64_t>(settings.jitter_ms * 1e6);
  impairment.stall_ns = static_cast<int64_t>(settings.stall_ms * 1e6);
  std::vector<impair::Outage> outages;
  for (const std::string& text : settings.down) {
    const auto outage = impair::parse_outage(text);
    if (!outage) {
      std::cerr << "fire3dv-impair: --down " << text << ": must be AT:FOR in seconds, such as 5:2.5\n";
      return kUsageError;
    }
    outages.push_back(*outage);
  }
  std::signal(SIGINT, [](int) { stop_requested = 1; });
  std::signal(SIGTERM, [](int) { stop_requested = 1; });
  std::signal(SIGUSR1, [](int) { link_down = 1; });
  std::signal(SIGUSR2, [](int) { link_down = 0; });

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
    const bool down = link_down || impair::is_down(outages, fire3dv::monotonic_ns() - started_ns);
    if (down == impairment.down) continue;
    impairment.down = down;
    (*relay)->set(impairment);
    std::cerr << "fire3dv-impair: the link is " << (down ? "down" : "up") << '\n';
  }
  print_counts((*relay)->uri(), (*relay)->counts());
  return 0;
}
