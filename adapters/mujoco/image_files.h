// Images that came back, as files: the same as fire3dv writes with --out, a folder for each camera.
//
//   DIR/CAMERA/frame_000012.png, frame_000012.depth.npy ...   called by the sequence of the frame that they
//   show DIR/frames.jsonl    one line an image: its files, its frame, its boxes DIR/cameras.jsonl   one line
//   an image: where its camera was, and its matrix as OpenCV has it
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

  // Copies what is to be written. stream: the publisher's name.
  Result<void> write(const std::string& camera, const std::string& stream, const fire3dv_image& image);
  // Returns when all that was given is written.
  Result<void> finish();

 private:
  ImageFiles(std::unique_ptr<sinks::FileSink> sink, std::filesystem::path list, std::ofstream lines)
      : sink_(std::move(sink)), list_(std::move(list)), lines_(std::move(lines)) {}

  std::unique_ptr<sinks::FileSink> sink_;
  std::filesystem::path list_;
  std::ofstream lines_;
};

}  // namespace fire3dv::mujoco
