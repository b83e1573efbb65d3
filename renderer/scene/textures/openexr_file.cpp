#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfEnvmap.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <exception>
#include <new>
#include <optional>
#include <stdexcept>

#include "renderer/scene/textures/environment.h"

namespace fire3dv::scene {
namespace {

constexpr std::array<uint8_t, 4> kOpenExrMagic{0x76, 0x2f, 0x31, 0x01};
constexpr size_t kPrologueBytes = 8;  // magic number and version
constexpr uint32_t kMultiPart = 0x1000;
// OpenEXR holds some rows of all channels, also of those that are not read.
constexpr size_t kMaxChannels = 64;

// The file in memory. OpenEXR expects exceptions at its end.
class MemoryStream : public Imf::IStream {
 public:
  MemoryStream(std::span<const std::byte> bytes, const std::string& name)
      : Imf::IStream(name.c_str()), bytes_(bytes) {}

  bool read(char to[], int count) override {
    const auto wanted = static_cast<size_t>(std::max(count, 0));
    if (at_ > bytes_.size() || wanted > bytes_.size() - at_) throw std::runtime_error("it is cut short");
    std::memcpy(to, bytes_.data() + at_, wanted);
    at_ += wanted;
    return at_ < bytes_.size();
  }
  uint64_t tellg() override { return at_; }
  void seekg(uint64_t position) override { at_ = position; }

 private:
  std::span<const std::byte> bytes_;
  uint64_t at_ = 0;
};

// Checks that all attributes of the headers lie inside of the file: OpenEXR allocates the sizes that they
// state.
bool headers_fit(std::span<const std::byte> bytes) {
  uint32_t version = 0;
  std::memcpy(&version, bytes.data() + kOpenExrMagic.size(), sizeof version);
  std::span<const std::byte> rest = bytes.subspan(kPrologueBytes);
  const auto take_text = [&]() -> std::optional<size_t> {  // its length
    const auto end = std::find(rest.begin(), rest.end(), std::byte{0});
    if (end == rest.end()) return std::nullopt;
    const auto length = static_cast<size_t>(end - rest.begin());
    rest = rest.subspan(length + 1);
    return length;
  };
  bool is_header_empty = true;
  for (;;) {
    const std::optional<size_t> name = take_text();
    if (!name) return false;
    if (*name == 0) {  // the end of a header; of several, an empty one is the last
      if ((version & kMultiPart) == 0 || is_header_empty) return true;
      is_header_empty = true;
      continue;
    }
    is_header_empty = false;
    uint32_t size = 0;
    if (!take_text() || rest.size() < sizeof size) return false;
    std::memcpy(&size, rest.data(), sizeof size);
    rest = rest.subspan(sizeof size);
    if (size > rest.size()) return false;
    rest = rest.subspan(size);
  }
}

uint64_t side(int first, int last) {
  return static_cast<uint64_t>(std::max<int64_t>(int64_t{last} - first + 1, 0));
}

// Names of the channels of red, green and blue. nullopt: there are none.
std::optional<std::array<std::string, 3>> color_channels(const Imf::ChannelList& channels) {
  if (channels.findChannel("R") && channels.findChannel("G") && channels.findChannel("B"))
    return std::array<std::string, 3>{"R", "G", "B"};
  for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
    const std::string name = channel.name();
    if (!name.ends_with(".R")) continue;
    const std::string layer = name.substr(0, name.size() - 1);
    if (channels.findChannel(layer + "G") && channels.findChannel(layer + "B"))
      return std::array<std::string, 3>{name, layer + "G", layer + "B"};
  }
  if (channels.findChannel("Y")) return std::array<std::string, 3>{"Y", "Y", "Y"};
  return std::nullopt;
}

struct Layout {
  Imath::Box2i display, data;
  std::array<std::string, 3> channels;
};

Result<Layout> read_layout(MemoryStream& stream, const std::string& name) {
  stream.seekg(kOpenExrMagic.size());
  int version = 0;
  stream.read(reinterpret_cast<char*>(&version), sizeof version);
  Imf::Header header;
  header.readFrom(stream, version);
  Layout layout{header.displayWindow(), header.dataWindow(), {}};
  for (const Imath::Box2i& window : {layout.display, layout.data}) {
    const auto fits =
        check_environment_size(side(window.min.x, window.max.x), side(window.min.y, window.max.y), name);
    if (!fits) return fits.error();
  }
  size_t count = 0;
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) ++count;
  if (count > kMaxChannels) {
    return Error{name + " has " + std::to_string(count) + " channels; at most " +
                 std::to_string(kMaxChannels) + " are read"};
  }
  if (Imf::hasEnvmap(header) && Imf::envmap(header) == Imf::ENVMAP_CUBE)
    return Error{name + " is a cube map; use an equirectangular image"};
  const auto channels = color_channels(header.channels());
  if (!channels) return Error{name + " has no channels R, G and B"};
  layout.channels = *channels;
  for (const std::string& channel : layout.channels) {
    const Imf::Channel& known = header.channels()[channel.c_str()];
    if (known.xSampling != 1 || known.ySampling != 1)
      return Error{name + " has subsampled colours; save it with the channels R, G and B"};
  }
  return layout;
}

