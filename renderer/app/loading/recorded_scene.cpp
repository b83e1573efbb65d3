#include "renderer/app/loading/recorded_scene.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "protocol/record/mcap/attachments.h"
#include "protocol/wire/check.h"

namespace fire3dv::app {

Result<std::unique_ptr<RecordedScene>> RecordedScene::extract(record::Reader& reader) {
  const std::string file = wire::printable(reader.name(), 4096);
  const auto& attachments = reader.index().attachments;
  const auto found = std::ranges::find(attachments, record::kGlbType, &record::AttachmentIndex::media_type);
  if (found == attachments.end())
    return Error{"no scene is attached to " + file + "; name it: fire3dv SCENE.glb --replay " + file};
  std::error_code failure;
  std::string folder = (std::filesystem::temp_directory_path(failure) / "fire3dv-scene-XXXXXX").string();
  if (failure || ::mkdtemp(folder.data()) == nullptr)
    return Error{"cannot make a folder for the scene attached to " + file + ": " +
                 (failure ? failure.message() : std::strerror(errno)) + "; set TMPDIR to a writable folder"};
  std::unique_ptr<RecordedScene> scene(new RecordedScene);
  scene->folder_ = folder;
  // Fixed file name: the name in the recording is untrusted.
  scene->path_ = scene->folder_ / "scene.glb";
  scene->name_ = wire::printable(found->name, 256);
  std::ofstream out(scene->path_, std::ios::binary);
  const auto good = reader.read_attachment(*found, [&](std::span<const std::byte> piece) -> Result<void> {
    out.write(reinterpret_cast<const char*>(piece.data()), static_cast<std::streamsize>(piece.size()));
    return out ? Result<void>()
               : Result<void>(Error{scene->path_.string() + " cannot be written; is the disk full?"});
  });
  out.close();
  if (!good) return good.error();
  if (!out) return Error{scene->path_.string() + " cannot be written; is the disk full?"};
  return scene;
}

RecordedScene::~RecordedScene() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

}  // namespace fire3dv::app
