#include "renderer/passes/environment/environment.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>
#include <string_view>

#include "renderer/gpu/pipelines/pipeline.h"
#include "shaders/shared/bindings.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

constexpr uint32_t kMaxSteps = 48;  // two cubes of at most ten levels, and single steps

// Compute steps of environment preprocessing: each writes one level of an image.
class EnvironmentSteps {
 public:
  EnvironmentSteps(gpu::Device& device, gpu::LoaderCommands& loader);

  // Reads all levels of `in` through a sampler.
  void sample(std::string_view shader, gpu::Image& in, VkSampler sampler, gpu::Image& out, uint32_t level,
              gpu_types::EnvironmentPush push);
  // Reads one level texel by texel.
  void load(std::string_view shader, gpu::Image& in, uint32_t in_level, gpu::Image& out, uint32_t level,
            gpu_types::EnvironmentPush push);
  // Reads no image.
  void fill(std::string_view shader, gpu::Image& out, gpu_types::EnvironmentPush push);

 private:
  struct Input {
    gpu::Image* image = nullptr;
    VkSampler sampler = VK_NULL_HANDLE;  // null: reads `level` texel by texel
    uint32_t level = 0;
  };
  void step(std::string_view shader, const Input& in, gpu::Image& out, uint32_t level,
            gpu_types::EnvironmentPush push);

  gpu::Device& device_;
  gpu::LoaderCommands& loader_;
  gpu::SetLayout set_layout_;
  gpu::PipelineLayout layout_;
  gpu::DescriptorPool pool_;
  // Alive until the commands are done; they retire with this object.
  std::vector<gpu::ImageView> views_;
  std::vector<std::pair<std::string_view, gpu::Pipeline>> pipelines_;
};

EnvironmentSteps::EnvironmentSteps(gpu::Device& device, gpu::LoaderCommands& loader)
    : device_(device), loader_(loader) {
  constexpr VkShaderStageFlags kStage = VK_SHADER_STAGE_COMPUTE_BIT;
  const VkDescriptorSetLayoutBinding bindings[] = {
      {FIRE3DV_BINDING_LEVEL_IN, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, kStage, nullptr},
      {FIRE3DV_BINDING_LEVEL_OUT, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, kStage, nullptr},
      {FIRE3DV_BINDING_LEVEL_ABOVE, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, kStage, nullptr},
  };
  set_layout_ = gpu::create_set_layout(device, bindings);
  layout_ = gpu::create_pipeline_layout(device, std::array{set_layout_.get()});

  const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kMaxSteps},
                                        {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 2 * kMaxSteps}};
  pool_ = gpu::create_descriptor_pool(device, kMaxSteps, sizes);
}

void EnvironmentSteps::sample(std::string_view shader, gpu::Image& in, VkSampler sampler, gpu::Image& out,
                              uint32_t level, gpu_types::EnvironmentPush push) {
  step(shader, {&in, sampler, 0}, out, level, push);
}

void EnvironmentSteps::load(std::string_view shader, gpu::Image& in, uint32_t in_level, gpu::Image& out,
                            uint32_t level, gpu_types::EnvironmentPush push) {
  step(shader, {&in, VK_NULL_HANDLE, in_level}, out, level, push);
}

void EnvironmentSteps::fill(std::string_view shader, gpu::Image& out, gpu_types::EnvironmentPush push) {
  step(shader, {}, out, 0, push);
}

