// Command line of fire3dv-drake.
#pragma once

#include <string>
#include <variant>

#include "programs/drake/http/server.h"
#include "programs/drake/render/image_renderer.h"
#include "renderer/app/options/options.h"

namespace fire3dv::drake {

struct Options {
  std::string address;  // HOST:PORT
  HttpLimits http;
  transport::http::AllowedSites sites;
  RenderSettings render;
  app::Options drawing;
};

// Returns the options, or the exit code for a program that ends now (help, or a printed usage error).
std::variant<Options, int> parse_options(int argc, char** argv);

}  // namespace fire3dv::drake
