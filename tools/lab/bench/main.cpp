// Benchmark program: fire3dv-bench makes the measurements that the README and docs/benchmarks quote.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <iostream>

#include "base/command_line.h"
#include "base/text.h"
#include "tools/lab/bench/links/link_benches.h"
#include "tools/lab/bench/record_bench.h"
#ifdef FIRE3DV_BENCH_FRAMES
#include "renderer/gpu/selection/required_gpu.h"
#include "tools/lab/bench/frames/frame_commands.h"
#endif

namespace {

using fire3dv::in_range;
using fire3dv::OptionGroup;

constexpr int kUsageError = 2;

int usage_error(const std::string& text) {
  std::cerr << "fire3dv-bench: error: " << text << " (see fire3dv-bench --help-all)\n";
  return kUsageError;
}

#ifdef FIRE3DV_BENCH_FRAMES
// 0, or the exit status after a printed error.
int check_gpu(const fire3dv::bench::DrawOptions& options) {
  if (!options.require_gpu) return 0;
  const fire3dv::Result<void> found = fire3dv::gpu::check_required_gpu(options.device);
  if (found) return 0;
  std::fprintf(stderr, "fire3dv-bench: %s\n", fire3dv::terminal_text(found.error().message).c_str());
  return fire3dv::gpu::kNoGpuExitStatus;
}

// Returns the command line with the program's bare name.
std::string command_line(int argc, char** argv) {
  std::string text = "fire3dv-bench";
  for (int i = 1; i < argc; ++i) text += std::string(" ") + argv[i];
  return text;
}
#endif

std::string commands_of(const CLI::App& app) {
  std::string names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names += (names.empty() ? "" : ", ") + command->get_name();
  return names;
}

CLI::App* add_command(CLI::App& app, const char* name, const char* text, const std::string& usage) {
  CLI::App* const command = app.add_subcommand(name, text);
  fire3dv::set_help(*command, usage);
  return command;
}

void add_one_way(CLI::App& app, fire3dv::bench::OneWayOptions& options) {
  OptionGroup group(app);
  group.add("--rounds", options.rounds, "N", "rounds of each link")->check(in_range(1, 100'000));
  group.add("--frames", options.frames, "N", "frames per round")->check(in_range(1, 10'000));
  group.add("--rate", options.rate_hz, "HZ", "frames per second")->check(in_range(1.0, 100'000.0));
  group.add("--key-file", options.security.udp_key_file, "FILE", "adds a row for udp:// with this key");
  group.add("--tls-cert", options.security.tls_certificate_file, "FILE",
            "adds a row for tls:// (self-signed, localhost)");
  group.add("--tls-key", options.security.tls_key_file, "FILE", "private key of that certificate (PEM)");
}

void add_record_write(CLI::App& app, fire3dv::bench::RecordWriteOptions& options) {
  app.add_option("file", options.file, "recording to write (.mcap)")->required();
  OptionGroup group(app);
  group.add("--seconds", options.seconds, "S", "length of the recording")->check(in_range(0.01, 86'400.0));
  group.add("--poses", options.nodes, "N", "poses per frame")->check(in_range(1, 1'000'000));
  group.add("--rate", options.rate_hz, "HZ", "frames per second")->check(in_range(1.0, 100'000.0));
  group.add_choice("--compression", options.compression, "zstd|lz4|none", "zstd, lz4 or none")
      ->type_name("NAME");
  group.add_choice("--layout", options.layout, "frames|poses|raw", "messages: frames, poses, or raw bytes")
      ->type_name("NAME");
  group.add_choice("--motion", options.motion, "arm|rest", "arm: every pose changes; rest: few do")
      ->type_name("NAME");
  group.add_flag("--foxglove", options.foxglove, "add Foxglove's channels");
}

void add_record_read(CLI::App& app, fire3dv::bench::RecordReadOptions& options) {
  app.add_option("file", options.file, "recording to read (.mcap)")->required();
  OptionGroup group(app);
  group.add("--seeks", options.seeks, "N", "number of seeks")->check(in_range(1, 100'000));
  group.add_flag("!--seek-only", options.reads_all, "measure seeks only");
  group.add("--memory-mb", options.memory_mb, "N", "memory of the reader, in MB")
      ->check(in_range(16u, 16'384u));
}

int run(int argc, char** argv) {
  CLI::App app{"Measures rendering, transports and recordings of FIRE-3DV on this machine."};
  app.name("fire3dv-bench");
  fire3dv::set_help(app, "COMMAND [OPTIONS]");
  fire3dv::set_program_flags(app);
  app.footer("Options of a command: fire3dv-bench COMMAND --help. Details: man fire3dv-bench.");
  app.require_subcommand(0, 1);
  app.set_help_all_flag("--help-all", "print the options of all commands");

  int rounds = 301;
  CLI::App* const transport =
      add_command(app, "transport", "cost of a publish over shared memory, beside a bare copy", "[ROUNDS]");
  transport->add_option("rounds", rounds, "number of rounds (default: 301)")->check(in_range(1, 1'000'000));
  fire3dv::bench::OneWayOptions way_options;
  CLI::App* const one_way =
      add_command(app, "one-way", "cost and latency of a publish over each link", "[OPTIONS]");
  add_one_way(*one_way, way_options);
  fire3dv::bench::PublishOptions publish_options;
  CLI::App* const publish = add_command(
      app, "publish", "publish at a fixed rate; print call times per input line", "URI [OPTIONS]");
  publish->add_option("uri", publish_options.uri, "shm://NAME, or tcp, tls, udp://HOST:PORT")->required();
  OptionGroup(*publish)
      .add("--poses", publish_options.poses, "N", "poses per frame")
      ->check(in_range(1, 1'000'000));
  OptionGroup(*publish)
      .add("--rate", publish_options.rate_hz, "HZ", "frames per second")
      ->check(in_range(1.0, 100'000.0));
  int request_rounds = 301;
  CLI::App* const request =
      add_command(app, "request", "cost of an image request, beside a publish", "[OPTIONS]");
  OptionGroup(*request).add("--rounds", request_rounds, "N", "number of rounds")->check(in_range(1, 100'000));
  fire3dv::bench::RecordWriteOptions write_options;
  CLI::App* const record_write =
      add_command(app, "record-write", "write a recording; print speed and size", "FILE.mcap [OPTIONS]");
  add_record_write(*record_write, write_options);
  fire3dv::bench::RecordReadOptions read_options;
  CLI::App* const record_read = add_command(
      app, "record-read", "read a recording; print speed, seek times and memory", "FILE.mcap [OPTIONS]");
  add_record_read(*record_read, read_options);
#ifdef FIRE3DV_BENCH_FRAMES
  fire3dv::bench::FrameOptions frame_options;
  CLI::App* const frame = add_command(app, "frame", "frame times by stage: table and CSV file", "[OPTIONS]");
  fire3dv::bench::add_frame_options(*frame, frame_options);
  fire3dv::bench::IngestOptions ingest_options;
  CLI::App* const ingest =
      add_command(app, "ingest", "poses per second that a receiver accepts on one core", "[OPTIONS]");
  OptionGroup(*ingest)
      .add("--seconds", ingest_options.seconds, "S", "duration of each row")
      ->check(in_range(0.01, 3600.0));
  fire3dv::bench::ImageOptions image_options;
  CLI::App* const images =
      add_command(app, "images", "latency from poses to an image in memory", "SCENE [OPTIONS]");
  fire3dv::bench::add_image_options(*images, image_options);
  fire3dv::bench::CamerasOptions cameras_options;
  CLI::App* const cameras =
      add_command(app, "cameras", "images per second of many cameras, read back", "SCENE [OPTIONS]");
  fire3dv::bench::add_cameras_options(*cameras, cameras_options);
#endif

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help
    return usage_error(fire3dv::usage_text(app, error));
  }
  if (app.get_subcommands().empty()) return usage_error("name a command: " + commands_of(app));
  if (*transport) return fire3dv::bench::publish_bench(rounds);
  if (*one_way) return fire3dv::bench::one_way_bench(way_options);
  if (*publish) return fire3dv::bench::publish_command(publish_options);
  if (*request) return fire3dv::bench::request_bench(request_rounds);
  if (*record_write) return fire3dv::bench::record_write(write_options);
  if (*record_read) return fire3dv::bench::record_read(read_options);
#ifdef FIRE3DV_BENCH_FRAMES
  if (*ingest) return fire3dv::bench::ingest_bench(ingest_options);
  if (*frame) {
    frame_options.command = command_line(argc, argv);
    if (auto checked = fire3dv::bench::check_frame_options(frame_options); !checked)
      return usage_error(checked.error().message);
    if (const int status = check_gpu(frame_options.draw)) return status;
    return fire3dv::bench::run_frames(frame_options);
  }
  if (*cameras) {
    if (auto checked = fire3dv::bench::check_draw_options(cameras_options.draw); !checked)
      return usage_error(checked.error().message);
    if (const int status = check_gpu(cameras_options.draw)) return status;
    return fire3dv::bench::run_cameras(cameras_options);
  }
  if (auto checked = fire3dv::bench::check_draw_options(image_options.draw); !checked)
    return usage_error(checked.error().message);
  if (const int status = check_gpu(image_options.draw)) return status;
  return fire3dv::bench::run_images(image_options);
#else
  return 0;
#endif
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& failure) {  // fatal: a Vulkan error or out of memory
    std::fprintf(stderr, "fire3dv-bench: %s\n", failure.what());
    return 1;
  }
}
