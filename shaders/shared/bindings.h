// Binding numbers, for C++ and GLSL alike.
#ifndef FIRE3DV_SHARED_BINDINGS_H
#define FIRE3DV_SHARED_BINDINGS_H

// set 0: the scene
#define FIRE3DV_BINDING_TOP_LEVEL 0
#define FIRE3DV_BINDING_TEXTURES 1  // last, since its count varies

// set 0 of an image filter
#define FIRE3DV_BINDING_FILTER_IN 0
#define FIRE3DV_BINDING_FILTER_OUT 1

// set 1: a frame's images
#define FIRE3DV_BINDING_DISPLAY 0

#endif
