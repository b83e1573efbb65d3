// Options of a command line that determine the pixels of images, without those that name files.
#pragma once

#include <string_view>

#include "renderer/app/options/options.h"
#include "renderer/sinks/run_provenance.h"

namespace fire3dv::app {

// The size, and all others that differ from their defaults, without dashes. The same options give the same
// list, whatever the order on the command line.
sinks::RunProvenance::Values appearance_options(const Options& options);

// True for names that appearance_options() may return: such options open no file.
bool is_appearance_option(std::string_view name);

}  // namespace fire3dv::app
