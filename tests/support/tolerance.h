// Image tolerances of all tests. There are two presets and no third: a test that needs another tolerance has
// found a defect or needs another scene.
#pragma once

namespace fire3dv::test {

class Tolerance {
 public:
  // Byte equality: ids, determinism, transport independence.
  static constexpr Tolerance exact() { return {"exact", 0, 0.0}; }

  // Colour against a golden: a limit per channel, and a fraction of pixels that may exceed it. Rounding
  // changes many pixels a little; an edge on the other side changes a few pixels a lot. A wrong light,
  // material or pose exceeds both.
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
