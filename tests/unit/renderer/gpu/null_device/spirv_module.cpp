#include "tests/unit/renderer/gpu/null_device/spirv_module.h"

#include <algorithm>
#include <vector>

namespace fire3dv::test {
namespace {

// Numbers of the SPIR-V specification.
enum Op : uint32_t {
  kEntryPoint = 15,
  kExecutionMode = 16,
  kCapability = 17,
  kTypeInt = 21,
  kTypeFloat = 22,
  kTypeVector = 23,
  kTypeMatrix = 24,
  kTypeImage = 25,
  kTypeSampledImage = 27,
  kTypeArray = 28,
  kTypeRuntimeArray = 29,
  kTypeStruct = 30,
  kTypePointer = 32,
  kConstant = 43,
  kSpecConstantTrue = 48,
  kSpecConstantFalse = 49,
  kSpecConstant = 50,
  kVariable = 59,
  kDecorate = 71,
  kMemberDecorate = 72,
  kExecutionModeId = 331,
  kTypeAccelerationStructure = 5341,
};
enum Decoration : uint32_t { kSpecId = 1, kBinding = 33, kDescriptorSet = 34, kOffset = 35 };
enum StorageClass : uint32_t {
  kUniformConstant = 0,
  kUniform = 2,
  kWorkgroup = 4,
  kPushConstant = 9,
  kStorage = 12
};
constexpr uint32_t kLocalSize = 17, kLocalSizeId = 38;  // execution modes

VkShaderStageFlagBits stage_of(uint32_t model) {
  switch (model) {
    case 0:
      return VK_SHADER_STAGE_VERTEX_BIT;
    case 4:
      return VK_SHADER_STAGE_FRAGMENT_BIT;
    case 5313:
      return VK_SHADER_STAGE_RAYGEN_BIT_KHR;
    case 5315:
      return VK_SHADER_STAGE_ANY_HIT_BIT_KHR;
    case 5316:
      return VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR;
    case 5317:
      return VK_SHADER_STAGE_MISS_BIT_KHR;
    default:
      return VK_SHADER_STAGE_COMPUTE_BIT;
  }
}

class Reader {
 public:
  SpirvModule read(std::span<const uint32_t> code) {
    for (size_t at = 5; at < code.size();) {
      const uint32_t words = code[at] >> 16;
      FIRE3DV_ASSERT(words > 0 && at + words <= code.size());
      read_instruction(code[at] & 0xffff, code.subspan(at + 1, words - 1));
      at += words;
    }
    if (!size_ids_.empty())
      module_.threads = constants_[size_ids_[0]] * constants_[size_ids_[1]] * constants_[size_ids_[2]];
    return std::move(module_);
  }

 private:
  struct Type {
    uint32_t op = 0;
    std::vector<uint32_t> operands;
  };

  void read_instruction(uint32_t op, std::span<const uint32_t> in) {
    switch (op) {
      case kCapability:
        module_.capabilities.insert(in[0]);
        break;
      case kEntryPoint:
        module_.stage = stage_of(in[0]);
        break;
      case kExecutionMode:
        if (in[1] == kLocalSize) module_.threads = in[2] * in[3] * in[4];
        break;
      case kExecutionModeId:
        if (in[1] == kLocalSizeId) size_ids_.assign(in.begin() + 2, in.begin() + 5);
        break;
      case kDecorate:
        if (in.size() > 2) decorations_[{in[0], in[1]}] = in[2];
        break;
      case kMemberDecorate:
        if (in[2] == kOffset) offsets_[in[0]][in[1]] = in[3];
        break;
      case kConstant:
      case kSpecConstant:
        constants_[in[1]] = in[2];
        break;
      case kSpecConstantTrue:
      case kSpecConstantFalse:
        if (const auto id = decorations_.find({in[1], kSpecId}); id != decorations_.end())
          module_.booleans[id->second] = op == kSpecConstantTrue;
        break;
      case kVariable:
        add_variable(types_[in[0]].operands[1], in[1], in[2]);
        break;
      default:
        if ((op >= kTypeInt && op <= kTypePointer) || op == kTypeAccelerationStructure)
          types_[in[0]] = {op, {in.begin() + 1, in.end()}};
    }
  }

  void add_variable(uint32_t type, uint32_t variable, uint32_t storage) {
    if (storage == kWorkgroup) module_.shared_bytes += size_of(type);
    if (storage == kPushConstant) module_.push_constant_bytes = size_of(type);
    const auto binding = decorations_.find({variable, kBinding});
    if ((storage != kUniformConstant && storage != kUniform && storage != kStorage) ||
        binding == decorations_.end())
      return;
    module_.descriptors[{decorations_[{variable, kDescriptorSet}], binding->second}] =
        descriptor_type(type, storage);
  }

  VkDescriptorType descriptor_type(uint32_t id, uint32_t storage) {
    const Type& type = types_[id];
    switch (type.op) {
      case kTypeArray:
      case kTypeRuntimeArray:
        return descriptor_type(type.operands[0], storage);
      case kTypeSampledImage:
        return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
      case kTypeAccelerationStructure:
        return VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
      case kTypeImage:  // operand 5: 2 is a storage image
        return type.operands[5] == 2 ? VK_DESCRIPTOR_TYPE_STORAGE_IMAGE : VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE;
      default:
        return storage == kUniform ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    }
  }

  uint32_t size_of(uint32_t id) {
    const Type& type = types_[id];
    switch (type.op) {
      case kTypeInt:
      case kTypeFloat:
        return type.operands[0] / 8;
      case kTypeVector:
      case kTypeMatrix:
        return type.operands[1] * size_of(type.operands[0]);
      case kTypeArray:
        return constants_[type.operands[1]] * size_of(type.operands[0]);
      case kTypePointer:
        return sizeof(VkDeviceAddress);
      case kTypeStruct: {
        uint32_t end = 0;
        for (uint32_t i = 0; i < type.operands.size(); ++i) {
          const auto offset = offsets_[id].find(i);
          end = std::max(end,
                         (offset == offsets_[id].end() ? end : offset->second) + size_of(type.operands[i]));
        }
        return end;
      }
      default:
        return 4;  // a boolean
    }
  }

  SpirvModule module_;
  std::vector<uint32_t> size_ids_;  // constants of the workgroup's size
  std::map<uint32_t, Type> types_;
  std::map<uint32_t, uint32_t> constants_;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> decorations_;
  std::map<uint32_t, std::map<uint32_t, uint32_t>> offsets_;
};

}  // namespace

SpirvModule read_spirv(std::span<const uint32_t> code) {
  return Reader().read(code);
}

}  // namespace fire3dv::test
