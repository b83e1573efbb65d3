#include "convert/sdf/sdf_warnings.h"

namespace fire3dv::convert {

void SdfWarnings::add(const std::string& text) {
  if (known_.size() > kMaxWarnings || !known_.insert(text).second) return;
  model_.warnings.push_back(
      prefix_ + (known_.size() > kMaxWarnings
                     ? "further warnings are left out: there are more than " + std::to_string(kMaxWarnings)
                     : text));
}

}  // namespace fire3dv::convert
