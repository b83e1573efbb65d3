// Converter program: fire3dv-convert FILE -o OUT.glb converts robot and scene descriptions (AMBF, URDF, MJCF,
// SDF) to one binary glTF file.
#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <map>
#include <new>

#include "base/command_line.h"
#include "base/log.h"
#include "base/output/output_file.h"
#include "base/plural.h"
#include "base/text.h"
#include "convert/glb/cache_entry.h"
#include "convert/glb/glb_joints.h"
#include "convert/glb/list_gltf.h"
#include "convert/glb/write_glb.h"
#include "convert/readers.h"
#include "renderer/scene/cache_files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;
constexpr int kFailed = 1, kUsageError = 2;

struct Options {
  std::string file, out, sources, launch, expanded, dae_up, gltf_up, up, unit;
  std::vector<std::string> package_folders, xacro_arguments;
  std::string smooth_angle;
  bool list = false, joints = false;
  ReadOptions read;
};

// Replaces line breaks and control characters, since names are untrusted and readers parse one message per
// line.
std::string printable(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return fire3dv::printable_text(text, SIZE_MAX);
}

void say(const std::string& text) {
  std::fprintf(stderr, "fire3dv-convert: %s\n", printable(fire3dv::with_level(text)).c_str());
}

int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

// Parses "0,2,5".
bool parse_indices(std::string_view text, std::vector<size_t>& indices) {
  while (!text.empty()) {
    size_t index = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
    if (error != std::errc() || index > 1'000'000) return false;
    indices.push_back(index);
    text.remove_prefix(static_cast<size_t>(end - text.data()));
    if (text.empty()) return true;
    if (!text.starts_with(',')) return false;
    text.remove_prefix(1);
  }
  return false;
}

// Parses NAME=VALUE, and NAME:=VALUE as the program xacro takes it.
bool parse_arguments(const std::vector<std::string>& texts, std::map<std::string, std::string>& arguments) {
  for (const std::string& text : texts) {
    const size_t equals = text.find('=');
    const size_t end =
        equals != std::string::npos && equals > 0 && text[equals - 1] == ':' ? equals - 1 : equals;
    if (equals == std::string::npos || end == 0) return false;
    arguments[text.substr(0, end)] = text.substr(equals + 1);
  }
  return true;
}

int write_expanded(const Options& options) {
  std::vector<std::string> warnings;
  const Result<std::string> text = read_urdf_text(options.file, options.read, warnings);
  for (const std::string& warning : warnings) say("warning: " + warning);
  const Result<void> done = !text ? Result<void>(text.error())
                            : options.expanded == "-"
                                ? base::write_descriptor(STDOUT_FILENO, std::as_bytes(std::span(*text)))
                                : base::write_output(options.expanded, std::as_bytes(std::span(*text)));
  if (!done) say(fire3dv::error_line(done.error().message));
  return done ? 0 : kFailed;
}

size_t triangles_of(const Mesh& mesh) {
  size_t triangles = 0;
  for (const Surface& surface : mesh.surfaces) triangles += surface.indices.size() / 3;
  return triangles;
}

void print_list(const Model& model) {
  std::vector<size_t> depths;
  for (const Node& node : model.nodes) {
    depths.push_back(node.parent ? depths[*node.parent] + 1 : 0);
    std::string what;
    if (node.mesh) what += "\t" + std::to_string(triangles_of(model.meshes[*node.mesh])) + " triangles";
    if (node.camera) what += "\tcamera";
    if (node.light) what += "\tlight";
    std::printf("%s%s%s\n", std::string(2 * depths.back(), ' ').c_str(), printable(node.name).c_str(),
                what.c_str());
  }
}

// Tabs separate the columns; no column holds one.
void print_columns(const std::string& line) {
  std::string text;
  for (size_t begin = 0; begin <= line.size();) {
    const size_t end = std::min(line.find('\t', begin), line.size());
    text += (begin ? "\t" : "") + printable(line.substr(begin, end - begin));
    begin = end + 1;
  }
  std::printf("%s\n", text.c_str());
}

void print_joints(const Model& model) {
  std::vector<std::string> names;
  for (const Node& node : model.nodes) names.push_back(node.name);
  for (const std::string& line : joint_lines(model.kinematics, names)) print_columns(line);
}

