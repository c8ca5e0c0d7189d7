// The outlines that the built-in character's surface is swept from, by profiles keyed along one coordinate, and where
// its limbs lie. Metres, bind pose; u in [0, 1] runs once around from the back over the left side. Internal to scene.
#pragma once
#include <span>

#include "core/portable_math.h"
#include "scene/mannequin/mannequin_body.h"

namespace crowdbench::scene::mannequin {

inline constexpr glm::dvec3 kForward{0.0, 0.0, 1.0};
inline constexpr glm::dvec3 kPalm = -kArmUp;

// Values at one place of a profile, whose keys ascend.
template <size_t K>
struct Key {
  double at;
  std::array<double, K> values;
};

// Cubic Hermite pieces between the keys; the end values beyond them.
template <size_t K>
std::array<double, K> along(std::span<const Key<K>> keys, double at) {
  if (at <= keys.front().at) return keys.front().values;
  if (at >= keys.back().at) return keys.back().values;
  size_t i = 0;
  while (keys[i + 1].at < at) ++i;
  const auto slope = [&](size_t k, size_t c) {
    const auto chord = [&](size_t a) {
      return (keys[a + 1].values[c] - keys[a].values[c]) / (keys[a + 1].at - keys[a].at);
    };
    if (k == 0) return chord(0);
    if (k + 1 == keys.size()) return chord(k - 1);
    const double before = chord(k - 1);
    const double after = chord(k);
    // The harmonic mean keeps a profile from swinging past its keys (Fritsch and Butland's monotone choice).
    return before * after <= 0.0 ? 0.0 : 2.0 * before * after / (before + after);
  };
  const double h = keys[i + 1].at - keys[i].at;
  const double t = (at - keys[i].at) / h;
  const double tt = t * t;
  const double ttt = tt * t;
  std::array<double, K> out{};
  for (size_t c = 0; c < K; ++c) {
    out[c] = (2 * ttt - 3 * tt + 1) * keys[i].values[c] + (ttt - 2 * tt + t) * h * slope(i, c) +
             (3 * tt - 2 * ttt) * keys[i + 1].values[c] + (ttt - tt) * h * slope(i + 1, c);
  }
  return out;
}

inline double square(double x) { return x * x; }

// A unit circle's point pushed towards the square around it; squareness 0 leaves it round.
glm::dvec2 rounded(double sine, double cosine, double squareness);

// Left and right are mirror images: the point for side 0 (left) or 1 (right), given the left one.
inline glm::dvec3 mirrored(const glm::dvec3& p, int side) { return side == 0 ? p : glm::dvec3(-p.x, p.y, p.z); }

inline constexpr double kHeadLow = 1.430;
inline constexpr double kHeadHigh = 1.736;
// The face gets more columns than the back of the head.
SinCos head_turn(double u);
glm::dvec3 head_shape(double u, double y);
// The hairline's height: forehead, temples, behind the ears, nape.
double hairline(double u);

inline constexpr double kTorsoLow = 0.955;
inline constexpr double kTorsoHigh = 1.502;
glm::dvec3 torso_shape(double u, double y);

// t along the arm: half width forwards, half width upwards.
inline constexpr Key<2> kSleeve[] = {{.022, {.066, .0430}}, {.050, {.0675, .0505}}, {.085, {.064, .0545}},
                                     {.125, {.060, .0550}}, {.170, {.057, .0545}},  {.210, {.0565, .0550}},
                                     {.232, {.0575, .0560}}};
// t: half width forwards, half width upwards, how far the centre lies forwards, and towards the palm.
inline constexpr Key<4> kArm[] = {
    {.140, {.042, .043, .000, .000}},   {.210, {.042, .043, .000, .000}},    {.255, {.0385, .040, -.001, .000}},
    {.285, {.037, .0385, -.003, .000}}, {.320, {.0405, .0395, -.001, .000}}, {.355, {.041, .038, .001, .000}},
    {.410, {.0365, .033, .001, .000}},  {.470, {.030, .026, .000, .000}},    {.515, {.0275, .021, .000, .000}},
    {.540, {.0275, .019, .000, .000}},  {.560, {.031, .0185, .002, .001}},   {.585, {.0385, .018, .003, .002}},
    {.610, {.0425, .017, .001, .003}},  {.632, {.0405, .0150, .000, .005}},  {.646, {.0350, .0100, .000, .007}},
    {.680, {.0390, .0120, .000, .016}}, {.705, {.0350, .0110, .000, .028}},  {.722, {.0220, .0080, .000, .038}}};
inline constexpr double kKnuckles = 0.646;  // the palm ends here where fingers follow, the mitten further on
inline constexpr double kWrist = kUpperArm + kForearm;
// On the left arm's axis, t metres from the shoulder.
inline glm::dvec3 arm_point(double t) { return kShoulder + kArmAxis * t; }

// y: front z, back z, half width, squareness.
inline constexpr Key<4> kPelvis[] = {{0.850, {.100, -.122, .1800, .16}}, {0.880, {.103, -.125, .1790, .16}},
                                     {0.920, {.106, -.126, .1750, .15}}, {0.960, {.108, -.120, .1680, .13}},
                                     {0.990, {.109, -.113, .1610, .11}}, {1.018, {.110, -.108, .1570, .10}}};
// y: front z, back z, centre x, half width.
inline constexpr Key<4> kLeg[] = {
    {0.026, {.062, -.080, .098, .0590}}, {0.045, {.058, -.080, .098, .0585}}, {0.110, {.047, -.075, .098, .0555}},
    {0.200, {.047, -.074, .098, .0575}}, {0.300, {.050, -.083, .099, .0630}}, {0.370, {.055, -.084, .099, .0650}},
    {0.440, {.064, -.076, .098, .0650}}, {0.500, {.071, -.071, .097, .0670}}, {0.560, {.076, -.074, .096, .0700}},
    {0.640, {.083, -.084, .095, .0780}}, {0.720, {.090, -.097, .094, .0860}}, {0.790, {.096, -.112, .0935, .0905}},
    {0.830, {.099, -.119, .093, .0915}}};
glm::dvec3 pelvis_shape(double u, double y);

// Height of a row of the shoe: front z, back z, half width, where the width is measured across.
struct ShoeRow {
  double y, front, back, half_width, heel_half_width;
};
inline constexpr ShoeRow kShoe[] = {
    {.000, .188, -.060, .0470, .0300}, {.006, .197, -.068, .0505, .0345}, {.024, .198, -.069, .0510, .0350},
    {.027, .192, -.063, .0470, .0315}, {.044, .188, -.060, .0465, .0315}, {.060, .160, -.058, .0435, .0315},
    {.076, .116, -.056, .0390, .0315}, {.096, .070, -.052, .0345, .0310}, {.118, .046, -.046, .0340, .0300}};
// A shoe's outline: broad at the ball, narrow at the heel, the inner edge straighter than the outer one. row: 0..8.
glm::dvec3 shoe_shape(double u, double row);

}  // namespace crowdbench::scene::mannequin
