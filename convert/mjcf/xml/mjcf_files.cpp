#include "convert/mjcf/xml/mjcf_files.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxMessages = 200;
constexpr size_t kMaxPaths = 100'000;
constexpr uint64_t kMaxFileBytes = uint64_t{256} << 20;

}  // namespace

MjcfMessages::~MjcfMessages() {
  if (left_out_ > 0) warnings_.push_back(std::to_string(left_out_) + " further warnings are left out");
}

void MjcfMessages::warn(std::string message) {
  if (std::find(warnings_.begin(), warnings_.end(), message) != warnings_.end()) return;
  if (stored_ == kMaxMessages) {
    ++left_out_;
    return;
  }
  ++stored_;
  warnings_.push_back(std::move(message));
}

MjcfFiles::MjcfFiles(const fs::path& model, const std::vector<fs::path>& folders, bool is_confined,
                     Sources& sources)
    : is_confined_(is_confined), sources_(sources) {
  allowed_.add(model.parent_path());
  std::error_code error;
  const fs::path own = fs::canonical(model, error);  // target folder, if the model is a symbolic link
  if (!error) allowed_.add(own.parent_path());
  for (const fs::path& folder : folders) allowed_.add(folder);
}

Result<fs::path> MjcfFiles::find(std::string name, const std::vector<fs::path>& folders) {
  if (std::any_of(name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
    return Error{quote(name) + " is a name with control characters: rename the file"};
  std::replace(name.begin(), name.end(), '\\', '/');
  std::vector<fs::path> candidates;
  if (fs::path(name).is_absolute())
    candidates.emplace_back(name);
  else
    for (const fs::path& folder : folders) candidates.push_back(folder / name);
  std::optional<Error> refused;
  for (const fs::path& candidate : candidates) {
    if (sources_.all().size() >= kMaxPaths)
      return Error{"the model names more than " + std::to_string(kMaxPaths) + " files"};
    sources_.add(candidate);
    std::error_code error;
    if (!fs::exists(candidate, error)) continue;
    const Result<fs::path> resolved = regular_file(candidate);
    if (!resolved)
      refused = resolved.error();
    else if (may_read(*resolved))
      return candidate;
    else
      refused =
          Error{quote(tidy_path(candidate).string()) +
                " lies outside the model's folder: copy it there, or name its folder with --package-path"};
  }
  if (refused) return *refused;
  return Error{quote(tidy_path(candidates.empty() ? fs::path(name) : candidates.front()).string()) +
               " does not exist"};
}

Result<FileBytes> MjcfFiles::read(const fs::path& file) const {
  // Checked again, since links may have changed since find().
  const Result<fs::path> resolved = regular_file(file);
  if (!resolved) return resolved.error();
  if (!may_read(*resolved)) return Error{quote(file.string()) + " lies outside the model's folder"};
  return read_asset(*resolved, kMaxFileBytes);
}

}  // namespace fire3dv::convert
