// Binding numbers, for C++ and GLSL alike.
#ifndef FIRE3DV_SHARED_BINDINGS_H
#define FIRE3DV_SHARED_BINDINGS_H

// set 0: the scene
#define FIRE3DV_BINDING_TOP_LEVEL 0
#define FIRE3DV_BINDING_TEXTURES 1  // last, since its count varies

// set 1: the images of the post pass
#define FIRE3DV_BINDING_POST_HDR 0
#define FIRE3DV_BINDING_POST_OUT 1

#endif
