#include "renderer/scene/cache/scene_digest.h"

#include <cstdint>
#include <span>
#include <vector>

#include "base/digest.h"
#include "renderer/scene/cache/member_bytes.h"

namespace fire3dv::scene {

std::string content_digest(const Scene& of) {
  // Member visitors take a mutable scene for readers and writers; a writer does not modify it.
  auto& scene = const_cast<Scene&>(of);
  std::vector<uint64_t> values;
  const auto add = [&](std::span<const std::byte> bytes) {
    Checksum checksum;
    checksum.add(bytes);
    values.push_back(checksum.value());
  };
  MemberWriter members;
  visit_members(scene, members);
  add(members.bytes());
  visit_arrays(scene, [&](auto& array) { add(std::as_bytes(std::span(array))); });
  return hex(digest_of(std::as_bytes(std::span(values)))).substr(0, 32);
}

}  // namespace fire3dv::scene
