#include "renderer/sinks/video/libav.h"

#include <dlfcn.h>

#include <map>
#include <string>

namespace fire3dv::sinks {
namespace {

// Soname versions: the loader accepts only the major versions of the headers of this build.
const std::map<std::string, int>& versions() {
  static const std::map<std::string, int> known{{"avcodec", LIBAVCODEC_VERSION_MAJOR},
                                                {"avformat", LIBAVFORMAT_VERSION_MAJOR},
                                                {"avutil", LIBAVUTIL_VERSION_MAJOR},
                                                {"swscale", LIBSWSCALE_VERSION_MAJOR}};
  return known;
}

Result<Libav> load() {
  std::map<std::string, void*> libraries;
  for (const auto& [name, version] : versions()) {
    const std::string file = "lib" + name + ".so." + std::to_string(version);
    void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library)
      return Error{"videos need " + file + ", which is not there: install the package lib" + name +
                   std::to_string(version) + ", or write images to a folder"};
    libraries[name] = library;
  }
  Libav functions;
  std::string missing;
  const auto find = [&](const char* library, const char* name) {
    void* const found = dlsym(libraries[library], name);
    if (!found && missing.empty()) missing = name;
    return found;
  };
#define FIRE3DV_LIBAV_FIND(library, function) \
  functions.function = reinterpret_cast<decltype(functions.function)>(find(#library, #function));
  FIRE3DV_LIBAV_FUNCTIONS(FIRE3DV_LIBAV_FIND)
#undef FIRE3DV_LIBAV_FIND
  if (!missing.empty())
    return Error{"the libav of this system has no " + missing +
                 ": write images to a folder instead of a video"};
  return functions;
}

}  // namespace

Result<const Libav*> libav() {
  static const Result<Libav> loaded = load();
  if (!loaded) return loaded.error();
  return &*loaded;
}

}  // namespace fire3dv::sinks
