// Benchmark program fire3dv-bench: the measurements that the README and docs/benchmarks quote.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <iostream>

#include "tools/lab/bench/links/dtls_bench.h"
#include "tools/lab/bench/links/one_way_bench.h"
#include "tools/lab/bench/links/publish_bench.h"
#include "tools/lab/bench/links/publish_command.h"
#include "tools/lab/bench/links/request_bench.h"
#include "tools/lab/bench/record_bench.h"
#ifdef FIRE3DV_BENCH_FRAMES
#include "tools/lab/bench/frames/cameras_command.h"
#include "tools/lab/bench/frames/frame_command.h"
#include "tools/lab/bench/links/ingest_bench.h"
#endif

namespace {

constexpr int kUsageError = 2;

int usage_error(const std::string& text) {
  std::cerr << "fire3dv-bench: " << text << " (see fire3dv-bench --help-all)\n";
  return kUsageError;
}

#ifdef FIRE3DV_BENCH_FRAMES
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

int run(int argc, char** argv) {
  CLI::App app{"Measures what FIRE-3DV costs."};
  app.name("fire3dv-bench");
  app.require_subcommand(0, 1);
  app.set_help_all_flag("--help-all", "the options of all commands");

  int rounds = 301;
  CLI::App* const transport = app.add_subcommand("transport", "what one publish costs beside a bare copy");
  transport->add_option("rounds", rounds, "how often each way is measured")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  fire3dv::bench::OneWayOptions way_options;
  CLI::App* const one_way = app.add_subcommand(
      "one-way", "what a publish costs and when its frame is there, over each link, beside bare ones");
  one_way->add_option("--rounds", way_options.rounds, "turns of each way")->check(CLI::Range(1, 100'000));
  one_way->add_option("--frames", way_options.frames, "frames a turn")->check(CLI::Range(1, 10'000));
  one_way->add_option("--rate", way_options.rate_hz, "frames a second")->check(CLI::Range(1.0, 100'000.0));
  one_way->add_option("--key-file", way_options.security.udp_key_file, "a key, for a row of udp:// with it");
  one_way->add_option("--tls-cert", way_options.security.tls_certificate_file,
                      "a certificate of localhost that has signed itself, for a row of tls://");
  one_way->add_option("--tls-key", way_options.security.tls_key_file, "file of that certificate's key");
  fire3dv::bench::DtlsOptions dtls_options;
  CLI::App* const dtls = app.add_subcommand(
      "dtls", "cost of udp:// with a key (DTLS 1.2) beside udp:// without: bytes, round trips, memory, time");
  dtls->add_option("--rounds", dtls_options.rounds, "turns of each way")->check(CLI::Range(1, 100'000));
  dtls->add_option("--rate", dtls_options.rate_hz, "frames a second; 0: without pauses")
      ->check(CLI::Range(0.0, 100'000.0));
  fire3dv::bench::PublishOptions publish_options;
  CLI::App* const publish = app.add_subcommand(
      "publish", "a simulator that publishes at a rate, and says how long its calls took when asked to");
  publish->add_option("uri", publish_options.uri, "where to")->required();
  publish->add_option("--poses", publish_options.poses, "poses a frame")->check(CLI::Range(1, 1'000'000));
  publish->add_option("--rate", publish_options.rate_hz, "frames a second")
      ->check(CLI::Range(1.0, 100'000.0));
  int request_rounds = 301;
  CLI::App* const request =
      app.add_subcommand("request", "what asking for an image costs a simulator, beside publishing a frame");
  request->add_option("--rounds", request_rounds, "turns of each call")->check(CLI::Range(1, 100'000));
  fire3dv::bench::RecordWriteOptions write_options;
  CLI::App* const record_write =
      app.add_subcommand("record-write", "makes a recording, and says how fast and how long it is");
  record_write->add_option("file", write_options.file, "the file to make")->required();
  record_write->add_option("--seconds", write_options.seconds, "of the recording")
      ->check(CLI::Range(0.01, 86'400.0));
  record_write->add_option("--poses", write_options.nodes, "poses a frame")->check(CLI::Range(1, 1'000'000));
  record_write->add_option("--rate", write_options.rate_hz, "frames a second")
      ->check(CLI::Range(1.0, 100'000.0));
  record_write->add_option("--compression", write_options.compression)
      ->check(CLI::IsMember({"zstd", "lz4", "none"}));
  record_write
      ->add_option("--layout", write_options.layout, "frames; one message a pose; or no format at all")
      ->check(CLI::IsMember({"frames", "poses", "raw"}));
  record_write->add_option("--motion", write_options.motion, "every pose in every frame, or nearly none")
      ->check(CLI::IsMember({"arm", "rest"}));
  record_write->add_flag("--foxglove", write_options.foxglove, "with Foxglove's channels");
  fire3dv::bench::RecordReadOptions read_options;
  CLI::App* const record_read = app.add_subcommand(
      "record-read", "reads a recording, and says how fast, how long seeks took, and the memory");
  record_read->add_option("file", read_options.file, "the recording")->required();
  record_read->add_option("--seeks", read_options.seeks, "how many")->check(CLI::Range(1, 100'000));
  record_read->add_flag("!--seek-only", read_options.reads_all, "do not read all of it");
  record_read->add_option("--memory-mb", read_options.memory_mb, "for the reader")
      ->check(CLI::Range(16u, 16'384u));
#ifdef FIRE3DV_BENCH_FRAMES
  fire3dv::bench::FrameOptions frame_options;
  CLI::App* const frame = app.add_subcommand(
      "frame", "times of frames, stage by stage, of scenes that grow: a table, a CSV file and a plot");
  fire3dv::bench::add_frame_options(*frame, frame_options);
  fire3dv::bench::IngestOptions ingest_options;
  CLI::App* const ingest =
      app.add_subcommand("ingest", "how many poses a second a renderer's intake takes on one core");
  ingest->add_option("--seconds", ingest_options.seconds, "for each row")->check(CLI::Range(0.01, 3600.0));
  fire3dv::bench::ImageOptions image_options;
  CLI::App* const images = app.add_subcommand(
      "images", "times from new poses to the image in memory, of one glTF scene whose objects turn");
  fire3dv::bench::add_image_options(*images, image_options);
  fire3dv::bench::CamerasOptions cameras_options;
  CLI::App* const cameras =
      app.add_subcommand("cameras", "images a second of many cameras of one glTF scene, read back to memory");
  fire3dv::bench::add_cameras_options(*cameras, cameras_options);
#endif

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help
    return usage_error(error.what());
  }
  if (app.get_subcommands().empty()) return usage_error("name a command: " + commands_of(app));
  if (*transport) return fire3dv::bench::publish_bench(rounds);
  if (*one_way) return fire3dv::bench::one_way_bench(way_options);
  if (*dtls) return fire3dv::bench::dtls_cost(dtls_options);
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
    return fire3dv::bench::run_frames(frame_options);
  }
  if (*cameras) {
    if (auto checked = fire3dv::bench::check_draw_options(cameras_options.draw); !checked)
      return usage_error(checked.error().message);
    return fire3dv::bench::run_cameras(cameras_options);
  }
  if (auto checked = fire3dv::bench::check_draw_options(image_options.draw); !checked)
    return usage_error(checked.error().message);
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
