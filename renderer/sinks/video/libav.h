// Function table of libav (FFmpeg), loaded at run time when a video is opened. Linking libav would load about
// a hundred libraries and add a tenth of a second to every start. Only video_file.cpp and stream_encoder.cpp
// include this header.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/dict.h>
#include <libavutil/error.h>
#include <libavutil/frame.h>
#include <libavutil/log.h>
#include <libavutil/mathematics.h>
#include <libavutil/mem.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include "base/error.h"

namespace fire3dv::sinks {

// X(library, function)
#define FIRE3DV_LIBAV_FUNCTIONS(X)            \
  X(avcodec, avcodec_find_encoder_by_name)    \
  X(avcodec, avcodec_alloc_context3)          \
  X(avcodec, avcodec_free_context)            \
  X(avcodec, avcodec_open2)                   \
  X(avcodec, avcodec_parameters_from_context) \
  X(avcodec, avcodec_send_frame)              \
  X(avcodec, avcodec_receive_packet)          \
  X(avcodec, av_packet_alloc)                 \
  X(avcodec, av_packet_free)                  \
  X(avcodec, av_packet_rescale_ts)            \
  X(avcodec, av_packet_unref)                 \
  X(avformat, av_find_input_format)           \
  X(avformat, av_guess_format)                \
  X(avformat, avformat_alloc_context)         \
  X(avformat, avformat_close_input)           \
  X(avformat, avformat_free_context)          \
  X(avformat, avformat_new_stream)            \
  X(avformat, avformat_open_input)            \
  X(avformat, avformat_query_codec)           \
  X(avformat, avformat_write_header)          \
  X(avformat, av_interleaved_write_frame)     \
  X(avformat, av_write_trailer)               \
  X(avformat, avio_open)                      \
  X(avformat, avio_closep)                    \
  X(avutil, av_dict_free)                     \
  X(avutil, av_dict_get)                      \
  X(avutil, av_dict_set)                      \
  X(avutil, av_frame_alloc)                   \
  X(avutil, av_frame_free)                    \
  X(avutil, av_frame_get_buffer)              \
  X(avutil, av_frame_make_writable)           \
  X(avutil, av_log_set_level)                 \
  X(avutil, av_strdup)                        \
  X(avutil, av_strerror)                      \
  X(swscale, sws_getContext)                  \
  X(swscale, sws_freeContext)                 \
  X(swscale, sws_getCoefficients)             \
  X(swscale, sws_setColorspaceDetails)        \
  X(swscale, sws_scale)

struct Libav {
#define FIRE3DV_LIBAV_MEMBER(library, function) decltype(&::function) function = nullptr;
  FIRE3DV_LIBAV_FUNCTIONS(FIRE3DV_LIBAV_MEMBER)
#undef FIRE3DV_LIBAV_MEMBER
};

// Process-wide table, loaded at the first call. The error names the missing library and its package.
Result<const Libav*> libav();

}  // namespace fire3dv::sinks
