// Test of polygon triangulation: triangles cover exactly the polygon, whatever its shape, first corner,
// direction and plane.
#include "convert/mesh/geometry/triangulate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>

#include "convert/mesh/geometry/polygon_holes.h"
#include "convert/mesh/geometry/sweep_triangulation.h"

namespace fire3dv::convert {
namespace {

using Polygon = std::vector<glm::dvec2>;

double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

bool is_inside(const Polygon& polygon, const glm::dvec2& p) {
  bool inside = false;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
  }
  return inside;
}

using Triangles = std::vector<PolygonTriangulator::Triangle>;

// Each of many points is covered once inside the polygon, and never outside.
void expect_cover(const Polygon& corners, const Triangles& triangles, const std::string& name) {
  glm::dvec2 low(1e9), high(-1e9);
  for (const glm::dvec2& c : corners) {
    low = glm::min(low, c);
    high = glm::max(high, c);
  }
  constexpr int kSamples = 23;
  int wrong = 0;
  for (int i = 0; i < kSamples * kSamples; ++i) {
    const glm::dvec2 p = low + (high - low) * glm::dvec2((i % kSamples + 0.4317) / kSamples,
                                                         (i / kSamples + 0.5743) / kSamples);
    int covers = 0;
    for (const auto& t : triangles) {
      const glm::dvec2 &a = corners[t[0]], &b = corners[t[1]], &c = corners[t[2]];
      const double u = cross(b - a, p - a), v = cross(c - b, p - b), w = cross(a - c, p - c);
      covers += (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0) ? 1 : 0;
    }
    wrong += covers != (is_inside(corners, p) ? 1 : 0) ? 1 : 0;
  }
  EXPECT_EQ(wrong, 0) << name;
  double area = 0, covered = 0;
  for (size_t i = 0; i < corners.size(); ++i)
    area += cross(corners[i], corners[(i + 1) % corners.size()]) / 2;
  for (const auto& t : triangles) {
    const double one = cross(corners[t[1]] - corners[t[0]], corners[t[2]] - corners[t[0]]) / 2;
    EXPECT_GE(one * area, 0) << name << ": a triangle faces the other way";
    covered += one;
  }
  EXPECT_NEAR(covered, area, 1e-9 * std::abs(area)) << name;
}

// The sweep, which the triangulator uses for large polygons only.
void expect_swept_cover(Polygon corners, const std::string& name) {
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  if (corners.back() == corners.front()) corners.pop_back();
  double area = 0;
  for (size_t i = 0; i < corners.size(); ++i) area += cross(corners[i], corners[(i + 1) % corners.size()]);
  if (area < 0) std::reverse(corners.begin(), corners.end());
  const std::optional<Triangles> swept = SweepTriangulation::cut(corners);
  ASSERT_TRUE(swept) << name;
  expect_cover(corners, *swept, name + ", swept");
}

void expect_exact_cover(const Polygon& polygon, const std::string& name) {
  for (const bool reversed : {false, true}) {
    for (size_t turn = 0; turn < std::min<size_t>(polygon.size(), 12); ++turn) {
      Polygon corners = polygon;
      std::rotate(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(turn), corners.end());
      if (reversed) std::reverse(corners.begin(), corners.end());
      // In a plane that no axis is perpendicular to, with the coordinates as they are.
      std::vector<glm::dvec3> in_space;
      for (const glm::dvec2& c : corners) in_space.emplace_back(c.x, 0.25 * c.x - 0.5 * c.y + 3, c.y);
      const std::string place =
          name + " from corner " + std::to_string(turn) + (reversed ? ", reversed" : "");
      PolygonTriangulator triangulator;
      const auto triangles = triangulator.triangulate(in_space);
      EXPECT_EQ(triangulator.warning(), "") << place;
      expect_cover(corners, triangles, place);
      expect_swept_cover(corners, place);
    }
  }
}

Polygon gear(int teeth) {
  Polygon polygon;
  for (int i = 0; i < 2 * teeth; ++i) {
    const double angle = std::numbers::pi * i / teeth, radius = i % 2 == 0 ? 1 : 1.3;
    polygon.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return polygon;
}

// A band that winds around the origin.
Polygon spiral(int corners) {
  Polygon polygon;
  const auto at = [&](int i, double width) {
    const double angle = 0.1 * i;
    const double radius = 1 + 0.1 * angle + width;
    return glm::dvec2(radius * std::cos(angle), radius * std::sin(angle));
  };
  for (int i = 0; i < corners; ++i) polygon.push_back(at(i, 0));
  for (int i = corners; i-- > 0;) polygon.push_back(at(i, 0.3));
  return polygon;
}

Polygon comb(int teeth) {
  Polygon polygon = {{0, -1}, {2.0 * teeth, -1}};
  for (int i = teeth; i-- > 0;) {
    polygon.emplace_back(2.0 * i + 1, 0);
    polygon.emplace_back(2.0 * i + 0.5, 5);
    polygon.emplace_back(2.0 * i, 0);
  }
  return polygon;
}

// Two arcs that bulge towards each other: no ear is far from the other corners.
Polygon bowl(int corners) {
  Polygon polygon;
  const int half = corners / 2;
  const auto add = [&](int i, double middle, double bulge) {
    const double x = -1 + 2.0 * i / (half - 1);
    polygon.emplace_back(x, middle + bulge * x * x);
  };
  for (int i = 0; i < half; ++i) add(i, 0.5, -0.5);
  for (int i = half; i-- > 0;) add(i, 1, 0.5);
  return polygon;
}

TEST(Triangulate, CoversThePolygonOnce) {
  expect_exact_cover({{0, 0}, {1, 1}, {0, 3}, {0.4, 1}}, "arrow");
  expect_exact_cover({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}, "L");
  expect_exact_cover({{0, 0}, {1, 0}, {2, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 1}, {1, 2}, {0, 2}, {0, 1}, {0, 0}},
                     "L with collinear and doubled corners");
  expect_exact_cover({{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 3}, {3, 3}, {3, 1}, {0, 1}}, "C");
  expect_exact_cover({{0, 0}, {3, 0}, {3, 3}, {0, 3}, {0, 0}, {1, 1}, {1, 2}, {2, 2}, {2, 1}, {1, 1}},
                     "hole by an edge that is doubled");
  expect_exact_cover({{0, 0},
                      {6, 0},
                      {6, 3},
                      {0, 3},
                      {0, 0},
                      {1, 1},
                      {1, 2},
                      {2, 2},
                      {3, 1},
                      {3, 2},
                      {4, 2},
                      {4, 1},
                      {3, 1},
                      {2, 2},
                      {2, 1},
                      {1, 1}},
                     "two holes, one behind the other");
  expect_exact_cover({{0, 0}, {2, 0}, {2, 2}, {1, 0}, {0, 2}}, "corner on an edge");
  expect_exact_cover(gear(30), "gear");
  expect_exact_cover(spiral(200), "spiral");
  expect_exact_cover(comb(50), "comb");
  expect_exact_cover(bowl(60), "bowl");
}

TEST(Triangulate, RandomPolygonsAreCoveredOnce) {
  std::mt19937 random(5);
  for (int round = 0; round < 40; ++round) {
    Polygon polygon;
    const int count = 4 + static_cast<int>(random() % 30);
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / count,
                   radius = 0.2 + static_cast<double>(random() % 1000) / 500;
      polygon.emplace_back(static_cast<float>(radius * std::cos(angle)),
                           static_cast<float>(radius * std::sin(angle)));
    }
    expect_exact_cover(polygon, "star " + std::to_string(round));
  }
}

TEST(Triangulate, ConvexPolygonsAreFans) {
  PolygonTriangulator triangulator;
  const std::vector<glm::dvec3> square = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 0, 1}, {0, 0, 1}};
  const std::vector<PolygonTriangulator::Triangle> fan = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}};
  EXPECT_EQ(triangulator.triangulate(square), fan);
  EXPECT_EQ(triangulator.triangulate(std::span(square).first(3)).size(), 1u);
  EXPECT_TRUE(triangulator.triangulate(std::span(square).first(2)).empty());
  EXPECT_EQ(triangulator.warning(), "");
}

