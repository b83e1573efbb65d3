// Test of the video sink against libav's decoders: lossless codecs bit for bit, lossy ones within limits, and
// colour tags.
#include "renderer/sinks/video/video_file.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "renderer/sinks/video/video_sink.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}

// x265 3.5 leaks a copy of its options per encoder; leaks of this project are still reported.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libx265";
}

namespace fire3dv::sinks {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kWidth = 64, kHeight = 64;
constexpr uint64_t kFrames = 10;

// Smooth colour gradients: 4:2:0 subsampling blurs edges with any encoder.
std::vector<uint8_t> ramp(uint64_t frame) {
  std::vector<uint8_t> rgba;
  for (uint32_t y = 0; y < kHeight; ++y) {
    for (uint32_t x = 0; x < kWidth; ++x) {
      rgba.push_back(static_cast<uint8_t>(40 + 3 * x));
      rgba.push_back(static_cast<uint8_t>(30 + 3 * y));
      rgba.push_back(static_cast<uint8_t>(200 - x - y + 2 * frame));
      rgba.push_back(255);
    }
  }
  return rgba;
}

struct Decoded {
  std::vector<std::vector<uint8_t>> frames;  // RGBA
  AVColorPrimaries primaries{};
  AVColorTransferCharacteristic transfer{};
  AVColorSpace matrix{};
  AVColorRange range{};
  AVRational rate{};
  AVCodecID codec{};
};

Decoded decode(const fs::path& path) {
  Decoded result;
  AVFormatContext* format = nullptr;
  EXPECT_EQ(avformat_open_input(&format, path.c_str(), nullptr, nullptr), 0);
  if (!format) return result;
  EXPECT_GE(avformat_find_stream_info(format, nullptr), 0);
  const AVCodecParameters* const about = format->streams[0]->codecpar;
  result.primaries = about->color_primaries;
  result.transfer = about->color_trc;
  result.matrix = about->color_space;
  result.range = about->color_range;
  result.rate = format->streams[0]->avg_frame_rate;
  result.codec = about->codec_id;
  AVCodecContext* decoder = avcodec_alloc_context3(avcodec_find_decoder(about->codec_id));
  avcodec_parameters_to_context(decoder, about);
  EXPECT_EQ(avcodec_open2(decoder, nullptr, nullptr), 0);
  AVPacket* packet = av_packet_alloc();
  AVFrame* frame = av_frame_alloc();
  const auto take = [&] {
    while (avcodec_receive_frame(decoder, frame) == 0) {
      SwsContext* to_rgb = sws_getContext(
          frame->width, frame->height, static_cast<AVPixelFormat>(frame->format), frame->width, frame->height,
          AV_PIX_FMT_RGBA, SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT, nullptr, nullptr, nullptr);
      const int* const bt709 = sws_getCoefficients(SWS_CS_ITU709);
      sws_setColorspaceDetails(to_rgb, bt709, frame->color_range == AVCOL_RANGE_JPEG, bt709, 1, 0, 1 << 16,
                               1 << 16);
      std::vector<uint8_t>& rgba = result.frames.emplace_back(size_t{4} * frame->width * frame->height);
      uint8_t* rows[] = {rgba.data()};
      const int strides[] = {4 * frame->width};
      sws_scale(to_rgb, frame->data, frame->linesize, 0, frame->height, rows, strides);
      sws_freeContext(to_rgb);
    }
  };
  while (av_read_frame(format, packet) == 0) {
    avcodec_send_packet(decoder, packet);
    av_packet_unref(packet);
    take();
  }
  avcodec_send_packet(decoder, nullptr);
  take();
  av_frame_free(&frame);
  av_packet_free(&packet);
  avcodec_free_context(&decoder);
  avformat_close_input(&format);
  return result;
}

double mean_error(const Decoded& decoded) {
  double sum = 0;
  for (uint64_t frame = 0; frame < decoded.frames.size(); ++frame) {
    const std::vector<uint8_t> wanted = ramp(frame);
    for (size_t i = 0; i < wanted.size(); ++i)
      sum += std::abs(int{decoded.frames[frame][i]} - int{wanted[i]});
  }
  return sum / static_cast<double>(decoded.frames.size() * kWidth * kHeight * 3);
}

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class Video : public ::testing::Test {
 protected:
  Video() {
    std::string name = (fs::temp_directory_path() / "fire3dv-video-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  ~Video() override { fs::remove_all(folder_); }

  VideoSettings settings(const char* name) {
    VideoSettings settings;
    settings.path = folder_ / name;
    settings.width = kWidth;
    settings.height = kHeight;
    settings.fps_numerator = 30000;
    settings.fps_denominator = 1001;
    return settings;
  }
  Decoded encoded(const VideoSettings& settings) {
    auto file = VideoFile::open(settings);
    EXPECT_TRUE(file.ok()) << (file.ok() ? "" : file.error().message);
    if (!file) return {};
    for (uint64_t frame = 0; frame < kFrames; ++frame) EXPECT_TRUE((*file)->add(ramp(frame)).ok());
    EXPECT_FALSE(fs::exists(settings.path));  // not before it is complete
    const auto finished = (*file)->finish();
    EXPECT_TRUE(finished.ok()) << (finished.ok() ? "" : finished.error().message);
    return decode(settings.path);
  }
  std::string refused(const VideoSettings& settings) {
    const auto file = VideoFile::open(settings);
    return file ? "" : file.error().message;
  }
  size_t files() { return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), {})); }

