#include "renderer/browser/server/encoder.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <optional>
#include <utility>

namespace fire3dv::serve {
namespace {

constexpr int kFullChromaQuality = 90;  // of JPEG: refined images

}  // namespace

Encoder::~Encoder() {
  {
    const std::scoped_lock lock(mutex_);
    is_ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Encoder::add(ViewerId viewer, Image&& image) {
  {
    const std::scoped_lock lock(mutex_);
    const auto waiting = std::ranges::find(jobs_, viewer, &Job::viewer);
    if (waiting != jobs_.end()) {
      image.needs_key |= waiting->image.needs_key;
      waiting->image = std::move(image);
    } else {
      jobs_.push_back({viewer, std::move(image)});
    }
  }
  changed_.notify_one();
}

void Encoder::forget(ViewerId viewer) {
  {
    const std::scoped_lock lock(mutex_);
    std::erase_if(jobs_, [&](const Job& job) { return job.viewer == viewer; });
    forgotten_.push_back(viewer);
  }
  changed_.notify_one();
}

EncodeTotals Encoder::totals(Codec codec) const {
  const std::scoped_lock lock(mutex_);
  const auto known = totals_.find(codec);
  return known == totals_.end() ? EncodeTotals() : known->second;
}

void Encoder::run() {
  for (;;) {
    std::optional<Job> job;
    std::vector<ViewerId> forgotten;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return is_ending_ || !jobs_.empty() || !forgotten_.empty(); });
      if (is_ending_) return;
      forgotten.swap(forgotten_);
      if (!jobs_.empty()) {
        job.emplace(std::move(jobs_.front()));
        jobs_.pop_front();
      }
    }
    for (const ViewerId viewer : forgotten) streams_.erase(viewer);
    if (!job) continue;
    try {
      encode(job->viewer, job->image);
    } catch (const std::bad_alloc&) {
      take_(job->viewer, {});
    }
  }
}

void Encoder::encode(ViewerId viewer, const Image& image) {
  const auto begun = std::chrono::steady_clock::now();
  ImageHeader header = image.header;
  std::vector<uint8_t> bytes, message;
  if (header.codec != Codec::jpeg) header.codec = append_video(viewer, image, bytes, header.is_key);
  if (header.codec == Codec::jpeg) {
    const auto file = jpeg_.encode(image.rgba8.data(), header.width, header.height, size_t{4} * header.width,
                                   static_cast<uint32_t>(image.quality),
                                   image.quality >= kFullChromaQuality ? Chroma::full : Chroma::half);
    if (!file) return take_(viewer, {});
    bytes.assign(file->begin(), file->end());
  }
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begun;
  header.encode_us = static_cast<uint32_t>(time.count() * 1e6);
  message.reserve(kImageHeaderBytes + bytes.size());
  append_header(header, message);
  message.insert(message.end(), bytes.begin(), bytes.end());
  {
    const std::scoped_lock lock(mutex_);
    EncodeTotals& totals = totals_[header.codec];
    ++totals.images;
    totals.bytes += message.size();
    totals.seconds += time.count();
  }
  take_(viewer, std::move(message));
}

// The codec that the system has; jpeg: none, and no bytes are appended. A new encoder begins with a key
// frame; another size or quality needs one.
Codec Encoder::append_video(ViewerId viewer, const Image& image, std::vector<uint8_t>& bytes, bool& is_key) {
  using Kind = sinks::StreamEncoder::Codec;
  is_key = false;
  const uint32_t width = image.header.width, height = image.header.height;
  if (width % 2 != 0 || height % 2 != 0) return Codec::jpeg;
  const int crf = 20 + std::clamp((85 - image.quality) / 4, 0, 20);
  const bool is_vp8 = image.header.codec == Codec::vp8;
  std::unique_ptr<sinks::StreamEncoder>& stream = streams_[viewer];
  const bool is_allowed = stream && (stream->codec() == Kind::vp8 ? is_vp8 || image.may_be_vp8 : !is_vp8);
  const bool fits =
      is_allowed && stream->width() == width && stream->height() == height && stream->crf() == crf;
  if (!fits || image.needs_key) {
    stream.reset();
    if (!is_vp8) stream = sinks::StreamEncoder::open(Kind::h264, width, height, crf);
    if (!stream && (is_vp8 || image.may_be_vp8))
      stream = sinks::StreamEncoder::open(Kind::vp8, width, height, crf);
  }
  if (!stream) return Codec::jpeg;
  if (stream->append(image.rgba8, bytes, is_key))
    return stream->codec() == Kind::vp8 ? Codec::vp8 : Codec::h264;
  stream.reset();
  bytes.clear();
  is_key = false;
  return Codec::jpeg;
}

}  // namespace fire3dv::serve
