// C entry points of client.h. They check arguments and call fire3dv_stream; errors become codes and messages.
#include "fire3dv/client.h"

#include <time.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "base/text.h"
#include "call.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/open.h"
#include "protocol/wire/check.h"
#include "protocol/wire/limits.h"
#include "stream.h"

using fire3dv::client::fail;
using fire3dv::client::guarded;
using fire3dv::client::StreamCall;
namespace wire = fire3dv::wire;

namespace {

constexpr size_t kFirstOptionsSize =
    offsetof(fire3dv_options, key_file);  // size of the struct in the first released version
constexpr size_t kFirstStatusSize = offsetof(fire3dv_status, conflicting_names);
constexpr uint32_t kKnownFlags = FIRE3DV_FRAME_DISCONTINUITY;

static_assert(int{FIRE3DV_FRAME_DISCONTINUITY} == int{wire::kFrameDiscontinuity});

int fail_struct(const char* name, size_t struct_size, size_t known_size) {
  const std::string text = std::string(name) + ".struct_size is " + std::to_string(struct_size);
  return fail(FIRE3DV_ERROR_ARGUMENT, text + "; set it to sizeof(fire3dv_" + name + ") (" +
                                          std::to_string(known_size) +
                                          " in this version of the library), and leave unknown fields 0");
}

// Checks flags and pose values of a whole or partial frame.
int check_frame(uint32_t flags, std::span<const wire::Affine3x4> poses) {
  if ((flags & ~kKnownFlags) != 0) {
    return fail(FIRE3DV_ERROR_ARGUMENT,
                "flags is " + std::to_string(flags) + "; only FIRE3DV_FRAME_* bits may be set");
  }
  const auto good =
      wire::check_poses("stream_from_body", poses, fire3dv::client::outgoing_limits().max_abs_value);
  if (!good) return fail(FIRE3DV_ERROR_ARGUMENT, good.error().message);
  return FIRE3DV_OK;
}

// Reads at most PATH_MAX bytes; the system refuses longer paths anyway.
std::string path_of(const char* name) {
  constexpr size_t kMaxPathBytes = 4096;
  return name ? std::string(name, strnlen(name, kMaxPathBytes)) : std::string();
}

int open(const char* uri, const fire3dv_options* given, fire3dv_stream** result) {
  if (!uri) return fail(FIRE3DV_ERROR_ARGUMENT, "uri is NULL");
  auto stream = std::make_unique<fire3dv_stream>();
  stream->adapter_name = "generic";
  fire3dv::transport::PublisherOptions link_options;
  if (given) {
    const size_t known = std::min(std::max(given->struct_size, kFirstOptionsSize), sizeof *given);
    if (!fire3dv::client::struct_is_known(given, given->struct_size, known)) {
      return fail_struct("options", given->struct_size, sizeof *given);
    }
    fire3dv_options complete{};
    std::memcpy(&complete, given, known);
    const fire3dv_options* const options = &complete;
    link_options.key_file = path_of(options->key_file);
    link_options.tls.ca_file = path_of(options->tls_ca_file);
    link_options.tls.certificate_file = path_of(options->tls_certificate_file);
    link_options.tls.key_file = path_of(options->tls_key_file);
    if (options->scene_budget_bytes > wire::kMaxSceneEditBytes)
      return fail(FIRE3DV_ERROR_ARGUMENT, "options.scene_budget_bytes is " +
                                              std::to_string(options->scene_budget_bytes) +
                                              "; at most 256 MiB are allowed");
    if (options->scene_budget_bytes != 0) stream->edits = wire::EditStore(options->scene_budget_bytes);
    const uint32_t limit = fire3dv::client::outgoing_limits().max_name_bytes;
    if (options->adapter_name)
      stream->adapter_name.assign(options->adapter_name, strnlen(options->adapter_name, limit + 1));
    const auto good = wire::check_text("options.adapter_name", stream->adapter_name, limit);
    if (!good.ok()) return fail(FIRE3DV_ERROR_ARGUMENT, good.error().message);
  }
  const auto parsed = fire3dv::transport::parse_uri(uri);
  if (!parsed.ok()) return fail(FIRE3DV_ERROR_ARGUMENT, parsed.error().message);
  auto link = fire3dv::transport::open_publisher(uri, link_options);
  if (!link.ok()) return fail(FIRE3DV_ERROR_SYSTEM, link.error().message);
  stream->link = std::move(*link);
  stream->uri = uri;
  stream->takes_input =
      parsed->scheme != fire3dv::transport::Uri::Scheme::udp || !link_options.key_file.empty();
  *result = stream.release();
  return FIRE3DV_OK;
}

int describe(fire3dv_stream* stream, const fire3dv_description* description) {
  if (!description) return fail(FIRE3DV_ERROR_ARGUMENT, "description is NULL");
  if (!fire3dv::client::struct_is_known(description, description->struct_size, sizeof *description)) {
    return fail_struct("description", description->struct_size, sizeof *description);
  }
  auto message = fire3dv::client::read_description(*description);
  if (!message.ok()) return fail(FIRE3DV_ERROR_ARGUMENT, message.error().message);
  const auto taken = stream->describe(std::move(*message));
  if (!taken.ok()) return fail(FIRE3DV_ERROR_SYSTEM, taken.error().message);
  return FIRE3DV_OK;
}

int publish(fire3dv_stream* stream, int64_t sim_time_ns, const float* stream_from_body, size_t pose_count,
            uint32_t flags) {
  if (stream->epoch == 0) {
    return fail(FIRE3DV_ERROR_STATE,
                "the stream has no description yet: call fire3dv_describe before fire3dv_publish");
  }
  if (pose_count != stream->node_count) {
    return fail(FIRE3DV_ERROR_ARGUMENT, "pose_count is " + std::to_string(pose_count) + " but " +
                                            std::to_string(stream->node_count) + " nodes were described");
  }
  if (!stream_from_body && pose_count > 0) return fail(FIRE3DV_ERROR_ARGUMENT, "stream_from_body is NULL");
  const std::span poses(reinterpret_cast<const wire::Affine3x4*>(stream_from_body), pose_count);
  if (const int refused = check_frame(flags, poses); refused != FIRE3DV_OK) return refused;
  stream->publish(sim_time_ns, flags, poses);
  return FIRE3DV_OK;
}

int publish_some(fire3dv_stream* stream, int64_t sim_time_ns, const uint32_t* node_indices,
                 const float* stream_from_body, size_t pose_count, uint32_t flags) {
  if (stream->epoch == 0) {
    return fail(FIRE3DV_ERROR_STATE,
                "the stream has no description yet: call fire3dv_describe before fire3dv_publish_some");
  }
  if (pose_count == 0 || pose_count > stream->node_count) {
    return fail(FIRE3DV_ERROR_ARGUMENT, "pose_count is " + std::to_string(pose_count) + "; name 1 to " +
                                            std::to_string(stream->node_count) + " of the described nodes");
  }
  if (!node_indices || !stream_from_body)
    return fail(FIRE3DV_ERROR_ARGUMENT, "node_indices or stream_from_body is NULL");
  for (size_t i = 0; i < pose_count; ++i) {
    if (node_indices[i] < stream->node_count && (i == 0 || node_indices[i] > node_indices[i - 1])) continue;
    return fail(FIRE3DV_ERROR_ARGUMENT, "node_indices[" + std::to_string(i) + "] is " +
                                            std::to_string(node_indices[i]) +
                                            "; indices must rise and be below the count of nodes, " +
                                            std::to_string(stream->node_count));
  }
  if (!stream->has_cached_poses && pose_count != stream->node_count)
    return fail(FIRE3DV_ERROR_STATE,
                "the first frame of a description that fire3dv_publish_some publishes must name all nodes");
  const std::span poses(reinterpret_cast<const wire::Affine3x4*>(stream_from_body), pose_count);
  if (const int refused = check_frame(flags, poses); refused != FIRE3DV_OK) return refused;
  stream->publish_some(sim_time_ns, flags, {node_indices, pose_count}, poses);
  return FIRE3DV_OK;
}

void fill(fire3dv_status& status, const fire3dv_stream& stream) {
  const fire3dv::transport::LinkStats stats = stream.link->stats();
  status.renderers = stats.peers;
  status.epoch = stream.epoch;
  status.sequence = stream.sequence;
  status.acked_sequence = stream.acked_sequence;
  status.frames_published = stream.frames_published;
  status.frames_dropped = stats.frames_dropped;
  status.welcome = stream.welcome;
  status.unmatched_names = stream.unmatched_names;
  status.conflicting_names = stream.conflicting_names;
  status.contested_names = stream.contested_names;
  status.images_dropped = stream.images.dropped();
  const std::string problem = stats.peers == 0 ? stream.link->problem() : std::string();
  const std::string sentence =
      problem.empty() ? stream.status_text() : wire::printable(problem, sizeof status.welcome_message - 1);
  const size_t length = std::min(sentence.size(), sizeof status.welcome_message - 1);
  std::memcpy(status.welcome_message, sentence.data(), length);
  status.welcome_message[length] = '\0';
}

int poll(fire3dv_stream* stream, fire3dv_status* status) {
  if (status && status->struct_size < kFirstStatusSize) {
    return fail_struct("status", status->struct_size, sizeof *status);
  }
  stream->read_replies();
  if (!status) return FIRE3DV_OK;
  fire3dv_status complete{};
  complete.struct_size = status->struct_size;
  fill(complete, *stream);
  std::memcpy(status, &complete, std::min(status->struct_size, sizeof complete));
  if (complete.renderers > 0 && stream->advice.size() > 1) stream->advice.erase(stream->advice.begin());
  return FIRE3DV_OK;
}

int wait_ack(StreamCall& call, fire3dv_stream& stream, uint64_t sequence, uint32_t timeout_ms) {
  if (stream.epoch == 0)
    return fail(FIRE3DV_ERROR_STATE, "the stream has no description yet: no frame can be shown");
  if (sequence == 0 || sequence > stream.sequence) {
    return fail(FIRE3DV_ERROR_ARGUMENT, "sequence is " + std::to_string(sequence) + "; frames 1 to " +
                                            std::to_string(stream.sequence) + " were published");
  }
  const std::optional<int> code = call.wait(timeout_ms, [&]() -> std::optional<int> {
    stream.read_replies();
    if (stream.acked_sequence >= sequence) return int{FIRE3DV_OK};
    return {};
  });
  if (code) return *code;
  return fail(FIRE3DV_ERROR_TIMEOUT, "no renderer has shown frame " + std::to_string(sequence) + " within " +
                                         std::to_string(timeout_ms) + " ms; " + stream.reach_text());
}

}  // namespace

