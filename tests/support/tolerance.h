// The one policy on how far an image may be from what is expected. Two presets, and no way to make a third: a
// test that needs another tolerance has found a defect or needs another scene.
#pragma once

namespace fire3dv::test {

class Tolerance {
 public:
  // Every byte the same: ids, determinism, "the transport does not matter".
  static constexpr Tolerance exact() { return {"exact", 0, 0.0}; }

  // Colour against a golden. Two separate knobs: how far a channel of one pixel may be off, and how many
  // pixels may be farther off than that. Rounding moves many pixels by a little; an edge that falls to the
  // other side moves a few pixels by a lot; a wrong light, material or pose does neither.
  static constexpr Tolerance colour() { return {"colour", 5, 0.001}; }

  constexpr const char* name() const { return name_; }
  constexpr int max_channel_delta() const { return max_channel_delta_; }           // of 255
  constexpr double max_share_over_delta() const { return max_share_over_delta_; }  // of all pixels

 private:
  constexpr Tolerance(const char* name, int max_channel_delta, double max_share_over_delta)
      : name_(name), max_channel_delta_(max_channel_delta), max_share_over_delta_(max_share_over_delta) {}

  const char* name_;
  int max_channel_delta_;
  double max_share_over_delta_;
};

}  // namespace fire3dv::test
