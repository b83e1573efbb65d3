// JSON conversion of wire messages: the meaning beside each golden message. The JSON contains every field, so
// two messages are equal exactly if their JSON texts are equal.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "protocol/wire/encode.h"
#include "protocol/wire/messages.h"

namespace fire3dv::conformance {

// Returns {"type": "Ack", "epoch": 1, ...}. Floats are written with all digits (round trip).
nlohmann::ordered_json to_json(const wire::Message& message);

// Encodes the message that the JSON describes, independently of the generator. Aborts on invalid JSON: the
// files belong to this project.
wire::Bytes encode_json(const nlohmann::ordered_json& meaning);

}  // namespace fire3dv::conformance