int list_nodes_of_gltf(const Options& options) {
  std::vector<std::string> warnings;
  const Result<std::vector<std::string>> lines = list_gltf(options.file, warnings);
  if (!lines) {
    say(fire3dv::error_line(lines.error().message));
    return kFailed;
  }
  for (const std::string& line : *lines) print_columns(line);
  for (const std::string& warning : warnings) say("warning: " + warning);
  return 0;
}

Result<void> write_outputs(const Options& options, int standard_output, const Model& model,
                           const std::vector<std::byte>& glb, const Sources::Source& self, int64_t begun_ns) {
  if (options.out == "-") {
    const Result<void> done = base::write_descriptor(standard_output, glb);
    if (!done) return Error{"cannot write to the standard output: " + done.error().message};
    return {};
  }
  if (options.sources.empty()) return base::write_output(options.out, glb);
  if (Result<void> done = write_cache_entry(options.out, glb); !done) return done;
  std::vector<Sources::Source> sources{self};  // a different converter version may produce another scene
  sources.insert(sources.end(), model.sources.all().begin(), model.sources.all().end());
  scene::ConversionRecord record = scene::record_of(options.out, sources, begun_ns);
  record.warnings = model.warnings;
  const std::string text = scene::text_of(record);
  return write_cache_entry(options.sources, std::as_bytes(std::span(text)));
}

int run(const Options& options) {
  // Redirects standard output of libraries while the scene is written there.
  const int standard_output = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
  if (options.out == "-") dup2(STDERR_FILENO, STDOUT_FILENO);

  const bool only_lists = options.list && options.out.empty() && !options.joints && options.expanded.empty();
  if (only_lists && is_gltf_name(options.file)) return list_nodes_of_gltf(options);
  if (!options.expanded.empty()) {
    const int status = write_expanded(options);
    if (status != 0 || (options.out.empty() && !options.list && !options.joints)) return status;
  }
  const int64_t begun_ns = now_ns();
  std::error_code error;
  Sources::Source self{fs::read_symlink("/proc/self/exe", error), {}};
  self.stamp = scene::stamp_of(self.file);
  Result<Model> model = read_description(options.file, options.read);
  if (!model) {
    say(fire3dv::error_line(model.error().message));
    return kFailed;
  }
  if (options.list) print_list(*model);
  if (options.joints) print_joints(*model);
  size_t bytes = 0;
  if (!options.out.empty()) {
    const Result<std::vector<std::byte>> glb = write_glb(*model, &model->warnings);
    if (!glb) {
      say(fire3dv::error_line(options.file + ": " + glb.error().message));
      return kFailed;
    }
    bytes = glb->size();
    if (Result<void> done = write_outputs(options, standard_output, *model, *glb, self, begun_ns); !done) {
      say(fire3dv::error_line(done.error().message));
      return kFailed;
    }
  }
  for (const std::string& warning : model->warnings) say("warning: " + warning);
  if (!options.out.empty()) {
    size_t triangles = 0;
    for (const Node& node : model->nodes)
      triangles += node.mesh ? triangles_of(model->meshes[*node.mesh]) : 0;
    using fire3dv::counted;
    say((options.out == "-" ? "" : options.out + ": ") + counted(model->nodes.size(), "node") + ", " +
        counted(triangles, "triangle") + ", " + counted(model->cameras.size(), "camera") + ", " +
        counted(model->lights.size(), "light") + ", " + std::to_string(bytes) + " bytes, " +
        counted(model->warnings.size(), "warning"));
  }
  return 0;
}

}  // namespace
}  // namespace fire3dv::convert

