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
    return Error{"no scene travels in " + file + "; name the one that it is of: fire3dv SCENE.glb --replay " +
                 file};
  std::error_code failure;
  std::string folder = (std::filesystem::temp_directory_path(failure) / "fire3dv-scene-XXXXXX").string();
  if (failure || ::mkdtemp(folder.data()) == nullptr)
    return Error{"no folder can be made for the scene that travels in " + file + ": " +
                 (failure ? failure.message() : std::strerror(errno)) +
                 "; set TMPDIR to one that can be written"};
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
  std::error_code nobody_to_tell;
  std::filesystem::remove_all(folder_, nobody_to_tell);
}

}  // namespace fire3dv::app
