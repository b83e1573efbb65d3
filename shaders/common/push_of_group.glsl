// Parameters of a group's view or world. Several in one dispatch (kSeveralWorlds) have an array of records: the
// pushed address leads to it, and a row of groups, z or y, selects one.
#ifndef FIRE3DV_PUSH_OF_GROUP_GLSL
#define FIRE3DV_PUSH_OF_GROUP_GLSL
#include "common/scene_variant.glsl"

// Defines `push` and push_of_group(), which main() assigns to it. Push, Ref: the record, and the name of the
// reference to such records. address: the pushed member.
#define FIRE3DV_DEFINE_PUSH_OF_GROUP(Push, Ref, address, row) \
  layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Ref { Push at[]; }; \
  Push push; \
  Push push_of_group() { \
    Push own = pushed; \
    if (kSeveralWorlds) own = Ref(pushed.address).at[row]; \
    return own; \
  }

#endif
