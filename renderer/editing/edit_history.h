// Undo history of an edit document. A step is what changed between two records, as (key, before, after): the
// caller records once per finished interaction, so that a drag is one step. The newest 200 steps are kept.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "renderer/editing/edit_document.h"

namespace fire3dv::state {

struct EditChange {
  EditKey key;
  std::optional<EditedValue> before, after;  // nullopt: as in the file
};
using EditStep = std::vector<EditChange>;

// Changes that turn one document into the other, in key order.
EditStep difference(const EditDocument& before, const EditDocument& after);

class EditHistory {
 public:
  static constexpr size_t kMaxSteps = 200;
  static constexpr size_t kMaxChanges = 1'000'000;  // of all steps; older steps are dropped first

  // The document after the recorded steps.
  const EditDocument& document() const { return document_; }
  // Adds the difference to the document as one step, and drops the undone steps. False: there is none.
  bool record(EditDocument now);
  // Adds a step of settings that are no part of the document, and gives the new ones a number: settings().
  void record_settings();
  // Number of the settings in force after the recorded steps; 0: the first ones. Later ones have larger
  // numbers.
  uint64_t settings() const;
  // Return false if there is no such step.
  bool undo();
  bool redo();
  // Replaces the document without a step. The steps stay: their keys name objects.
  void set_document(EditDocument document);
  // Forgets all steps.
  void reset(EditDocument document);

  size_t undo_steps() const { return undone_from_; }
  size_t redo_steps() const { return steps_.size() - undone_from_; }
  // First change of the next step, or the settings; empty: there is none.
  std::string undo_text() const;
  std::string redo_text() const;

  // True if the document equals the one of the last mark_saved(), at first the empty one.
  bool is_saved() const { return is_saved_; }
  size_t unsaved_count() const { return difference(saved_, document_).size(); }  // of edits
  void mark_saved();

 private:
  // One of both.
  struct Step {
    EditStep edits;
    std::optional<uint64_t> settings;  // from this step on
  };
  void add(Step step);
  static std::string text_of(const Step& step);
  void apply(const EditStep& step, bool forward);
  void document_changed() { is_saved_ = document_ == saved_; }

  EditDocument document_, saved_;
  bool is_saved_ = true;
  std::deque<Step> steps_;                             // the oldest first
  size_t undone_from_ = 0;                             // steps from here on are undone
  size_t changes_ = 0;                                 // of all steps
  uint64_t first_settings_ = 0, newest_settings_ = 0;  // before the steps; of all that were recorded
};

}  // namespace fire3dv::state
