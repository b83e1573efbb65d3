/* FIRE-3DV client: publishes the poses of a simulation to renderers. C11 and C++.
 *
 *   fire3dv_stream *stream = fire3dv_open("shm://demo", &options);
 *   fire3dv_describe(stream, &description);
 *   loop { step(); fire3dv_publish(stream, sim_time_ns, poses, count, 0); }
 *   fire3dv_close(&stream);
 *
 * Units and frames: a pose is a 3x4 matrix, 12 floats, row-major, that takes coordinates of the body to coordinates of
 *   the stream (stream_from_body). world_from_stream takes those to the renderer's world: glTF's, Y up, metres. Times
 *   are nanoseconds.
 * Thread-safety: one stream belongs to one thread at a time. Different streams are independent. fire3dv_last_error is
 *   per thread.
 * Ownership: the library copies all that it is given before a call returns. A stream is freed by fire3dv_close alone.
 * Waiting: no call waits for a renderer, a network or another process, but fire3dv_wait_ack, which says how long.
 * Allocation: fire3dv_publish allocates nothing after the first frame of a description; over shm:// it makes no
 *   system call either.
 * Scene edits (visibility, colours, lights, cameras, nodes, vertices): fire3dv/scene.h.
 * Errors: functions return 0 (FIRE3DV_OK) or a negative FIRE3DV_ERROR_*; fire3dv_last_error gives one sentence. No
 *   function aborts on bad arguments, and a missing renderer is not an error.
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
  FIRE3DV_ERROR_ARGUMENT = -1, /* null pointer, wrong count, a URI or name that is not valid */
  FIRE3DV_ERROR_STATE = -2,    /* publish before describe */
  FIRE3DV_ERROR_SYSTEM = -3,   /* the operating system refused; the message says what */
  FIRE3DV_ERROR_TIMEOUT = -4,  /* fire3dv_wait_ack only */
  FIRE3DV_ERROR_BUDGET = -5    /* scene edits (fire3dv/scene.h) would take more than scene_budget_bytes */
};

/* Zero-initialised fields mean the default, but struct_size must be set: it lets later versions add fields. */
typedef struct fire3dv_options {
  size_t struct_size;       /* sizeof(fire3dv_options) */
  const char *adapter_name; /* for people; default "generic" */
  /* Files only, never keys themselves; files of keys must be closed to other users. They are read in fire3dv_open. */
  const char *key_file;             /* udp://: the key that the renderer has too, 64 hexadecimal digits; NULL = none */
  const char *tls_ca_file;          /* tls://: certificates to trust (PEM); NULL = the system's */
  const char *tls_certificate_file; /* tls://: this simulator's own, for renderers that ask (PEM); NULL = none */
  const char *tls_key_file;         /* tls://: of that certificate */
  size_t scene_budget_bytes; /* what all scene edits together may take (fire3dv/scene.h); 0 = 64 MiB, at most 256 MiB */
} fire3dv_options;

typedef struct fire3dv_description {
  size_t struct_size;              /* sizeof(fire3dv_description) */
  const char *const *node_names;   /* node_count UTF-8 names; pose i moves the scene node of that name */
  size_t node_count;
  const double *world_from_stream; /* 12 doubles, row-major; NULL = identity */
  const float *body_from_node;     /* 12 floats for all nodes, or 12 per node; NULL = identity */
  size_t body_from_node_count;     /* 0, 1 or node_count */
  double nominal_rate_hz;          /* 0 = unknown */
  const char *scene_uri;           /* hint for people and recordings; NULL = none */
} fire3dv_description;

enum { FIRE3DV_FRAME_DISCONTINUITY = 1 }; /* bodies or time jumped: do not interpolate into this frame */

typedef struct fire3dv_status {
  size_t struct_size;        /* sizeof(fire3dv_status), set by the caller */
  uint32_t renderers;        /* connected or attached now */
  uint64_t epoch;            /* random id of this stream's description */
  uint64_t sequence;         /* of the last published frame, 0 = none */
  uint64_t acked_sequence;   /* newest frame that a renderer has shown, 0 = none */
  uint64_t frames_published;
  uint64_t frames_dropped;   /* overtaken by a newer frame before all of them had left */
  int32_t welcome;           /* last answer: -1 none yet, 0 accepted, 1 version mismatch, 2 bad description,
                                3 refused, 4 bad key */
  uint32_t unmatched_names;  /* of the last answer; the names are in welcome_message */
  char welcome_message[512]; /* one line for people, NUL-terminated, cut if longer; while no renderer is reached: why */
  uint32_t conflicting_names; /* nodes that another stream drives already: our poses do not move them */
  uint32_t contested_names;   /* nodes that we drive and keep, and another stream asks for; both are named in welcome_message */
} fire3dv_status;

/* Version of the library, "0.1.0". Static storage. */
FIRE3DV_API const char *fire3dv_version(void);

/* Opens a link: "shm://NAME", "tcp://HOST:PORT", "tls://HOST:PORT", "udp://HOST:PORT" (HOST may be a multicast group;
 * "?mtu=N" behind it sets the longest datagram). Succeeds whether or not a renderer is there.
 * options may be NULL. Returns NULL on error. */
FIRE3DV_API fire3dv_stream *fire3dv_open(const char *uri, const fire3dv_options *options);

/* Says which nodes the poses move. Starts a new epoch: sequence restarts at 1. May be called again when bodies come or
 * go. Blocks for no one; allocates. */
FIRE3DV_API int fire3dv_describe(fire3dv_stream *stream, const fire3dv_description *description);

/* Publishes one whole frame: pose_count (= the description's node_count) matrices of 12 floats. NaN, infinity and
 * magnitudes above 1e12 are refused with FIRE3DV_ERROR_ARGUMENT. flags: FIRE3DV_FRAME_*. */
FIRE3DV_API int fire3dv_publish(fire3dv_stream *stream, int64_t sim_time_ns, const float *stream_from_body,
                                size_t pose_count, uint32_t flags);

/* Publishes a frame in which only some nodes have moved: node_indices[i], in rising order, is the node of pose i, and all
 * others are where they were. The first frame of a description that is published so must name all nodes; after that
 * fire3dv_publish may be used beside it. Costs less than fire3dv_publish over a network, and nothing less over shm://. */
FIRE3DV_API int fire3dv_publish_some(fire3dv_stream *stream, int64_t sim_time_ns, const uint32_t *node_indices,
                                     const float *stream_from_body, size_t pose_count, uint32_t flags);

/* Reads what renderers have answered, fills *status unless status is NULL, and answers their questions about the clock.
 * Never waits. Call it now and then. */
FIRE3DV_API int fire3dv_poll(fire3dv_stream *stream, fire3dv_status *status);

/* Lockstep: waits until a renderer has shown this sequence of the current epoch, or timeout_ms is over. */
FIRE3DV_API int fire3dv_wait_ack(fire3dv_stream *stream, uint64_t sequence, uint32_t timeout_ms);

/* Ends the stream in order, frees it and sets *stream to NULL. NULL and pointer to NULL are fine. */
FIRE3DV_API void fire3dv_close(fire3dv_stream **stream);

/* The reason of this thread's last failed call, or "". Valid until the thread's next call; a call that succeeds leaves
 * it as it is. */
FIRE3DV_API const char *fire3dv_last_error(void);

#ifdef __cplusplus
}
#endif
#endif