int main(int argc, char** argv) {
  using namespace fire3dv::convert;
  CLI::App app{"Converts AMBF, URDF, MJCF, SDF, OBJ, STL, PLY, DAE and 3MF files to a binary glTF scene.",
               "fire3dv-convert"};
  fire3dv::set_help(app, "FILE --out OUT.glb [OPTIONS]");
  app.footer("Exit status: 0 written, 1 failed, 2 wrong usage. Details: man fire3dv-convert.");
  fire3dv::set_program_flags(app);
  Options options;
  app.add_option("file", options.file, "description, by its contents, or mesh file, by its name")->required();
  fire3dv::OptionGroup group(app);
  group.add("--out,-o", options.out, "OUT.glb", "file to write; -: standard output");
  CLI::Option* launch =
      group.add("--models,-l", options.launch, "0,1,...", "AMBF: models of the launch file, by index");
  group.add_flag("--all", options.read.launch_all, "AMBF: all models of the launch file")->excludes(launch);
  group.add("--ns", options.read.name_space, "NAME", "AMBF: namespace of the names");
  group.add_repeatable("--package-path", options.package_folders, "DIR",
                       "folder of package://, model:// and MJCF files; repeatable");
  group.add_choice("--up", options.up, "y|z",
                   "OBJ, STL, PLY: up axis of the file (default: y for OBJ, else z)");
  group.add_choice("--unit", options.unit, "m|cm|mm|in", "OBJ, STL, PLY: unit of the file (default: m)");
  group.add_choice("--dae-up", options.dae_up, "auto|apply|ignore",
                   "URDF, SDF: up_axis of DAE meshes; auto: ignored, as by RViz");
  group.add_choice("--gltf-up", options.gltf_up, "auto|apply|ignore",
                   "glTF meshes of URDF, SDF: turn to Z up; auto: for URDF alone");
  group
      .add("--smooth-angle", options.smooth_angle, "DEG",
           "meshes without normals: angle of smooth edges; 0: flat (default: 37)")
      ->check(fire3dv::number_between(0, 180));
  group.add_flag("--confined", options.read.is_confined,
                 "description of unknown origin: its folder and --package-path alone");
  group.add_repeatable("--xacro-arg", options.xacro_arguments, "NAME=VALUE",
                       "xacro: value of an argument; repeatable");
  group.add("--xacro", options.read.xacro_program, "PROGRAM", "xacro: program that expands the file");
  group.add("--expanded", options.expanded, "OUT.urdf", "xacro: write the expanded URDF; -: standard output");
  group.add_flag("--geoms", options.read.geoms_apart, "MJCF: one node for each geom");
  group.add_flag("--list", options.list, "print the names of the nodes; also of glTF files");
  group.add_flag("--joints", options.joints, "print the joints: name, type, node, limits");
  group.add("--sources", options.sources, "FILE", "write the list of source files and their times");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "fire3dv-convert: error: " << fire3dv::usage_text(app, error)
              << " (see fire3dv-convert --help)\n";
    return kUsageError;
  }
  const auto usage_error = [](const char* text) {
    std::cerr << "fire3dv-convert: error: " << text << " (see fire3dv-convert --help)\n";
    return kUsageError;
  };
  if (options.out.empty() && !options.list && !options.joints && options.expanded.empty())
    return usage_error("name the file to write: -o OUT.glb");
  if (!options.sources.empty() && (options.out.empty() || options.out == "-"))
    return usage_error("--sources needs a file to be written: -o OUT.glb");
  if (launch->count() > 0 && !parse_indices(options.launch, options.read.launch_indices))
    return usage_error("-l: must be numbers with commas between them, such as 0,1");
  if (!parse_arguments(options.xacro_arguments, options.read.xacro_arguments))
    return usage_error("--xacro-arg: must be NAME=VALUE");
  if (!options.up.empty()) options.read.mesh_up = options.up == "y" ? MeshUp::y : MeshUp::z;
  if (!options.unit.empty())
    options.read.mesh_unit_m = options.unit == "m"    ? 1
                               : options.unit == "cm" ? 0.01
                               : options.unit == "mm" ? 0.001
                                                      : 0.0254;
  if (!options.smooth_angle.empty()) options.read.smooth_angle_deg = std::stod(options.smooth_angle);
  options.read.dae_up = options.dae_up == "apply";
  if (options.gltf_up == "apply" || options.gltf_up == "ignore")
    options.read.gltf_up = options.gltf_up == "apply";
  options.read.package_folders.assign(options.package_folders.begin(), options.package_folders.end());
  try {
    return run(options);
  } catch (const std::bad_alloc&) {
    say(fire3dv::error_line(options.file + ": it does not fit into memory"));
  } catch (const std::exception& fault) {  // thrown by a library
    say(fire3dv::error_line(options.file + ": it cannot be converted: " + fault.what()));
  }
  return kFailed;
}
