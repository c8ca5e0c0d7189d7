// How a tile of one agent is seen: from where, on which plane, and how that becomes a place on a page.
#pragma once
#include <glm/glm.hpp>
#include <optional>

namespace crowdbench::renderers {

// A box in model space, metres.
struct Box {
  glm::dvec3 low{0.0}, high{0.0};
  glm::dvec3 centre() const { return 0.5 * (low + high); }
};

// The plane through the box's centre across the direction to the eye; model space, metres. right x up = to_eye.
// right is the picture's own, as near as it can be, so that texels lie along pixels and nothing turns over a pole.
struct TileView {
  glm::dvec3 centre{0.0};
  glm::dvec3 right{1, 0, 0}, up{0, 1, 0}, to_eye{0, 0, 1};
  double distance = 0;             // of the eye from the centre
  double nearest = 0;              // depth of the box's nearest corner before the eye
  glm::dvec2 low{0.0}, high{0.0};  // what the box covers of the plane as the eye sees it, from the centre
  double texel = 0;                // metres of the plane
};

// nullopt where the eye is within the box or nearly so: nothing is seen as if on a plane from there. picture_right: the
// picture's axis to the right, of any length above 0. texel: of what is to be captured.
std::optional<TileView> tile_view(const Box& box, const glm::dvec3& eye, const glm::dvec3& picture_right, double texel);

// Whole texels of the rectangle [low, high].
glm::ivec2 tile_texels(const TileView& view);

// Rows of the matrix from a point (x, y, z, 1) to clip space of a page of `side` texels, on which the rectangle's lower
// left corner lies at texel `corner`. Depth is reversed: 0 far away. The point is model space turned by a heading (sine
// and cosine: +Z goes to (sin, 0, cos)).
struct TileRows {
  glm::vec4 x, y, z, w;
};
TileRows tile_rows(const TileView& view, const glm::vec2& heading, const glm::ivec2& corner, int side);

// A model-space vector turned by a heading, as shaders/frame.glsl turns it, and back.
glm::dvec3 turned(const glm::dvec3& v, const glm::vec2& heading);
glm::dvec3 turned_back(const glm::dvec3& v, const glm::vec2& heading);

}  // namespace crowdbench::renderers
