// Buffers of depth of field.
#ifndef FIRE3DV_DEPTH_OF_FIELD_GLSL
#define FIRE3DV_DEPTH_OF_FIELD_GLSL
#include "common/buffers.glsl"
#include "shared/bindings.h"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer BlurTexelRef { BlurTexel at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer BlurTexelOut { BlurTexel at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer BlurTileRef { BlurTile at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer BlurTileOut { BlurTile at[]; };

const float kSharpRadius = 0.5;  // of discs that cover one pixel

#endif
