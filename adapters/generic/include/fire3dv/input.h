/* Inputs of the FIRE-3DV client: a stream declares what people may do to its simulation (sliders, buttons, a
 * run bar, dragging of bodies), and polls the events that they cause in windows and browsers. C11 and C++.
 *
 *   fire3dv_input gain = {sizeof gain, FIRE3DV_INPUT_SLIDER};
 *   gain.maximum = 2; gain.value = 1;
 *   fire3dv_declare_input(stream, "controller/gain", &gain);             // once
 *   fire3dv_event event = {sizeof event};
 *   for (int i = 0; i < 1024 && fire3dv_poll_events(stream, &event, 1) == 1; ++i)  // each step: never waits
 *     if (strcmp(event.input, "controller/gain") == 0) set_gain(event.value);
 *
 * Rights: nothing is sent for what is not declared. Events come from renderers over shm://, tcp://, tls://
 * and udp:// with a key, from their windows and from browsers with a control link. Names: what stands before
 * the last "/" of a name is its folder in panels. State: a declaration is kept like a scene edit
 * (fire3dv/scene.h): renderers that join late receive it with the value of the last polled event, so all
 * viewers agree; fire3dv_describe keeps it, the end of the stream removes it, and it takes part of
 * fire3dv_options.scene_budget_bytes. Order: of sliders, speeds and moves of a drag only the newest event is
 * queued; of all others at most 1024 are, and later ones are dropped and counted. Events of an earlier
 * description, repeated ones, and those whose input was cleared or whose value is out of range never arrive;
 * but what is held when fire3dv_describe or fire3dv_clear_input is called ends with an event, whose node is
 * that of the description before. A renderer may send as fast as it likes: take a bounded number at a time.
 * Blocking, ownership, thread-safety: as in client.h. No call waits.
 */
#ifndef FIRE3DV_INPUT_H
#define FIRE3DV_INPUT_H

#include "fire3dv/client.h"

#ifdef __cplusplus
extern "C" {
#endif

#define FIRE3DV_MAX_INPUTS 256 /* of one stream */

enum { /* fire3dv_input.kind */
       FIRE3DV_INPUT_SLIDER = 0,
       FIRE3DV_INPUT_BUTTON = 1,
       FIRE3DV_INPUT_TOGGLE = 2,
       FIRE3DV_INPUT_CHOICE = 3,
       FIRE3DV_INPUT_TEXT = 4,
       FIRE3DV_INPUT_RUN = 5, /* run bar */
       FIRE3DV_INPUT_DRAG = 6 /* bodies of the description may be dragged by a spring */
};

enum { /* fire3dv_input.flags of a run bar: what it takes */
       FIRE3DV_INPUT_RUN_PAUSE = 1,
       FIRE3DV_INPUT_STEP = 2,
       FIRE3DV_INPUT_RESET = 4,
       FIRE3DV_INPUT_SPEED = 8
};

enum {                          /* fire3dv_event.action */
       FIRE3DV_EVENT_SET = 0,   /* slider, toggle (0, 1), choice (its index): value; text: text */
       FIRE3DV_EVENT_PRESS = 1, /* button */
       FIRE3DV_EVENT_RUN = 2,
       FIRE3DV_EVENT_PAUSE = 3,
       FIRE3DV_EVENT_STEP = 4, /* value: number of steps, 1 or more */
       FIRE3DV_EVENT_RESET = 5,
       FIRE3DV_EVENT_SPEED = 6, /* value: simulated seconds per second */
       FIRE3DV_EVENT_BEGIN = 7, /* drag: node, node_point, target */
       FIRE3DV_EVENT_MOVE = 8,  /* drag: the same */
       FIRE3DV_EVENT_END = 9 /* drag: node; also when its viewer is gone: 5 s after its last sign of life */
};

typedef struct fire3dv_input {
  size_t struct_size;      /* sizeof(fire3dv_input) */
  int32_t kind;            /* FIRE3DV_INPUT_* */
  uint32_t flags;          /* run bar: FIRE3DV_INPUT_RUN_PAUSE, ... */
  double minimum, maximum; /* slider: its range; run bar with FIRE3DV_INPUT_SPEED: that of the speed */
  double step;             /* slider: distance of its values; 0 = any value */
  double value; /* current value. Slider; toggle: 0 or 1; choice: index; run bar: 1 running, 0 paused; drag:
                   stiffness of the spring in N/m, for display, 0 = unknown */
  double speed; /* run bar: current speed, simulated seconds per second */
  const char* unit;           /* slider: UTF-8 of at most 63 bytes; NULL = none */
  const char* text;           /* text: current value, UTF-8 of at most 1023 bytes; NULL = empty */
  const char* const* choices; /* choice: 1 to 256 different UTF-8 texts of 1 to 127 bytes */
  size_t choice_count;
} fire3dv_input;

typedef struct fire3dv_event {
  size_t struct_size;  /* sizeof(fire3dv_event), set by the caller */
  int32_t kind;        /* of the input: FIRE3DV_INPUT_* */
  int32_t action;      /* FIRE3DV_EVENT_* */
  uint64_t source;     /* random id of the renderer */
  uint32_t viewer;     /* who did it, there: 0 = its window, else the number of a browser's page */
  uint32_t node;       /* drag: index of the body in the description's node_names */
  uint64_t time_ns;    /* when, on the renderer's monotonic clock; 0: the library ended a drag */
  int64_t sim_time_ns; /* of the frame that the person saw */
  uint64_t lost;       /* events dropped since the one polled before: invalid, or too many */
  double value;
  double node_point[3]; /* drag: the grabbed point in the body's frame, which is that of its pose */
  double target[3];     /* drag: where that point is dragged to, in the stream's frame. With a spring of
                           stiffness k, the force on the body at that point is
                           k * (target - stream_from_body * node_point) */
  char input[128];      /* name, NUL-terminated */
  char text[1024];      /* NUL-terminated */
} fire3dv_event;

/* Declares an input, or declares it again, for example with another value. `name`: UTF-8 of 1 to 127 bytes.
 * FIRE3DV_ERROR_ARGUMENT: a value is not valid; FIRE3DV_ERROR_BUDGET: more than 256 inputs, or
 * scene_budget_bytes is used up. After an error the old declaration stays in force. */
FIRE3DV_API int fire3dv_declare_input(fire3dv_stream* stream, const char* name, const fire3dv_input* input);

/* Removes an input; drags by it end with an event. A name without an input is no error. */
FIRE3DV_API int fire3dv_clear_input(fire3dv_stream* stream, const char* name);

/* Takes the oldest events, at most `capacity`, into the array `events`, whose first element has struct_size
 * set. Returns their number, 0 if there are none, or an error code. Also reads renderers' messages, as
 * fire3dv_poll does. Never waits. */
FIRE3DV_API int fire3dv_poll_events(fire3dv_stream* stream, fire3dv_event* events, size_t capacity);

#ifdef __cplusplus
}
#endif
#endif
