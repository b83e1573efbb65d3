// JSON conversion of scene edit values.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "protocol/wire/scene_edit.h"

namespace fire3dv::conformance {

nlohmann::ordered_json value_to_json(const wire::EditValue& value);
wire::EditValue value_from_json(const nlohmann::ordered_json& json);

}  // namespace fire3dv::conformance
