/* C API of the FIRE-3DV client library: publishes pose frames of a simulator to renderers. C11 and C++.
 *
 *   fire3dv_stream *stream = fire3dv_open("shm://demo", &options);
 *   fire3dv_describe(stream, &description);
 *   loop { step(); fire3dv_publish(stream, sim_time_ns, poses, count, 0); }
 *   fire3dv_close(&stream);
 *
 * Units and frames: a pose is a 3x4 matrix of 12 floats, row-major. It maps body coordinates to stream
 * coordinates (stream_from_body). world_from_stream maps stream coordinates to the renderer's world: glTF
 * axes, +Y up, metres. Times are nanoseconds. Thread-safety: any thread may use a stream; calls
 * exclude each other, and waits let others in. Only its frames have an order: publish from one thread.
 * fire3dv_close ends waits of other threads, with FIRE3DV_ERROR_STATE, and waits for their calls; no call may
 * begin after it. A child of fork() cannot use a stream of its parent (FIRE3DV_ERROR_STATE), but may close
 * it, which the renderer does not see. Different streams are independent. fire3dv_last_error is per thread.
 * Ownership: the library copies all arguments before a call returns. Only fire3dv_close frees a stream.
 * Blocking: no call waits for a renderer, a network or another process, except fire3dv_wait_ack and
 * fire3dv_wait_image, which take a timeout. Allocation: fire3dv_publish allocates nothing after the first
 * frame of a description. Over shm:// it also makes no system call. Errors: functions return FIRE3DV_OK (0)
 * or a negative FIRE3DV_ERROR_* code; fire3dv_last_error returns the message. Bad arguments never abort the
 * program. A missing renderer is not an error. Scene edits (visibility, colours, lights, cameras, nodes,
 * vertices): fire3dv/scene.h. Images: fire3dv/image.h.
 */
#ifndef FIRE3DV_CLIENT_H
#define FIRE3DV_CLIENT_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define FIRE3DV_API __attribute__((visibility("default")))
#else
#define FIRE3DV_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fire3dv_stream fire3dv_stream;

enum {
  FIRE3DV_OK = 0,
  FIRE3DV_ERROR_ARGUMENT = -1, /* null pointer, wrong count, invalid number, URI or name */
  FIRE3DV_ERROR_STATE = -2,    /* call out of order, such as publish before describe */
  FIRE3DV_ERROR_SYSTEM = -3,   /* operating system or link failure; the message has the cause */
  FIRE3DV_ERROR_TIMEOUT = -4,  /* fire3dv_wait_ack, fire3dv_wait_image */
  FIRE3DV_ERROR_BUDGET = -5    /* scene edits (fire3dv/scene.h) would exceed scene_budget_bytes */
};

/* Zero-initialised fields select the default. struct_size must be set; it lets later versions append fields.
 */
typedef struct fire3dv_options {
  size_t struct_size;       /* sizeof(fire3dv_options) */
  const char* adapter_name; /* shown in logs and panels; default "generic" */
  /* Paths of files that fire3dv_open reads; never key material itself. Other users must have no access to key
   * files. */
  const char* key_file;    /* udp://: pre-shared key of both ends, 64 hexadecimal digits; NULL = none */
  const char* tls_ca_file; /* tls://: trusted CA certificates (PEM); NULL = those of the system */
  const char* tls_certificate_file; /* tls://: client certificate, for renderers that require one (PEM); NULL
                                       = none */
  const char* tls_key_file;         /* tls://: private key of that certificate */
  size_t scene_budget_bytes; /* limit of all encoded scene edits (fire3dv/scene.h); 0 = 64 MiB, at most 256
                                MiB */
} fire3dv_options;

typedef struct fire3dv_description {
  size_t struct_size;            /* sizeof(fire3dv_description) */
  const char* const* node_names; /* node_count UTF-8 names; pose i moves the scene node of that name */
  size_t node_count;
  const double* world_from_stream; /* 12 doubles, row-major; NULL = identity */
  const float* body_from_node;     /* 12 floats for all nodes, or 12 per node; NULL = identity */
  size_t body_from_node_count;     /* 0, 1 or node_count */
  double nominal_rate_hz;          /* 0 = unknown */
  const char* scene_uri;           /* informative, for users and recordings; NULL = none */
} fire3dv_description;

enum {
  FIRE3DV_FRAME_DISCONTINUITY = 1
}; /* bodies or time jumped: renderers do not interpolate into this frame */

