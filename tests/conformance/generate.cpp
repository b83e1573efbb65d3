// Generator of the golden messages and their JSON:
//   build/<preset>/tests/conformance_generate tests/conformance/data
// Run it by hand after a deliberate change of the protocol, and review the diff before the commit.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "protocol/wire/decode.h"
#include "tests/conformance/cases.h"
#include "tests/conformance/json_message.h"

namespace conformance = fire3dv::conformance;
namespace wire = fire3dv::wire;

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: conformance_generate FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  wire::Decoder decoder;
  const auto write = [&](const std::vector<conformance::Case>& cases) {
    for (const conformance::Case& one : cases) {
      nlohmann::ordered_json meaning;
      if (!one.refused.empty()) {
        meaning["refused"] = one.refused;
      } else {
        const auto message = decoder.decode(one.bytes);
        if (!message.ok()) {
          std::fprintf(stderr, "%s: %s\n", one.name.c_str(), message.error().message.c_str());
          return false;
        }
        if (!one.encodable) meaning["only_read"] = true;
        meaning["message"] = conformance::to_json(*message);
      }
      std::ofstream(folder / (one.name + ".bin"), std::ios::binary)
          .write(reinterpret_cast<const char*>(one.bytes.data()),
                 static_cast<std::streamsize>(one.bytes.size()));
      std::ofstream(folder / (one.name + ".json")) << meaning.dump(1) << '\n';
    }
    return true;
  };
  const bool good = write(conformance::cases_of_this_version()) &&
                    write(conformance::cases_of_later_versions()) && write(conformance::refused_cases()) &&
                    write(conformance::edit_cases()) && write(conformance::later_edit_cases()) &&
                    write(conformance::refused_edit_cases()) && write(conformance::scalar_cases()) &&
                    write(conformance::refused_scalar_cases()) && write(conformance::input_cases()) &&
                    write(conformance::later_input_cases()) && write(conformance::refused_input_cases()) &&
                    write(conformance::image_cases()) && write(conformance::refused_image_cases());
  return good ? 0 : 1;
}