  fs::path folder_;
};

TEST_F(Video, LosslessIsEveryPixel) {
  VideoSettings lossless = settings("ramp.mkv");
  lossless.codec = "ffv1";
  const Decoded decoded = encoded(lossless);
  ASSERT_EQ(decoded.frames.size(), kFrames);
  EXPECT_EQ(decoded.codec, AV_CODEC_ID_FFV1);
  for (uint64_t frame = 0; frame < kFrames; ++frame) EXPECT_EQ(decoded.frames[frame], ramp(frame)) << frame;
}

TEST_F(Video, DefaultVideoIsClose) {
  const Decoded decoded = encoded(settings("ramp.mp4"));
  ASSERT_EQ(decoded.frames.size(), kFrames);
  EXPECT_EQ(decoded.codec, AV_CODEC_ID_H264);
  EXPECT_LT(mean_error(decoded), 1.5);
  EXPECT_EQ(decoded.matrix, AVCOL_SPC_BT709);
  EXPECT_EQ(decoded.primaries, AVCOL_PRI_BT709);
  EXPECT_EQ(decoded.transfer, AVCOL_TRC_IEC61966_2_1);
  EXPECT_EQ(decoded.range, AVCOL_RANGE_MPEG);
  EXPECT_EQ(decoded.rate.num, 30000);
  EXPECT_EQ(decoded.rate.den, 1001);
}

// The remaining error is the rounding to YUV.
TEST_F(Video, QualityAndChromaAreApplied) {
  VideoSettings best = settings("best.mkv");
  best.crf = 0;
  best.full_chroma = true;
  EXPECT_LT(mean_error(encoded(best)), 0.6);
  VideoSettings poor = settings("poor.mkv");
  poor.crf = 45;
  EXPECT_GT(mean_error(encoded(poor)), 1.5);
  EXPECT_LT(fs::file_size(poor.path), fs::file_size(best.path) / 2);
}

TEST_F(Video, TheOtherCodecsAreReadBack) {
  for (const auto& [codec, name] : {std::pair("h265", "a.mp4"), std::pair("av1", "b.webm")}) {
    VideoSettings wanted = settings(name);
    wanted.codec = codec;
    const Decoded decoded = encoded(wanted);
    EXPECT_EQ(decoded.frames.size(), kFrames) << codec;
    EXPECT_LT(mean_error(decoded), 2.5) << codec;
    EXPECT_EQ(decoded.matrix, AVCOL_SPC_BT709) << codec;
  }
}

TEST_F(Video, SameFramesAreSameBytes) {
  encoded(settings("one.mp4"));
  encoded(settings("two.mp4"));
  EXPECT_EQ(bytes_of(folder_ / "one.mp4"), bytes_of(folder_ / "two.mp4"));
}

// Pins the process to one core for encoders that query the number of cores.
TEST_F(Video, OneCoreGivesTheSameBytes) {
  const std::vector<std::pair<const char*, const char*>> all{
      {"h264", ".mp4"}, {"h265", ".mp4"}, {"av1", ".webm"}, {"ffv1", ".mkv"}};
  for (const auto& [codec, ending] : all) {
    VideoSettings wanted = settings((std::string(codec) + ending).c_str());
    wanted.codec = codec;
    encoded(wanted);
    const std::string on_all = bytes_of(wanted.path);
    fs::remove(wanted.path);
    cpu_set_t before, one;
    ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
    CPU_ZERO(&one);
    for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++cpu) {
      if (CPU_ISSET(cpu, &before)) CPU_SET(cpu, &one);
    }
    ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
    encoded(wanted);
    EXPECT_EQ(sched_setaffinity(0, sizeof before, &before), 0);
    EXPECT_TRUE(bytes_of(wanted.path) == on_all) << codec;
  }
}

TEST_F(Video, WhatCannotBeWrittenIsSaid) {
  VideoSettings wrong = settings("a.mp4");
  wrong.codec = "mjpeg";
  EXPECT_NE(
      refused(wrong).find("codec mjpeg is not available for .mp4 files here; these are: h264, h265, av1"),
      std::string::npos)
      << refused(wrong);
  wrong = settings("a.webm");
  wrong.codec = "h264";
  EXPECT_NE(refused(wrong).find("these are: av1"), std::string::npos) << refused(wrong);
  wrong = settings("a.mp4");
  wrong.width = 63;
  EXPECT_NE(refused(wrong).find("not 63x64"), std::string::npos) << refused(wrong);
  wrong = settings("a.mp4");
  wrong.crf = 52;
  EXPECT_NE(refused(wrong).find("--crf must be from 0 to 51"), std::string::npos) << refused(wrong);
  wrong = settings("none/a.mp4");
  EXPECT_NE(refused(wrong).find("none/a.mp4: No such file"), std::string::npos) << refused(wrong);
  EXPECT_EQ(files(), 0u);
}

