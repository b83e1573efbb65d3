#include "renderer/dataset/pages/readme.h"

#include <cstdio>
#include <string_view>

#include "base/plural.h"
#include "base/text.h"

namespace fire3dv::dataset {
namespace {

// Cell of a Markdown table, of untrusted text.
std::string cell(std::string_view text) {
  std::string out;
  for (const char c : printable_text(text, 200)) {
    if (std::string_view("\\`*_{}[]<>#|&~").find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return out.empty() ? "(no name)" : out;
}

// Line of a code block.
std::string code(std::string_view text) {
  return "    " + printable_text(text, text.size()) + "\n";
}

}  // namespace

std::string make_readme(const Description& description, const Layout& layout, const Statistics& statistics) {
  char alpha[32];
  std::snprintf(alpha, sizeof alpha, "%.4g", description.label_alpha);
  const bool has_silhouettes = layout.further_outputs().has(wire::kAmodal);
  std::string text =
      "# Data set in the format `" + description.format + "`\n\n" + counted(statistics.images, "image") +
      " of " + std::to_string(description.width) + "x" + std::to_string(description.height) + " pixels, " +
      counted(description.cameras.size(), "camera") + ", " + counted(statistics.labels, "labelled instance") +
      ". Open `index.html` to look at it.\n\n";
  text +=
      "Licence: " + (description.license.empty() ? std::string("not stated") : cell(description.license)) +
      "\n\n";
  text += "## Command\n\n" + code(description.command) +
          "\nThe same inputs, device and driver give the same bytes, also in shards (`fire3dv join`).\n"
          "`manifest.json` has the digests of the inputs, and the device. `dataset.json` has objects,\n"
          "instances and cameras, `frames.jsonl` for each image the camera, and for each instance pose, box\n"
          "and mask (COCO's run lengths) of the visible part" +
          (has_silhouettes ? ", box and size of the silhouette, visible share" : "") + "; keypoints.\n\n";
  text +=
      "## Conventions\n\n"
      "- Camera axes are OpenCV's: x right, y down, z forward. Pinhole, without distortion.\n"
      "- Pixels: the centre of the top left pixel is (0, 0), so that a centred camera has\n"
      "  cx = (width - 1) / 2. Boxes count whole pixels: left, top, width, height.\n"
      "- The world is the scene's: metres, Y up, right-handed (glTF).\n"
      "- Depth is measured along the camera's axis, not along the ray.\n"
      "- Blended surfaces with more alpha than ";
  text += std::string(alpha) +
          " (`--label-alpha`), and transmissive ones, count as\n"
          "  opaque in depth and labels. Others, lines and points are in the colours only.\n\n";
  if (!description.randomization.empty()) {
    text += "## Randomisation\n\nSeed " + std::to_string(description.seed) +
            ". `drawn` of a line of `frames.jsonl` has the values of that image. The file:\n\n";
    for (const std::string& line : description.randomization) text += code(line);
    text += "\n";
  }
  text += "## Files\n\n" + layout.conventions(description) + "\n";
  text += "## Objects\n\n| obj_id | name | diameter, mm | labels | distance, m |\n|---|---|---|---|---|\n";
  for (const Object& object : description.objects) {
    const auto found = statistics.objects.find(object.id);
    const ObjectCounts counts = found == statistics.objects.end() ? ObjectCounts() : found->second;
    char numbers[160];
    std::snprintf(numbers, sizeof numbers, " | %.1f | %llu | %.3f to %.3f |\n", object.diameter_mm,
                  static_cast<unsigned long long>(counts.labels), counts.least_m, counts.most_m);
    text += "| " + std::to_string(object.id) + " | " + cell(object.name) + numbers;
  }
  text += "\n| instance | name | path | obj_id | class |\n|---|---|---|---|---|\n";
  for (const Instance& instance : description.instances)
    text += "| " + std::to_string(instance.number) + " | " + cell(instance.name) + " | " +
            cell(instance.path) + " | " + std::to_string(description.objects[instance.object].id) + " | " +
            std::to_string(instance.semantic) + " |\n";
  text += "\n| scene or camera | name |\n|---|---|\n";
  for (size_t i = 0; i < description.cameras.size(); ++i)
    text += "| " + std::to_string(i) + " | " + cell(description.cameras[i]) + " |\n";
  if (!statistics.warnings.empty()) text += "\n## Warnings\n\n";
  for (const std::string& warning : statistics.warnings) text += "- " + cell(warning) + "\n";
  return text;
}

}  // namespace fire3dv::dataset
