#include "renderer/sinks/video/stream_encoder.h"

#include <algorithm>
#include <string>

#include "base/error.h"
#include "renderer/sinks/video/bt709.h"
#include "renderer/sinks/video/libav.h"

namespace fire3dv::sinks {
namespace {

constexpr int64_t kMaxVp8BitsPerSecond = 40'000'000;

}  // namespace

struct StreamEncoder::Impl {
  const Libav& av;
  Codec kind;
  uint32_t width, height;
  int crf;
  AVCodecContext* encoder = nullptr;
  AVFrame* frame = nullptr;
  AVPacket* packet = nullptr;
  SwsContext* conversion = nullptr;
  int64_t frames = 0;

  ~Impl() {
    if (packet) av.av_packet_free(&packet);
    if (frame) av.av_frame_free(&frame);
    if (encoder) av.avcodec_free_context(&encoder);
    if (conversion) av.sws_freeContext(conversion);
  }

  bool open(const AVCodec* codec);
};

bool StreamEncoder::Impl::open(const AVCodec* codec) {
  encoder = av.avcodec_alloc_context3(codec);
  frame = av.av_frame_alloc();
  packet = av.av_packet_alloc();
  if (!encoder || !frame || !packet) return false;
  encoder->width = static_cast<int>(width);
  encoder->height = static_cast<int>(height);
  encoder->time_base = {1, 30};  // of the rate control; viewers show a frame when it comes
  encoder->framerate = {30, 1};
  encoder->pix_fmt = AV_PIX_FMT_YUV420P;
  set_bt709(*encoder);
  encoder->gop_size = 600;  // the connection loses nothing
  encoder->max_b_frames = 0;
  encoder->thread_count = 1;
  AVDictionary* options = nullptr;
  const auto set = [&](const char* name, const std::string& value) {
    av.av_dict_set(&options, name, value.c_str(), 0);
  };
  if (kind == Codec::h264) {
    set("preset", "superfast");
    set("tune", "zerolatency");
    set("profile", "baseline");
    set("crf", std::to_string(crf));
  } else {
    encoder->bit_rate = kMaxVp8BitsPerSecond;  // its quality is an upper limit, too
    set("deadline", "realtime");
    set("cpu-used", "8");
    set("lag-in-frames", "0");
    set("auto-alt-ref", "0");
    set("crf", std::to_string(std::clamp(2 * crf - 30, 4, 63)));
  }
  const int opened = av.avcodec_open2(encoder, codec, &options);
  av.av_dict_free(&options);
  if (opened < 0) return false;
  match_encoder(*frame, *encoder);
  conversion = open_bt709_conversion(av, *encoder, SWS_BILINEAR);
  return conversion && av.av_frame_get_buffer(frame, 0) >= 0;
}

StreamEncoder::StreamEncoder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
StreamEncoder::~StreamEncoder() = default;

uint32_t StreamEncoder::width() const {
  return impl_->width;
}

uint32_t StreamEncoder::height() const {
  return impl_->height;
}

int StreamEncoder::crf() const {
  return impl_->crf;
}

StreamEncoder::Codec StreamEncoder::codec() const {
  return impl_->kind;
}

std::unique_ptr<StreamEncoder> StreamEncoder::open(Codec kind, uint32_t width, uint32_t height, int crf) {
  FIRE3DV_ASSERT(width > 0 && height > 0 && width % 2 == 0 && height % 2 == 0);
  const Result<const Libav*> av = libav();
  if (!av) return nullptr;
  (*av)->av_log_set_level(AV_LOG_ERROR);
  const AVCodec* const codec =
      (*av)->avcodec_find_encoder_by_name(kind == Codec::h264 ? "libx264" : "libvpx");
  if (!codec) return nullptr;
  std::unique_ptr<Impl> impl(new Impl{**av, kind, width, height, crf});
  if (!impl->open(codec)) return nullptr;
  return std::unique_ptr<StreamEncoder>(new StreamEncoder(std::move(impl)));
}

bool StreamEncoder::append(std::span<const uint8_t> rgba8, std::vector<uint8_t>& stream, bool& is_key) {
  Impl& it = *impl_;
  FIRE3DV_ASSERT(rgba8.size() == size_t{4} * it.width * it.height);
  if (it.av.av_frame_make_writable(it.frame) < 0) return false;
  const uint8_t* const rows[] = {rgba8.data()};
  const int strides[] = {static_cast<int>(4 * it.width)};
  it.av.sws_scale(it.conversion, rows, strides, 0, it.encoder->height, it.frame->data, it.frame->linesize);
  it.frame->pts = it.frames++;
  if (it.av.avcodec_send_frame(it.encoder, it.frame) < 0) return false;
  // Without look-ahead each frame comes out at once.
  if (it.av.avcodec_receive_packet(it.encoder, it.packet) < 0) return false;
  stream.insert(stream.end(), it.packet->data, it.packet->data + it.packet->size);
  is_key = (it.packet->flags & AV_PKT_FLAG_KEY) != 0;
  it.av.av_packet_unref(it.packet);
  return true;
}

}  // namespace fire3dv::sinks