TEST_F(Video, LateFailuresAreReportedEarly) {
  const auto told = [](const VideoSettings& settings) {
    const auto good = check_video_settings(settings);
    return good ? "" : good.error().message;
  };
  VideoSettings wrong = settings("folder.mp4");
  fs::create_directories(wrong.path);
  EXPECT_NE(told(wrong).find("folder.mp4 is a folder"), std::string::npos) << told(wrong);
  wrong = settings("fast.mkv");
  wrong.fps_numerator = 1000;
  wrong.fps_denominator = 1;
  EXPECT_EQ(told(wrong), "");
  wrong.fps_numerator = 1001;
  EXPECT_NE(told(wrong).find("at most 1000 frames a second"), std::string::npos) << told(wrong);
  wrong.path = folder_ / "fast.mp4";
  EXPECT_EQ(told(wrong), "");
}

TEST_F(Video, OddSizeIsFineWithoutLoss) {
  VideoSettings odd = settings("odd.mkv");
  odd.codec = "ffv1";
  odd.width = 63;
  odd.height = 1;
  auto file = VideoFile::open(odd);
  ASSERT_TRUE(file.ok());
  ASSERT_TRUE((*file)->add(std::vector<uint8_t>(63 * 4, 9)).ok());
  ASSERT_TRUE((*file)->finish().ok());
  EXPECT_EQ(decode(odd.path).frames.size(), 1u);
}

TEST_F(Video, LinksBesideItAreNotFollowed) {
  const fs::path outside = folder_ / "outside";
  std::ofstream(outside) << "mine";
  for (const char* name : {"v.mkv", "v.mkv.jsonl"}) fs::create_symlink(outside, folder_ / name);
  VideoSettings wanted = settings("v.mkv");
  wanted.codec = "ffv1";
  auto sink = VideoSink::open(wanted);
  ASSERT_TRUE(sink.ok()) << sink.error().message;
  (*sink)->abandon();
  EXPECT_EQ(bytes_of(outside), "mine");
  EXPECT_EQ(files(), 3u) << "the links";
}

// As large as a provenance may be, and with marks of its JSON.
TEST_F(Video, CommentsAreReadBack) {
  const std::string comment = "{\"a\":\"" + std::string(65000, 'x') + "=;#\\\"}";
  for (const char* name : {"c.mp4", "c.mkv"}) {
    VideoSettings wanted = settings(name);
    EXPECT_EQ(encoded(wanted).frames.size(), kFrames);
    EXPECT_EQ(read_video_comment(wanted.path).value(), "");
    wanted.comment = comment;
    fs::remove(wanted.path);
    EXPECT_EQ(encoded(wanted).frames.size(), kFrames);
    const auto back = read_video_comment(wanted.path);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(*back, comment) << name;
    const std::string whole = bytes_of(wanted.path);
    std::ofstream(wanted.path, std::ios::binary) << "ffconcat version 1.0\nfile /etc/passwd\n";
    EXPECT_FALSE(read_video_comment(wanted.path).ok());
    for (const size_t bytes : {size_t{0}, size_t{40}, whole.size() / 2}) {
      std::ofstream(wanted.path, std::ios::binary) << whole.substr(0, bytes);
      (void)read_video_comment(wanted.path);
    }
  }
  EXPECT_FALSE(read_video_comment(folder_ / "absent.mp4").ok());
}

TEST_F(Video, VideoAndListOrNothing) {
  const auto take = [&](VideoSink& sink) {
    for (uint64_t frame = 0; frame < kFrames; ++frame) {
      FrameImage image;
      image.width = kWidth;
      image.height = kHeight;
      image.frame_index = frame;
      image.camera = "front";
      image.rgba8 = ramp(frame);
      ASSERT_TRUE(sink.consume(std::move(image)).ok());
    }
  };
  auto sink = VideoSink::open(settings("v.mp4"));
  ASSERT_TRUE(sink.ok());
  take(**sink);
  (*sink)->abandon();
  EXPECT_EQ(files(), 0u);
  sink = VideoSink::open(settings("v.mp4"));
  ASSERT_TRUE(sink.ok());
  take(**sink);
  ASSERT_TRUE((*sink)->finish().ok());
  EXPECT_EQ(files(), 2u);
  const std::string list = bytes_of(folder_ / "v.mp4.jsonl");
  EXPECT_EQ(static_cast<uint64_t>(std::count(list.begin(), list.end(), '\n')), kFrames);
  EXPECT_TRUE(list.starts_with("{\"file\":\"v.mp4\",\"frame\":0,\"camera\":\"front\""));
  EXPECT_EQ(decode(folder_ / "v.mp4").frames.size(), kFrames);
}

}  // namespace
}  // namespace fire3dv::sinks
