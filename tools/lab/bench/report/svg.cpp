#include "tools/lab/bench/report/svg.h"

#include <cstdio>

namespace fire3dv::bench {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

std::string attribute(const char* name, double value) {
  return std::string(" ") + name + "=\"" + number(value) + "\"";
}

std::string escaped(const std::string& words) {
  std::string text;
  for (const char c : words) {
    switch (c) {
      case '&':
        text += "&amp;";
        break;
      case '<':
        text += "&lt;";
        break;
      case '>':
        text += "&gt;";
        break;
      default:
        text += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return text;
}

}  // namespace

Svg::Svg(double width, double height)
    : body_("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(width) + " " +
            number(height) + "\"" + attribute("width", width) + attribute("height", height) +
            " font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n") {}

void Svg::line(Point from, Point to, const std::string& colour, double width) {
  body_ += "<line" + attribute("x1", from.x) + attribute("y1", from.y) + attribute("x2", to.x) +
           attribute("y2", to.y) + " stroke=\"" + colour + "\"" + attribute("stroke-width", width) + "/>\n";
}

void Svg::polyline(const std::vector<Point>& points, const std::string& colour, bool dashed) {
  body_ += "<polyline points=\"";
  for (const Point& point : points) body_ += number(point.x) + "," + number(point.y) + " ";
  body_ += "\" fill=\"none\" stroke-width=\"2\" stroke=\"" + colour + "\"" +
           (dashed ? " stroke-dasharray=\"6 4\"" : "") + "/>\n";
}

void Svg::circle(Point center, double radius, const std::string& colour) {
  body_ += "<circle" + attribute("cx", center.x) + attribute("cy", center.y) + attribute("r", radius) +
           " fill=\"" + colour + "\"/>\n";
}

void Svg::text(Point at, const std::string& words, Anchor anchor, double size) {
  constexpr const char* kAnchors[] = {"start", "middle", "end"};
  body_ += "<text" + attribute("x", at.x) + attribute("y", at.y) + attribute("font-size", size) +
           " text-anchor=\"" + kAnchors[static_cast<int>(anchor)] + "\">" + escaped(words) + "</text>\n";
}

}  // namespace fire3dv::bench
