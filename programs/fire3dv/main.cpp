#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <variant>
#include <vector>

#include "base/log.h"
#include "base/nearest_names.h"
#include "base/process/failure.h"
#include "base/text.h"
#include "renderer/app/drake_command.h"
#include "renderer/app/options/options.h"
#include "renderer/app/start.h"
#include "renderer/app/stop_signals.h"
#include "renderer/dataset/command.h"
#include "renderer/dataset/dataset_format.h"
#include "renderer/doctor/command/command.h"
#include "renderer/offline/commands.h"
#include "renderer/relabel/command.h"
#include "renderer/verify/command.h"

namespace {

constexpr int kUsageError = 2;

// exit_code_if_stopped: nullopt: signals end the program, which then starts no thread for them.
template <typename Options>
int run_with(const std::variant<Options, int>& options, int (*run)(const Options&),
             std::optional<int> exit_code_if_stopped) {
  if (const int* exit_code = std::get_if<int>(&options)) return *exit_code;
  if (exit_code_if_stopped) fire3dv::app::install_stop_signals(*exit_code_if_stopped);
  try {
    return run(std::get<Options>(options));
  } catch (const std::exception& failure) {  // Vulkan errors and out of memory: not recoverable
    return fire3dv::report_failure(fire3dv::Error{fire3dv::describe_failure(failure)});
  }
}

// Error for a first word that is neither a command nor a file. nullopt: it is one, or an option.
std::optional<std::string> find_wrong_command(const std::string& word) {
  static const std::vector<std::string> kCommands{"dataset", "doctor", "join", "relabel", "render", "verify"};
  std::error_code fault;
  if (word.empty() || word.find_first_of("-./") != std::string::npos || std::filesystem::exists(word, fault))
    return std::nullopt;
  return "there is no command and no file " + fire3dv::quote(word) +
         fire3dv::name_hint(word, kCommands, "commands");
}

int join(const fire3dv::offline::JoinOptions& options) {
  return fire3dv::offline::join(options, fire3dv::dataset::DatasetFormat::find);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace fire3dv;
  const std::string_view command = argc > 1 ? argv[1] : "";
  if (command == "render") return run_with(offline::parse_render_options(argc, argv), offline::render, 1);
  if (command == "dataset") return run_with(dataset::parse_dataset_options(argc, argv), dataset::run, 1);
  if (command == "relabel") return run_with(relabel::parse_relabel_options(argc, argv), relabel::run, 1);
  if (command == "join") return run_with(offline::parse_join_options(argc, argv), join, 1);
  if (command == "verify")
    return run_with(verify::parse_verify_options(argc, argv), verify::run, verify::kUnchecked);
  if (command == "doctor") return run_with(doctor::parse_options(argc, argv), doctor::run, std::nullopt);
  if (const auto wrong = find_wrong_command(std::string(command))) {
    std::cerr << "fire3dv: error: " << *wrong << " (see fire3dv --help)\n";
    return kUsageError;
  }
  if (const auto drake = app::drake_arguments(argc, argv)) return report_failure(app::execute_drake(*drake));
  return run_with(app::parse_options(argc, argv), app::run, 0);
}
