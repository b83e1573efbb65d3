// Minimal SVG writer. Coordinates are pixels, y down.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace fire3dv::bench {

struct Point {
  double x = 0, y = 0;
};

class Svg {
 public:
  Svg(double width, double height);

  void line(Point from, Point to, const std::string& colour, double width = 1);
  void polyline(const std::vector<Point>& points, const std::string& colour, bool dashed);
  void circle(Point center, double radius, const std::string& colour);
  enum class Anchor { start, middle, end };
  void text(Point at, const std::string& words, Anchor anchor = Anchor::start, double size = 13);

  std::string finish() const { return body_ + "</svg>\n"; }

 private:
  std::string body_;
};

}  // namespace fire3dv::bench
