// MuJoCo simulator for renderers: fire3dv-mujoco MODEL.xml --to URI steps and publishes a model.

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "adapters/mujoco/image_files.h"
#include "adapters/mujoco/interaction.h"
#include "adapters/mujoco/options.h"
#include "adapters/mujoco/timing.h"
#include "base/log.h"
#include "base/output/output_file.h"
#include "base/process/stop_signals.h"

namespace fire3dv::mujoco {
namespace {

// Log line of the program on standard error. Replaces control characters, since names in `text` are
// untrusted.
void log_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  std::fprintf(stderr, "fire3dv-mujoco: %s\n", fire3dv::with_level(text).c_str());
}

// Non-blocking reader of command lines on standard input. Returns no lines without standard input, after its
// end, and while the program is a background job.
class CommandLines {
 public:
  CommandLines();
  // Returns the next complete line, if one has arrived.
  std::optional<std::string> next();

 private:
  std::string text_;
  bool is_over_ = false;
};

// Ignoring SIGTTIN makes a read from the terminal fail in a background job instead of stopping the program.
CommandLines::CommandLines() {
  std::signal(SIGTTIN, SIG_IGN);
}

std::optional<std::string> CommandLines::next() {
  constexpr size_t kMaxBytes = 4096;  // line limit; no command is longer
  if (text_.find('\n') == std::string::npos && !is_over_) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (::poll(&input, 1, 0) > 0) {
      char bytes[512];
      const ssize_t count = ::read(STDIN_FILENO, bytes, sizeof bytes);
      if (count > 0 && text_.size() < kMaxBytes) text_.append(bytes, static_cast<size_t>(count));
      is_over_ = count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN);
    }
  }
  const size_t end = text_.find('\n');
  if (end == std::string::npos) {
    if (text_.size() >= kMaxBytes) text_.clear();
    return std::nullopt;
  }
  std::string line = text_.substr(0, end);
  text_.erase(0, end + 1);
  return line;
}

class Runner {
 public:
  Runner(Simulation simulation, Publisher publisher, std::optional<ImageFiles> files, const Options& options)
      : simulation_(std::move(simulation)),
        publisher_(std::move(publisher)),
        files_(std::move(files)),
        options_(options),
        pace_(options.speed),
        paused_(options.paused) {
    if (options.controls)
      interaction_.emplace(simulation_.model(), !options.paused, options.lockstep ? 0 : options.speed);
  }

