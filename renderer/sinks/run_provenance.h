// Provenance of a run: digests of its inputs, its options, the build and the machine. With the number of an
// image it determines the pixels, so that `fire3dv verify` can draw the image again. Images carry it as JSON:
//
//   PNG   text chunk "Provenance"
//   video metadata "comment"
//   data set, folder of frames   manifest.json, "provenance"
//
// Texts of files are untrusted. No value is a path of a file: inputs are digests, `files` are names alone.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"

namespace fire3dv::sinks {

struct RunProvenance {
  using Values = std::vector<std::pair<std::string, std::string>>;  // names may repeat in `options`

  std::string command;  // "render", "dataset", or "fire3dv" for live runs
  Values build;         // version, commit, build_id
  Values machine;       // device, driver, cpu
  Values files;         // names of "recording" and "scene" without folders, as a hint
  Values inputs;        // digests and texts that determine the pixels: "scene", "recording", ...
  Values options;       // of the command line, without dashes; flags have an empty value
  bool operator==(const RunProvenance&) const = default;
};

constexpr const char* kProvenanceKeyword = "Provenance";
constexpr size_t kMaxProvenanceBytes = 64 << 10;

// Version, commit and linker's build ID of this program. The ID changes with the code and the shaders.
RunProvenance::Values this_build();
std::string cpu_name();  // of this machine

// One line of ASCII. nullopt: it would be longer than kMaxProvenanceBytes.
std::optional<std::string> encode_provenance(const RunProvenance& provenance);
// Untrusted text. The error says what is wrong with it.
Result<RunProvenance> decode_provenance(std::string_view text);

// Value of a name; null: there is none.
const std::string* find_value(const RunProvenance::Values& values, std::string_view name);
// First difference of two lists, such as "scene is A in the file and B here"; nullopt: there is none.
std::optional<std::string> first_difference(const RunProvenance::Values& in_file,
                                            const RunProvenance::Values& here);

}  // namespace fire3dv::sinks
