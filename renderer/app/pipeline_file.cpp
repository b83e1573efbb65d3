#include "renderer/app/pipeline_file.h"

#include <cstring>
#include <system_error>

#include "renderer/scene/atomic_file.h"
#include "renderer/scene/files.h"
#include "shaders/embedded.h"

namespace fire3dv::app {
namespace {

constexpr char kMagic[8] = {'F', '3', 'D', 'V', 'P', 'I', 'P', '\0'};
constexpr uint64_t kMostBytes = uint64_t{256} << 20;  // of one file, and of the folder
constexpr std::string_view kEnding = ".pipelines";

struct Head {
  char magic[sizeof(kMagic)];
  scene::Digest kind;
  uint64_t data_bytes;
  uint64_t checksum;  // of the data
};
static_assert(sizeof(Head) == 56);

uint64_t checksum_of(std::span<const std::byte> bytes) {
  scene::Checksum checksum;
  checksum.add(bytes);
  return checksum.value();
}

}  // namespace

scene::Digest pipeline_kind(const VkPhysicalDeviceProperties& device) {
  std::string text = std::string(device.deviceName) + '\0';
  for (const uint32_t number : {device.vendorID, device.deviceID, device.driverVersion, device.apiVersion})
    text += std::to_string(number) + '\0';
  text += scene::hex(device.pipelineCacheUUID);
  for (const std::string_view name : shaders::names()) {
    const std::span<const uint32_t> code = shaders::embedded(name);
    text += name;
    text.append(reinterpret_cast<const char*>(code.data()), code.size_bytes());
  }
  return scene::digest_of(std::as_bytes(std::span(text)));
}

Result<void> write_pipeline_file(const std::filesystem::path& path, const scene::Digest& kind,
                                 std::span<const std::byte> data) {
  Head head{};
  std::memcpy(head.magic, kMagic, sizeof(kMagic));
  head.kind = kind;
  head.data_bytes = data.size();
  head.checksum = checksum_of(data);
  return scene::write_atomically(path, {std::as_bytes(std::span(&head, 1)), data});
}

Result<std::vector<std::byte>> read_pipeline_file(const std::filesystem::path& path,
                                                  const scene::Digest& kind) {
  const auto unusable = [&](const char* why) {
    return Error{"cache: " + scene::quote(path.string()) + " is made anew: " + why};
  };
  Result<scene::OpenFile> file = scene::OpenFile::open(path, kMostBytes);
  if (!file) return Error{"cache: " + file.error().message};
  Head head{};
  if (!file->read(0, std::as_writable_bytes(std::span(&head, 1)))) return unusable("it is too short");
  if (std::memcmp(head.magic, kMagic, sizeof(kMagic)) != 0) return unusable("it holds no pipelines");
  if (head.kind != kind) return unusable("it is of another device, driver or version of this program");
  if (head.data_bytes != file->size() - sizeof(Head)) return unusable("it is not of the length that it says");
  std::vector<std::byte> data(head.data_bytes);
  if (!file->read(sizeof(Head), data) || checksum_of(data) != head.checksum) return unusable("it is damaged");
  return data;
}

PipelineFile::PipelineFile(gpu::Device& device, const std::optional<std::filesystem::path>& folder)
    : device_(device) {
  if (folder) {
    kind_ = pipeline_kind(device.identity());
    path_ = *folder / (scene::hex(std::span(kind_).first(16)) + std::string(kEnding));
    std::error_code error;
    if (std::filesystem::exists(path_, error)) {
      auto data = read_pipeline_file(path_, kind_);
      if (data) known_ = std::move(*data);
      if (!data) note_ = data.error().message;
    }
  }
  device.start_pipeline_cache(known_);
}

Result<void> PipelineFile::keep() const {
  if (path_.empty()) return {};
  const std::vector<std::byte> data = device_.pipeline_cache_data();
  // A driver with a cache of its own, such as lavapipe, gives nothing.
  if (data.empty() || data == known_ || data.size() > kMostBytes - sizeof(Head)) {
    if (!known_.empty()) scene::touch(path_);
    return {};
  }
  std::error_code error;
  std::filesystem::create_directories(path_.parent_path(), error);
  if (error)
    return Error{"cannot make the folder " + scene::quote(path_.parent_path().string()) + ": " +
                 error.message()};
  auto written = write_pipeline_file(path_, kind_, data);
  scene::remove_oldest(path_.parent_path(), kEnding, kMostBytes);
  return written;
}

}  // namespace fire3dv::app
