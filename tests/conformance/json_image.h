// JSON conversion of image messages.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "protocol/wire/encode.h"

namespace fire3dv::conformance {

nlohmann::ordered_json image_to_json(const wire::ImageRequest& m);
nlohmann::ordered_json image_to_json(const wire::ImageFrame& m);
nlohmann::ordered_json image_to_json(const wire::ImageRefused& m);
// Returns an empty buffer if the JSON describes another message type.
wire::Bytes encode_image_json(const nlohmann::ordered_json& json);

}  // namespace fire3dv::conformance
