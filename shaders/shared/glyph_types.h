// Text markers in the marker pass: the kind whose elements are glyphs, and the glyph atlas. Of MarkerPush
// `rotations` has two vec4 per glyph: its rectangle in units of the font size, y up, from the position, and
// the same corners in the atlas, in texels; `sizes` is the atlas; `segments` its number of rows.
#ifndef FIRE3DV_SHARED_GLYPH_TYPES_H
#define FIRE3DV_SHARED_GLYPH_TYPES_H

#define FIRE3DV_MARKER_TEXTS 10u

// Bytes of a signed distance field, row by row from the top. Values rise into the glyph.
#define FIRE3DV_GLYPH_ATLAS_WIDTH 1024u
#define FIRE3DV_GLYPH_ON_EDGE 128.0f
#define FIRE3DV_GLYPH_VALUES_PER_TEXEL 25.6f

#endif
