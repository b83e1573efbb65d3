#include "adapters/mujoco/publisher.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <tuple>
#include <utility>

#include "adapters/mujoco/client_errors.h"
#include "tools/convert/glb/lights.h"
#include "tools/convert/glb/write_glb.h"
#include "tools/convert/mjcf/mjcf_load.h"

namespace fire3dv::mujoco {
namespace {

using Clock = std::chrono::steady_clock;

// Rotates MuJoCo's Z up to glTF's Y up.
const std::vector<double> kWorldFromStream = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0};

}  // namespace

Publisher::Publisher(const mjModel& m, convert::MjcfNames names, double rate_hz)
    : names_(std::move(names)),
      nodes_(m, names_),
      looks_(m),
      clock_(rate_hz),
      bodies_(m.nbody),
      cameras_(m.ncam),
      lights_(m.nlight),
      tendons_(m.ntendon),
      geoms_(m.ngeom) {}

Result<Publisher> Publisher::open(const mjModel& model, const PublishOptions& options) {
  Publisher publisher(model, convert::MjcfNames(model), options.rate_hz);
  Description description;
  description.node_names = publisher.nodes_.names();
  description.world_from_stream = kWorldFromStream;
  const double step_rate_hz = model.opt.timestep > 0 ? 1 / model.opt.timestep : 0;
  description.nominal_rate_hz = options.rate_hz > 0 ? std::min(options.rate_hz, step_rate_hz) : step_rate_hz;
  description.scene_uri = options.scene_uri;
  for (const std::string& uri : options.uris) {
    const Result<void> opened = told("cannot publish to", uri, [&] {
      Stream stream(uri, options.adapter_name, options.security);
      stream.describe(description);
      publisher.targets_.push_back({uri, std::move(stream)});
    });
    if (!opened) return opened.error();
  }
  return publisher;
}

int64_t Publisher::sim_time_ns(const mjData& data) {
  constexpr double kMost_s = 9e9;  // limit of int64 nanoseconds: 285 years
  return std::llround(std::clamp(data.time, -kMost_s, kMost_s) * 1e9);
}

Result<bool> Publisher::publish(const mjModel& model, const mjData& data) {
  if (std::tie(model.nbody, model.ncam, model.nlight, model.ntendon, model.ngeom) !=
      std::tie(bodies_, cameras_, lights_, tendons_, geoms_))
    return Error{"this is not the model that the stream was opened for: open another one for it"};
  if (!due(data)) return false;
  nodes_.write(model, data, poses_);
  if (Result<void> sent = send_appearance(model); !sent) return sent.error();
  const int64_t now_ns = sim_time_ns(data);
  const uint32_t flags = clock_.published(now_ns) ? FIRE3DV_FRAME_DISCONTINUITY : 0;
  ++sequence_;
  for (Target& target : targets_) {
    const Result<void> sent = told("cannot publish to", target.uri, [&] {
      target.stream.publish(std::chrono::nanoseconds(now_ns), poses_.data(), poses_.size() / 12, flags);
    });
    if (!sent) return sent.error();
  }
  return true;
}

Result<void> Publisher::send_appearance(const mjModel& model) {
  for (const GeomEdit& edit : looks_.changes(model)) {
    const std::string& name = names_.geoms[edit.geom];
    for (Target& target : targets_) {
      const Result<void> sent = told("cannot tell a geom's looks to", target.uri, [&] {
        if (edit.visible) target.stream.set_visible(name, *edit.visible);
        if (edit.rgba) target.stream.set_base_color(name, *edit.rgba);
      });
      if (!sent) return sent;
    }
  }
  return {};
}

Result<void> Publisher::wait_shown(double timeout_s, const std::atomic<bool>& stop) {
  if (sequence_ == 0) return {};
  const auto deadline = Clock::now() + std::chrono::duration<double>(timeout_s);
  for (Target& target : targets_) {
    bool shown = false;
    while (!shown && !stop) {
      const Result<void> waited = told("cannot wait for", target.uri, [&] {
        shown = target.stream.wait_ack(sequence_, std::chrono::milliseconds(100));  // short, so that `stop`
                                                                                    // is checked
      });
      if (!waited) return waited;
      if (!shown && Clock::now() >= deadline)
        return Error{"no renderer on " + target.uri + " has shown frame " + std::to_string(sequence_) +
                     " in time: start one that listens there, or wait longer"};
    }
  }
  return {};
}

Result<std::vector<Publisher::Link>> Publisher::poll() {
  std::vector<Link> links;
  for (Target& target : targets_) {
    const Result<void> polled = told("cannot poll", target.uri, [&] {
      links.push_back({target.uri, target.stream.poll()});
    });
    if (!polled) return polled.error();
  }
  return links;
}

Result<std::vector<std::byte>> scene_of(const mjModel& model, const mjData& data, const std::string& name,
                                        std::vector<std::string>& warnings) {
  convert::Model made;
  made.name = name;
  convert::ReadOptions options;
  options.geoms_apart = true;
  convert::add_mjcf(model, data, options, made);
  convert::add_light_if_none(made);
  Result<std::vector<std::byte>> glb = convert::write_glb(made, &made.warnings);
  warnings.insert(warnings.end(), made.warnings.begin(), made.warnings.end());
  return glb;
}

}  // namespace fire3dv::mujoco
