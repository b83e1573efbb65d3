#include "renderer/sinks/video/video_file.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "base/files.h"
#include "renderer/sinks/video/bt709.h"
#include "renderer/sinks/video/libav.h"

namespace fire3dv::sinks {
namespace {

constexpr const char* kGray12 = "h265 with 12-bit grey";

// Encoders of each codec in order of preference.
struct Encoder {
  const char* codec;
  const char* name;
  const char* quality;  // option for constant quality; null: lossless
  const char* usual_quality;
  int max_quality;
  uint32_t least_side;  // minimum size in pixels
  const char* options;  // name=value, separated by commas
};
constexpr std::array kEncoders{
    Encoder{"h264", "libx264", "crf", "18", 51, 1, "preset=medium"},
    Encoder{"h265", "libx265", "crf", "20", 51, 1,
            "preset=medium,x265-params=log-level=error:frame-threads=4:pools=8:info=0"},
    Encoder{kGray12, "libx265", nullptr, nullptr, 0, 16,
            "preset=medium,x265-params=lossless=1:log-level=error:frame-threads=4:pools=8:info=0"},
    Encoder{"av1", "libsvtav1", "crf", "26", 63, 64, "preset=8"},
    Encoder{"av1", "libaom-av1", "crf", "26", 63, 1, "cpu-used=6,row-mt=1"},
    Encoder{"ffv1", "ffv1", nullptr, nullptr, 0, 1, "level=3,slicecrc=1"},
};

std::string codec_of(const VideoSettings& settings) {
  if (settings.is_gray12) return kGray12;
  if (!settings.codec.empty()) return settings.codec;
  return lower_extension(settings.path) == ".webm" ? "av1" : "h264";
}

const char* container_of(const std::filesystem::path& path) {
  const std::string ending = lower_extension(path);
  return ending == ".mp4" ? "mp4" : ending == ".webm" ? "webm" : "matroska";
}

struct Chosen {
  const Encoder* encoder;
  const AVCodec* codec;
  const AVOutputFormat* format;
};

Result<Chosen> choose(const Libav& av, const VideoSettings& settings) {
  const std::string wanted = codec_of(settings);
  const AVOutputFormat* const format = av.av_guess_format(container_of(settings.path), nullptr, nullptr);
  if (!format)
    return Error{"the libav of this system writes no " + lower_extension(settings.path) + " files"};
  std::string there;
  for (const Encoder& encoder : kEncoders) {
    const AVCodec* const codec = av.avcodec_find_encoder_by_name(encoder.name);
    const bool too_small =
        settings.width != 0 && std::min(settings.width, settings.height) < encoder.least_side;
    if (!codec || too_small || av.avformat_query_codec(format, codec->id, FF_COMPLIANCE_NORMAL) != 1)
      continue;
    if (wanted == encoder.codec) return Chosen{&encoder, codec, format};
    if (std::string_view(encoder.codec) != kGray12 && there.find(encoder.codec) == std::string::npos)
      there += (there.empty() ? "" : ", ") + std::string(encoder.codec);
  }
  return Error{"codec " + wanted + " is not available for " + lower_extension(settings.path) +
               " files here; these are: " + (there.empty() ? "none" : there)};
}

Result<void> check_quality(const VideoSettings& settings, const Encoder& encoder) {
  if (!settings.crf) return {};
  if (!encoder.quality)
    return Error{"codec " + std::string(encoder.codec) + " loses nothing and takes no --crf"};
  if (*settings.crf < 0 || *settings.crf > encoder.max_quality)
    return Error{"--crf must be from 0 to " + std::to_string(encoder.max_quality) + " with codec " +
                 encoder.codec};
  return {};
}

// Its own options have a minimum interval, and frames that refer to earlier groups.
void add_x265_interval(const Libav& av, int frames, AVDictionary** options) {
  const AVDictionaryEntry* const before = av.av_dict_get(*options, "x265-params", nullptr, 0);
  const std::string number = std::to_string(frames);
  const std::string text = std::string(before ? before->value : "") + ":keyint=" + number +
                           ":min-keyint=" + number + ":open-gop=0:bframes=0";
  av.av_dict_set(options, "x265-params", text.c_str(), 0);
}

}  // namespace

bool is_video_name(const std::filesystem::path& path) {
  const std::string ending = lower_extension(path);
  return ending == ".mp4" || ending == ".mkv" || ending == ".webm";
}

bool is_foreign_video_name(const std::filesystem::path& path) {
  constexpr std::array kForeign{".avi",  ".mov", ".gif", ".m4v", ".mpg",
                                ".mpeg", ".ts",  ".wmv", ".flv", ".ogv"};
  const std::string ending = lower_extension(path);
  return std::any_of(kForeign.begin(), kForeign.end(),
                     [&](const char* foreign) { return ending == foreign; });
}

Result<std::string> read_video_comment(const std::filesystem::path& path) {
  const auto av = libav();
  if (!av) return av.error();
  std::error_code fault;
  if (!std::filesystem::is_regular_file(path, fault))
    return Error{"cannot read " + path.string() + ": no regular file"};
  (*av)->av_log_set_level(AV_LOG_FATAL);
  // One reader alone, so that no other format can name further files.
  const AVInputFormat* const reader =
      (*av)->av_find_input_format(container_of(path) == std::string_view("mp4") ? "mov" : "matroska");
  AVFormatContext* file = nullptr;
  if (!reader || (*av)->avformat_open_input(&file, ("file:" + path.string()).c_str(), reader, nullptr) < 0)
    return Error{"cannot read " + path.string() + ": it is no video of its ending"};
  const AVDictionaryEntry* const entry = (*av)->av_dict_get(file->metadata, "comment", nullptr, 0);
  std::string comment = entry ? entry->value : "";
  (*av)->avformat_close_input(&file);
  return comment;
}

struct VideoFile::Impl {
  const Libav& av;
  VideoSettings settings;
  std::optional<base::AtomicFile> output;
  AVFormatContext* format = nullptr;
  AVCodecContext* encoder = nullptr;
  AVStream* stream = nullptr;
  AVFrame* frame = nullptr;
  AVPacket* packet = nullptr;
  SwsContext* conversion = nullptr;
  bool file_open = false, finished = false;
  uint64_t frames = 0;

