// Messages as JSON: the meaning that stands beside each golden message. Says every field, so that a
// comparison of two such texts is a comparison of two messages.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "protocol/wire/encode.h"
#include "protocol/wire/messages.h"

namespace fire3dv::conformance {

// {"type": "Ack", "epoch": 1, ...}. Floats are written with all their digits.
nlohmann::ordered_json to_json(const wire::Message& message);

// Encodes the message that the JSON means, independently of how it was made. Aborts on JSON that means none:
// the files are ours.
wire::Bytes encode_json(const nlohmann::ordered_json& meaning);

}  // namespace fire3dv::conformance
