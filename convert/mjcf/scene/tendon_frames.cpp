#include "convert/mjcf/scene/tendon_frames.h"

#include <algorithm>

#include "convert/model.h"

namespace fire3dv::convert {

TendonFrame piece_frame(const TendonPiece& piece) {
  const glm::dvec3 way = piece.to - piece.from;
  const double length = glm::length(way);
  TendonFrame frame;
  frame.position = 0.5 * (piece.from + piece.to);
  if (length > 0) frame.turn = glm::mat3_cast(shining(-way));
  frame.scale = {piece.radius_m, piece.radius_m, length / 2};
  return frame;
}

void tendon_frames(const std::vector<TendonPiece>& pieces, size_t max_points,
                   std::vector<TendonFrame>& frames) {
  frames.assign(max_points > 0 ? 2 * max_points - 1 : 0, {});
  if (max_points == 0) return;
  const size_t max_pieces = max_points - 1;
  size_t end = max_pieces;
  const auto add_ball = [&](const glm::dvec3& position, double radius_m) {
    if (end < frames.size()) frames[end++] = {position, glm::dmat3(1), glm::dvec3(radius_m)};
  };
  for (size_t i = 0; i < pieces.size() && i < max_pieces; ++i) {
    frames[i] = piece_frame(pieces[i]);
    const bool continues = i > 0 && pieces[i - 1].to == pieces[i].from;
    // A ball between two segments takes the larger radius.
    add_ball(pieces[i].from,
             continues ? std::max(pieces[i - 1].radius_m, pieces[i].radius_m) : pieces[i].radius_m);
    if (i + 1 == pieces.size() || pieces[i + 1].from != pieces[i].to)
      add_ball(pieces[i].to, pieces[i].radius_m);
  }
  const glm::dvec3 rest = pieces.empty() ? glm::dvec3(0) : pieces.back().to;
  for (size_t i = pieces.size(); i < max_pieces; ++i) frames[i].position = rest;
  for (; end < frames.size(); ++end) frames[end].position = rest;
}

}  // namespace fire3dv::convert
