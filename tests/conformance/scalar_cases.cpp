// Golden messages of scalars (protocol 1.5): valid and invalid.
#include <limits>

#include "tests/conformance/cases.h"

namespace fire3dv::conformance {
namespace {

using namespace wire;

constexpr uint64_t kScalarEpoch = 0x0123456789abcdef;

Scalars joints() {
  return {{"shoulder", "elbow", "K\u00f6rper/\u00b0"}, {"rad", "", "N\u00b7m"}};
}

ScalarValues values() {
  constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();
  return {41, -1'500'000'000, {0.1, kNoValue, -1e300}};
}

SceneEdit scalar_case(Property property, EditValue value) {
  return {kScalarEpoch, 42, "arm/joints", property, std::move(value)};
}

}  // namespace

std::vector<Case> scalar_cases() {
  return {
      {"scene_edit-scalars", encode(scalar_case(Property::scalars, joints())), true, {}},
      {"scene_edit-scalars_one",
       encode(scalar_case(Property::scalars, Scalars{{"energy"}, {"J"}})),
       true,
       {}},
      {"scene_edit-scalars_cleared", encode(scalar_case(Property::scalars, Cleared{})), true, {}},
      {"scene_edit-scalar_values", encode(scalar_case(Property::scalar_values, values())), true, {}},
      {"scene_edit-scalar_values_cleared", encode(scalar_case(Property::scalar_values, Cleared{})), true, {}},
  };
}

std::vector<Case> refused_scalar_cases() {
  std::vector<Case> result;
  const auto add = [&](std::string name, const SceneEdit& bad, std::string refused) {
    result.push_back({"refused-scene_edit_" + std::move(name), encode(bad), false, "SceneEdit." + refused});
  };
  const auto add_scalars = [&](std::string name, std::string refused, auto change) {
    Scalars scalars = joints();
    change(scalars);
    add("scalars_" + std::move(name), scalar_case(Property::scalars, scalars), std::move(refused));
  };
  add_scalars("none", "names is empty", [](Scalars& s) { s = {}; });
  add_scalars("too_many", "names holds 4097", [](Scalars& s) { s.names.assign(kMaxScalars + 1, "x"); });
  add_scalars("name_empty", "names[1]", [](Scalars& s) { s.names[1] = ""; });
  add_scalars("name_newline", "names[0]", [](Scalars& s) { s.names[0] = "a\nb"; });
  add_scalars("name_cut_utf8", "names[2]", [](Scalars& s) { s.names[2] = "\xc3"; });
  add_scalars("name_too_long", "names[2]", [](Scalars& s) { s.names[2] = std::string(1025, 'x'); });
  add_scalars("name_repeated", "names[2] repeats", [](Scalars& s) { s.names[2] = "shoulder"; });
  add_scalars("units_count", "units holds 2", [](Scalars& s) { s.units.pop_back(); });
  add_scalars("unit_too_long", "units[1]", [](Scalars& s) { s.units[1] = std::string(65, 'x'); });
  add_scalars("unit_escape", "units[0]", [](Scalars& s) { s.units[0] = "\x1b[2J"; });
  SceneEdit bad = scalar_case(Property::scalars, joints());
  bad.node = "";
  add("scalars_group_empty", bad, "node is empty");
  add("scalars_of_other_property", scalar_case(Property::scalar_values, joints()), "value");
  ScalarValues scalars = values();
  scalars.declaration = 0;
  add("scalar_values_declaration_zero", scalar_case(Property::scalar_values, scalars), "declaration");
  scalars = values();
  scalars.values.clear();
  add("scalar_values_none", scalar_case(Property::scalar_values, scalars), "values is empty");
  scalars.values.resize(kMaxScalars + 1);
  add("scalar_values_too_many", scalar_case(Property::scalar_values, scalars), "values holds 4097");
  return result;
}

}  // namespace fire3dv::conformance