void EnvironmentSteps::step(std::string_view shader, const Input& in, gpu::Image& out, uint32_t level,
                            gpu_types::EnvironmentPush push) {
  auto known = std::find_if(pipelines_.begin(), pipelines_.end(),
                            [&](const auto& entry) { return entry.first == shader; });
  if (known == pipelines_.end()) {
    pipelines_.emplace_back(shader, gpu::create_compute_pipeline(device_, layout_.get(), shader));
    known = pipelines_.end() - 1;
  }

  const VkDescriptorSet set = gpu::allocate_set(device_, pool_.get(), set_layout_.get());

  std::vector<Use> uses;
  std::array<VkDescriptorImageInfo, 2> images{};
  std::array<VkWriteDescriptorSet, 2> writes{};
  views_.push_back(gpu::create_level_view(device_, out, level));
  images[0] = {VK_NULL_HANDLE, views_.back().get(), VK_IMAGE_LAYOUT_GENERAL};
  writes[0] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  writes[0].dstBinding = FIRE3DV_BINDING_LEVEL_OUT;
  writes[0].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  uses.emplace_back(out, access::compute_write);
  if (in.image) {
    writes[1] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    if (in.sampler) {
      images[1] = {in.sampler, in.image->view.get(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
      writes[1].dstBinding = FIRE3DV_BINDING_LEVEL_IN;
      writes[1].descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
      uses.emplace_back(*in.image, access::compute_sample);
    } else {
      views_.push_back(gpu::create_level_view(device_, *in.image, in.level));
      images[1] = {VK_NULL_HANDLE, views_.back().get(), VK_IMAGE_LAYOUT_GENERAL};
      writes[1].dstBinding = FIRE3DV_BINDING_LEVEL_ABOVE;
      writes[1].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
      if (in.image != &out) uses.emplace_back(*in.image, access::compute_read);
    }
  }
  const uint32_t write_count = in.image ? 2 : 1;
  for (uint32_t i = 0; i < write_count; ++i) {
    writes[i].dstSet = set;
    writes[i].descriptorCount = 1;
    writes[i].pImageInfo = &images[i];
  }
  vkUpdateDescriptorSets(device_.handle(), write_count, writes.data(), 0, nullptr);

  push.size = std::max(out.extent.width >> level, 1u);
  loader_.recorder().pass("environment", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, known->second.get());
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 1, &set, 0, nullptr);
    vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdDispatch(commands, (push.size + 7) / 8, (push.size + 7) / 8, out.layers);
  });
}

// Maps read at every pixel have 4 bytes per texel, which a CPU unpacks for all lanes at once. It unpacks
// texels of 8 bytes one by one.
struct MapFormat {
  VkFormat sampled, written_as;
  size_t texel_bytes;
};
constexpr MapFormat kPackedRadiance{VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, VK_FORMAT_R32_UINT, 4};
constexpr MapFormat kHalves{VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R16G16B16A16_SFLOAT, 8};
// Packed maps are written by shaders that define FIRE3DV_PACKED_RADIANCE.
constexpr MapFormat kSpecular = kPackedRadiance, kIrradiance = kPackedRadiance, kAlbedo = kHalves;
constexpr uint32_t kMinFace = 64, kMaxFace = 512;  // texels along a face of the sharpest reflection
constexpr uint32_t kRoughestFace = 8, kSmallestFace = 4, kIrradianceFace = 16;
constexpr uint32_t kAlbedoSide = FIRE3DV_ENVIRONMENT_ALBEDO_SIDE, kAlbedoSamples = 256;

constexpr gpu::Access kShading{
    VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
    VK_ACCESS_2_SHADER_READ_BIT, false, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};

uint32_t levels_between(uint32_t largest, uint32_t smallest) {
  return static_cast<uint32_t>(std::bit_width(largest) - std::bit_width(smallest)) + 1;
}

// Halves both sides: means of four texels, or of fewer at an odd edge.
std::vector<uint32_t> halved(const std::vector<uint32_t>& texels, uint32_t width, uint32_t height) {
  const uint32_t half_width = std::max(width / 2, 1u), half_height = std::max(height / 2, 1u);
  std::vector<uint32_t> half(size_t{half_width} * half_height);
  for (uint32_t y = 0; y < half_height; ++y) {
    const size_t rows[] = {size_t{2} * y * width, size_t{std::min(2 * y + 1, height - 1)} * width};
    for (uint32_t x = 0; x < half_width; ++x) {
      const uint32_t left = 2 * x, right = std::min(2 * x + 1, width - 1);
      glm::vec3 sum(0);
      for (const size_t row : rows) {
        sum += scene::unpack_rgb9e5(texels[row + left]) + scene::unpack_rgb9e5(texels[row + right]);
      }
      half[size_t{y} * half_width + x] = scene::pack_rgb9e5(sum * 0.25f);
    }
  }
  return half;
}

// Computes mip levels on the CPU, since the packed format is not renderable.
gpu::Image upload_equirectangular(gpu::Device& device, gpu::LoaderCommands& loader,
                                  const scene::EnvironmentImage& source) {
  gpu::ImageInfo info;
  info.format = VK_FORMAT_E5B9G9R9_UFLOAT_PACK32;
  info.extent = {source.width, source.height};
  info.mip_levels = static_cast<uint32_t>(std::bit_width(std::max(source.width, source.height)));
  info.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  gpu::Image image = gpu::create_image(device, info);
  loader.upload_level(image, 0, std::as_bytes(std::span(source.rgb9e5)));
  std::vector<uint32_t> texels;
  for (uint32_t level = 1; level < info.mip_levels; ++level) {
    const std::vector<uint32_t>& above = level == 1 ? source.rgb9e5 : texels;
    texels =
        halved(above, std::max(source.width >> (level - 1), 1u), std::max(source.height >> (level - 1), 1u));
    loader.upload_level(image, level, std::as_bytes(std::span(texels)));
  }
  return image;
}

