// README.md of a data set: contents, units, axes, image origin, licence, and the command that makes it again.
#pragma once

#include <string>

#include "renderer/dataset/labels/description.h"
#include "renderer/dataset/layouts/layout.h"
#include "renderer/dataset/pages/statistics.h"

namespace fire3dv::dataset {

std::string make_readme(const Description& description, const Layout& layout, const Statistics& statistics);

}  // namespace fire3dv::dataset