const char* fire3dv_version(void) {
  return FIRE3DV_VERSION;
}

fire3dv_stream* fire3dv_open(const char* uri, const fire3dv_options* options) {
  fire3dv_stream* stream = nullptr;
  guarded([&] { return open(uri, options, &stream); });
  return stream;
}

int fire3dv_describe(fire3dv_stream* stream, const fire3dv_description* description) {
  return guarded(stream, [&] { return describe(stream, description); });
}

int fire3dv_publish(fire3dv_stream* stream, int64_t sim_time_ns, const float* stream_from_body,
                    size_t pose_count, uint32_t flags) {
  return guarded(stream, [&] { return publish(stream, sim_time_ns, stream_from_body, pose_count, flags); });
}

int fire3dv_publish_some(fire3dv_stream* stream, int64_t sim_time_ns, const uint32_t* node_indices,
                         const float* stream_from_body, size_t pose_count, uint32_t flags) {
  return guarded(stream, [&] {
    return publish_some(stream, sim_time_ns, node_indices, stream_from_body, pose_count, flags);
  });
}

int fire3dv_poll(fire3dv_stream* stream, fire3dv_status* status) {
  return guarded(stream, [&] { return poll(stream, status); });
}

int fire3dv_wait_ack(fire3dv_stream* stream, uint64_t sequence, uint32_t timeout_ms) {
  return guarded(stream, [&](StreamCall& call) { return wait_ack(call, *stream, sequence, timeout_ms); });
}

void fire3dv_close(fire3dv_stream** stream) {
  if (!stream || !*stream) return;
  fire3dv_stream* const closed = std::exchange(*stream, nullptr);
  if (!closed->is_inherited()) {
    guarded([&] {
      const StreamCall call(*closed);
      closed->closing.store(true);
      if (closed->epoch != 0) closed->link->send_control(wire::encode(wire::Goodbye{closed->epoch}));
      return FIRE3DV_OK;
    });
    closed->closing.store(true);
    const timespec pause{0, 100'000};
    while (closed->calls.load() != 0) ::nanosleep(&pause, nullptr);  // waits see `closing` in time
  }
  delete closed;
}

const char* fire3dv_last_error(void) {
  return fire3dv::client::last_error();
}
