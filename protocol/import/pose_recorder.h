// Second reading of a recording: poses of the plan's nodes at the times of its moving frames, written as a
// recording of one stream.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/frames/frame_buffer.h"
#include "protocol/frames/frame_tree.h"
#include "protocol/import/batches.h"
#include "protocol/import/plan.h"
#include "protocol/import/stream_writer.h"
#include "protocol/wire/affine.h"

namespace fire3dv::imported {

class PoseRecorder {
 public:
  // plan: borrowed. file: for messages.
  static Result<PoseRecorder> open(const std::string& file, const Plan& plan,
                                   std::unique_ptr<record::Sink> sink);

  // Transforms of one message, in the order of the recording.
  Result<void> add(const std::vector<TransformSample>& samples, bool is_static);
  // Writes the last frames and finishes the file.
  Result<void> finish();

  const StreamWriter& writer() const { return *writer_; }

 private:
  PoseRecorder(const std::string& file, const Plan& plan) : file_(file), plan_(&plan) {}

  // False for a transform that the survey has refused, too.
  bool insert(const TransformSample& sample, bool is_static);
  Result<void> write_before(int64_t time_ns);
  Result<void> write_frame(int64_t time_ns);

  std::string file_;
  const Plan* plan_;
  std::optional<StreamWriter> writer_;
  frames::FrameBuffer buffer_;
  frames::FrameTree tree_;
  frames::FrameId fixed_ = frames::kNoFrame;
  std::vector<frames::FrameId> frame_of_node_;
  std::vector<wire::Affine3x4> poses_;
  std::set<int64_t> due_;  // times of frames that wait for later transforms
  int64_t newest_ns_ = 0, last_ns_ = 0;
  uint64_t inserted_ = 0;
};

}  // namespace fire3dv::imported