  Impl(const Libav& functions, VideoSettings wanted) : av(functions), settings(std::move(wanted)) {}

  ~Impl() {
    if (packet) av.av_packet_free(&packet);
    if (frame) av.av_frame_free(&frame);
    if (encoder) av.avcodec_free_context(&encoder);
    if (conversion) av.sws_freeContext(conversion);
    if (format && file_open) av.avio_closep(&format->pb);
    if (format) av.avformat_free_context(format);
  }

  Error failed(const std::string& what, int code) const {
    char reason[AV_ERROR_MAX_STRING_SIZE] = "";
    av.av_strerror(code, reason, sizeof reason);
    // libav codes system errors as negated errno.
    const bool of_system = code > -4096;
    return Error{"cannot " + what + " " + settings.path.string() + ": " +
                 (of_system ? system_reason(-code) : reason)};
  }

  Result<void> open(const Chosen& chosen);
  Result<void> open_encoder(const Chosen& chosen);
  Result<void> open_conversion();
  Result<void> begin_frame();   // the frame can be filled
  Result<void> encode_frame();  // after begin_frame()
  Result<void> write_packets();
};

Result<void> VideoFile::Impl::open_encoder(const Chosen& chosen) {
  encoder = av.avcodec_alloc_context3(chosen.codec);
  if (!encoder) return Error{"there is no memory left for the video"};
  const bool is_gray = settings.is_gray12, keeps_rgb = chosen.encoder->quality == nullptr && !is_gray;
  encoder->width = static_cast<int>(settings.width);
  encoder->height = static_cast<int>(settings.height);
  encoder->time_base = {static_cast<int>(settings.fps_denominator), static_cast<int>(settings.fps_numerator)};
  encoder->framerate = {encoder->time_base.den, encoder->time_base.num};
  encoder->pix_fmt = keeps_rgb              ? AV_PIX_FMT_BGR0
                     : is_gray              ? AV_PIX_FMT_GRAY12LE
                     : settings.full_chroma ? AV_PIX_FMT_YUV444P
                                            : AV_PIX_FMT_YUV420P;
  set_bt709(*encoder);
  if (keeps_rgb) {
    encoder->colorspace = AVCOL_SPC_RGB;
    encoder->color_range = AVCOL_RANGE_JPEG;
  }
  if (is_gray) {  // numbers, no colours
    encoder->color_primaries = AVCOL_PRI_UNSPECIFIED;
    encoder->color_trc = AVCOL_TRC_UNSPECIFIED;
    encoder->colorspace = AVCOL_SPC_UNSPECIFIED;
    encoder->color_range = AVCOL_RANGE_JPEG;
  } else {
    encoder->chroma_sample_location = AVCHROMA_LOC_LEFT;
  }
  if (settings.key_frame_interval) {
    encoder->gop_size = *settings.key_frame_interval;
    encoder->max_b_frames = 0;
  }
  encoder->sample_aspect_ratio = {1, 1};
  encoder->flags |= AV_CODEC_FLAG_BITEXACT;  // no version strings: the same frames give the same bytes
  if (format->oformat->flags & AVFMT_GLOBALHEADER) encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  // Fixed thread count: encoders partition their work by it, and the same frames must give the same bytes on
  // every machine. FFV1 is partitioned into slices.
  constexpr int kThreads = 8;
  encoder->thread_count = keeps_rgb ? 0 : kThreads;
  if (keeps_rgb) encoder->slices = std::min(settings.width, settings.height) >= 64 ? 16 : 1;
  // Apple players require this tag for H.265 in MP4.
  if (chosen.codec->id == AV_CODEC_ID_HEVC && container_of(settings.path) == std::string_view("mp4"))
    encoder->codec_tag = MKTAG('h', 'v', 'c', '1');

  AVDictionary* options = nullptr;
  const std::string text = chosen.encoder->options;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find(',', at), text.size()), equals = text.find('=', at);
    av.av_dict_set(&options, text.substr(at, equals - at).c_str(),
                   text.substr(equals + 1, end - equals - 1).c_str(), 0);
    at = end + 1;
  }
  if (settings.key_frame_interval && chosen.codec->id == AV_CODEC_ID_HEVC)
    add_x265_interval(av, *settings.key_frame_interval, &options);
  if (chosen.encoder->quality) {
    const std::string quality = settings.crf ? std::to_string(*settings.crf) : chosen.encoder->usual_quality;
    av.av_dict_set(&options, chosen.encoder->quality, quality.c_str(), 0);
  }
  const int opened = av.avcodec_open2(encoder, chosen.codec, &options);
  av.av_dict_free(&options);
  if (opened < 0) return failed("begin the encoding of", opened);
  return {};
}