std::vector<glm::vec3> read_pixels(MemoryStream& stream, const Layout& layout) {
  const size_t width = side(layout.data.min.x, layout.data.max.x),
               height = side(layout.data.min.y, layout.data.max.y);
  std::vector<glm::vec3> pixels(width * height);
  stream.seekg(0);
  Imf::InputFile file(stream, 0);
  const bool is_grey = layout.channels[0] == layout.channels[1];
  Imf::FrameBuffer buffer;
  for (int c = 0; c < (is_grey ? 1 : 3); ++c) {
    buffer.insert(layout.channels[static_cast<size_t>(c)],
                  Imf::Slice::Make(Imf::FLOAT, &pixels[0][c], layout.data, sizeof(glm::vec3),
                                   sizeof(glm::vec3) * width));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(layout.data.min.y, layout.data.max.y);
  if (is_grey) {
    for (glm::vec3& pixel : pixels) pixel = glm::vec3(pixel.x);
  }
  return pixels;
}

EnvironmentImage packed(const Layout& layout, const std::vector<glm::vec3>& pixels) {
  float brightest = 0;
  for (const glm::vec3& pixel : pixels) {
    for (int c = 0; c < 3; ++c) {
      if (std::isfinite(pixel[c])) brightest = std::max(brightest, pixel[c]);
    }
  }
  EnvironmentImage image;
  image.width = static_cast<uint32_t>(side(layout.display.min.x, layout.display.max.x));
  image.height = static_cast<uint32_t>(side(layout.display.min.y, layout.display.max.y));
  if (brightest > 0)
    image.scale = environment_scale(std::ldexp(1.0f, std::min(std::ilogb(brightest) + 1, 127)));
  image.rgb9e5.reserve(size_t{image.width} * image.height);
  const size_t data_width = side(layout.data.min.x, layout.data.max.x);
  for (int y = layout.display.min.y; y <= layout.display.max.y; ++y) {
    for (int x = layout.display.min.x; x <= layout.display.max.x; ++x) {
      glm::vec3 radiance(0);
      if (layout.data.intersects({x, y})) {
        radiance = pixels[data_width * static_cast<size_t>(y - layout.data.min.y) +
                          static_cast<size_t>(x - layout.data.min.x)];
      }
      image.rgb9e5.push_back(pack_rgb9e5(radiance / image.scale));
    }
  }
  return image;
}

}  // namespace

bool is_openexr_file(std::span<const std::byte> bytes) {
  return bytes.size() >= kPrologueBytes &&
         std::memcmp(bytes.data(), kOpenExrMagic.data(), kOpenExrMagic.size()) == 0;
}

Result<EnvironmentImage> decode_openexr_file(std::span<const std::byte> bytes, const std::string& name) {
  if (!is_openexr_file(bytes)) return Error{name + " is not an OpenEXR image"};
  if (!headers_fit(bytes)) return Error{name + ": the header ends early; copy or save the file again"};
  try {
    // The size of tiles is limited before memory for them is allocated.
    static const bool kAreTilesLimited = [] {
      Imf::Header::setMaxTileSize(kMaxEnvironmentWidth, kMaxEnvironmentHeight);
      return true;
    }();
    static_cast<void>(kAreTilesLimited);
    MemoryStream stream(bytes, name);
    const Result<Layout> layout = read_layout(stream, name);
    if (!layout) return layout.error();
    return packed(*layout, read_pixels(stream, *layout));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& fault) {
    return Error{name + " cannot be read: " + fault.what()};
  }
}

}  // namespace fire3dv::scene