gpu::Image create_map(gpu::Device& device, const MapFormat& format, uint32_t side, uint32_t levels,
                      bool cube) {
  gpu::ImageInfo info;
  info.format = format.sampled;
  info.written_as = format.written_as;
  info.extent = {side, side};
  info.mip_levels = levels;
  info.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
               VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  info.cube = cube;
  return gpu::create_image(device, info);
}

gpu::Sampler create_sampler(gpu::Device& device, VkSamplerAddressMode around) {
  VkSamplerCreateInfo info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  info.magFilter = info.minFilter = VK_FILTER_LINEAR;
  info.mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR;
  info.addressModeU = around;
  info.addressModeV = info.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  info.maxLod = VK_LOD_CLAMP_NONE;
  VkSampler sampler = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateSampler(device.handle(), &info, nullptr, &sampler));
  return gpu::Sampler(device, sampler);
}

// Polished surfaces get more levels, since their reflections show more detail. Inverse of the mapping in
// environment.glsl.
float roughness_of_level(uint32_t level, uint32_t levels) {
  return 1 - std::sqrt(1 - static_cast<float>(level) / static_cast<float>(levels - 1));
}

// Narrow lobes need few samples, since each is prefiltered; wide lobes have few texels.
uint32_t samples_of_level(uint32_t level) {
  return std::min(32u << (level - 1), 128u);
}

}  // namespace

Digest environment_kind(const VkPhysicalDeviceProperties& device, const scene::EnvironmentImage& image,
                        std::span<const uint32_t> recipe) {
  std::string text =
      hex(gpu::device_kind(device, "environment_")) + hex(digest_of(std::as_bytes(std::span(image.rgb9e5))));
  for (const uint32_t number : {image.width, image.height}) text += '\0' + std::to_string(number);
  for (const uint32_t number : recipe) text += '\0' + std::to_string(number);
  return digest_of(std::as_bytes(std::span(text)));
}

Environment::Environment(gpu::Device& device, const scene::EnvironmentImage& image,
                         const scene::EnvironmentImage& lighting, EnvironmentStore* cache)
    : device_(device),
      scale_(image.scale),
      background_sampler_(create_sampler(device, VK_SAMPLER_ADDRESS_MODE_REPEAT)),
      map_sampler_(create_sampler(device, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE)) {
  gpu::LoaderCommands loader(device);
  background_image_ = upload_equirectangular(device, loader, image);
  const Recipe recipe = Recipe::of(image);
  specular_ = create_map(device, kSpecular, recipe.face, static_cast<uint32_t>(recipe.specular.size()), true);
  irradiance_ = create_map(device, kIrradiance, kIrradianceFace, 1, true);
  albedo_ = create_map(device, kAlbedo, kAlbedoSide, 1, false);

  size_t bytes = 0;
  for (const Level& level : levels()) bytes += level.bytes;
  const Digest kind = cache ? environment_kind(device.identity(), lighting, recipe.numbers()) : Digest{};
  const auto found = cache ? cache->find(kind, bytes) : std::nullopt;
  if (found) {
    upload(loader, *found);
  } else {
    if (&lighting == &image) {
      prepare(loader, recipe, background_image_);
    } else {
      gpu::Image without_sun = upload_equirectangular(device, loader, lighting);
      prepare(loader, recipe, without_sun);
    }
    if (cache) cache->keep(kind, download(loader));
  }
  loader.recorder().transition({Use(background_image_, kShading), Use(specular_, kShading),
                                Use(irradiance_, kShading), Use(albedo_, kShading)});
  loader.finish();
}

std::vector<Environment::Level> Environment::levels() {
  std::vector<Level> levels;
  const auto add = [&](gpu::Image& image, const MapFormat& format) {
    for (uint32_t level = 0; level < image.mip_levels; ++level) {
      const size_t side = image.extent.width >> level;
      levels.push_back({&image, level, image.layers * side * side * format.texel_bytes});
    }
  };
  add(specular_, kSpecular);
  add(irradiance_, kIrradiance);
  add(albedo_, kAlbedo);
  return levels;
}