Result<void> VideoFile::Impl::open_conversion() {
  constexpr int kExact =
      SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP | SWS_BITEXACT;
  conversion = open_bt709_conversion(av, *encoder, kExact);
  if (conversion) return {};
  return Error{"the libav of this system cannot convert images of " + std::to_string(encoder->width) + "x" +
               std::to_string(encoder->height) + " for a video"};
}

Result<void> VideoFile::Impl::open(const Chosen& chosen) {
  const uint32_t max_side = 16'384;
  if (settings.width == 0 || settings.height == 0 || settings.width > max_side || settings.height > max_side)
    return Error{"a video has sides of 1 to " + std::to_string(max_side) + " pixels"};
  const bool halved = chosen.encoder->quality && !settings.full_chroma;
  if (halved && (settings.width % 2 != 0 || settings.height % 2 != 0))
    return Error{"a " + std::string(chosen.encoder->codec) +
                 " video has an even number of pixels on each side, not " + std::to_string(settings.width) +
                 "x" + std::to_string(settings.height) + ": choose another --size, or --codec ffv1"};
  av.av_log_set_level(AV_LOG_ERROR);
  setenv("SVT_LOG", "1", 0);  // silences the banner of SVT-AV1
  format = av.avformat_alloc_context();
  frame = av.av_frame_alloc();
  packet = av.av_packet_alloc();
  if (!format || !frame || !packet) return Error{"there is no memory left for the video"};
  format->oformat = chosen.format;
  format->flags |= AVFMT_FLAG_BITEXACT;
  if (auto opened = open_encoder(chosen); !opened) return opened;
  if (!settings.is_gray12) {
    if (auto opened = open_conversion(); !opened) return opened;
  }
  stream = av.avformat_new_stream(format, nullptr);
  if (!stream) return Error{"there is no memory left for the video"};
  if (const int done = av.avcodec_parameters_from_context(stream->codecpar, encoder); done < 0)
    return failed("describe", done);
  stream->time_base = encoder->time_base;
  stream->avg_frame_rate = encoder->framerate;
  match_encoder(*frame, *encoder);
  if (const int done = av.av_frame_get_buffer(frame, 0); done < 0) return failed("take memory for", done);
  base::remove_abandoned_temporaries(settings.path.parent_path(), settings.path.filename().string());
  Result<base::AtomicFile> created = base::AtomicFile::create(settings.path);
  if (!created) return created.error();
  output.emplace(std::move(*created));
  // The "file:" scheme prevents libav from parsing a path as a URL.
  const std::string url = "file:" + output->temporary_path();
  format->url = av.av_strdup(url.c_str());  // some containers reopen the file to read it
  if (const int done = av.avio_open(&format->pb, url.c_str(), AVIO_FLAG_WRITE); done < 0)
    return failed("write", done);
  file_open = true;
  if (!settings.comment.empty()) av.av_dict_set(&format->metadata, "comment", settings.comment.c_str(), 0);
  AVDictionary* options = nullptr;
  if (container_of(settings.path) == std::string_view("mp4"))
    av.av_dict_set(&options, "movflags", "faststart", 0);  // for progressive playback
  const int begun = av.avformat_write_header(format, &options);
  av.av_dict_free(&options);
  if (begun < 0) return failed("write", begun);
  return {};
}

