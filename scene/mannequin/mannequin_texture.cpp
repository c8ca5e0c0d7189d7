// The built-in character's one texture: every texel of a chart is painted by where it lies on the body, so that eyes,
// buttons and seams sit on the surface however many triangles it has. Colours are sRGB code values; cloth is light and
// hardly saturated, because outfits multiply it.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/portable_math.h"
#include "core/random.h"
#include "scene/mannequin/mannequin_body.h"

namespace crowdbench::scene::mannequin {
namespace {

using glm::dvec3;
using Colour = glm::dvec3;  // 0..255

constexpr Colour kSkin{224, 182, 154};
constexpr Colour kLips{190, 118, 106};
constexpr Colour kHair{92, 66, 48};
constexpr Colour kShirt{164, 186, 210};
constexpr Colour kTrousers{98, 103, 120};
constexpr Colour kBelt{66, 46, 34};
constexpr Colour kLeather{104, 70, 48};
constexpr Colour kSole{62, 56, 54};
constexpr double kTorsoBottom = 0.955;  // metres at v = 0 and 1 of the torso's chart
constexpr double kTorsoTop = 1.502;

double square(double x) { return x * x; }
Colour mix(const Colour& a, const Colour& b, double t) { return a + (b - a) * std::clamp(t, 0.0, 1.0); }

// 1 on a line through `at`, fading over `width` to both sides.
double line(double x, double at, double width) { return 1.0 - smooth(0.0, width, std::abs(x - at)); }
// 1 inside [low, high], fading over `edge` outside.
double within(double x, double low, double high, double edge) {
  return smooth(low - edge, low, x) * (1.0 - smooth(high, high + edge, x));
}
// 1 inside an ellipse, fading from its edge outwards by `soft` of its radius.
double spot(double dx, double dy, double rx, double ry, double soft) {
  return 1.0 - smooth(1.0, 1.0 + soft, std::sqrt(square(dx / rx) + square(dy / ry)));
}

// A table of random values in [-1, 1]: a hash of every cell would be most of the painting's time.
constexpr int kNoiseCells = 4096;
const std::array<double, kNoiseCells>& noise_table() {
  static const std::array<double, kNoiseCells> table = [] {
    std::array<double, kNoiseCells> values{};
    for (size_t i = 0; i < values.size(); ++i) values[i] = random_unit(20, i, 0) * 2.0 - 1.0;
    return values;
  }();
  return table;
}

// Smooth value noise in [-1, 1], `period` cells around in x >= 0.
double noise(double x, double y, int period, int purpose) {
  const auto& table = noise_table();
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y + 64.0) - 64;  // floor, for y > -64
  const auto cell = [&](int dx, int dy) {
    const int wrapped = (column + dx) % period;
    return table[static_cast<size_t>((wrapped * 97 + (row + dy + 64) * 1543 + purpose * 389) % kNoiseCells)];
  };
  const double tx = smooth(0.0, 1.0, x - column);
  const double ty = smooth(0.0, 1.0, y - row);
  const double low = cell(0, 0) + (cell(1, 0) - cell(0, 0)) * tx;
  const double high = cell(0, 1) + (cell(1, 1) - cell(0, 1)) * tx;
  return low + (high - low) * ty;
}

// u runs around in [0, 1]; across and up are cells of the coarsest octave.
double folds(double u, double v, int across, double up, int purpose) {
  return 0.6 * noise(u * across, v * up, across, purpose) +
         0.4 * noise(u * 2 * across, v * 2 * up, 2 * across, purpose + 1);
}
double grain(double u, double v, int across, double up) { return noise(u * across, v * up, across, 90); }

Colour paint_skin(double u, double v) {
  return kSkin * (1.0 + 0.018 * grain(u, v, 48, 48) + 0.02 * folds(u, v, 6, 6, 10));
}

Colour paint_hair(double u, double v) {
  const double strand =
      0.65 * noise(u * 90, v * 5 + 2 * noise(u * 8, v * 3, 8, 31), 90, 30) + 0.35 * noise(u * 40, v * 3, 40, 32);
  const double sheen = line(v, 0.55, 0.35);
  return kHair * (0.90 + 0.20 * strand + 0.12 * sheen) * (0.82 + 0.18 * smooth(0.0, 0.18, v));
}

// hair_edge: height of the hairline on this column.
Colour paint_head(double u, double v, double hair_edge) {
  const dvec3 p = head_point(u, v);
  Colour c = paint_skin(u, v);
  const double x = std::abs(p.x);
  const double side = p.x < 0 ? -1.0 : 1.0;
  if (p.z > 0.025) {
    const double y = p.y;
    c = mix(c, Colour(214, 148, 126), 0.45 * spot(x - 0.043, y - 1.612, 0.006, 0.005, 4.0));          // cheeks
    c = mix(c, Colour(150, 104, 86), 0.34 * spot(x - 0.033, y - 1.6435, 0.0165, 0.0085, 0.8));        // eye sockets
    c = mix(c, Colour(160, 112, 92), 0.40 * line(x, 0.0125, 0.006) * within(y, 1.604, 1.640, 0.01));  // beside the nose
    c = mix(c, Colour(150, 96, 78), 0.45 * spot(x, y - 1.6015, 0.015, 0.0022, 1.6));                  // under the nose
    c = mix(c, Colour(92, 52, 42), 0.80 * spot(x - 0.0068, y - 1.6035, 0.0032, 0.0018, 0.6));         // nostrils
    // Brows.
    const double brow_y = 1.6615 + 0.0035 * (1.0 - square((x - 0.036) / 0.018));
    const double brow = within(x, 0.0165, 0.0500, 0.003) * spot(0.0, y - brow_y, 1.0, 0.0019 + 0.035 * (0.05 - x), 0.7);
    c = mix(c, kHair * 0.80, 0.80 * brow);
    // Eyes: white, iris, pupil, light, lids.
    const double ex = (x - 0.0325) / 0.0150;
    const double arch = 1.0 - square(ex);
    const double upper = 1.6425 + 0.0066 * std::max(arch, 0.0);
    const double lower = 1.6425 - 0.0050 * std::max(arch, 0.0);
    if (std::abs(ex) < 1.0) {
      const double open = within(y, lower, upper, 0.0007);
      Colour eye(240, 236, 230);
      eye = mix(eye, Colour(176, 160, 150), 0.5 * smooth(0.002, 0.0, upper - y));
      const double r = std::sqrt(square(p.x - side * 0.0320) + square(y - 1.6432));
      eye = mix(eye, Colour(82, 58, 42), 1.0 - smooth(0.0056, 0.0064, r));
      eye = mix(eye, Colour(16, 12, 12), 1.0 - smooth(0.0026, 0.0033, r));
      const double glint = std::sqrt(square(p.x - side * 0.0320 - 0.0022) + square(y - 1.6456));
      eye = mix(eye, Colour(250, 250, 250), 1.0 - smooth(0.0010, 0.0016, glint));
      c = mix(c, eye, open);
      c = mix(c, Colour(70, 48, 40), 0.90 * line(y, upper + 0.0006, 0.0017));
      c = mix(c, Colour(140, 92, 78), 0.60 * line(y, lower - 0.0004, 0.0012));
      c = mix(c, Colour(150, 104, 86), 0.55 * line(y, upper + 0.0050, 0.0016) * arch);
    }
    // Mouth: the lips and the line between them.
    const double mx = x / 0.0245;
    if (mx < 1.0) {
      const double bow = 1.0 - square(mx);
      const double middle = 1.5758 + 0.0022 * square(mx);  // the corners turn up a little
      const double top = middle + 0.0058 * bow - 0.0016 * line(x, 0.0, 0.004);
      const double low = middle - 0.0076 * bow;
      c = mix(c, kLips, 0.85 * within(y, low, top, 0.0014));
      c = mix(c, Colour(206, 140, 126), 0.5 * spot(x, y - 1.5718, 0.010, 0.0018, 1.5));
      c = mix(c, Colour(112, 58, 52), 0.85 * line(y, middle + 0.0010 * line(x, 0.006, 0.006), 0.0014));
    }
    c = mix(c, Colour(158, 108, 90), 0.40 * spot(x, y - 1.5650, 0.014, 0.0018, 1.8));  // below the lower lip
  }
  // Light hardly gets under the jaw; the scalp takes the hair's colour.
  const double under = within(p.y, 1.440, 1.512, 0.016) * smooth(-0.02, 0.035, p.z);
  c = c * (1.0 - 0.24 * under);
  c = c * (1.0 - 0.16 * (1.0 - smooth(1.455, 1.50, p.y)));
  c = mix(c, kHair * 0.92,
          0.92 * smooth(hair_edge - 0.010, hair_edge + 0.003, p.y + 0.003 * noise(u * 70, 0.0, 70, 33)));
  return c;
}

Colour cloth(const Colour& base, double u, double v, int across, double up, double depth, int purpose) {
  return base * (1.0 + depth * folds(u, v, across, up, purpose) + 0.015 * grain(u, v, 160, 160));
}

Colour paint_torso(double u, double v) {
  const dvec3 p = torso_point(u, v);
  const double x = std::abs(p.x);
  const double waist = 1.0 - smooth(1.02, 1.17, p.y);
  Colour c = cloth(kShirt, u, v, 9, 5.0, 0.045 + 0.03 * waist, 40);
  c = c * (1.0 + 0.07 * waist * noise(u * 26, v * 3.0, 26, 44));  // gathered where it is tucked in
  c = c * (1.0 - 0.22 * spot(x - 0.172, p.y - 1.305, 0.012, 0.035, 3.0));
  c = c * (1.0 - 0.15 * (1.0 - smooth(1.020, 1.050, p.y)));
  c = c * (1.0 - 0.10 * line(u, 0.25, 0.0022) - 0.10 * line(u, 0.75, 0.0022));  // side seams
  if (p.z > 0.0) {
    // Placket with three buttons.
    const double placket = within(p.y, 1.315, 1.478, 0.001);
    c = c * (1.0 + 0.03 * placket * within(x, 0.0, 0.0165, 0.001));
    c = c * (1.0 - 0.26 * placket * line(x, 0.0170, 0.0016));
    c = c * (1.0 - 0.22 * line(p.y, 1.315, 0.0018) * within(x, 0.0, 0.017, 0.001));
    for (const double button : {1.448, 1.398, 1.345}) {
      c = mix(c, c * 0.62, 0.8 * spot(p.x - 0.0008, p.y - button + 0.0010, 0.0062, 0.0062, 0.3));
      c = mix(c, Colour(240, 240, 236), spot(p.x, p.y - button, 0.0052, 0.0052, 0.2));
      c = mix(c, Colour(150, 150, 150), spot(p.x, p.y - button, 0.0012, 0.0012, 0.5));
    }
  }
  // The collar; its leaves lie on the shirt in front and throw a little shadow.
  const double height = kTorsoBottom + v * (kTorsoTop - kTorsoBottom);
  double collar_low = 1.4780;
  if (p.z > 0.0) collar_low -= 0.034 * smooth(0.066, 0.030, x) * smooth(0.004, 0.018, x);
  const double behind = p.z > 0.0 ? smooth(0.004, 0.008, x) : 1.0;
  c = c * (1.0 - 0.20 * line(height, collar_low - 0.0016, 0.0030) * behind);
  c = mix(c, kShirt * 1.06, 0.7 * smooth(collar_low, collar_low + 0.0008, height));
  c = c * (1.0 - 0.35 * smooth(0.985, 1.0, v));
  return c;
}

Colour paint_sleeve(double u, double v) {
  Colour c = cloth(kShirt, u, v, 6, 4.0, 0.06, 50);
  c = c * (1.0 - 0.16 * line(u, 0.5, 0.22) * smooth(0.35, 1.0, v));  // armpit
  c = c * (1.0 - 0.16 * line(v, 0.12, 0.012) - 0.10 * line(u, 0.5, 0.006));
  return c * (1.0 - 0.35 * (1.0 - smooth(0.0, 0.02, v)));
}

// t: metres along the arm; z: across it, -1 at the little finger's edge, 1 at the thumb's; palm: 1 inside.
Colour paint_arm(double u, double v) {
  Colour c = paint_skin(u, v);
  const double t = 0.722 - v * (0.722 - 0.14);
  const SinCos turn = sincos_turns(u + 0.05);
  c = mix(c, Colour(206, 150, 126), 0.30 * line(t, 0.285, 0.03) * smooth(0.2, -0.8, -turn.cos));  // elbow
  c = c * (1.0 - 0.20 * smooth(0.245, 0.215, t));                                                 // in the sleeve
  c = c * (1.0 - 0.07 * smooth(-0.2, -0.9, -turn.sin) * within(t, 0.30, 0.52, 0.05));
  // The mitten's fingers.
  if (t > 0.640) {
    for (const double z : {-0.5, 0.0, 0.5}) c = c * (1.0 - 0.38 * line(turn.cos, z, 0.12) * smooth(0.640, 0.652, t));
  }
  c = mix(c, Colour(206, 146, 124), 0.30 * line(t, 0.632, 0.016));
  return c;
}

Colour paint_finger(double u, double v) {
  Colour c = paint_skin(u, v);
  c = c * (1.0 - 0.10 * line(v, 0.36, 0.05) - 0.10 * line(v, 0.68, 0.05));
  c = mix(c, Colour(214, 152, 132), 0.4 * smooth(0.75, 1.0, v));
  const double nail = within(u, 0.63, 0.87, 0.02) * within(v, 0.84, 0.97, 0.02);
  return mix(c, Colour(236, 200, 184), 0.8 * nail);
}

Colour paint_ear(double u, double v) {
  Colour c = mix(paint_skin(u, v), Colour(206, 142, 122), 0.35);
  return c * (0.78 + 0.22 * smooth(0.15, 0.6, v)) * (1.0 - 0.25 * smooth(0.93, 1.0, v));
}

Colour paint_pelvis(double u, double v) {
  const double y = 0.858 + v * (1.017 - 0.858);
  const double front = std::abs(u - 0.5);
  const double back = 0.5 - front;
  Colour c = cloth(kTrousers, u, v, 10, 2.0, 0.05 * smooth(0.0, 0.3, v), 60);
  c = c * (1.0 - 0.22 * line(u, 0.25, 0.002) - 0.22 * line(u, 0.75, 0.002));
  c = c * (1.0 - 0.25 * line(u, 0.5 - 0.012 * smooth(0.0, 0.5, v), 0.0022));  // fly
  c = c * (1.0 - 0.25 * line(back, 0.0, 0.002));
  // Slanted front pockets, straight back pockets.
  c = c * (1.0 - 0.30 * line(front, 0.150 + 0.9 * (0.985 - y), 0.0030) * within(y, 0.905, 0.982, 0.002));
  const double bx = back - 0.115;
  const double pocket = within(bx, -0.058, 0.058, 0.002) * within(y, 0.878, 0.955, 0.001) -
                        within(bx, -0.055, 0.055, 0.002) * within(y, 0.880, 0.953, 0.001);
  c = c * (1.0 - 0.25 * pocket);
  // Belt, loops, buckle.
  if (y > 0.978) {
    c = mix(c, kBelt * (1.0 + 0.06 * grain(u, v, 80, 20)), smooth(0.978, 0.980, y));
    c = c * (1.0 - 0.35 * line(y, 0.9815, 0.0015) - 0.35 * line(y, 1.0130, 0.0015));
    for (const double loop : {0.115, 0.300}) {
      c = mix(c, kTrousers * 0.92, within(front, loop - 0.005, loop + 0.005, 0.001));
    }
    c = mix(c, kTrousers * 0.92, within(back, -0.005, 0.005, 0.001));
    const double outer = within(front, 0.0, 0.0215, 0.001) * within(y, 0.9795, 1.0150, 0.001);
    const double inner = within(front, 0.0, 0.0150, 0.001) * within(y, 0.9850, 1.0095, 0.001);
    c = mix(c, Colour(196, 186, 158), outer * (1.0 - inner));
  }
  return c * (1.0 - 0.25 * line(y, 0.9760, 0.0040));
}

Colour paint_leg(double u, double v) {
  const double y = 0.028 + v * (0.858 - 0.028);
  Colour c = cloth(kTrousers, u, v, 5, 12.0, 0.05 * smooth(1.0, 0.93, v), 70);
  // Crinkles behind and in front of the knee and above the hem.
  const double knee = line(y, 0.49, 0.13);
  const double cuff = 1.0 - smooth(0.03, 0.20, y);
  c = c * (1.0 + 0.05 * std::max(knee, cuff) * noise(u * 4, y * 60 + 2.0 * noise(u * 5, y * 9, 5, 75), 4, 74));
  c = c * (1.0 - 0.14 * line(u, 0.40, 0.004) - 0.10 * line(u, 0.906, 0.004));  // side seam, inner seam
  c = c * (1.0 + 0.05 * line(u, 0.655, 0.010) * within(v, 0.1, 0.85, 0.1));    // pressed crease
  c = c * (1.0 - 0.22 * within(u, 0.80, 1.0, 0.10) * smooth(0.70, 1.0, v));    // between the thighs
  c = c * (1.0 - 0.20 * line(y, 0.050, 0.0030));
  return c * (1.0 - 0.30 * (1.0 - smooth(0.0, 0.008, v)));
}

Colour paint_shoe(double u, double v) {
  const double row = v * 8.0;
  const double front = std::abs(u - 0.5);
  Colour c = kLeather * (1.0 + 0.05 * folds(u, v, 10, 6.0, 80) + 0.02 * grain(u, v, 100, 60));
  c = mix(c, kLeather * 1.22, 0.5 * spot(front, row - 4.2, 0.06, 0.5, 1.5));  // light on the toe cap
  c = c * (1.0 - 0.35 * line(row - 4.0 - 10.0 * front, 0.35, 0.14) * within(front, 0.0, 0.14, 0.01));
  c = c * (1.0 - 0.30 * line(front, 0.33, 0.006) * smooth(3.0, 3.3, row));
  for (const double lace : {5.15, 5.55, 5.95, 6.4}) {
    c = mix(c, kLeather * 0.42, 0.9 * line(row, lace, 0.11) * within(front, 0.0, 0.075, 0.006));
  }
  c = c * (1.0 - 0.30 * (1.0 - smooth(3.0, 3.5, row)));
  const Colour sole = kSole * (1.0 - 0.25 * line(row, 1.5, 0.12) + 0.10 * smooth(2.0, 2.6, row));
  return mix(sole, c, smooth(2.90, 3.0, row));
}

Colour paint_sole(double u, double v) {
  const double tread = line(v * 24.0 - std::floor(v * 24.0), 0.5, 0.25);
  return kSole * (0.85 - 0.20 * tread + 0.03 * grain(u, v, 40, 40));
}

Colour paint(int id, double u, double v, double hair_edge) {
  switch (id) {
    case chart_head: return paint_head(u, v, hair_edge);
    case chart_hair: return paint_hair(u, v);
    case chart_torso: return paint_torso(u, v);
    case chart_sleeve: return paint_sleeve(u, v);
    case chart_arm: return paint_arm(u, v);
    case chart_finger: return paint_finger(u, v);
    case chart_ear: return paint_ear(u, v);
    case chart_pelvis: return paint_pelvis(u, v);
    case chart_leg: return paint_leg(u, v);
    case chart_shoe: return paint_shoe(u, v);
    default: return paint_sole(u, v);
  }
}

}  // namespace

Image8 make_texture() {
  Image8 image(kTextureSide, kTextureSide, 4);
  for (size_t i = 3; i < image.data.size(); i += 4) image.data[i] = 255;
  for (int id = 0; id < kCharts; ++id) {
    const Chart& c = chart(id);
    for (int x = 0; x < c.width; ++x) {
      // The gutter repeats the chart's edge, so that filtering never meets a neighbour.
      const double u = std::clamp((x + 0.5 - kGutter) / (c.width - 2 * kGutter), 0.0, 1.0);
      const double hair_edge = id == chart_head ? hair_point(u, 0.0).y : 0.0;
      for (int y = 0; y < c.height; ++y) {
        const double v = 1.0 - std::clamp((y + 0.5 - kGutter) / (c.height - 2 * kGutter), 0.0, 1.0);
        const Colour colour = paint(id, u, v, hair_edge);
        uint8_t* texel = image.at(c.x + x, c.y + y);
        for (int i = 0; i < 3; ++i) {
          texel[i] = static_cast<uint8_t>(std::clamp(colour[i], 0.0, 255.0) + 0.5);
        }
      }
    }
  }
  return image;
}

}  // namespace crowdbench::scene::mannequin
