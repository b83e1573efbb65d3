/* Scalars of the FIRE-3DV client: named numbers with units that a stream publishes besides poses, such as
 * joint angles, forces and energies. C11 and C++.
 *
 *   const char *names[] = {"kinetic", "potential"}, *units[] = {"J", "J"};
 *   fire3dv_scalars energy = {sizeof energy, names, units, 2};
 *   fire3dv_declare_scalars(stream, "energy", &energy);      // once
 *   const double values[] = {1.5, 9.81};
 *   fire3dv_set_scalars(stream, "energy", sim_time_ns, values, 2);  // each time step
 *
 * Groups: scalars are declared in groups, which may be set at different rates. A stream has at most 4096
 * scalars. Delivery: as long as a link and its reader keep up, renderers and recordings receive each array of
 * values. A link that falls behind drops values of a group for newer ones. Pose frames do not wait for
 * scalars. State: a declaration and the newest values of its group are kept like scene edits
 * (fire3dv/scene.h): renderers that join late receive them, fire3dv_describe keeps them, the end of the
 * stream removes them, and both take part of fire3dv_options.scene_budget_bytes. Blocking, ownership,
 * thread-safety: as in client.h. No call waits. Arrays and texts are
 * copied before a call returns. Scalars may be declared and set before fire3dv_describe.
 */
#ifndef FIRE3DV_SCALARS_H
#define FIRE3DV_SCALARS_H

#include "fire3dv/client.h"

#ifdef __cplusplus
extern "C" {
#endif

#define FIRE3DV_MAX_SCALARS 4096 /* of one stream, in all groups */

typedef struct fire3dv_scalars {
  size_t struct_size;       /* sizeof(fire3dv_scalars) */
  const char* const* names; /* count UTF-8 names, all different, of 1 to 1024 bytes */
  const char* const*
      units;    /* count UTF-8 units of at most 64 bytes, such as "rad" or "N m"; NULL = none have a unit,
                   NULL or "" for one = it has none. Values are shown in this unit, never converted */
  size_t count; /* at least 1 */
} fire3dv_scalars;

/* Declares a group of scalars, or declares it again. Values set before belong to the old declaration.
 * FIRE3DV_ERROR_ARGUMENT: a name or unit is not valid; FIRE3DV_ERROR_BUDGET: too many scalars, or
 * scene_budget_bytes is used up. After an error the old declaration stays in force. */
FIRE3DV_API int fire3dv_declare_scalars(fire3dv_stream* stream, const char* group,
                                        const fire3dv_scalars* scalars);

/* Sets all values of a group at one simulation time, in the order of the declaration. A value that is NaN or
 * infinite means: no value at this time. Times may repeat; a time before the last one begins the group's
 * history again. FIRE3DV_ERROR_STATE: the group is not declared; FIRE3DV_ERROR_ARGUMENT: count is not that of
 * the declaration. */
FIRE3DV_API int fire3dv_set_scalars(fire3dv_stream* stream, const char* group, int64_t sim_time_ns,
                                    const double* values, size_t count);

/* Removes the group. A name without a group is no error. */
FIRE3DV_API int fire3dv_clear_scalars(fire3dv_stream* stream, const char* group);

#ifdef __cplusplus
}
#endif
#endif