Result<void> VideoFile::Impl::write_packets() {
  for (;;) {
    const int got = av.avcodec_receive_packet(encoder, packet);
    if (got == AVERROR(EAGAIN) || got == AVERROR_EOF) return {};
    if (got < 0) return failed("encode", got);
    packet->stream_index = stream->index;
    if (packet->duration == 0) packet->duration = 1;
    av.av_packet_rescale_ts(packet, encoder->time_base, stream->time_base);
    const int written = av.av_interleaved_write_frame(format, packet);
    if (written < 0) return failed("write", written);
  }
}

Result<void> VideoFile::Impl::begin_frame() {
  FIRE3DV_ASSERT(!finished);
  // The encoder may hold a reference to the previous frame.
  if (const int done = av.av_frame_make_writable(frame); done < 0) return failed("take memory for", done);
  return {};
}

Result<void> VideoFile::Impl::encode_frame() {
  frame->pts = static_cast<int64_t>(frames++);
  if (const int sent = av.avcodec_send_frame(encoder, frame); sent < 0) return failed("encode", sent);
  return write_packets();
}

Result<void> check_video_settings(const VideoSettings& settings) {
  const auto av = libav();
  if (!av) return av.error();
  const auto chosen = choose(**av, settings);
  if (!chosen) return chosen.error();
  if (auto good = check_quality(settings, *chosen->encoder); !good) return good;
  if (settings.is_gray12) {
    VideoFile::Impl trial(**av, settings);
    trial.format = (*av)->avformat_alloc_context();
    if (!trial.format) return Error{"there is no memory left for the video"};
    trial.format->oformat = chosen->format;
    if (!trial.open_encoder(*chosen))
      return Error{"the H.265 encoder of this system (x265) takes no grey of 12 bits"};
  }
  std::error_code fault;
  if (std::filesystem::is_directory(settings.path, fault))
    return Error{settings.path.string() +
                 " is a folder, and a video is a file: name another, or remove the folder"};
  // Matroska time stamps have millisecond resolution.
  if (container_of(settings.path) != std::string_view("mp4") &&
      settings.fps_numerator > 1000 * settings.fps_denominator)
    return Error{"a " + lower_extension(settings.path) +
                 " video has at most 1000 frames a second: choose a lower --fps, or .mp4"};
  return {};
}

VideoFile::VideoFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VideoFile::~VideoFile() = default;

uint64_t VideoFile::frames() const {
  return impl_->frames;
}

Result<std::unique_ptr<VideoFile>> VideoFile::open(const VideoSettings& settings) {
  const auto av = libav();
  if (!av) return av.error();
  const auto chosen = choose(**av, settings);
  if (!chosen) return chosen.error();
  if (auto good = check_quality(settings, *chosen->encoder); !good) return good.error();
  auto impl = std::make_unique<Impl>(**av, settings);
  if (auto opened = impl->open(*chosen); !opened) return opened.error();
  return std::unique_ptr<VideoFile>(new VideoFile(std::move(impl)));
}

Result<void> VideoFile::add_gray12(std::span<const uint16_t> values) {
  Impl& it = *impl_;
  const size_t width = it.settings.width, height = it.settings.height;
  FIRE3DV_ASSERT(it.settings.is_gray12 && values.size() == width * height);
  if (auto ready = it.begin_frame(); !ready) return ready;
  for (size_t y = 0; y < height; ++y)
    std::memcpy(it.frame->data[0] + static_cast<ptrdiff_t>(y) * it.frame->linesize[0],
                values.data() + y * width, width * sizeof(uint16_t));
  return it.encode_frame();
}

Result<void> VideoFile::add(std::span<const uint8_t> rgba8) {
  Impl& it = *impl_;
  FIRE3DV_ASSERT(!it.settings.is_gray12 &&
                 rgba8.size() == size_t{4} * it.settings.width * it.settings.height);
  if (auto ready = it.begin_frame(); !ready) return ready;
  const uint8_t* const rows[] = {rgba8.data()};
  const int strides[] = {static_cast<int>(4 * it.settings.width)};
  it.av.sws_scale(it.conversion, rows, strides, 0, it.encoder->height, it.frame->data, it.frame->linesize);
  return it.encode_frame();
}

Result<void> VideoFile::finish() {
  Impl& it = *impl_;
  FIRE3DV_ASSERT(!it.finished);
  if (const int sent = it.av.avcodec_send_frame(it.encoder, nullptr); sent < 0)
    return it.failed("encode", sent);
  if (auto written = it.write_packets(); !written) return written;
  if (const int ended = it.av.av_write_trailer(it.format); ended < 0) return it.failed("write", ended);
  if (const int closed = it.av.avio_closep(&it.format->pb); closed < 0) return it.failed("write", closed);
  if (auto committed = it.output->commit(); !committed) return committed;
  it.finished = true;
  return {};
}

}  // namespace fire3dv::sinks
