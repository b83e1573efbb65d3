#include "convert/mjcf/deformable/composite.h"

#include <algorithm>

#include "base/text.h"
#include "convert/mjcf/deformable/composite_parts.h"

namespace fire3dv::convert {
namespace {

constexpr int64_t kMaxBodies = 100'000;
constexpr int kMaxChain = 1000;

// Counts of 1 come last.
Result<int> dimensions_of(const CompositeParts& parts) {
  int dimensions = 0;
  int64_t bodies = 1;
  bool had_one = false;
  for (const int count : parts.count) {
    if (count < 1) return Error{"its count is not positive"};
    if (count > 1 && had_one) return Error{"a count of 1 is before a greater one"};
    had_one = had_one || count == 1;
    dimensions += count > 1;
    bodies = std::min(bodies * count, 2 * kMaxBodies);
  }
  if (bodies > kMaxBodies) return Error{"it has more than " + std::to_string(kMaxBodies) + " bodies"};
  return dimensions;
}

}  // namespace

Result<Composite> expand_composite(const MjcfAttributes& from, const std::string& body) {
  CompositeParts parts(from, body);
  Composite made;
  const Result<int> dimensions = dimensions_of(parts);
  if (!dimensions) return dimensions.error();
  parts.dimensions = *dimensions;
  const std::string& type = parts.type;
  const bool is_shell = type == "box" || type == "cylinder" || type == "ellipsoid";
  const bool is_chain = type == "rope" || type == "loop" || type == "cloth";
  if (is_chain && std::max(parts.count[0], parts.count[1]) > kMaxChain)
    return Error{"it has more than " + std::to_string(kMaxChain) + " bodies in a chain"};
  const MjcfElement* const skin = parts.child("skin");
  // A skin hides the geoms.
  parts.shows_geoms = !skin || type == "cable" || is_shell;
  Result<void> done;
  if (type == "cable")
    done = expand_cable(parts, made);
  else if (type == "particle" || type == "grid")
    done = expand_particles(parts, made);
  else if (type == "rope" || type == "loop")
    done = expand_rope(parts, made);
  else if (type == "cloth")
    done = expand_cloth(parts, made);
  else if (is_shell)
    done = expand_shell(parts, made);
  else
    done = Error{"type=" + quote(type) + " is unknown"};
  if (!done) return done.error();
  if (skin && is_shell) made.note = "its bodies are shown without the skin";
  if (skin && made.skin && !skin->text("subgrid").empty() && skin->text("subgrid") != "0")
    made.note = "its skin is shown without subgrid";
  return made;
}

}  // namespace fire3dv::convert
