// Draw settings of a camera's optics and sensor, between the light of the scene and the pixels of `color`,
// and of the lamps beside its lens. Formulas and sources: docs/endoscope.md. With the initial values there
// are no passes, no lamps, and the image is that of a plain camera.
#pragma once

#include <cstdint>

namespace fire3dv::settings {

struct OpticsSettings {
  float vignette = 0;  // exponent of the cosine of the angle off the axis; 0: none
  // Content mask: a disc around the image's centre, black outside. In halves of the image's height.
  float mask_radius = 0;  // 0: no mask
  float mask_cut = 0;     // the disc ends this far above and below the centre; 0: it is whole
  float aberration = 0;  // lateral colour: red is 1 + aberration times as large as green, blue 1 - aberration
  float response = 0;    // exponent of the response curve is 1 / response; 0: tone mapping and sRGB
  // Condensation on the window before the lens.
  float fog = 0;           // share of the window that is fogged, 0 to 1
  float fog_blur_deg = 4;  // standard deviation of the blur
  float fog_veil = 0.2f;   // share of fogged light that is spread over all of the image
  float drops = 0;         // share of the window under drops
  float drop_size_deg = 8;
  // Sensor, after EMVA 1288. Electrons; exposed light of 1 fills the well.
  float full_well = 0;    // 0: no noise
  float read_noise = 4;   // standard deviation in the dark, of a frame
  float dark_signal = 0;  // mean in the dark
  float prnu_percent = 0.5f;
  float dsnu = 2;
  uint32_t noise_seed = 0;  // of noise, fixed patterns and drops

  bool condenses() const { return fog > 0 || drops > 0; }
  bool any() const {
    return vignette > 0 || mask_radius > 0 || aberration != 0 || response > 0 || condenses() || full_well > 0;
  }
  bool operator==(const OpticsSettings&) const = default;
};

// Lamps in a ring around the lens, fixed to the camera: radiant intensity times exp(-spread * (1 - cos)) of
// the angle off the view direction (Modrzejewski et al. 2020).
struct LampSettings {
  uint32_t count = 0;
  float intensity_cd = 1;  // of each, ahead
  float spread = 2.767f;
  float offset_mm = 3.8f;  // from the optical axis
  bool operator==(const LampSettings&) const = default;
};

}  // namespace fire3dv::settings