Environment::Recipe Environment::Recipe::of(const scene::EnvironmentImage& image) {
  Recipe recipe;
  recipe.face = std::clamp(std::bit_floor(std::max(image.height / 2, 1u)), kMinFace, kMaxFace);
  recipe.radiance_levels = levels_between(recipe.face, kSmallestFace);
  recipe.irradiance_from = levels_between(recipe.face, kIrradianceFace) - 1;
  const float texels_per_texel = static_cast<float>(image.height) / static_cast<float>(2 * recipe.face);
  recipe.cube = {0, 0, 0, std::max(std::log2(texels_per_texel), 0.0f)};
  recipe.albedo = {0, kAlbedoSamples, 0, 0};
  const uint32_t levels = levels_between(recipe.face, kRoughestFace);
  for (uint32_t level = 0; level < levels; ++level) {
    recipe.specular.push_back({0, level ? samples_of_level(level) : 1, roughness_of_level(level, levels), 0});
  }
  return recipe;
}

std::vector<uint32_t> Environment::Recipe::numbers() const {
  std::vector<uint32_t> numbers{face,
                                radiance_levels,
                                irradiance_from,
                                kIrradianceFace,
                                kAlbedoSide,
                                uint32_t{kSpecular.sampled},
                                uint32_t{kIrradiance.sampled},
                                uint32_t{kAlbedo.sampled}};
  const auto add = [&](const gpu_types::EnvironmentPush& push) {
    numbers.insert(numbers.end(), {push.samples, std::bit_cast<uint32_t>(push.roughness),
                                   std::bit_cast<uint32_t>(push.lod)});
  };
  add(cube);
  add(albedo);
  for (const gpu_types::EnvironmentPush& push : specular) add(push);
  return numbers;
}

void Environment::prepare(gpu::LoaderCommands& loader, const Recipe& recipe, gpu::Image& lighting) {
  gpu::Image radiance = create_map(device_, kHalves, recipe.face, recipe.radiance_levels, true);
  EnvironmentSteps steps(device_, loader);
  steps.sample("environment_cube.comp", lighting, background_sampler_.get(), radiance, 0, recipe.cube);
  for (uint32_t level = 1; level < recipe.radiance_levels; ++level) {
    steps.load("environment_downsample.comp", radiance, level - 1, radiance, level, {});
  }
  steps.load("environment_irradiance.comp", radiance, recipe.irradiance_from, irradiance_, 0, {});
  for (uint32_t level = 0; level < specular_.mip_levels; ++level) {
    steps.sample("environment_specular.comp", radiance, map_sampler_.get(), specular_, level,
                 recipe.specular[level]);
  }
  steps.fill("environment_albedo.comp", albedo_, recipe.albedo);
  loader.finish();  // waits, since the steps' resources end here
}

void Environment::upload(gpu::LoaderCommands& loader, std::span<const std::byte> maps) {
  for (const Level& level : levels()) {
    loader.upload_level(*level.image, level.level, maps.first(level.bytes));
    maps = maps.subspan(level.bytes);
  }
}

std::vector<std::byte> Environment::download(gpu::LoaderCommands& loader) {
  const std::vector<Level> all = levels();
  size_t bytes = 0;
  for (const Level& level : all) bytes += level.bytes;
  gpu::Buffer buffer =
      gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, gpu::Memory::readback);
  VkDeviceSize offset = 0;
  for (const Level& level : all) {
    loader.download_level(*level.image, level.level, buffer, offset);
    offset += level.bytes;
  }
  loader.recorder().transition({Use(buffer, gpu::access::host_read)});
  loader.finish();
  return {buffer.mapped, buffer.mapped + bytes};
}

gpu::EnvironmentTextures Environment::textures() const {
  return {{{background_image_.view.get(), background_sampler_.get()},
           {specular_.view.get(), map_sampler_.get()},
           {irradiance_.view.get(), map_sampler_.get()},
           {albedo_.view.get(), map_sampler_.get()}}};
}

void Environment::describe(gpu_types::Globals& globals, float intensity, float rotation_rad) const {
  globals.environment_intensity = intensity * scale_;
  globals.environment_turn = {std::cos(rotation_rad), std::sin(rotation_rad)};
}

float Environment::background_level(const View& view, uint32_t image_height) const {
  return equirectangular_level(view, image_height, background_image_.extent.height);
}

float equirectangular_level(const View& view, uint32_t image_height, uint32_t texels_high) {
  const float pixel_rad = 2 * glm::length(view.world_from_ndc_y) / static_cast<float>(image_height);
  const float texel_rad = 3.14159265f / static_cast<float>(texels_high);
  return pixel_rad > texel_rad ? std::log2(pixel_rad / texel_rad) : 0;
}

}  // namespace fire3dv::passes