  Result<void> run() {
    for (const ImageSpec& spec : options_.images) {
      const Result<uint64_t> id = publisher_.request_images(simulation_.model(), spec);
      if (!id) return id.error();
      requests_.push_back(*id);
    }
    if (Result<void> declared = declare_controls(); !declared) return declared;
    if (Result<void> sent = publish(); !sent) return sent;
    const double step_s = simulation_.model().opt.timestep;
    while (!stop_requested && (options_.duration_s <= 0 || stepped_s_ < options_.duration_s - step_s / 2)) {
      if (Result<void> done = process_commands(); !done) return done;
      if (Result<void> done = process_events(); !done) return done;
      if (paused_ && !single_step_ && requested_steps_ <= 0) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        if (!options_.lockstep) {
          if (Result<void> done = store_images(); !done) return done;
        }
        if (Result<void> polled = poll_renderers(); !polled) return polled;
        continue;
      }
      if (Result<void> done = step(); !done) return done;
      stepped_s_ += step_s;
      const bool is_single = std::exchange(single_step_, false) || paused_;
      if (requested_steps_ > 0) --requested_steps_;
      if (is_single) publisher_.jump();
      if (!publisher_.due(simulation_.data())) continue;
      if (Result<void> sent = publish(); !sent) return sent;
    }
    return {};
  }

  // Waits for pending image writes.
  Result<void> finish() { return files_ ? files_->finish() : Result<void>{}; }

  void log_result() {
    if (files_)
      log_line(options_.out.string() + ": " + std::to_string(images_written_) + " images, " +
               std::to_string(images_lost_) + " lost");
    const auto links = publisher_.poll();
    if (!links) return;
    for (const Publisher::Link& link : *links) {
      log_line(link.uri + ": " + std::to_string(link.status.frames_published) + " frames published, " +
               std::to_string(link.status.frames_dropped) + " overtaken, " +
               std::to_string(link.status.acked_sequence) + " is the last that was shown");
    }
  }

 private:
  Result<void> declare_controls() {
    if (!interaction_) return {};
    for (fire3dv_stream* const stream : publisher_.streams())
      if (Result<void> declared = interaction_->declare(stream); !declared) return declared;
    return {};
  }

  Result<void> step() {
    if (!interaction_) return simulation_.step();
    return simulation_.step([this](const mjModel& model, mjData& data) { interaction_->apply(model, data); });
  }

  // What people did in windows and browsers.
  Result<void> process_events() {
    if (!interaction_) return {};
    size_t number = 0;
    for (fire3dv_stream* const stream : publisher_.streams()) {
      const Result<Interaction::Requests> asked = interaction_->poll(stream, number++);
      if (!asked) return asked.error();
      if (asked->is_running) {
        paused_ = !*asked->is_running;
        pace_.restart();
      }
      if (asked->speed) pace_.set_speed(*asked->speed);
      if (!paused_ || asked->is_running || asked->reset) requested_steps_ = 0;
      if (paused_) requested_steps_ = std::min(requested_steps_ + asked->steps, Interaction::kMaxSteps);
      if (asked->reset)
        if (Result<void> done = reset(); !done) return done;
    }
    return {};
  }

  Result<void> reset() {
    if (interaction_) interaction_->reset();
    if (Result<void> declared = declare_controls(); !declared) return declared;
    if (Result<void> done = simulation_.reset(); !done) return done;
    publisher_.jump();
    pace_.restart();
    return publish();
  }

  // By a line on standard input: all viewers see it.
  Result<void> set_paused(bool is_paused) {
    paused_ = is_paused;
    if (!interaction_) return {};
    interaction_->set_running(!is_paused);
    return declare_controls();
  }

  Result<void> publish() {
    if (Result<void> updated = simulation_.update_poses(); !updated) return updated;
    if (!options_.lockstep) wait_until_due();
    const Result<bool> sent = publisher_.publish(simulation_.model(), simulation_.data());
    if (!sent) return sent.error();
    // With one renderer, its images acknowledge the frame already.
    if (options_.lockstep && (requests_.empty() || options_.publish.uris.size() > 1)) {
      if (Result<void> shown = publisher_.wait_shown(options_.ack_timeout_s, stop_requested, log_line);
          !shown)
        return shown;
    }
    if (Result<void> done = store_images(); !done) return done;
    return poll_renderers();
  }

  // Writes images: in lockstep those of this frame, else all that have arrived.
  Result<void> store_images() {
    for (size_t i = 0; i < requests_.size(); ++i) {
      while (true) {
        const Result<Image> image =
            options_.lockstep ? publisher_.wait_image(requests_[i], options_.ack_timeout_s, stop_requested)
                              : publisher_.take_image(requests_[i]);
        if (!image) return image.error();
        if (!*image) break;
        images_lost_ += (*image)->lost;
        if ((*image)->sequence == 0) continue;  // rendered before the first frame
        Result<void> written =
            files_->write(options_.images[i].camera, options_.publish.adapter_name, **image);
        if (!written) return written;
        ++images_written_;
        if (options_.lockstep) break;
      }
    }
    return {};
  }

  void wait_until_due() {
    while (!stop_requested) {
      const auto sleep = pace_.sleep_before(simulation_.data().time, Pace::Clock::now());
      if (sleep <= Pace::Clock::duration::zero()) return;
      std::this_thread::sleep_for(sleep);
    }
  }

  // Logs new messages of renderers and MuJoCo, each once.
  Result<void> poll_renderers() {
    const auto links = publisher_.poll();
    if (!links) return links.error();
    printed_messages_.resize(links->size());
    for (size_t i = 0; i < links->size(); ++i) {
      const Publisher::Link& link = (*links)[i];
      if (link.status.welcome_message[0] == '\0' || printed_messages_[i] == link.status.welcome_message)
        continue;
      printed_messages_[i] = link.status.welcome_message;
      log_line(link.uri + ": " + printed_messages_[i]);
    }
    for (const std::string& warning : simulation_.take_warnings()) log_line("warning: " + warning);
    return {};
  }

  Result<void> process_commands() {
    const auto line = commands_.next();
    if (!line) return {};
    if (*line == "pause") {
      return set_paused(true);
    } else if (*line == "go") {
      pace_.restart();
      return set_paused(false);
    } else if (*line == "step") {
      single_step_ = true;
      pace_.restart();
      return set_paused(true);
    } else if (*line == "reset") {
      return reset();
    } else if (*line == "quit") {
      stop_requested = true;
    } else if (!line->empty()) {
      log_line("warning: \"" + *line + "\" is not one of pause, go, step, reset, quit");
    }
    return {};
  }

  Simulation simulation_;
  Publisher publisher_;
  std::optional<Interaction> interaction_;
  std::optional<ImageFiles> files_;
  const Options& options_;
  Pace pace_;
  CommandLines commands_;
  std::vector<std::string> printed_messages_;
  std::vector<uint64_t> requests_;  // parallel to options_.images
  uint64_t images_written_ = 0, images_lost_ = 0;
  double stepped_s_ = 0;
  bool paused_, single_step_ = false;
  int requested_steps_ = 0;  // by people, while paused
};

