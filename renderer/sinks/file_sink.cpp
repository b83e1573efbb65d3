#include "renderer/sinks/file_sink.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "renderer/sinks/output_text.h"
#include "renderer/sinks/png.h"

namespace fire3dv::sinks {

Result<std::unique_ptr<FileSink>> FileSink::open(const FileSinkOptions& options) {
  if (options.folder.empty()) return Error{"no folder is given for the images: name one"};
  if (auto made = base::create_folder(options.folder); !made) return made.error();
  base::remove_abandoned_temporaries(options.folder, "frame_");
  std::unique_ptr<FileSink> sink(new FileSink(options));
  const std::filesystem::path log_path = options.folder / "frames.jsonl";
  errno = 0;
  sink->log_.open(log_path, std::ios::trunc);
  if (!sink->log_) return Error{"cannot write " + log_path.string() + ": " + system_reason(errno)};
  sink->start();
  return sink;
}

FileSink::FileSink(const FileSinkOptions& options)
    : QueuedSink(std::max<size_t>(options.queue_limit, 1)), options_(options) {}

FileSink::~FileSink() {
  (void)finish();
}

uint64_t FileSink::count_stale_frames() const {
  constexpr std::string_view kBegin = "frame_";
  uint64_t count = 0;
  for (const auto& [folder, last] : last_frame_of_folder_) {
    std::set<uint64_t> stale;  // a frame may have several files
    std::error_code fault;
    for (std::filesystem::directory_iterator entry(options_.folder / folder, fault), end;
         !fault && entry != end; entry.increment(fault)) {
      const std::string name = entry->path().filename().string();
      if (!name.starts_with(kBegin)) continue;
      uint64_t number = 0;
      const char* const begin = name.data() + kBegin.size();
      const auto [stop, error] = std::from_chars(begin, name.data() + name.size(), number);
      if (error == std::errc() && stop != name.data() + name.size() && *stop == '.' && number > last)
        stale.insert(number);
    }
    count += stale.size();
  }
  return count;
}

// Makes the whole series durable. File contents are flushed one by one, so one flush of the list and of each
// folder suffices.
Result<void> FileSink::complete() {
  log_.close();
  const std::filesystem::path list = options_.folder / "frames.jsonl";
  int fault = base::flush_file(list);
  if (fault == 0) fault = base::flush_folder_of(list);
  for (const auto& [camera, folder] : folder_of_camera_)
    if (fault == 0) fault = base::flush_folder_of(options_.folder / folder / "frame");
  if (fault == 0) return {};
  return Error{"cannot flush the images in " + options_.folder.string() +
               " to the disk: " + system_reason(fault)};
}

namespace {

// Arrays have no text of their own: their line has the provenance.
std::string line_of(const FrameFiles& files, const FrameImage& image) {
  std::string line = frame_line(files, image);
  if (image.run_provenance && !(files.planes.empty() && files.amodal.empty()))
    line.insert(line.rfind('}'), ",\"provenance\":" + *image.run_provenance);
  return line;
}

}  // namespace

Result<FrameFiles> write_frame_files(const FrameImage& image, const std::filesystem::path& begin,
                                     const WriteFile& write) {
  FrameFiles files;
  const auto named = [&](const std::string& ending) {
    return std::filesystem::path(begin.string() + ending);
  };
  if (!image.rgba8.empty()) {
    files.color = named(".png");
    auto bytes = encode_png(image);
    if (!bytes) return Error{"cannot encode " + files.color.string() + ": " + bytes.error().message};
    if (auto written = write(files.color, std::move(*bytes)); !written) return written.error();
  }
  for (const FramePlane& plane : image.planes) {
    files.planes.push_back(named("." + std::string(wire::info_of(plane.output).cli_name) + ".npy"));
    auto written = write(files.planes.back(), encode_npy(plane, image.width, image.height));
    if (!written) return written.error();
  }
  if (image.amodal) {
    files.amodal = named(".amodal.npy");
    auto written = write(files.amodal, encode_npy("|u1", masks_shape(image), image.amodal->masks));
    if (!written) return written.error();
  }
  return files;
}

Result<void> FileSink::write(const FrameImage& image) {
  auto folder = folder_of(image.camera);
  if (!folder) return folder.error();
  const auto last = last_frame_of_folder_.find(*folder);
  if (last != last_frame_of_folder_.end() && image.frame_index <= last->second) {
    return Error{"frame " + std::to_string(image.frame_index) + " was given twice for " +
                 (options_.folder / *folder).string() + ": several cameras need a folder each"};
  }
  last_frame_of_folder_[*folder] = image.frame_index;
  char name[40];
  std::snprintf(name, sizeof name, "frame_%06llu", static_cast<unsigned long long>(image.frame_index));
  const auto files = write_frame_files(
      image, *folder / name, [&](const std::filesystem::path& file, std::vector<uint8_t> bytes) {
        return write_whole_file(options_.folder / file, bytes, base::Durability::contents);
      });
  if (!files) return files.error();
  errno = 0;
  log_ << line_of(*files, image) << std::flush;  // flush per line: a killed run keeps its list
  if (!log_)
    return Error{"cannot write " + (options_.folder / "frames.jsonl").string() + ": " + system_reason(errno)};
  ++frames_written_;
  return {};
}

Result<std::filesystem::path> FileSink::folder_of(const std::string& camera) {
  if (!options_.folder_per_camera) return std::filesystem::path{};
  if (const auto known = folder_of_camera_.find(camera); known != folder_of_camera_.end())
    return known->second;
  // Different names may map to the same safe file name; the later one gets a number.
  const std::string base = safe_file_name(camera.empty() ? "camera" : camera);
  std::string name = base;
  const auto taken = [&] {
    return std::any_of(folder_of_camera_.begin(), folder_of_camera_.end(),
                       [&](const auto& entry) { return entry.second == name; });
  };
  for (int number = 2; taken(); ++number) name = base + "_" + std::to_string(number);
  if (auto made = base::create_folder(options_.folder / name); !made) return made.error();
  return folder_of_camera_[camera] = name;
}

static_assert(std::endian::native == std::endian::little, "planes are written as they lie in memory");

std::vector<uint8_t> encode_npy(std::string_view numpy_type, std::span<const uint64_t> shape,
                                std::span<const uint8_t> values) {
  std::string sizes;
  for (const uint64_t size : shape) sizes += (sizes.empty() ? "" : ", ") + std::to_string(size);
  std::string header =
      "{'descr': '" + std::string(numpy_type) + "', 'fortran_order': False, 'shape': (" + sizes + "), }";
  // The format requires data at a multiple of 64 bytes, after a line feed.
  constexpr size_t kBefore = 10;
  header.append(63 - (kBefore + header.size()) % 64, ' ');
  header += '\n';
  std::vector<uint8_t> bytes{0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0};
  bytes.push_back(static_cast<uint8_t>(header.size() & 0xff));
  bytes.push_back(static_cast<uint8_t>(header.size() >> 8));
  bytes.reserve(bytes.size() + header.size() + values.size());
  bytes.insert(bytes.end(), header.begin(), header.end());
  bytes.insert(bytes.end(), values.begin(), values.end());
  return bytes;
}

std::vector<uint8_t> encode_npy(const FramePlane& plane, uint32_t width, uint32_t height) {
  const wire::ImageOutputInfo& info = wire::info_of(plane.output);
  std::vector<uint64_t> shape{height, width};
  if (info.channels > 1) shape.push_back(info.channels);
  return encode_npy(info.numpy_type, shape, plane.bytes);
}

std::array<uint64_t, 3> masks_shape(const FrameImage& image) {
  return {image.amodal->records.size(), image.height, (image.width + 7) / 8};
}

Result<void> write_npy(const std::filesystem::path& path, const FramePlane& plane, uint32_t width,
                       uint32_t height, base::Durability durability) {
  return write_whole_file(path, encode_npy(plane, width, height), durability);
}

}  // namespace fire3dv::sinks
