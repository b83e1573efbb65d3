#include "renderer/doctor/report/report.h"

#include <sys/utsname.h>

#include <algorithm>

#include "base/build_info.h"
#include "base/plural.h"
#include "base/text.h"
#include "renderer/doctor/report/redaction.h"
#include "renderer/doctor/report/variables.h"

namespace fire3dv::doctor {
namespace {

constexpr size_t kLevelColumns = 9, kIdColumns = 23;

std::string padded(std::string text, size_t columns) {
  text.resize(std::max(text.size() + 1, columns), ' ');
  return text;
}

// Texts of drivers, files and the environment, in one line.
std::string one_line(const std::string& text) {
  return printable_text(text, text.size());
}

size_t count(std::span<const CheckedFinding> findings, Level level) {
  return static_cast<size_t>(std::count_if(
      findings.begin(), findings.end(), [&](const CheckedFinding& f) { return f.finding.level == level; }));
}

std::string kernel_text() {
  utsname name{};
  if (::uname(&name) != 0) return "";
  return std::string(name.sysname) + " " + name.release + " " + name.machine;
}

std::string heading(const Facts& facts) {
  std::string text = std::string("fire3dv ") + kVersion + " (commit " + kCommit + "), ";
  if (!facts.system.empty()) text += facts.system + ", ";
  text += kernel_text();
  if (facts.container) text += ", in a container";
  if (facts.wsl) text += ", WSL";
  return text + "\n";
}

std::string cuda_index(const Facts& facts, const DeviceFacts& device) {
  for (const CudaDeviceFacts& cuda : facts.cuda_devices) {
    if (!cuda.mig && cuda.uuid == device.uuid) return std::to_string(cuda.index);
  }
  return "-";
}

std::string device_table(const Facts& facts) {
  if (facts.devices.empty()) return "";
  std::string text = "\n--device  cuda:  PCI address   UUID                                  name (driver)\n";
  for (const DeviceFacts& device : facts.devices) {
    text += padded(std::to_string(device.index), 10) + padded(cuda_index(facts, device), 7) +
            padded(device.pci_address.empty() ? "-" : device.pci_address, 14) + padded(device.uuid, 38) +
            one_line(device.name + " (" + device.driver + ")") + "\n";
  }
  const std::string visible = facts.variable("CUDA_VISIBLE_DEVICES");
  if (!facts.cuda_devices.empty() && !visible.empty())
    text += "CUDA_VISIBLE_DEVICES=" + one_line(visible) + " orders the column cuda:\n";
  return text;
}

std::string summary(std::span<const CheckedFinding> findings) {
  const size_t errors = count(findings, Level::error), warnings = count(findings, Level::warning);
  if (errors == 0 && warnings == 0) return "all is well\n";
  return counted(errors, "error") + ", " + counted(warnings, "warning") +
         (errors == 0 ? ": fire3dv can draw here\n" : ": fix the errors first, from the top\n");
}

// Fence of a Markdown block: longer than the backticks in it, which end no such block.
std::string fence_around(const std::string& text) {
  size_t longest = 2;
  for (size_t at = text.find('`'); at != std::string::npos; at = text.find('`', at)) {
    const size_t end = std::min(text.find_first_not_of('`', at), text.size());
    longest = std::max(longest, end - at);
    at = end;
  }
  return std::string(longest + 1, '`');
}

}  // namespace

std::string report_text(const Facts& facts, std::span<const CheckedFinding> findings) {
  std::string text = heading(facts) + device_table(facts) + "\n";
  for (const auto& [id, finding] : findings) {
    text += padded(level_name(finding.level), kLevelColumns) + padded(id, kIdColumns) +
            one_line(finding.text) + "\n";
    if (!finding.fix.empty())
      text += std::string(kLevelColumns + kIdColumns, ' ') + "type: " + one_line(finding.fix) + "\n";
  }
  return text + "\n" + summary(findings);
}

nlohmann::json report_json(const Facts& facts, std::span<const CheckedFinding> findings) {
  nlohmann::json devices = nlohmann::json::array(), cuda = nlohmann::json::array(),
                 list = nlohmann::json::array();
  const auto outcome = [](const Trial& trial) -> nlohmann::json {
    if (trial.outcome == Outcome::not_tried) return nullptr;
    return trial.passed();
  };
  for (const DeviceFacts& device : facts.devices)
    devices.push_back({{"index", device.index},
                       {"name", device.name},
                       {"driver", device.driver},
                       {"type", device.type},
                       {"uuid", device.uuid},
                       {"pci_address", device.pci_address},
                       {"missing", device.missing},
                       {"read_back", outcome(device.read_back)},
                       {"ray_tracing", outcome(device.ray)}});
  for (const CudaDeviceFacts& device : facts.cuda_devices)
    cuda.push_back(
        {{"index", device.index}, {"name", device.name}, {"uuid", device.uuid}, {"mig", device.mig}});
  for (const auto& [id, finding] : findings)
    list.push_back(
        {{"id", id}, {"level", level_name(finding.level)}, {"text", finding.text}, {"fix", finding.fix}});
  return {{"version", kVersion},
          {"commit", kCommit},
          {"system", facts.system},
          {"kernel", kernel_text()},
          {"container", facts.container},
          {"wsl", facts.wsl},
          {"exit_status", exit_status(findings)},
          {"devices", devices},
          {"cuda_devices", cuda},
          {"findings", list}};
}

std::string report_file(const Facts& facts, std::span<const CheckedFinding> findings) {
  std::string text = report_text(facts, findings) + "\n";
  for (const ManifestFacts& manifest : facts.manifests) {
    const std::string outcome = manifest.load.passed() ? " loads" : " " + describe(manifest.load);
    text += "manifest " + printable_text(manifest.file, 1000) + ": " +
            printable_text(manifest.fault.empty() ? manifest.library + outcome : manifest.fault, 1000) + "\n";
  }
  for (const LayerFacts& layer : facts.implicit_layers)
    text +=
        "implicit layer " + printable_text(layer.name, 200) + ": " + printable_text(layer.file, 1000) + "\n";
  text = redacted(without_hidden_values(text, facts) + variable_lines(facts), private_words(facts));
  const std::string fence = fence_around(text);
  return "Output of `fire3dv doctor`. Names of its user and of hosts, home folders and IP addresses are "
         "replaced.\n\n" +
         fence + "\n" + text + fence + "\n";
}

}  // namespace fire3dv::doctor
