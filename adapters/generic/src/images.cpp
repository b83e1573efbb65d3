#include "images.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/plural.h"
#include "image_answer.h"
#include "protocol/wire/encode.h"
#include "protocol/wire/image.h"

namespace fire3dv::client {
namespace {

// Link state key of a request slot, apart from the keys of scene edits, which count from 1.
constexpr uint64_t key_of(uint32_t slot) {
  return uint64_t{1} << 63 | slot;
}
constexpr size_t kMaxRefusals = wire::kMaxImageRequests;
constexpr uint32_t kMaxBoxes = 4096;  // per image, for the size of reserved slots
constexpr uint32_t kMaxReadAtOnce = wire::kMaxImageRequests;
constexpr size_t kMaxArrivedBytes = size_t{1} << 30;  // limit of images that the caller has not taken

// For check_answer().
wire::ImageBatch without_poses(const wire::ImageBatch& batch) {
  wire::ImageBatch result;
  result.worlds = batch.views();  // the number of views stays
  return result;
}

// id 0: of any request but batches, whose answers have another shape.
bool is_of(const Images::Arrived& image, uint64_t id) {
  return id == 0 ? !image.is_batch : image.frame.request == id;
}

bool switches_document(wire::ImageWhen when) {
  return when == wire::ImageWhen::every_nth || when == wire::ImageWhen::rate;
}

}  // namespace

Result<void> Images::send(transport::PublisherLink& link, const wire::ImageRequest& request) {
  return link.put_state(key_of(request.place), std::make_shared<const wire::Bytes>(wire::encode(request)));
}

Result<uint64_t> Images::request(transport::PublisherLink& link, wire::ImageRequest request) {
  if (open_.size() == wire::kMaxImageRequests)
    return Error{"the limit of open image requests is reached (" + std::to_string(open_.size()) +
                 "); cancel some, or wait for them"};
  const uint32_t views = request.views();
  const uint64_t pixel_bytes = wire::pixel_bytes_of(
      request.intrinsics.width, request.intrinsics.height * views, request.outputs, kMaxBoxes);
  if (pixel_bytes > wire::kMaxPixelBytes && views > 1)
    return Error{counted(views, "view") + " of " + std::to_string(request.intrinsics.width) + " x " +
                 std::to_string(request.intrinsics.height) + " with these outputs have " +
                 std::to_string(pixel_bytes) + " bytes; at most " + std::to_string(wire::kMaxPixelBytes) +
                 " come back in one batch: request it in parts, or fewer outputs"};
  if (pixel_bytes > wire::kMaxPixelBytes)
    return Error{"an image of " + std::to_string(request.intrinsics.width) + " x " +
                 std::to_string(request.intrinsics.height) + " with these outputs has " +
                 std::to_string(pixel_bytes) + " bytes; at most " + std::to_string(wire::kMaxPixelBytes) +
                 " come back: request a smaller one, or fewer outputs"};
  const size_t block_bytes = wire::max_block_bytes(pixel_bytes);
  const size_t longest = std::max(block_bytes, max_block_bytes());
  if (auto room = link.make_room_for_images(longest, open_.size() + 1); !room) return room.error();
  if (open_.size() + 1 > most_open_ || longest > most_block_bytes_) {
    most_open_ = std::max(most_open_, open_.size() + 1);
    most_block_bytes_ = std::max(most_block_bytes_, longest);
    copy_lent_images();
  }

  request.id = last_id_ + 1;
  request.place = free_slots_.empty() ? next_slot_ : free_slots_.back();
  if (auto sent = send(link, request); !sent) return sent.error();
  ++last_id_;
  if (free_slots_.empty())
    ++next_slot_;
  else
    free_slots_.pop_back();
  // The link has a copy of the poses.
  if (request.batch) request.batch = without_poses(*request.batch);
  Open& open = open_[last_id_];
  open.request = std::move(request);
  open.block_bytes = block_bytes;
  max_block_bytes_ = longest;
  return last_id_;
}

size_t Images::max_block_bytes() {
  if (!max_block_bytes_) {
    max_block_bytes_ = 0;
    for (const auto& [id, open] : open_) max_block_bytes_ = std::max(*max_block_bytes_, open.block_bytes);
  }
  return *max_block_bytes_;
}

void Images::close(std::map<uint64_t, Open>::iterator open) {
  free_slots_.push_back(open->second.request.place);
  if (max_block_bytes_ == open->second.block_bytes) max_block_bytes_.reset();
  open_.erase(open);
}

Result<void> Images::cancel(transport::PublisherLink& link, uint64_t epoch, uint64_t id) {
  std::erase_if(arrived_, [&](const Arrived& image) { return image.frame.request == id; });
  refused_.erase(id);
  const auto open = open_.find(id);
  if (open == open_.end()) return {};
  wire::ImageRequest back;
  back.epoch = epoch;
  back.id = id;
  back.place = open->second.request.place;
  back.when = wire::ImageWhen::never;
  close(open);
  return send(link, back);
}

Result<void> Images::restart_epoch(transport::PublisherLink& link, uint64_t epoch) {
  for (auto at = open_.begin(); at != open_.end();) {
    const auto open = at++;
    wire::ImageRequest& request = open->second.request;
    if (!switches_document(request.when)) {
      refuse(open->first, static_cast<bool>(request.batch),
             "the stream was described again before the image arrived; request it again");
      close(open);
      continue;
    }
    request.epoch = epoch;
    request.sequence = 0;
    open->second.last_number = open->second.last_sequence = 0;  // both restart with the epoch
    open->second.has_come = false;
    if (auto sent = send(link, request); !sent) return sent;
  }
  return {};
}

void Images::refuse(uint64_t id, bool is_batch, std::string why) {
  if (refused_.size() == kMaxRefusals) refused_.erase(refused_.begin());
  refused_[id] = {std::move(why), is_batch};
}

void Images::on(const wire::ImageRefused& refused) {
  const auto open = open_.find(refused.request);
  if (open == open_.end() || open->second.request.epoch != refused.epoch) return;
  refuse(refused.request, static_cast<bool>(open->second.request.batch),
         refused.message.empty() ? "the renderer gives no reason" : refused.message);
  close(open);
}

void Images::collect(transport::PublisherLink& link, uint64_t epoch, uint64_t newest_sequence, uint64_t id) {
  for (uint32_t read = 0; read < kMaxReadAtOnce && !has_arrived(id); ++read) {
    std::optional<transport::PublisherLink::Image> image = link.poll_image();
    if (!image) return;
    if (auto fits = arrived(epoch, newest_sequence, std::move(*image)); !fits) {
      ++dropped_;
      dropped_why_ = fits.error().message;
    }
  }
}

// Malformed images are errors. Those of a request or an epoch that has ended are late, no fault of the
// renderer.
Result<void> Images::arrived(uint64_t epoch, uint64_t newest_sequence,
                             transport::PublisherLink::Image&& image) {
  const auto block = wire::read_image_block(image.block);
  if (!block) return block.error();
  const auto message = decoder_.decode(block->head);
  if (!message) return message.error();
  const auto* frame = std::get_if<wire::ImageFrame>(&*message);
  if (frame == nullptr) return Error{"its head is another message"};
  if (frame->epoch != epoch) return {};
  if (frame->request != block->request) return Error{"its head names another request"};
  if (frame->pixel_bytes > block->pixels.size())
    return Error{"it has " + std::to_string(block->pixels.size()) + " bytes of pixels instead of " +
                 std::to_string(frame->pixel_bytes)};
  const auto open = open_.find(frame->request);
  if (open == open_.end()) return {};  // cancelled, or already answered by another renderer
  if (auto fits = check_answer(*frame, block->pixels, open->second.request, newest_sequence); !fits)
    return fits;
  store(*frame, block->pixels, std::move(image));
  return {};
}

std::string Images::dropped_text() const {
  if (dropped_ == 0) return "";
  return counted(dropped_, "image") + (dropped_ == 1 ? " was" : " were") + " dropped (the last one, since " +
         dropped_why_ + ")";
}

void Images::store(const wire::ImageFrame& frame, std::span<const std::byte> pixels,
                   transport::PublisherLink::Image&& keep) {
  const auto open = open_.find(frame.request);
  Open& request = open->second;
  // The first image of a frame counts, whichever renderer sent it. Each renderer numbers its own images from
  // 1.
  if (request.has_come && frame.sequence <= request.last_sequence) return;
  // A frame has one image of a request at most, so that not more are lost than frames have passed.
  if (frame.number > request.last_number)
    request.lost += std::min(frame.number - request.last_number - 1, frame.sequence - request.last_sequence);
  request.last_number = frame.number;
  request.last_sequence = frame.sequence;
  request.has_come = true;
  request.lost +=
      std::erase_if(arrived_, [&](const Arrived& image) { return image.frame.request == frame.request; });
  arrived_.push_back(
      {frame, pixels, std::move(keep), request.lost, static_cast<bool>(request.request.batch)});
  if (!switches_document(request.request.when)) close(open);
  bound_arrived();
}

// Bounds the memory of images that the caller does not take; drops the oldest first.
void Images::bound_arrived() {
  size_t bytes = 0;
  for (const Arrived& image : arrived_) bytes += image.pixels.size();
  while (arrived_.size() > 1 && (bytes > kMaxArrivedBytes || arrived_.size() > wire::kMaxImageRequests)) {
    const Arrived& oldest = arrived_.front();
    bytes -= oldest.pixels.size();
    if (!open_.contains(oldest.frame.request))
      refuse(oldest.frame.request, oldest.is_batch,
             "its image was given up, since too many had come that nobody took");
    arrived_.pop_front();
  }
}

// The link may have moved to larger memory: images that nobody takes would keep the earlier one.
void Images::copy_lent_images() {
  for (Arrived& image : arrived_) {
    if (!image.keep.is_lent) continue;
    const auto copy = std::make_shared<const wire::Bytes>(image.keep.block.begin(), image.keep.block.end());
    const auto offset = static_cast<size_t>(image.pixels.data() - image.keep.block.data());
    image.pixels = std::span<const std::byte>(*copy).subspan(offset, image.pixels.size());
    image.keep = {copy, *copy};
  }
}

bool Images::has_open_singles() const {
  return std::any_of(open_.begin(), open_.end(),
                     [](const auto& entry) { return !entry.second.request.batch; });
}

bool Images::has_arrived(uint64_t id) const {
  return std::any_of(arrived_.begin(), arrived_.end(),
                     [&](const Arrived& image) { return is_of(image, id); });
}

std::optional<Images::Arrived> Images::take(uint64_t id) {
  const auto found =
      std::find_if(arrived_.begin(), arrived_.end(), [&](const Arrived& image) { return is_of(image, id); });
  if (found == arrived_.end()) return {};
  Arrived image = std::move(*found);
  arrived_.erase(found);
  if (const auto open = open_.find(image.frame.request); open != open_.end()) open->second.lost = 0;
  return image;
}

std::optional<std::string> Images::take_refusal(uint64_t id) {
  const auto found = id == 0 ? std::find_if(refused_.begin(), refused_.end(),
                                            [](const auto& entry) { return !entry.second.is_batch; })
                             : refused_.find(id);
  if (found == refused_.end()) return {};
  std::string why = "request " + std::to_string(found->first) + ": " + found->second.why;
  refused_.erase(found);
  return why;
}

}  // namespace fire3dv::client
