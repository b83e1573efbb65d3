// Writer of received images, in the file layout of fire3dv --out, with one folder per camera.
//
//   DIR/CAMERA/frame_000012.png, frame_000012.depth.npy ...  number: sequence of the frame shown
//   DIR/frames.jsonl    one line per image: files, frame, boxes
//   DIR/cameras.jsonl   one line per image: camera pose and OpenCV camera matrix
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "adapters/mujoco/publisher.h"
#include "renderer/sinks/file_sink.h"

namespace fire3dv::mujoco {

class ImageFiles {
 public:
  static Result<ImageFiles> open(const std::filesystem::path& folder);

  // Copies the planes and queues the write. stream: name of the publisher.
  Result<void> write(const std::string& camera, const std::string& stream, const fire3dv_image& image);
  // Waits until all queued images are written.
  Result<void> finish();

 private:
  ImageFiles(std::unique_ptr<sinks::FileSink> sink, std::filesystem::path list, std::ofstream lines)
      : sink_(std::move(sink)), list_(std::move(list)), lines_(std::move(lines)) {}

  std::unique_ptr<sinks::FileSink> sink_;
  std::filesystem::path list_;
  std::ofstream lines_;
};

}  // namespace fire3dv::mujoco
