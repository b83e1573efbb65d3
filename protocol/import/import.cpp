#include "protocol/import/import.h"

#include <algorithm>
#include <cstdio>
#include <string_view>
#include <utility>

#include "protocol/import/batches.h"
#include "protocol/import/link_poses.h"
#include "protocol/import/plan.h"
#include "protocol/import/pose_recorder.h"
#include "protocol/import/survey.h"

namespace fire3dv::imported {
namespace {

class Import {
 public:
  Import(BatchReader reader, const ImportOptions& options) : reader_(std::move(reader)), options_(options) {
    if (options.robot && !options.robot->bodies().empty())
      links_.emplace(*options.robot, options.frame_prefix, options_.is_in_degrees);
  }

  Result<ImportReport> run(std::unique_ptr<record::Sink> sink);

 private:
  Result<void> survey();
  Result<void> find_first_time();
  Result<void> record(PoseRecorder& recorder);
  bool is_link(std::string_view frame) const {
    if (frame.starts_with('/')) frame.remove_prefix(1);
    return plan_.links.contains(frame);
  }
  // part: of the readings, 0 or 1.
  Result<void> note_progress(double part) {
    if (!options_.on_progress || options_.on_progress((part + reader_.source().progress()) / 2)) return {};
    return Error{"stopped"};
  }

  BatchReader reader_;
  const ImportOptions& options_;
  std::optional<LinkPoses> links_;
  Survey survey_;
  Plan plan_;
};

Result<void> Import::survey() {
  survey_ = Survey();
  if (Result<void> begun = reader_.rewind(); !begun) return begun;
  while (true) {
    Result<const Batch*> batch = reader_.next(survey_.faults());
    if (!batch) return batch.error();
    if (!*batch) return {};
    if (Result<void> added = survey_.add(**batch); !added) return added;
    if (Result<void> noted = note_progress(0); !noted) return noted;
  }
}

Result<void> Import::record(PoseRecorder& recorder) {
  Faults repeated;  // reported by the survey
  if (Result<void> begun = reader_.rewind(); !begun) return begun;
  while (true) {
    Result<const Batch*> next = reader_.next(repeated);
    if (!next) return next.error();
    if (!*next) return recorder.finish();
    const Batch& batch = **next;
    if (batch.joints && plan_.uses_joints) {
      const JointState& state = *batch.joints;
      for (size_t i = 0; i < state.names.size(); ++i) links_->set(state.names[i], state.positions[i]);
      if (Result<void> added = recorder.add(links_->transforms(state.stamp_ns), false); !added) return added;
    }
    std::vector<TransformSample> transforms = batch.transforms;
    std::erase_if(transforms, [&](const TransformSample& sample) { return is_link(sample.child); });
    if (Result<void> added = recorder.add(transforms, batch.is_static); !added) return added;
    if (Result<void> noted = note_progress(1); !noted) return noted;
  }
}

Result<ImportReport> Import::run(std::unique_ptr<record::Sink> sink) {
  if (Result<void> done = survey(); !done) return done.error();
  if (reader_.choose_clocks())
    if (Result<void> done = survey(); !done) return done.error();
  const std::string& file = reader_.source().name();
  Result<Plan> plan = make_plan(file, survey_, links_ ? &*links_ : nullptr, options_);
  if (!plan) return plan.error();
  plan_ = std::move(*plan);
  Result<PoseRecorder> recorder = PoseRecorder::open(file, plan_, std::move(sink));
  if (!recorder) return recorder.error();
  if (Result<void> done = record(*recorder); !done) return done.error();

  ImportReport report;
  report.notes = std::move(plan_.notes);
  for (std::string& text : reader_.clock_notes()) report.notes.push_back(std::move(text));
  report.warnings = reader_.unreadable();
  for (auto& texts : {reader_.clock_warnings(), reader_.source().take_warnings(),
                      survey_.faults().sentences(), plan_.warnings})
    report.warnings.insert(report.warnings.end(), texts.begin(), texts.end());
  if (const auto largest =
          plan_.uses_joints && !options_.is_in_degrees ? links_->largest_beyond_turn() : std::nullopt) {
    char number[32];
    std::snprintf(number, sizeof number, "%.4g", *largest);
    report.warnings.push_back("joint positions reach " + std::string(number) +
                              ", more than a turn in radians of most joints: if they are degrees, set "
                              "--joint-unit deg");
  }
  report.fixed_frame = std::move(plan_.fixed_frame);
  report.nodes = std::move(plan_.nodes);
  report.frames = recorder->writer().frames();
  report.first_ns = recorder->writer().first_ns();
  report.last_ns = recorder->writer().last_ns();
  return report;
}

}  // namespace

Result<ImportReport> import_states(MessageSource& source, const ImportOptions& options,
                                   std::unique_ptr<record::Sink> sink) {
  Result<BatchReader> reader = BatchReader::open(source);
  if (!reader) return reader.error();
  return Import(std::move(*reader), options).run(std::move(sink));
}

}  // namespace fire3dv::imported