// Main loop: steps the model at the requested pace and publishes it. Returns after SIGINT, SIGTERM or SIGHUP,
// with streams closed in order.
Result<void> run(const Options& options) {
  install_stop_signals();
  Result<Simulation> simulation =
      Simulation::load(options.model, options.keyframe, options.drive, options.package_folders);
  if (!simulation) return simulation.error();
  if (!options.scene.empty()) {
    std::vector<std::string> warnings;
    const auto glb = scene_of(simulation->model(), simulation->data(),
                              std::filesystem::path(options.model).stem().string(), warnings);
    if (!glb) return Error{options.model + ": " + glb.error().message};
    if (Result<void> written = base::write_output(options.scene, *glb); !written) return written;
    for (const std::string& warning : warnings) log_line("warning: " + warning);
  }
  if (options.publish.uris.empty()) return {};
  Result<Publisher> publisher = Publisher::open(simulation->model(), options.publish);
  if (!publisher) return publisher.error();
  std::optional<ImageFiles> files;
  if (!options.images.empty()) {
    Result<ImageFiles> opened = ImageFiles::open(options.out);
    if (!opened) return opened.error();
    files = std::move(*opened);
  }
  Runner runner(std::move(*simulation), std::move(*publisher), std::move(files), options);
  Result<void> done = runner.run();
  if (Result<void> written = runner.finish(); done) done = written;
  runner.log_result();
  return done;
}

}  // namespace
}  // namespace fire3dv::mujoco

int main(int argc, char** argv) {
  using namespace fire3dv::mujoco;
  int exit_code = 0;
  const auto options = parse_options(argc, argv, &exit_code);
  if (!options) return exit_code;
  try {
    const fire3dv::Result<void> done = run(*options);
    if (done) return 0;
    log_line(fire3dv::error_line(done.error().message));
  } catch (const std::bad_alloc&) {
    log_line("error: the model does not fit into memory");
  } catch (const std::exception& fault) {  // thrown by a library
    log_line(fire3dv::error_line(fault.what()));
  }
  return 1;
}
