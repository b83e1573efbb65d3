// index.html of a data set: one self-contained page with a contact sheet, counts, distributions and warnings.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/error.h"
#include "renderer/dataset/labels/description.h"
#include "renderer/dataset/layouts/layout.h"
#include "renderer/dataset/pages/statistics.h"
#include "renderer/offline/frame_format.h"

namespace fire3dv::dataset {

// Reads colours of some images from the folder.
Result<std::string> make_page(const std::filesystem::path& folder, const Description& description,
                              const Layout& layout, const Statistics& statistics,
                              const offline::FrameLines& lines);

// Text for HTML, without mark-up of its own.
std::string html_text(std::string_view text);

}  // namespace fire3dv::dataset
