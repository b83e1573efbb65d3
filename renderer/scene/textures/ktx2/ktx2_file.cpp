#include "renderer/scene/textures/ktx2/ktx2_file.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fire3dv::scene::ktx2 {
namespace {

constexpr std::array<uint8_t, 12> kIdentifier{0xAB, 'K',  'T',  'X',  ' ',  '2',
                                              '0',  0xBB, '\r', '\n', 0x1A, '\n'};
constexpr size_t kHeaderBytes = 80, kLevelBytes = 24;
constexpr uint32_t kMaxLevels = 32;
// Values of VkFormat.
constexpr uint32_t kUndefined = 0, kRgb8 = 23, kRgb8Srgb = 29, kRgba8 = 37, kRgba8Srgb = 43;
// Values of the Khronos Data Format Specification.
constexpr uint32_t kModelEtc1s = 163, kModelUastc = 166, kTransferLinear = 1, kTransferSrgb = 2,
                   kFlagPremultiplied = 1;
constexpr size_t kDescriptorBytes = 24, kSampleBytes = 16;

static_assert(std::endian::native == std::endian::little, "KTX 2.0's numbers are read as they are in memory");

template <typename T>
T number_at(std::span<const std::byte> bytes, size_t offset) {
  T number;
  std::memcpy(&number, bytes.data() + offset, sizeof number);
  return number;
}

std::optional<std::span<const std::byte>> part(std::span<const std::byte> bytes, uint64_t offset,
                                               uint64_t length) {
  if (offset > bytes.size() || length > bytes.size() - offset) return std::nullopt;
  return bytes.subspan(offset, length);
}

constexpr std::array<Channel, 4> kRedGreen{Channel::red, Channel::green, Channel::zero, Channel::one};
constexpr std::array<Channel, 4> kRedAlphaAsGreen{Channel::red, Channel::alpha, Channel::zero, Channel::one};
constexpr std::array<Channel, 4> kRgb{Channel::red, Channel::green, Channel::blue, Channel::one};
constexpr std::array<Channel, 4> kRgba{Channel::red, Channel::green, Channel::blue, Channel::alpha};

struct Descriptor {
  uint32_t model = 0, transfer = 0, flags = 0;
  std::vector<uint32_t> channels;  // of the samples
};

Result<Descriptor> read_descriptor(std::span<const std::byte> bytes) {
  // The total size precedes the basic descriptor block.
  constexpr size_t kFirst = 4;
  if (bytes.size() < kFirst + kDescriptorBytes || number_at<uint32_t>(bytes, kFirst) != 0)
    return Error{"its data format descriptor lacks the basic block"};
  const std::span<const std::byte> block = bytes.subspan(kFirst);
  const size_t size = number_at<uint16_t>(block, 6);
  if (size < kDescriptorBytes || size > block.size())
    return Error{"its data format descriptor states " + std::to_string(size) + " bytes and has " +
                 std::to_string(block.size())};
  Descriptor descriptor;
  descriptor.model = number_at<uint8_t>(block, 8);
  descriptor.transfer = number_at<uint8_t>(block, 10);
  descriptor.flags = number_at<uint8_t>(block, 11);
  for (size_t at = kDescriptorBytes; at + kSampleBytes <= size; at += kSampleBytes)
    descriptor.channels.push_back(number_at<uint8_t>(block, at + 3) & 15u);
  return descriptor;
}

Result<void> apply_etc1s(const Descriptor& descriptor, Ktx2File& file) {
  // Channel numbers of the samples: 0 RGB, 3 red, 4 green, 15 alpha.
  const std::vector<uint32_t>& channels = descriptor.channels;
  file.coding = Coding::etc1s;
  file.has_alpha_slice = channels.size() == 2;
  if (channels == std::vector<uint32_t>{0} || channels == std::vector<uint32_t>{3}) {
    file.swizzle = kRgb;
  } else if (channels == std::vector<uint32_t>{0, 15}) {
    file.swizzle = kRgba;
  } else if (channels == std::vector<uint32_t>{3, 4}) {
    file.swizzle = kRedAlphaAsGreen;
  } else {
    return Error{"its ETC1S blocks have unknown channels"};
  }
  if (file.supercompression != Supercompression::basis_lz)
    return Error{"its ETC1S blocks are not compressed with BasisLZ"};
  return {};
}

Result<void> apply_uastc(const Descriptor& descriptor, Ktx2File& file) {
  // Channel numbers: 0 RGB, 3 RGBA, 4 red, 5 red and green as alpha, 6 red and green. A coding of red alone
  // repeats it in green and blue; some writers give colours this number.
  constexpr std::array<std::pair<uint32_t, std::array<Channel, 4>>, 5> kChannels{
      {{0, kRgb}, {3, kRgba}, {4, kRgb}, {5, kRedAlphaAsGreen}, {6, kRedGreen}}};
  file.coding = Coding::uastc;
  const auto* const found = std::find_if(kChannels.begin(), kChannels.end(), [&](const auto& known) {
    return descriptor.channels == std::vector<uint32_t>{known.first};
  });
  if (found == kChannels.end()) return Error{"its UASTC blocks have unknown channels"};
  file.swizzle = found->second;
  return {};
}

Result<void> apply_format(uint32_t format, const Descriptor& descriptor, Ktx2File& file) {
  if (descriptor.transfer == kTransferSrgb || descriptor.transfer == kTransferLinear)
    file.is_srgb = descriptor.transfer == kTransferSrgb;
  file.is_premultiplied = (descriptor.flags & kFlagPremultiplied) != 0;
  if (format == kUndefined && descriptor.model == kModelEtc1s) return apply_etc1s(descriptor, file);
  if (file.supercompression == Supercompression::basis_lz)
    return Error{"it is compressed with BasisLZ, but its blocks are not ETC1S"};
  if (format == kUndefined && descriptor.model == kModelUastc) return apply_uastc(descriptor, file);
  if (format == kRgb8 || format == kRgb8Srgb) {
    file.coding = Coding::rgb8;
    file.swizzle = kRgb;
  } else if (format == kRgba8 || format == kRgba8Srgb) {
    file.coding = Coding::rgba8;
  } else {
    return Error{"its format is " + std::to_string(format) + " (VkFormat) with the colour model " +
                 std::to_string(descriptor.model) + "; ETC1S, UASTC, R8G8B8 and R8G8B8A8 of 8 bits are read"};
  }
  return {};
}

// Value of a key, without a trailing zero byte. nullopt: there is none.
std::optional<std::string_view> value_of(std::span<const std::byte> pairs, std::string_view key) {
  while (pairs.size() >= 4) {
    const uint32_t length = number_at<uint32_t>(pairs, 0);
    if (length > pairs.size() - 4) break;
    const std::string_view pair(reinterpret_cast<const char*>(pairs.data()) + 4, length);
    const size_t end = pair.find('\0');
    if (end != std::string_view::npos && pair.substr(0, end) == key) {
      std::string_view value = pair.substr(end + 1);
      if (value.ends_with('\0')) value.remove_suffix(1);
      return value;
    }
    pairs = pairs.subspan(std::min<size_t>(pairs.size(), 4 + (size_t{length} + 3) / 4 * 4));
  }
  return std::nullopt;
}

void apply_swizzle(std::string_view letters, Ktx2File& file) {
  constexpr std::string_view kLetters = "rgba01";  // in the order of Channel
  if (letters.size() != 4 || letters.find_first_not_of(kLetters) != std::string_view::npos) return;
  const std::array<Channel, 4> of_coding = file.swizzle;
  for (size_t i = 0; i < 4; ++i) {
    const auto source = static_cast<Channel>(kLetters.find(letters[i]));
    file.swizzle[i] = source <= Channel::alpha ? of_coding[static_cast<size_t>(source)] : source;
  }
}

Result<void> check_shape(std::span<const std::byte> bytes, Ktx2File& file) {
  file.width = number_at<uint32_t>(bytes, 20);
  file.height = number_at<uint32_t>(bytes, 24);
  const auto depth = number_at<uint32_t>(bytes, 28), layers = number_at<uint32_t>(bytes, 32),
             faces = number_at<uint32_t>(bytes, 36);
  file.level_count = std::max(number_at<uint32_t>(bytes, 40), 1u);
  if (file.width == 0 || file.height == 0 || depth > 1 || layers > 1 || faces != 1)
    return Error{"it is not a two-dimensional texture of one layer"};
  if (file.level_count > kMaxLevels)
    return Error{"it has " + std::to_string(file.level_count) + " mip levels"};
  return {};
}

}  // namespace

