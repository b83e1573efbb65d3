// Messages about images as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "protocol/wire/encode.h"

namespace fire3dv::conformance {

nlohmann::ordered_json image_to_json(const wire::ImageRequest& m);
nlohmann::ordered_json image_to_json(const wire::ImageFrame& m);
nlohmann::ordered_json image_to_json(const wire::ImageRefused& m);
// Empty where the JSON is of another message.
wire::Bytes encode_image_json(const nlohmann::ordered_json& json);

}  // namespace fire3dv::conformance
