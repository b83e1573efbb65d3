// Exposure of an image: metered by light_meter_resolve.comp, or fixed.
#ifndef FIRE3DV_EXPOSURE_GLSL
#define FIRE3DV_EXPOSURE_GLSL

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer MeteredExposureRef { float value; };

// metered: address, or 0.
float image_exposure(uint64_t metered, float fixed_exposure) {
  return metered != 0ul ? MeteredExposureRef(metered).value : fixed_exposure;
}

#endif
