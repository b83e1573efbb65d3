#include "renderer/passes/markers/true_type_font.h"

#include <cstddef>

#include "base/error.h"
#include "renderer/passes/markers/font.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#define STBTT_STATIC
#define STB_TRUETYPE_IMPLEMENTATION
#include <stb/stb_truetype.h>
#pragma GCC diagnostic pop

namespace fire3dv::passes {
namespace {

// Takes pixels of stb_truetype; null: none.
void take(unsigned char* pixels, TrueTypeFont::Bitmap& bitmap) {
  if (!pixels) return;
  bitmap.values.assign(pixels, pixels + static_cast<ptrdiff_t>(bitmap.width) * bitmap.height);
  stbtt_FreeBitmap(pixels, nullptr);
}

}  // namespace

struct TrueTypeFont::Face {
  stbtt_fontinfo info;
  int ascent = 0, descent = 0;  // in units of the font

  float scale(float em_px) const { return stbtt_ScaleForMappingEmToPixels(&info, em_px); }
};

TrueTypeFont::TrueTypeFont() : face_(std::make_unique<Face>()) {
  const auto* const bytes = reinterpret_cast<const unsigned char*>(font_bytes().data());
  const int is_read = stbtt_InitFont(&face_->info, bytes, stbtt_GetFontOffsetForIndex(bytes, 0));
  FIRE3DV_ASSERT(is_read != 0);
  int gap = 0;
  stbtt_GetFontVMetrics(&face_->info, &face_->ascent, &face_->descent, &gap);
}

TrueTypeFont::~TrueTypeFont() = default;

int TrueTypeFont::glyph_index(uint32_t character) const {
  return stbtt_FindGlyphIndex(&face_->info, static_cast<int>(character));
}

float TrueTypeFont::ascent(float em_px) const {
  return face_->scale(em_px) * static_cast<float>(face_->ascent);
}

float TrueTypeFont::descent(float em_px) const {
  return -face_->scale(em_px) * static_cast<float>(face_->descent);
}

float TrueTypeFont::advance(int glyph, float em_px) const {
  int advance = 0, bearing = 0;
  stbtt_GetGlyphHMetrics(&face_->info, glyph, &advance, &bearing);
  return face_->scale(em_px) * static_cast<float>(advance);
}

TrueTypeFont::Bitmap TrueTypeFont::coverage(int glyph, float em_px) const {
  Bitmap bitmap;
  const float scale = face_->scale(em_px);
  take(stbtt_GetGlyphBitmap(&face_->info, scale, scale, glyph, &bitmap.width, &bitmap.height, &bitmap.left,
                            &bitmap.top),
       bitmap);
  return bitmap;
}

TrueTypeFont::Bitmap TrueTypeFont::distance_field(int glyph, float em_px, const Field& field) const {
  Bitmap bitmap;
  take(stbtt_GetGlyphSDF(&face_->info, face_->scale(em_px), glyph, field.margin_px, field.on_edge,
                         field.per_pixel, &bitmap.width, &bitmap.height, &bitmap.left, &bitmap.top),
       bitmap);
  return bitmap;
}

}  // namespace fire3dv::passes
