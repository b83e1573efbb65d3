// Command line that draws the images of a run again, from their provenance.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/sinks/run_provenance.h"
#include "renderer/verify/options.h"

namespace fire3dv::verify {

// Inputs that the user names, or that lie beside the image under the name that its provenance has; a name
// with a folder is never used. Error: an input is missing. needs_recording: the images show a stream.
struct Inputs {
  std::filesystem::path recording, scene;  // empty: the run had none
};
Result<Inputs> find_inputs(const VerifyOptions& options, const std::filesystem::path& folder,
                           const sinks::RunProvenance& provenance, bool needs_recording);

// Words after the program's name: of `fire3dv render` and `fire3dv dataset` with the command, of live runs
// without. Options of the user replace those of the provenance. Error: the provenance has an option that
// opens a file, or an unknown one. out: value of --out, which is not written.
Result<std::vector<std::string>> words_of_run(const sinks::RunProvenance& provenance, const Inputs& inputs,
                                              const std::vector<std::string>& user_words,
                                              const std::string& out);

}  // namespace fire3dv::verify