TEST(Triangulate, CrossedPolygonsAreReported) {
  PolygonTriangulator triangulator;
  EXPECT_EQ(
      triangulator.triangulate(std::vector<glm::dvec3>{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).size(),
      2u);
  EXPECT_NE(triangulator.warning().find("1 polygon crosses itself"), std::string::npos);
  std::vector<glm::dvec3> star;
  for (int i = 0; i < 5; ++i)
    star.emplace_back(std::cos(0.8 * std::numbers::pi * i), std::sin(0.8 * std::numbers::pi * i), 0);
  EXPECT_LE(triangulator.triangulate(star).size(), 3u);
  EXPECT_NE(triangulator.warning().find("2 polygons cross themselves"), std::string::npos);
}

TEST(Triangulate, FoldedSliversAreNotReported) {
  PolygonTriangulator triangulator;
  const std::vector<glm::dvec3> crossed = {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
  triangulator.triangulate(std::vector<glm::dvec3>{{0, 0, 0}, {99, 0, 0}, {0, 99, 0}});
  triangulator.triangulate(crossed);
  EXPECT_EQ(triangulator.warning(), "");
  for (int i = 0; i < 20; ++i) triangulator.triangulate(crossed);
  EXPECT_NE(triangulator.warning(), "");
}

TEST(Triangulate, SweepsOfCrossedPolygonsEnd) {
  std::mt19937 random(3);
  for (int round = 0; round < 300; ++round) {
    Polygon polygon;
    for (size_t i = 0; i < 4 + random() % 40; ++i) {
      const glm::dvec2 point(random() % 9, random() % 9);
      if (polygon.empty() || point != polygon.back()) polygon.push_back(point);
    }
    if (polygon.back() == polygon.front()) polygon.pop_back();
    if (polygon.size() < 3) continue;
    const Triangles swept = SweepTriangulation::cut(polygon).value_or(Triangles());
    for (const auto& triangle : swept)
      for (const uint32_t corner : triangle) ASSERT_LT(corner, polygon.size());
  }
}

TEST(Triangulate, AnyPolygonEnds) {
  PolygonTriangulator triangulator;
  // Without an area: no warning, since nothing is seen.
  const std::vector<glm::dvec3> line = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {1, 1, 1}};
  triangulator.triangulate(line);
  triangulator.triangulate(std::vector<glm::dvec3>(1000, glm::dvec3(1)));
  EXPECT_EQ(triangulator.warning(), "");
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinite = std::numeric_limits<double>::infinity();
  triangulator.triangulate(std::vector<glm::dvec3>{{0, 0, 0}, {nan, 0, 0}, {1, 1, 0}, {0, infinite, 0}});
  triangulator.triangulate(
      std::vector<glm::dvec3>{{0, 0, 0}, {1e300, 0, 0}, {1e300, 1e300, 0}, {1, 2, 0}, {-1e300, 5, 0}});
  std::mt19937 random(3);
  for (int round = 0; round < 300; ++round) {
    std::vector<glm::dvec3> polygon;
    for (size_t i = 0; i < 3 + random() % 40; ++i)
      polygon.emplace_back(random() % 5, random() % 5, round % 3 == 0 ? random() % 3 : 0);
    for (const auto& triangle : triangulator.triangulate(polygon))
      for (const uint32_t corner : triangle) ASSERT_LT(corner, polygon.size());
    ASSERT_LE(triangulator.triangulate(polygon).size(), polygon.size() - 2);
  }
}

TEST(Triangulate, LargePolygonsAreExact) {
  PolygonTriangulator triangulator;
  for (const Polygon& large : {spiral(20'000), comb(20'000), bowl(250'000)}) {
    std::vector<glm::dvec3> polygon;
    for (const glm::dvec2& c : large) polygon.emplace_back(c, 0);
    EXPECT_EQ(triangulator.triangulate(polygon).size(), polygon.size() - 2);
  }
  EXPECT_EQ(triangulator.warning(), "");
}

// Area of the triangles of an outline and its holes; negative if they are not joined.
double joined_area(const std::vector<Polygon>& rings, std::vector<uint32_t>* joined = nullptr) {
  std::vector<HoleJoiner::Ring> in_space;
  std::vector<glm::dvec3> corners;
  for (const Polygon& ring : rings) {
    in_space.emplace_back();
    for (const glm::dvec2& c : ring) in_space.back().emplace_back(c.x, 0.25 * c.x - 0.5 * c.y + 3, c.y);
    corners.insert(corners.end(), in_space.back().begin(), in_space.back().end());
  }
  const std::vector<uint32_t> order = HoleJoiner().join(in_space);
  if (joined) *joined = order;
  if (order.empty()) return -1;
  std::vector<glm::dvec3> polygon;
  for (const uint32_t corner : order) polygon.push_back(corners[corner]);
  PolygonTriangulator triangulator;
  double area = 0;
  for (const auto& [a, b, c] : triangulator.triangulate(polygon)) {
    const auto flat = [&](uint32_t corner) { return glm::dvec2(polygon[corner].x, polygon[corner].z); };
    area += std::abs(cross(flat(b) - flat(a), flat(c) - flat(a))) / 2;
  }
  EXPECT_EQ(triangulator.warning(), "");
  return area;
}

Polygon square_at(double x, double y, double half) {
  return {{x - half, y - half}, {x + half, y - half}, {x + half, y + half}, {x - half, y + half}};
}

TEST(PolygonHoles, AreNotCovered) {
  const Polygon plate = square_at(0, 0, 2);
  EXPECT_NEAR(joined_area({plate}), 16, 1e-9);
  for (const bool reversed : {false, true}) {
    Polygon hole = square_at(0.5, 0.25, 0.5);
    if (reversed) std::reverse(hole.begin(), hole.end());
    EXPECT_NEAR(joined_area({plate, hole}), 15, 1e-9) << "in any direction";
  }
  EXPECT_NEAR(joined_area({plate, {{0, 0}, {1, 0}}}), 16, 1e-9) << "a hole without an area";
  // A perforated sheet: rows of equal holes, whose corners lie on common lines.
  std::vector<Polygon> sheet{plate};
  for (int i = 0; i < 64; ++i)
    sheet.push_back(square_at(-1.75 + 0.5 * (i % 8), -1.75 + 0.5 * (i / 8), 0.125));
  EXPECT_NEAR(joined_area(sheet), 16 - 64 * 0.0625, 1e-9);
  // A U with a hole in each arm.
  const Polygon u{{0, 0}, {5, 0}, {5, 4}, {4, 4}, {4, 1}, {1, 1}, {1, 4}, {0, 4}};
  EXPECT_NEAR(joined_area({u, square_at(0.5, 3, 0.25), square_at(4.5, 3, 0.25), square_at(2.5, 0.5, 0.25)}),
              11 - 0.75, 1e-9);
  std::vector<uint32_t> order;
  joined_area({plate, square_at(0, 0, 1)}, &order);
  EXPECT_EQ(order.size(), 10u) << "two corners are doubled";
}

TEST(PolygonHoles, RandomHolesAreNotCovered) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.2, 0.2), size(0.05, 0.25);
  for (int round = 0; round < 20; ++round) {
    std::vector<Polygon> rings{square_at(0, 0, 3)};
    double holes = 0;
    for (int i = 0; i < 25; ++i) {
      const double half = size(random);
      const glm::dvec2 at(i % 5 - 2 + shift(random), i / 5 - 2 + shift(random));
      rings.push_back({at + glm::dvec2(half, 0), at + glm::dvec2(0, half), at - glm::dvec2(half, 0),
                       at - glm::dvec2(0, half)});
      holes += 2 * half * half;
    }
    EXPECT_NEAR(joined_area(rings), 36 - holes, 1e-9) << round;
  }
}

// Thousands of holes are joined in time n log n, at corners that several bridges share.
TEST(PolygonHoles, ManyAreNotCovered) {
  constexpr int kSide = 48;
  std::vector<Polygon> rings{square_at(0, 0, 1)};
  for (int i = 0; i < kSide * kSide; ++i) {
    const glm::dvec2 at((i % kSide + 0.5) * 2 / kSide - 1, (i / kSide + 0.5) * 2 / kSide - 1);
    rings.push_back(square_at(at.x, at.y, 0.5 / kSide));
  }
  EXPECT_NEAR(joined_area(rings), 3, 1e-9);
  rings.push_back(square_at(9, 0, 0.5));
  EXPECT_EQ(joined_area(rings), -1) << "one is outside";
}

TEST(PolygonHoles, RefusesWhatNoEdgeJoins) {
  const Polygon plate = square_at(0, 0, 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(joined_area({plate, square_at(9, 0, 0.5)}), -1) << "outside";
  EXPECT_EQ(joined_area({plate, {{0, 0}, {nan, 0}, {0, 1}}}), -1);
  EXPECT_EQ(joined_area({{{0, 0}, {1, 0}, {2, 0}}, square_at(0, 0, 0.5)}), -1) << "no area";
  EXPECT_EQ(joined_area({{{0, 0}, {1, 0}}}), -1);
}

}  // namespace
}  // namespace fire3dv::convert
