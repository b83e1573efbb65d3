// Overlay file: the user's edits of a scene as a small JSON file beside it, one line per edited object. The
// format is docs/editing.md's; it is versioned, and text and document convert without loss. Files are
// untrusted: every member is checked, and size and number of edits have limits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "base/error.h"
#include "renderer/editing/edit_document.h"

namespace fire3dv::state {

constexpr int kOverlayVersion = 2;  // files without additions, their materials and instances have version 1
constexpr uint64_t kMaxOverlayBytes = 16 << 20;
constexpr size_t kMaxOverlayEdits = 100'000;
constexpr size_t kMaxOverlayAdditions = 10'000;

// scene: name of the scene file, for readers; it opens nothing.
std::string overlay_text(const EditDocument& document, const std::string& scene);
// Errors name the member, such as edits[3].rotation.
Result<EditDocument> parse_overlay(std::span<const std::byte> text);

// Errors name the file.
Result<EditDocument> load_overlay(const std::filesystem::path& file);
// Replaces the file atomically.
Result<void> save_overlay(const std::filesystem::path& file, const EditDocument& document,
                          const std::string& scene);

}  // namespace fire3dv::state
