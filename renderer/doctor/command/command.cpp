#include "renderer/doctor/command/command.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <span>
#include <string>

#include "base/command_line.h"
#include "base/log.h"
#include "base/output/output_file.h"
#include "renderer/doctor/bench.h"
#include "renderer/doctor/child.h"
#include "renderer/doctor/report/report.h"

namespace fire3dv::doctor {
namespace {

constexpr int kUsageError = 2;
constexpr int kBenchLimits = 30;  // time limits of one device's benchmark: it compiles all pipelines

int run_benchmarks(const Facts& facts, std::chrono::milliseconds limit) {
  std::vector<BenchRow> rows;
  bool all = !facts.devices.empty();
  for (const DeviceFacts& device : facts.devices) {
    if (!device.read_back.passed()) {
      print_log_line("fire3dv", warning("doctor: device " + std::to_string(device.index) + " (" +
                                        device.name + ") is left out, see fire3dv doctor"));
      all = all && !device.usable();
      continue;
    }
    const ChildResult times = run_in_child([&] { return run_bench(device.index); }, limit * kBenchLimits);
    BenchRow row{device.name, device.driver, times.trial, 0, {}};
    if (times.trial.passed()) {
      row.triangles = times.value.at("triangles").get<uint64_t>();
      row.ms = times.value.at("ms").get<std::vector<double>>();
    } else {
      all = false;
      print_log_line("fire3dv", error_line("doctor: the benchmark on device " + std::to_string(device.index) +
                                           " (" + device.name + ") " + describe(times.trial)));
    }
    rows.push_back(row);
  }
  if (facts.devices.empty())
    print_log_line("fire3dv",
                   error_line("doctor: there is no Vulkan device" +
                              (facts.listing.went_wrong() ? ", since listing them " + describe(facts.listing)
                                                          : std::string()) +
                              "; see fire3dv doctor"));
  if (!rows.empty()) std::fputs(bench_table(rows).c_str(), stdout);
  return all ? 0 : 1;
}

bool print(const std::string& text) {
  return std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0;
}

// Standard output may be a file: it is continued.
Result<void> write_report(const std::filesystem::path& path, const std::string& text) {
  if (base::is_open_as(STDOUT_FILENO, path))
    return print(text) ? Result<void>() : Error{"standard output cannot be written"};
  Result<void> written = base::write_output(path, std::as_bytes(std::span(text)));
  if (written) print_log_line("fire3dv", "doctor: the report for an issue is in " + path.string());
  return written;
}

}  // namespace

std::variant<Options, int> parse_options(int argc, char** argv) {
  Options options;
  CLI::App app{"Checks drivers, devices and this machine; names each fault, and the line to type."};
  app.name("fire3dv doctor");
  set_help(app, "[OPTIONS]");
  app.footer(
      "Exit status: 0 nothing is broken, 1 something is, 2 wrong command line. Details: man fire3dv-doctor.");
  set_program_flags(app);
  OptionGroup group(app);
  group.add_flag("--json", options.json, "print JSON, with an id for each check");
  group.add("--report", options.report, "FILE",
            "also write FILE for an issue, without names, home folders and IPs");
  group.add_flag("--bench", options.bench, "print frame times of each device as a Markdown table instead");
  group.add_repeatable("--listen", options.addresses.listen, "URI",
                       "check that this port is free; repeatable");
  group.add("--serve", options.addresses.serve, "HOST:PORT", "the same for the live view");
  group.add("--metrics", options.addresses.metrics, "HOST:PORT", "the same for metrics");
  group.add("--time-limit", options.time_limit_s, "SECONDS", "of each experiment with a driver or device")
      ->check(number_between(0.1, 3600));
  try {
    app.parse(argc - 1, argv + 1);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "fire3dv doctor: error: " << usage_text(app, error) << " (see fire3dv doctor --help)\n";
    return kUsageError;
  }
  if (options.bench && (options.json || !options.report.empty())) {
    std::cerr << "fire3dv doctor: error: --bench prints a table alone: leave out --json and --report\n";
    return kUsageError;
  }
  return options;
}

int run(const Options& options) {
  const std::chrono::milliseconds limit(static_cast<int64_t>(options.time_limit_s * 1000));
  if (::isatty(STDERR_FILENO) && !options.json)
    print_log_line("fire3dv", "doctor: trying drivers and devices, at most " +
                                  std::to_string(static_cast<int64_t>(options.time_limit_s)) + " s each");
  const Facts facts = gather_facts(options.addresses, limit);
  if (options.bench) return run_benchmarks(facts, limit);
  const std::vector<CheckedFinding> findings = run_checks(facts);
  const bool printed = print(
      options.json
          ? report_json(facts, findings).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n"
          : report_text(facts, findings));
  if (!printed) return report_failure(Error{"doctor: standard output cannot be written"});
  if (!options.report.empty()) {
    if (const Result<void> written = write_report(options.report, report_file(facts, findings)); !written)
      return report_failure(Error{"--report: " + written.error().message});
  }
  return exit_status(findings);
}

}  // namespace fire3dv::doctor
