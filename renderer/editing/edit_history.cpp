#include "renderer/editing/edit_history.h"

#include <utility>

namespace fire3dv::state {

EditStep difference(const EditDocument& before, const EditDocument& after) {
  EditStep step;
  auto b = before.begin();
  auto a = after.begin();
  while (b != before.end() || a != after.end()) {
    if (a == after.end() || (b != before.end() && b->first < a->first)) {
      step.push_back({b->first, b->second, std::nullopt});
      ++b;
    } else if (b == before.end() || a->first < b->first) {
      step.push_back({a->first, std::nullopt, a->second});
      ++a;
    } else {
      if (!(a->second == b->second)) step.push_back({a->first, b->second, a->second});
      ++a;
      ++b;
    }
  }
  return step;
}

bool EditHistory::record(EditDocument now) {
  EditStep step = difference(document_, now);
  if (step.empty()) return false;
  add({std::move(step), std::nullopt});
  document_ = std::move(now);
  document_changed();
  return true;
}

void EditHistory::record_settings() {
  add({{}, ++newest_settings_});
}

void EditHistory::add(Step step) {
  while (steps_.size() > undone_from_) {
    changes_ -= steps_.back().edits.size();
    steps_.pop_back();
  }
  changes_ += step.edits.size();
  steps_.push_back(std::move(step));
  while (steps_.size() > kMaxSteps || (changes_ > kMaxChanges && steps_.size() > 1)) {
    changes_ -= steps_.front().edits.size();
    first_settings_ = steps_.front().settings.value_or(first_settings_);
    steps_.pop_front();
  }
  undone_from_ = steps_.size();
}

uint64_t EditHistory::settings() const {
  for (size_t step = undone_from_; step-- > 0;)
    if (steps_[step].settings) return *steps_[step].settings;
  return first_settings_;
}

bool EditHistory::undo() {
  if (undone_from_ == 0) return false;
  apply(steps_[--undone_from_].edits, false);
  return true;
}

bool EditHistory::redo() {
  if (undone_from_ == steps_.size()) return false;
  apply(steps_[undone_from_++].edits, true);
  return true;
}

void EditHistory::apply(const EditStep& step, bool forward) {
  for (const EditChange& change : step) {
    const std::optional<EditedValue>& value = forward ? change.after : change.before;
    if (value) {
      document_.insert_or_assign(change.key, *value);
    } else {
      document_.erase(change.key);
    }
  }
  document_changed();
}

void EditHistory::set_document(EditDocument document) {
  document_ = std::move(document);
  document_changed();
}

void EditHistory::reset(EditDocument document) {
  steps_.clear();
  undone_from_ = changes_ = 0;
  first_settings_ = newest_settings_ = 0;
  set_document(std::move(document));
}

void EditHistory::mark_saved() {
  saved_ = document_;
  is_saved_ = true;
}

std::string EditHistory::text_of(const Step& step) {
  if (step.settings) return "the render settings";
  std::string text = describe(step.edits.front().key);
  if (step.edits.size() > 1) text += " and " + std::to_string(step.edits.size() - 1) + " more";
  return text;
}

std::string EditHistory::undo_text() const {
  return undone_from_ == 0 ? std::string() : text_of(steps_[undone_from_ - 1]);
}

std::string EditHistory::redo_text() const {
  return undone_from_ == steps_.size() ? std::string() : text_of(steps_[undone_from_]);
}

}  // namespace fire3dv::state
