// Colours of our videos, for libav: sRGB pixels as BT.709 with limited range.
#pragma once

#include "renderer/sinks/video/libav.h"

namespace fire3dv::sinks {

// Sets primaries, transfer function, matrix and range of an encoder whose images are converted by
// open_bt709_conversion().
inline void set_bt709(AVCodecContext& encoder) {
  encoder.color_primaries = AVCOL_PRI_BT709;
  encoder.color_trc = AVCOL_TRC_IEC61966_2_1;
  encoder.colorspace = AVCOL_SPC_BT709;
  encoder.color_range = AVCOL_RANGE_MPEG;
}

// Describes a frame as its encoder expects it.
inline void match_encoder(AVFrame& frame, const AVCodecContext& encoder) {
  frame.format = encoder.pix_fmt;
  frame.width = encoder.width;
  frame.height = encoder.height;
  frame.color_primaries = encoder.color_primaries;
  frame.color_trc = encoder.color_trc;
  frame.colorspace = encoder.colorspace;
  frame.color_range = encoder.color_range;
}

// Conversion from RGBA of the encoder's size to its pixel format. Null: libav has none. The caller frees it.
inline SwsContext* open_bt709_conversion(const Libav& av, const AVCodecContext& encoder, int flags) {
  SwsContext* const conversion =
      av.sws_getContext(encoder.width, encoder.height, AV_PIX_FMT_RGBA, encoder.width, encoder.height,
                        encoder.pix_fmt, flags, nullptr, nullptr, nullptr);
  if (!conversion || encoder.pix_fmt == AV_PIX_FMT_BGR0) return conversion;
  const int* const bt709 = av.sws_getCoefficients(SWS_CS_ITU709);
  constexpr int kOne = 1 << 16;
  if (av.sws_setColorspaceDetails(conversion, bt709, 1, bt709, 0, 0, kOne, kOne) >= 0) return conversion;
  av.sws_freeContext(conversion);
  return nullptr;
}

}  // namespace fire3dv::sinks