typedef struct fire3dv_status {
  size_t struct_size;      /* sizeof(fire3dv_status), set by the caller */
  uint32_t renderers;      /* connected or attached renderers */
  uint64_t epoch;          /* random id of the current description */
  uint64_t sequence;       /* last published frame, 0 = none */
  uint64_t acked_sequence; /* newest frame that a renderer has shown, 0 = none */
  uint64_t frames_published;
  uint64_t frames_dropped;  /* superseded by a newer frame before they were sent completely */
  int32_t welcome;          /* last answer: -1 none yet, 0 accepted, 1 version mismatch, 2 bad description,
                               3 refused, 4 bad key */
  uint32_t unmatched_names; /* names without a scene node, from the last answer; welcome_message lists them */
  char welcome_message[512]; /* one line for users, NUL-terminated, may be truncated; without a renderer: the
                                cause */
  uint32_t
      conflicting_names; /* nodes that another stream drives already: poses of this stream do not move them */
  uint32_t
      contested_names;     /* nodes of this stream that another stream requests; welcome_message lists them */
  uint64_t images_dropped; /* malformed, or no answer to their request (fire3dv/image.h); the error of a wait
                              that times out says why */
} fire3dv_status;

/* Returns the library version, "MAJOR.MINOR.PATCH". Static storage. */
FIRE3DV_API const char* fire3dv_version(void);

/* Opens a link: "shm://NAME", "tcp://HOST:PORT", "tls://HOST:PORT" or "udp://HOST:PORT". A udp:// HOST may be
 * a multicast group; its options (mtu, parity, ...) are in fire3dv(1). Succeeds without a
 * renderer. options may be NULL. Returns NULL on error. */
FIRE3DV_API fire3dv_stream* fire3dv_open(const char* uri, const fire3dv_options* options);

/* Sets the nodes that poses move and starts a new epoch: the sequence restarts at 1. Call it again when
 * bodies are added or removed. Allocates; does not block. */
FIRE3DV_API int fire3dv_describe(fire3dv_stream* stream, const fire3dv_description* description);

/* Publishes one whole frame of pose_count matrices; pose_count must equal the description's node_count.
 * Refuses NaN, infinity and magnitudes above 1e12 with FIRE3DV_ERROR_ARGUMENT. flags: FIRE3DV_FRAME_* bits.
 *
 * A pose replaces the node's whole transform, including its scale: a node that the scene file scales (a mesh
 * in millimetres with scale 0.001) needs that scale in its poses, in body_from_node, or applied to its mesh.
 * Renderers report nodes that lose a scale once per description; see fire3dv_status.welcome_message. */
FIRE3DV_API int fire3dv_publish(fire3dv_stream* stream, int64_t sim_time_ns, const float* stream_from_body,
                                size_t pose_count, uint32_t flags);

/* Publishes a frame in which only some nodes have moved; all others keep their pose. node_indices[i] is the
 * node of pose i; indices must increase. The first call of a description must name all nodes; later calls may
 * alternate with fire3dv_publish. Sends less data over a network than fire3dv_publish; over shm:// the cost
 * is the same. */
FIRE3DV_API int fire3dv_publish_some(fire3dv_stream* stream, int64_t sim_time_ns,
                                     const uint32_t* node_indices, const float* stream_from_body,
                                     size_t pose_count, uint32_t flags);

/* Processes renderers' messages, answers their clock queries and fills *status unless status is NULL. Never
 * blocks. Call it regularly: over shm:// it also puts the file in /dev/shm back, if somebody has removed it,
 * within about a second; fire3dv_publish makes no system call and cannot notice. Renderers that are connected
 * go on, but later ones find nothing until then. */
FIRE3DV_API int fire3dv_poll(fire3dv_stream* stream, fire3dv_status* status);

/* Lockstep: waits until a renderer has shown frame `sequence` of the current epoch. Returns
 * FIRE3DV_ERROR_TIMEOUT after timeout_ms. */
FIRE3DV_API int fire3dv_wait_ack(fire3dv_stream* stream, uint64_t sequence, uint32_t timeout_ms);

/* Ends the stream in order, frees it and sets *stream to NULL. Accepts NULL and a pointer to NULL. */
FIRE3DV_API void fire3dv_close(fire3dv_stream** stream);

/* Returns the message of this thread's last failed call, or "". Valid until the thread's next call. A
 * successful call does not clear it. */
FIRE3DV_API const char* fire3dv_last_error(void);

#ifdef __cplusplus
}
#endif
#endif
