/* Robots by joint positions: reads the joints of a scene that fire3dv-convert has written, and computes the
 * poses of its nodes (forward kinematics). C11 and C++.
 *
 *   fire3dv_robot *robot = fire3dv_open_robot("arm.glb", 0);
 *   fire3dv_description description = {sizeof description};
 *   fire3dv_get_robot_description(robot, &description);
 *   fire3dv_describe(stream, &description);
 *   loop { fire3dv_set_positions(robot, q, count, 0); fire3dv_publish_robot(stream, robot, sim_time_ns, 0); }
 *   fire3dv_close_robot(&robot);
 *
 * Units: radians and metres. Quaternions are x y z w.
 * Frames: the robot's model frame is that of its description file, usually Z up. stream_from_model places it
 * in the stream, the identity at first. A pose is a 3x4 matrix, row-major: stream_from_node. Positions: one
 * number for each revolute and prismatic joint; planar: x, y, angle; ball: a quaternion; floating: x, y, z,
 * quaternion. They are the numbers of all joints that follow no other, in the order of joints, and begin with
 * the pose of the scene file. Thread-safety: any thread may use a robot, and calls exclude each
 * other; none may be in progress when it is closed. Robots are independent of each other. Errors: as in
 * fire3dv/client.h. Files are untrusted: limits are in docs/joints.md.
 */
#ifndef FIRE3DV_JOINTS_H
#define FIRE3DV_JOINTS_H

#include "fire3dv/client.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fire3dv_robot fire3dv_robot;

enum {
  FIRE3DV_JOINT_FIXED = 0,
  FIRE3DV_JOINT_REVOLUTE = 1,  /* about an axis; without limits: continuous */
  FIRE3DV_JOINT_PRISMATIC = 2, /* along an axis */
  FIRE3DV_JOINT_PLANAR = 3,    /* in the plane normal to the axis, and about the axis */
  FIRE3DV_JOINT_BALL = 4,      /* about the anchor */
  FIRE3DV_JOINT_FLOATING = 5
};

/* Flag of fire3dv_open_robot: joints that mimic others have positions of their own. */
enum { FIRE3DV_ROBOT_NO_MIMIC = 1 };

enum {
  FIRE3DV_POSITIONS_CLAMP = 1, /* clamp to the limits; without it, positions beyond the limits are valid */
  FIRE3DV_POSITIONS_WXYZ = 2   /* quaternions are w x y z, as in MuJoCo's qpos */
};

typedef struct fire3dv_joint {
  size_t struct_size;     /* sizeof(fire3dv_joint), set by the caller */
  const char* name;       /* unique; owned by the robot, as node */
  const char* node;       /* scene node that it moves */
  int32_t type;           /* FIRE3DV_JOINT_* */
  int32_t followed_joint; /* index of the joint that it mimics; -1: none */
  double multiplier;      /* position = multiplier * followed position + offset */
  double offset;
  size_t position_index; /* of its first number in the positions */
  size_t position_count; /* 0: fixed, or follows another joint */
  double axis[3];        /* unit vector in the node's frame; revolute, prismatic, planar */
  double anchor[3];      /* point of the node's frame that the joint turns about */
  int32_t has_limits;    /* revolute, prismatic */
  double lower;
  double upper;
} fire3dv_joint;

/* Reads a .glb or .gltf file with joints. flags: FIRE3DV_ROBOT_*. Returns NULL on error. */
FIRE3DV_API fire3dv_robot* fire3dv_open_robot(const char* file, uint32_t flags);

/* The same from memory; the bytes may be freed afterwards. */
FIRE3DV_API fire3dv_robot* fire3dv_read_robot(const void* bytes, size_t byte_count, uint32_t flags);

/* Frees the robot and sets *robot to NULL. Accepts NULL and a pointer to NULL. */
FIRE3DV_API void fire3dv_close_robot(fire3dv_robot** robot);

/* Counts of joints and of positions; 0 for NULL. */
FIRE3DV_API size_t fire3dv_joint_count(const fire3dv_robot* robot);
FIRE3DV_API size_t fire3dv_position_count(const fire3dv_robot* robot);

/* Fills *joint, whose struct_size is set. index: below fire3dv_joint_count. */
FIRE3DV_API int fire3dv_get_joint(const fire3dv_robot* robot, size_t index, fire3dv_joint* joint);

/* Sets all positions. count: fire3dv_position_count. flags: FIRE3DV_POSITIONS_*. Refuses numbers that are not
 * finite and quaternions without length; others are normalised. On error nothing changes. */
FIRE3DV_API int fire3dv_set_positions(fire3dv_robot* robot, const double* positions, size_t count,
                                      uint32_t flags);

/* Sets the positions of one joint. count: its position_count. Refuses a joint that follows another. */
FIRE3DV_API int fire3dv_set_joint(fire3dv_robot* robot, size_t index, const double* positions, size_t count,
                                  uint32_t flags);

/* Copies all positions. count: fire3dv_position_count. */
FIRE3DV_API int fire3dv_get_positions(const fire3dv_robot* robot, double* positions, size_t count);

/* Places the robot in the stream. stream_from_model: 12 doubles, row-major; NULL = identity. Bodies that
 * float, or that the description file places in its world, move with it, too. */
FIRE3DV_API int fire3dv_set_base(fire3dv_robot* robot, const double* stream_from_model);

/* Fills a description whose struct_size is set: node names, world_from_stream and scales. The arrays are the
 * robot's, and valid until it is closed. Other fields are unchanged. */
FIRE3DV_API int fire3dv_get_robot_description(const fire3dv_robot* robot, fire3dv_description* description);

/* Computes the poses of the description's nodes, 12 floats each. pose_count: its node_count. */
FIRE3DV_API int fire3dv_get_poses(fire3dv_robot* robot, float* stream_from_node, size_t pose_count);

/* Computes the pose of the body with this node name, in double precision: 12 doubles, row-major. */
FIRE3DV_API int fire3dv_get_node_pose(fire3dv_robot* robot, const char* node, double* stream_from_node);

/* Sets the joint positions as scalars (fire3dv/scalars.h) at this time, which renderers plot and recordings
 * contain. group: NULL = "joint_positions"; two robots of a stream need two. The first call declares it:
 * revolute joints by their names in rad, prismatic ones in m; planar NAME/x, NAME/y in m, NAME/angle in rad;
 * floating NAME/x, NAME/y, NAME/z in m. Quaternions, and joints that follow others, are left out. Without any
 * position it does nothing. FIRE3DV_ERROR_BUDGET: a stream has at most FIRE3DV_MAX_SCALARS scalars. */
FIRE3DV_API int fire3dv_set_joint_scalars(fire3dv_stream* stream, fire3dv_robot* robot, const char* group,
                                          int64_t sim_time_ns);

/* Publishes one frame with the poses of fire3dv_get_poses. The stream has the robot's description. flags:
 * FIRE3DV_FRAME_* bits. */
FIRE3DV_API int fire3dv_publish_robot(fire3dv_stream* stream, fire3dv_robot* robot, int64_t sim_time_ns,
                                      uint32_t flags);

#ifdef __cplusplus
}
#endif
#endif
