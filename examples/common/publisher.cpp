#include "examples/common/publisher.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <utility>

#include "base/command_line.h"
#include "examples/common/materials.h"

namespace examples {

void set_help(CLI::App& app, const std::string& usage) {
  fire3dv::set_help(app, usage);
  fire3dv::set_program_flags(app);
}

CLI::Option* add_link_options(CLI::App& app, LinkOptions& options) {
  constexpr const char* kGroup = "Streams";
  CLI::Option* to = app.add_option("--to", options.to, "shm://NAME, or tcp, tls, udp://HOST:PORT; repeatable")
                        ->type_name("URI")
                        ->group(kGroup)
                        ->allow_extra_args(false);
  fire3dv::add_client_security(app, options.security.key_file, options.security.tls_ca_file,
                               options.security.tls_certificate_file, options.security.tls_key_file, kGroup);
  app.add_option("--ack-timeout", options.ack_timeout_s, "limit of one wait of --lockstep")
      ->type_name("SECONDS")
      ->group(kGroup)
      ->check(in_range(0.1, 86400.0))
      ->capture_default_str();
  return to;
}

namespace {

using std::chrono::milliseconds, std::chrono::nanoseconds;

std::string failed(const char* what, const std::string& uri, const fire3dv::ClientError& error) {
  return std::string(what) + " " + uri + ": " + error.what();
}

}  // namespace

std::optional<std::string> Publisher::open(const std::string& adapter_name,
                                           const std::vector<std::string>& uris,
                                           const fire3dv::Security& security) {
  for (const std::string& uri : uris) {
    try {
      targets_.push_back({uri, fire3dv::Stream(uri, adapter_name, security)});
    } catch (const fire3dv::ClientError& error) {
      return failed("cannot open", uri, error);
    }
  }
  return std::nullopt;
}

std::optional<std::string> Publisher::describe(const fire3dv::Description& description) {
  for (Target& target : targets_) {
    try {
      target.stream.describe(description);
    } catch (const fire3dv::ClientError& error) {
      return failed("cannot describe the bodies to", target.uri, error);
    }
  }
  sequence_ = 0;
  return std::nullopt;
}

std::optional<std::string> Publisher::publish(int64_t sim_time_ns, const std::vector<float>& poses,
                                              bool discontinuity) {
  ++sequence_;
  const uint32_t flags = discontinuity ? FIRE3DV_FRAME_DISCONTINUITY : 0;
  for (Target& target : targets_) {
    try {
      target.stream.publish(nanoseconds(sim_time_ns), poses.data(), poses.size() / 12, flags);
    } catch (const fire3dv::ClientError& error) {
      return failed("cannot publish to", target.uri, error);
    }
  }
  return std::nullopt;
}

std::optional<std::string> Publisher::set_marker(const char* name, const fire3dv_marker& marker) {
  for (Target& target : targets_) {
    if (fire3dv_set_marker(target.stream.get(), name, &marker) != FIRE3DV_OK)
      return "cannot send the marker " + std::string(name) + " to " + target.uri + ": " +
             fire3dv_last_error();
  }
  return std::nullopt;
}

std::optional<std::string> Publisher::declare_scalars(const char* group, const fire3dv_scalars& scalars) {
  for (Target& target : targets_) {
    if (fire3dv_declare_scalars(target.stream.get(), group, &scalars) != FIRE3DV_OK)
      return "cannot send the scalars " + std::string(group) + " to " + target.uri + ": " +
             fire3dv_last_error();
  }
  return std::nullopt;
}

std::optional<std::string> Publisher::set_scalars(const char* group, int64_t sim_time_ns,
                                                  const std::vector<double>& values) {
  for (Target& target : targets_) {
    if (fire3dv_set_scalars(target.stream.get(), group, sim_time_ns, values.data(), values.size()) !=
        FIRE3DV_OK)
      return "cannot send the scalars " + std::string(group) + " to " + target.uri + ": " +
             fire3dv_last_error();
  }
  return std::nullopt;
}

std::optional<std::string> Publisher::set_vertices(const char* node, const std::vector<float>& positions,
                                                   const std::vector<float>& normals) {
  fire3dv_vertices vertices{};
  vertices.struct_size = sizeof vertices;
  vertices.positions = positions.data();
  vertices.normals = normals.data();
  vertices.vertex_count = positions.size() / 3;
  for (Target& target : targets_) {
    if (fire3dv_set_vertices(target.stream.get(), node, &vertices) != FIRE3DV_OK)
      return "cannot send the vertices of " + std::string(node) + " to " + target.uri + ": " +
             fire3dv_last_error();
  }
  return std::nullopt;
}

std::optional<std::string> Publisher::request_picture(const std::string& camera, double timeout_s,
                                                      const std::atomic<bool>& stop, Image& image) {
  if (targets_.empty()) return "there is no renderer to draw a picture";
  Target& target = targets_[0];
  try {
    fire3dv_image_request request{};
    request.node = camera.c_str();
    request.width = static_cast<uint32_t>(image.width);
    request.height = static_cast<uint32_t>(image.height);
    request.sequence = sequence_;
    const uint64_t id = target.stream.request_image(request);
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
    while (!stop && std::chrono::steady_clock::now() < deadline) {
      const fire3dv::Image drawn = target.stream.wait_image(id, milliseconds(100));
      const fire3dv_image_plane* const plane = fire3dv_plane_of(drawn.get(), FIRE3DV_IMAGE_COLOR_SRGB8);
      if (!plane) continue;
      image.rgb.clear();
      for (uint32_t row = 0; row < plane->height; ++row) {
        const auto* pixel = static_cast<const uint8_t*>(plane->data) + size_t{row} * plane->row_stride;
        for (uint32_t column = 0; column < plane->width; ++column, pixel += 4)
          image.rgb.insert(image.rgb.end(), pixel, pixel + 3);
      }
      return std::nullopt;
    }
  } catch (const fire3dv::ClientError& error) {
    return failed("cannot get a picture from", target.uri, error);
  }
  return "no renderer on " + target.uri + " has drawn the picture in time";
}

std::optional<std::string> Publisher::wait_shown(double timeout_s, const std::atomic<bool>& stop) {
  constexpr std::chrono::seconds kToldWait{3};
  const auto begun = std::chrono::steady_clock::now();
  const auto deadline = begun + std::chrono::duration<double>(timeout_s);
  for (Target& target : targets_) {
    try {
      while (!stop &&
             !target.stream.wait_ack(sequence_, milliseconds(100))) {  // short, so that Ctrl-C is handled
        if (!target.has_told_wait && std::chrono::steady_clock::now() - begun >= kToldWait) {
          target.has_told_wait = true;
          std::fprintf(stderr, "waiting for a renderer at %s to show frame %llu\n", target.uri.c_str(),
                       static_cast<unsigned long long>(sequence_));
        }
        if (std::chrono::steady_clock::now() < deadline) continue;
        return "no renderer on " + target.uri + " has shown frame " + std::to_string(sequence_) +
               " in time: start one that listens there, or give a longer --ack-timeout";
      }
    } catch (const fire3dv::ClientError& error) {
      return failed("cannot wait for", target.uri, error);
    }
  }
  return std::nullopt;
}

std::vector<Publisher::Link> Publisher::poll() {
  std::vector<Link> links;
  for (Target& target : targets_) {
    try {
      links.push_back({target.uri, target.stream.poll()});
    } catch (const fire3dv::ClientError& error) {
      std::fprintf(stderr, "%s\n", failed("cannot poll", target.uri, error).c_str());
    }
  }
  return links;
}

namespace {

struct Spread {
  double median = 0, worst = 0;
};

Spread spread_of(std::vector<double>& values) {
  if (values.empty()) return {};
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  const double median = *middle;
  return {median, *std::max_element(values.begin(), values.end())};
}

}  // namespace

void Report::print(double sim_time_s, const std::vector<Publisher::Link>& links) {
  const Clock::time_point now = Clock::now();
  const double seconds = std::chrono::duration<double>(now - since_).count();
  const size_t frames = publish_us_.size();
  const Spread step = spread_of(step_us_), publish = spread_of(publish_us_);
  std::fprintf(stderr,
               "t %6.2f s  %5.0f frames/s  step median %.0f max %.0f us  publish median %.1f max %.1f us\n",
               sim_time_s, static_cast<double>(frames) / std::max(seconds, 1e-9), step.median, step.worst,
               publish.median, publish.worst);
  printed_messages_.resize(links.size());
  for (size_t i = 0; i < links.size(); ++i) {
    const fire3dv_status& status = links[i].status;
    std::fprintf(
        stderr,
        "  %s: renderers %u, published %llu, newest shown is frame %llu, dropped %llu, unmatched names %u\n",
        links[i].uri.c_str(), status.renderers, static_cast<unsigned long long>(status.frames_published),
        static_cast<unsigned long long>(status.acked_sequence),
        static_cast<unsigned long long>(status.frames_dropped), status.unmatched_names);
    if (status.welcome_message[0] != '\0' && printed_messages_[i] != status.welcome_message) {
      printed_messages_[i] = status.welcome_message;
      // Without a renderer the message is the link's own, such as its verdict on a certificate.
      const std::string message = status.welcome_message, prefix = links[i].uri + ": ";
      const bool has_uri = message.starts_with(prefix);
      std::fprintf(stderr, "  %s%s%s\n", prefix.c_str(),
                   status.renderers != 0 ? "the renderer says: "
                   : status.welcome >= 0 ? "the renderer has left; it said: "
                                         : "not connected: ",
                   message.c_str() + (has_uri ? prefix.size() : 0));
    }
  }
  since_ = now;
  step_us_.clear();
  publish_us_.clear();
}

}  // namespace examples
