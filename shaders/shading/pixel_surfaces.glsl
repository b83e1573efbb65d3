// Shared list of the distinct surfaces of a workgroup's 8 x 8 pixels; edge pixels show several. Lanes process
// list entries, so a subgroup does not iterate as often as its richest pixel. Only for 4 samples; with one
// sample a pixel shows one surface.
#ifndef FIRE3DV_PIXEL_SURFACES_GLSL
#define FIRE3DV_PIXEL_SURFACES_GLSL
#include "common/pixel_ids.glsl"

const uint kPixels = 64;

struct PixelSurface {
  uint id;       // 0: background
  uint lane;     // lane of the pixel
  uint samples;  // bit mask; 0: outside of the image
};

#if FIRE3DV_SAMPLES == 4
// A pixel's first surface has its lane's index, which keeps neighbours together; further surfaces follow.
shared uvec2 surface_list[4 * kPixels];
shared uint further_surfaces;

// List indices of this lane's pixel: the first at its lane, `count` - 1 from `further`.
struct OwnSurfaces {
  uint count;
  uint further;
};

// All lanes must call it.
OwnSurfaces list_surfaces(GlobalsRef globals, uint64_t visibility, uint pixel, bool inside) {
  const uint lane = gl_LocalInvocationIndex;
  if (lane == 0) further_surfaces = 0;
  barrier();
  OwnSurfaces own = OwnSurfaces(0, 0);
  uint samples[4], ids[4];
  if (inside) {
    const PixelIds all = pixel_ids(globals, visibility, pixel);
    uint open = kAllSamples;
    for (int i = 0; i < 4; ++i) {
      if (open == 0) break;
      ids[i] = id_of_sample(all, findLSB(open));
      samples[i] = samples_with(all, ids[i]);
      open &= ~samples[i];
      ++own.count;
    }
  }
  surface_list[lane] = own.count > 0 ? uvec2(ids[0], lane | samples[0] << 8) : uvec2(0);
  if (own.count > 1) {
    own.further = kPixels + atomicAdd(further_surfaces, own.count - 1);
    for (int i = 1; i < 4; ++i) {
      if (i < own.count) surface_list[own.further + i - 1] = uvec2(ids[i], lane | samples[i] << 8);
    }
  }
  barrier();
  return own;
}

uint surface_count() { return kPixels + further_surfaces; }

PixelSurface surface_at(uint slot) {
  const uvec2 entry = surface_list[slot];
  return PixelSurface(entry.x, entry.y & 255, entry.y >> 8);
}
#endif

#endif
