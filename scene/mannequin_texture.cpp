#include "scene/mannequin_body.h"
namespace crowdbench::scene::mannequin {
Image8 make_texture() {
  Image8 image(kTextureSide, kTextureSide, 4);
  const glm::ivec3 colours[kCharts] = {{214, 168, 140}, {70, 48, 35},    {72, 112, 160},  {72, 112, 160},
                                       {214, 168, 140}, {214, 168, 140}, {214, 168, 140}, {52, 56, 74},
                                       {52, 56, 74},    {60, 40, 30},    {30, 30, 30}};
  for (int id = 0; id < kCharts; ++id) {
    const Chart& c = chart(id);
    for (int y = c.y; y < c.y + c.height; ++y)
      for (int x = c.x; x < c.x + c.width; ++x) {
        auto* p = image.at(x, y);
        p[0] = (uint8_t)colours[id].x;
        p[1] = (uint8_t)colours[id].y;
        p[2] = (uint8_t)colours[id].z;
        p[3] = 255;
      }
  }
  return image;
}
}  // namespace crowdbench::scene::mannequin