bool is_ktx2(std::span<const std::byte> bytes) {
  return bytes.size() >= kIdentifier.size() &&
         std::memcmp(bytes.data(), kIdentifier.data(), kIdentifier.size()) == 0;
}

Result<Ktx2File> read_ktx2(std::span<const std::byte> bytes) {
  const Error kCutShort{"the KTX 2.0 file is cut short"};
  if (!is_ktx2(bytes)) return Error{"it is not a KTX 2.0 file"};
  if (bytes.size() < kHeaderBytes) return kCutShort;
  Ktx2File file;
  if (auto done = check_shape(bytes, file); !done) return done.error();
  const auto scheme = number_at<uint32_t>(bytes, 44);
  if (scheme > static_cast<uint32_t>(Supercompression::zstandard)) {
    return Error{"its supercompression scheme is " + std::to_string(scheme) +
                 "; none, BasisLZ and Zstandard are read"};
  }
  file.supercompression = static_cast<Supercompression>(scheme);
  const auto levels = part(bytes, kHeaderBytes, kLevelBytes * file.level_count);
  const auto descriptor_bytes = part(bytes, number_at<uint32_t>(bytes, 48), number_at<uint32_t>(bytes, 52));
  const auto pairs = part(bytes, number_at<uint32_t>(bytes, 56), number_at<uint32_t>(bytes, 60));
  const auto global_data = part(bytes, number_at<uint64_t>(bytes, 64), number_at<uint64_t>(bytes, 72));
  if (!levels || !descriptor_bytes || !pairs || !global_data) return kCutShort;
  const auto level = part(bytes, number_at<uint64_t>(*levels, 0), number_at<uint64_t>(*levels, 8));
  if (!level) return kCutShort;
  file.level = *level;
  file.global_data = *global_data;

  const Result<Descriptor> descriptor = read_descriptor(*descriptor_bytes);
  if (!descriptor) return descriptor.error();
  if (auto done = apply_format(number_at<uint32_t>(bytes, 12), *descriptor, file); !done) return done.error();
  if (const auto letters = value_of(*pairs, "KTXswizzle")) apply_swizzle(*letters, file);
  const std::string_view orientation = value_of(*pairs, "KTXorientation").value_or("rd");
  file.is_mirrored_x = orientation.starts_with('l');
  file.is_mirrored_y = orientation.size() > 1 && orientation[1] == 'u';
  return file;
}

}  // namespace fire3dv::scene::ktx2
