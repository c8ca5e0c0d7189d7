// The surface of the built-in character: swept cross-sections, joined where a body is one surface (a shirt's sleeves
// leave its torso through an armhole, a pair of trousers parts at the crotch), hidden inside each other where clothes
// meet skin. Every piece is closed.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <map>
#include <span>
#include <tuple>

#include "core/portable_math.h"
#include "scene/mannequin_body.h"

namespace crowdbench::scene::mannequin {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr dvec3 kForward{0.0, 0.0, 1.0};
constexpr dvec3 kPalm = -kArmUp;

// ---------------------------------------------------------------------------------------------------------------
// Profiles: values keyed along one coordinate, joined by cubic Hermite pieces with averaged slopes.

template <size_t K>
struct Key {
  double at;
  std::array<double, K> values;
};

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

double square(double x) { return x * x; }

// A unit circle's point pushed towards the square around it; squareness 0 leaves it round.
dvec2 rounded(double sine, double cosine, double squareness) {
  const double s2 = sine * sine;
  const double c2 = cosine * cosine;
  const double out = 1.0 + squareness * (1.0 / std::sqrt(std::sqrt(s2 * s2 + c2 * c2)) - 1.0);
  return {sine * out, cosine * out};
}

// ---------------------------------------------------------------------------------------------------------------
// Head, neck and hair.

// y: front z, back z, half width, squareness, how far the front hangs below the back.
constexpr Key<5> kHead[] = {{1.430, {.044, -.078, .064, .00, .010}},    {1.468, {.036, -.070, .052, .00, .014}},
                            {1.500, {.034, -.066, .0475, .00, .016}},   {1.520, {.039, -.067, .0475, .00, .016}},
                            {1.533, {.064, -.069, .0490, -.05, .018}},  {1.544, {.0875, -.072, .0535, -.12, .017}},
                            {1.557, {.0935, -.075, .0585, -.12, .013}}, {1.574, {.0935, -.080, .0640, -.08, .008}},
                            {1.590, {.0955, -.085, .0680, -.03, .004}}, {1.604, {.0958, -.089, .0703, .01, .002}},
                            {1.620, {.0958, -.093, .0725, .04, .000}},  {1.640, {.0950, -.097, .0745, .04, .000}},
                            {1.658, {.0985, -.100, .0755, .03, .000}},  {1.676, {.0975, -.101, .0755, .02, .000}},
                            {1.693, {.0905, -.097, .0725, .01, .000}},  {1.710, {.0770, -.087, .0645, .00, .000}},
                            {1.724, {.0570, -.070, .0510, .00, .000}},  {1.733, {.0300, -.046, .0310, .00, .000}},
                            {1.736, {.0080, -.026, .0130, .00, .000}}};
constexpr double kHeadLow = 1.430;
constexpr double kHeadHigh = 1.736;

constexpr Key<1> kNose[] = {{1.592, {0.0}},  {1.600, {.006}}, {1.607, {.019}}, {1.614, {.0215}},
                            {1.628, {.016}}, {1.644, {.008}}, {1.660, {.002}}, {1.672, {0.0}}};

double bump(double squared_distance) { return squared_distance < 1.0 ? square(1.0 - squared_distance) : 0.0; }

// The face gets more columns than the back of the head.
SinCos head_turn(double u) { return sincos_turns(u + 0.075 * sincos_turns(u).sin); }

dvec3 head_shape(double u, double y) {
  const auto p = along<5>(kHead, y);
  const SinCos turn = head_turn(u);
  const dvec2 round = rounded(turn.sin, -turn.cos, p[3]);
  const double middle = 0.5 * (p[0] + p[1]);
  dvec3 at{p[2] * round.x, y, middle + 0.5 * (p[0] - p[1]) * round.y};
  at.y -= p[4] * round.y;
  if (round.y > 0.0) {
    at.z += along<1>(kNose, y)[0] * bump(square(at.x / 0.021));
    at.z -= 0.0085 * bump(square((std::abs(at.x) - 0.033) / 0.024) + square((y - 1.641) / 0.019));  // eye sockets
    at.z += 0.0050 * bump(square((std::abs(at.x) - 0.034) / 0.026) + square((y - 1.612) / 0.022));  // cheekbones
    at.z += 0.0045 * bump(square(at.x / 0.030) + square((y - 1.581) / 0.016));                      // lips
    at.z -= 0.0030 * bump(square(at.x / 0.030) + square((y - 1.566) / 0.008));                      // below the lip
    at.z += 0.0035 * bump(square(at.x / 0.024) + square((y - 1.549) / 0.014));                      // chin
  }
  return at;
}

// The hairline: forehead, temples, behind the ears, nape; by the cosine and sine of the way around (front = 1).
double hairline(double u) {
  const SinCos turn = head_turn(u);
  const double front = -turn.cos;
  if (front > 0.62) return 1.706 - 0.004 * smooth(0.80, 1.00, front);  // a little lower in the middle
  if (front > 0.40) return 1.706 - 0.034 * smooth(0.62, 0.40, front);
  if (front > 0.16) return 1.672 - 0.044 * smooth(0.40, 0.16, front);
  if (front > -0.05) return 1.628 + 0.004 * smooth(0.16, -0.05, front);
  return 1.632 - 0.090 * smooth(-0.05, -0.70, front);
}

// ---------------------------------------------------------------------------------------------------------------
// Shirt.

// y: front z, back z, half width, squareness, how far the sides stand above the front.
constexpr Key<5> kTorso[] = {{0.955, {.098, -.106, .150, .10, .000}},  {1.005, {.105, -.106, .155, .10, .000}},
                             {1.035, {.110, -.105, .1555, .10, .000}}, {1.080, {.110, -.100, .152, .10, .000}},
                             {1.130, {.109, -.100, .151, .12, .000}},  {1.190, {.111, -.107, .155, .14, .000}},
                             {1.250, {.116, -.116, .161, .16, .000}},  {1.305, {.116, -.124, .167, .18, .000}},
                             {1.350, {.108, -.126, .170, .18, .002}},  {1.390, {.093, -.122, .169, .16, .006}},
                             {1.420, {.076, -.113, .164, .12, .011}},  {1.446, {.060, -.100, .154, .06, .011}},
                             {1.464, {.051, -.088, .114, .00, .009}},  {1.476, {.050, -.080, .076, .00, .000}},
                             {1.484, {.052, -.078, .065, .00, -.006}}, {1.502, {.057, -.080, .0645, .00, -.006}}};
constexpr double kTorsoLow = 0.955;
constexpr double kTorsoHigh = 1.502;

dvec3 torso_shape(double u, double y) {
  const auto p = along<5>(kTorso, y);
  const SinCos turn = sincos_turns(u);
  const dvec2 round = rounded(turn.sin, -turn.cos, p[3]);
  const double middle = 0.5 * (p[0] + p[1]);
  dvec3 at{p[2] * round.x, y + p[4] * square(turn.sin), middle + 0.5 * (p[0] - p[1]) * round.y};
  if (y > 1.46) at.y -= 0.024 * smooth(1.46, 1.49, y) * smooth(-0.2, 1.0, -turn.cos);  // a collar dips in front
  // Chest and shoulder blades.
  if (round.y > 0.0) {
    at.z += 0.010 * bump(square((std::abs(at.x) - 0.075) / 0.085) + square((y - 1.315) / 0.085));
  } else {
    at.z -= 0.008 * bump(square((std::abs(at.x) - 0.080) / 0.075) + square((y - 1.345) / 0.090));
    at.z += 0.007 * bump(square(at.x / 0.035) + square((y - 1.22) / 0.20));
  }
  return at;
}

// t along the arm: half width forwards, half width upwards.
constexpr Key<2> kSleeve[] = {{.022, {.066, .0430}}, {.050, {.0675, .0505}}, {.085, {.064, .0545}},
                              {.125, {.060, .0550}}, {.170, {.057, .0545}},  {.210, {.0565, .0550}},
                              {.232, {.0575, .0560}}};
// t: half width forwards, half width upwards, how far the centre lies forwards, and towards the palm.
constexpr Key<4> kArm[] = {
    {.140, {.042, .043, .000, .000}},   {.210, {.042, .043, .000, .000}},    {.255, {.0385, .040, -.001, .000}},
    {.285, {.037, .0385, -.003, .000}}, {.320, {.0405, .0395, -.001, .000}}, {.355, {.041, .038, .001, .000}},
    {.410, {.0365, .033, .001, .000}},  {.470, {.030, .026, .000, .000}},    {.515, {.0275, .021, .000, .000}},
    {.540, {.0275, .019, .000, .000}},  {.560, {.031, .0185, .002, .001}},   {.585, {.0385, .018, .003, .002}},
    {.610, {.0425, .017, .001, .003}},  {.632, {.0405, .0150, .000, .005}},  {.646, {.0350, .0100, .000, .007}},
    {.680, {.0390, .0120, .000, .016}}, {.705, {.0350, .0110, .000, .028}},  {.722, {.0220, .0080, .000, .038}}};
constexpr double kKnuckles = 0.646;  // the palm ends here where fingers follow, the mitten further on
constexpr double kWrist = kUpperArm + kForearm;

dvec3 arm_point(double t) { return kShoulder + kArmAxis * t; }

// ---------------------------------------------------------------------------------------------------------------
// Trousers and shoes.

// y: front z, back z, half width, squareness.
constexpr Key<4> kPelvis[] = {{0.850, {.100, -.122, .1800, .16}}, {0.880, {.103, -.125, .1790, .16}},
                              {0.920, {.106, -.126, .1750, .15}}, {0.960, {.108, -.120, .1680, .13}},
                              {0.990, {.109, -.113, .1610, .11}}, {1.018, {.110, -.108, .1570, .10}}};
// y: front z, back z, centre x, half width.
constexpr Key<4> kLeg[] = {
    {0.026, {.062, -.080, .098, .0590}}, {0.045, {.058, -.080, .098, .0585}}, {0.110, {.047, -.075, .098, .0555}},
    {0.200, {.047, -.074, .098, .0575}}, {0.300, {.050, -.083, .099, .0630}}, {0.370, {.055, -.084, .099, .0650}},
    {0.440, {.064, -.076, .098, .0650}}, {0.500, {.071, -.071, .097, .0670}}, {0.560, {.076, -.074, .096, .0700}},
    {0.640, {.083, -.084, .095, .0780}}, {0.720, {.090, -.097, .094, .0860}}, {0.790, {.096, -.112, .0935, .0905}},
    {0.830, {.099, -.119, .093, .0915}}};

dvec3 pelvis_shape(double u, double y) {
  const auto p = along<4>(kPelvis, y);
  const SinCos turn = sincos_turns(u);
  const dvec2 round = rounded(turn.sin, -turn.cos, p[3]);
  dvec3 at{p[2] * round.x, y, 0.5 * (p[0] + p[1]) + 0.5 * (p[0] - p[1]) * round.y};
  // A cleft behind, seat on both sides of it.
  if (round.y < 0.0) {
    at.z -= 0.012 * bump(square((std::abs(at.x) - 0.075) / 0.075) + square((y - 0.885) / 0.075));
    at.z += 0.010 * bump(square(at.x / 0.035) + square((y - 0.86) / 0.07));
  }
  return at;
}

// Height of a row of the shoe: front z, back z, half width, where the width is measured across.
struct ShoeRow {
  double y, front, back, half_width, heel_half_width;
};
constexpr ShoeRow kShoe[] = {
    {.000, .188, -.060, .0470, .0300}, {.006, .197, -.068, .0505, .0345}, {.024, .198, -.069, .0510, .0350},
    {.027, .192, -.063, .0470, .0315}, {.044, .188, -.060, .0465, .0315}, {.060, .160, -.058, .0435, .0315},
    {.076, .116, -.056, .0390, .0315}, {.096, .070, -.052, .0345, .0310}, {.118, .046, -.046, .0340, .0300}};

// A shoe's outline: broad at the ball, narrow at the heel, the inner edge straighter than the outer one.
dvec3 shoe_shape(double u, double row) {
  const double place = std::clamp(row, 0.0, 8.0);
  const auto below = std::min(static_cast<size_t>(place), size_t{7});
  const double t = place - static_cast<double>(below);
  const auto mix = [&](double ShoeRow::*m) { return kShoe[below].*m + (kShoe[below + 1].*m - kShoe[below].*m) * t; };
  const SinCos turn = sincos_turns(u);
  const double front = -turn.cos;
  const dvec2 round = rounded(turn.sin, front, 0.22);
  const double length = mix(&ShoeRow::front) - mix(&ShoeRow::back);
  const double z = 0.5 * (mix(&ShoeRow::front) + mix(&ShoeRow::back)) + 0.5 * length * round.y;
  const double forward = smooth(-0.030, 0.115, z);
  double half = mix(&ShoeRow::heel_half_width) + (mix(&ShoeRow::half_width) - mix(&ShoeRow::heel_half_width)) * forward;
  half *= round.x < 0.0 ? 1.0 - 0.10 * forward : 1.0;
  const double y = mix(&ShoeRow::y);
  const double toe_spring = 0.010 * square(smooth(0.12, 0.20, z)) * (y < 0.05 ? 1.0 : 0.5);
  return {0.098 + half * round.x + 0.010 * forward, y + toe_spring, z + kAnkleZ};
}

// ---------------------------------------------------------------------------------------------------------------
// Skin weights, by position in the bind pose.

struct Influence {
  int joint;
  double weight;
};
using Influences = std::vector<Influence>;

Influences torso_weights(const dvec3& p, bool sleeve) {
  const double lower = smooth(0.99, 1.13, p.y);
  const double upper = smooth(1.12, 1.28, p.y);
  const int side = p.x >= 0.0 ? 0 : 1;
  const double x = std::abs(p.x);
  double arm = smooth(0.110, 0.225, x) * (sleeve ? 1.0 : smooth(1.20, 1.34, p.y));
  const double t = glm::dot(dvec3(x, p.y, p.z) - kShoulder, kArmAxis);
  if (sleeve) arm = std::max(arm, smooth(-0.02, 0.09, t));
  const double collar = smooth(0.03, 0.13, x) * smooth(1.30, 1.43, p.y) * 0.8;
  const double neck = 0.35 * smooth(1.47, 1.51, p.y);
  Influences out{{upper_arm(side), arm}};
  const double body = 1.0 - arm;
  out.push_back({clavicle(side), body * collar});
  out.push_back({head, body * (1.0 - collar) * neck});
  const double rest = body * (1.0 - collar) * (1.0 - neck);
  out.push_back({hips, rest * (1.0 - lower)});
  out.push_back({spine, rest * lower * (1.0 - upper)});
  out.push_back({chest, rest * lower * upper});
  return out;
}

Influences leg_weights(const dvec3& p) {
  const double left = smooth(-0.035, 0.035, p.x);
  // The crease of the hip runs from the crotch up to the outer side.
  const double crease = 0.895 + 0.25 * (std::abs(p.x) - 0.09);
  double leg = smooth(crease + 0.075, crease - 0.075, p.y);
  leg *= 1.0 - 0.45 * (1.0 - std::abs(2.0 * left - 1.0));
  const double lower = smooth(kKneeY + 0.065, kKneeY - 0.065, p.y);
  const double up = smooth(0.99, 1.13, p.y);
  return {{hips, (1.0 - leg) * (1.0 - up)},       {spine, (1.0 - leg) * up},
          {thigh(0), leg * left * (1.0 - lower)}, {thigh(1), leg * (1.0 - left) * (1.0 - lower)},
          {shin(0), leg * left * lower},          {shin(1), leg * (1.0 - left) * lower}};
}

Influences shoe_weights(const dvec3& p) {
  const int side = p.x >= 0.0 ? 0 : 1;
  const double bend = smooth(kBallZ - 0.030, kBallZ + 0.030, p.z);
  const double above = 0.6 * smooth(0.075, 0.125, p.y);
  return {{toes(side), bend * (1.0 - above)}, {foot(side), (1.0 - bend) * (1.0 - above)}, {shin(side), above}};
}

Influences head_weights(const dvec3& p, bool full) {
  const double turn = smooth(1.455, 1.545, p.y);
  if (!full) return {{chest, 1.0 - turn}, {head, turn}};
  const double low = smooth(1.445, 1.490, p.y);
  const double high = smooth(1.490, 1.560, p.y);
  return {{chest, 1.0 - low}, {kNeck, low * (1.0 - high)}, {head, low * high}};
}

Influences arm_weights(const dvec3& p, bool full) {
  const int side = p.x >= 0.0 ? 0 : 1;
  const double t = glm::dot(dvec3(std::abs(p.x), p.y, p.z) - kShoulder, kArmAxis);
  const double bend = smooth(kUpperArm - 0.045, kUpperArm + 0.045, t);
  const double wrist = smooth(kWrist - 0.030, kWrist + 0.022, t);
  Influences out{{upper_arm(side), 1.0 - bend}, {hand(side), bend * wrist}};
  const double rest = bend * (1.0 - wrist);
  const double twist = full ? smooth(kUpperArm + 0.05, kWrist, t) : 0.0;
  out.push_back({forearm(side), rest * (1.0 - twist)});
  if (full) out.push_back({forearm_twist(side), rest * twist});
  return out;
}

// Along one finger, or over the mitten by the nearest finger.
Influences finger_weights(const dvec3& p, int digit) {
  const int side = p.x >= 0.0 ? 0 : 1;
  if (digit < 0) {
    double nearest = 1e9;
    for (int d = 1; d < 5; ++d) {
      const double distance = std::abs(finger_chain(side, d)[1].z - p.z);
      if (distance < nearest) std::tie(nearest, digit) = std::tuple{distance, d};
    }
  }
  const auto chain = finger_chain(side, digit);
  const auto past = [&](int bone) {
    const auto b = static_cast<size_t>(bone);
    const dvec3 along_bone = glm::normalize(chain[b + 1] - chain[b]);
    return smooth(-0.007, 0.007, glm::dot(p - chain[b], along_bone));
  };
  const double a = past(0);
  const double b = a * past(1);
  const double c = b * past(2);
  return {{hand(side), 1.0 - a},
          {finger(side, digit, 0), a - b},
          {finger(side, digit, 1), b - c},
          {finger(side, digit, 2), c}};
}

// ---------------------------------------------------------------------------------------------------------------
// Assembly.

struct Corner {
  int point;
  dvec2 uv;
};
using Triangle = std::array<Corner, 3>;

struct Point {
  dvec3 position;
  Influences influences;
};

// One closed row of a swept surface and where it lies in its chart.
struct Ring {
  std::vector<int> points;
  double v = 0;
};

class Builder {
 public:
  Builder(int joints) : full_(joints == kFullJoints) {}
  bool full() const { return full_; }

  int add(const dvec3& position, Influences influences) {
    points_.push_back({position, std::move(influences)});
    return static_cast<int>(points_.size()) - 1;
  }
  const dvec3& at(int point) const { return points_[static_cast<size_t>(point)].position; }

  void triangle(const Corner& a, const Corner& b, const Corner& c) {
    if (a.point != b.point && b.point != c.point && c.point != a.point) piece_.push_back({a, b, c});
  }
  // Split along the shorter diagonal, which follows the surface better.
  void quad(const Corner& a, const Corner& b, const Corner& c, const Corner& d) {
    if (glm::distance(at(a.point), at(c.point)) <= glm::distance(at(b.point), at(d.point)) + 1e-9) {
      triangle(a, b, c);
      triangle(a, c, d);
    } else {
      triangle(a, b, d);
      triangle(b, c, d);
    }
  }
  // Between two rings of equal size.
  void band(const Ring& low, const Ring& high, int chart_id) {
    const size_t n = low.points.size();
    assert(high.points.size() == n);
    for (size_t i = 0; i < n; ++i) {
      const size_t next = (i + 1) % n;
      const double u0 = static_cast<double>(i) / static_cast<double>(n);
      const double u1 = static_cast<double>(i + 1) / static_cast<double>(n);
      quad({low.points[i], chart_uv(chart_id, u0, 1 - low.v)}, {low.points[next], chart_uv(chart_id, u1, 1 - low.v)},
           {high.points[next], chart_uv(chart_id, u1, 1 - high.v)},
           {high.points[i], chart_uv(chart_id, u0, 1 - high.v)});
    }
  }
  // Closes a ring without a middle point: a strip across it. `uv` places each of its points.
  void cap(const Ring& ring, const std::function<dvec2(size_t)>& uv) {
    const size_t n = ring.points.size();
    size_t low = 0;
    size_t high = n - 1;
    while (high - low >= 2) {
      const Corner a{ring.points[low], uv(low)};
      const Corner b{ring.points[low + 1], uv(low + 1)};
      const Corner c{ring.points[high], uv(high)};
      triangle(a, b, c);
      ++low;
      if (high - low >= 2) {
        triangle(b, {ring.points[high - 1], uv(high - 1)}, c);
        --high;
      }
    }
  }
  void cap(const Ring& ring, int chart_id) {
    cap(ring, [&](size_t i) {
      return chart_uv(chart_id, static_cast<double>(i) / static_cast<double>(ring.points.size()), 1 - ring.v);
    });
  }
  // A ring shut to one point.
  void tip(const Ring& ring, int point, double v, int chart_id) {
    const size_t n = ring.points.size();
    for (size_t i = 0; i < n; ++i) {
      const double u0 = static_cast<double>(i) / static_cast<double>(n);
      const double u1 = static_cast<double>(i + 1) / static_cast<double>(n);
      triangle({ring.points[i], chart_uv(chart_id, u0, 1 - ring.v)},
               {ring.points[(i + 1) % n], chart_uv(chart_id, u1, 1 - ring.v)},
               {point, chart_uv(chart_id, 0.5 * (u0 + u1), 1 - v)});
    }
  }

  // Ends one closed piece: turns every triangle so that its front is outside and files it under its part.
  void finish(Part part);

  Mesh mesh() const;

 private:
  bool full_;
  std::vector<Point> points_;
  std::vector<Triangle> piece_;
  std::array<std::vector<Triangle>, kPartCount> parts_;
};

void Builder::finish(Part part) {
  // Neighbours agree when they run along their common edge in opposite directions: from the first triangle outwards,
  // each one is turned to agree with the neighbour that it was reached from.
  std::map<std::pair<int, int>, std::vector<size_t>> by_edge;
  for (size_t t = 0; t < piece_.size(); ++t) {
    for (size_t i = 0; i < 3; ++i) {
      by_edge[std::minmax(piece_[t][i].point, piece_[t][(i + 1) % 3].point)].push_back(t);
    }
  }
  const auto runs = [&](size_t t, int from, int to) {
    for (size_t i = 0; i < 3; ++i) {
      if (piece_[t][i].point == from && piece_[t][(i + 1) % 3].point == to) return true;
    }
    return false;
  };
  std::vector<bool> seen(piece_.size(), false);
  std::vector<size_t> queue{0};
  seen[0] = true;
  while (!queue.empty()) {
    const size_t t = queue.back();
    queue.pop_back();
    const Triangle here = piece_[t];
    for (size_t i = 0; i < 3; ++i) {
      const int a = here[i].point;
      const int b = here[(i + 1) % 3].point;
      for (const size_t other : by_edge[std::minmax(a, b)]) {
        if (seen[other]) continue;
        seen[other] = true;
        if (runs(other, a, b)) std::swap(piece_[other][1], piece_[other][2]);
        queue.push_back(other);
      }
    }
  }
  double volume = 0;
  for (const Triangle& t : piece_) {
    volume += glm::dot(at(t[0].point), glm::cross(at(t[1].point), at(t[2].point)));
  }
  for (Triangle& t : piece_) {
    if (volume < 0.0) std::swap(t[1], t[2]);
    parts_[part].push_back(t);
  }
  piece_.clear();
}

Mesh Builder::mesh() const {
  std::vector<dvec3> normals(points_.size(), dvec3(0.0));
  for (const auto& part : parts_) {
    for (const Triangle& t : part) {
      const dvec3 area = glm::cross(at(t[1].point) - at(t[0].point), at(t[2].point) - at(t[0].point));
      for (const Corner& c : t) normals[static_cast<size_t>(c.point)] += area;
    }
  }
  Mesh mesh;
  for (int part = 0; part < kPartCount; ++part) {
    Primitive primitive;
    primitive.first_index = static_cast<uint32_t>(mesh.indices.size());
    primitive.first_vertex = static_cast<uint32_t>(mesh.positions.size());
    primitive.material = part;
    std::map<std::tuple<int, double, double>, uint32_t> made;
    for (const Triangle& t : parts_[static_cast<size_t>(part)]) {
      for (const Corner& c : t) {
        const auto [it, fresh] =
            made.try_emplace({c.point, c.uv.x, c.uv.y}, static_cast<uint32_t>(mesh.positions.size()));
        mesh.indices.push_back(it->second);
        if (!fresh) continue;
        const Point& point = points_[static_cast<size_t>(c.point)];
        mesh.positions.emplace_back(point.position);
        mesh.normals.emplace_back(glm::normalize(normals[static_cast<size_t>(c.point)]));
        mesh.uvs.emplace_back(c.uv);
        Influences kept = point.influences;
        std::ranges::stable_sort(kept, [](const Influence& a, const Influence& b) { return a.weight > b.weight; });
        kept.resize(std::max(kept.size(), size_t{kInfluences}), {0, 0.0});
        double sum = 0;
        for (int i = 0; i < kInfluences; ++i) sum += kept[static_cast<size_t>(i)].weight;
        glm::u16vec4 joints{0};
        glm::vec4 weights{0.0F};
        for (int i = 0; i < kInfluences; ++i) {
          const Influence& k = kept[static_cast<size_t>(i)];
          if (k.weight / sum < 1e-4) continue;
          joints[i] = static_cast<uint16_t>(k.joint);
          weights[i] = static_cast<float>(k.weight / sum);
        }
        mesh.joints.push_back(joints);
        mesh.weights.push_back(weights / (weights.x + weights.y + weights.z + weights.w));
      }
    }
    primitive.index_count = static_cast<uint32_t>(mesh.indices.size()) - primitive.first_index;
    primitive.vertex_count = static_cast<uint32_t>(mesh.positions.size()) - primitive.first_vertex;
    mesh.primitives.push_back(primitive);
  }
  return mesh;
}

dvec3 mirrored(const dvec3& p, int side) { return side == 0 ? p : dvec3(-p.x, p.y, p.z); }

// ---------------------------------------------------------------------------------------------------------------
// Levels of detail: how many columns, and which rows.

struct Detail {
  int head_columns;
  std::vector<double> head_rows;  // y
  int hair_columns, hair_rows;
  bool ears;
  bool folds;                      // hems and collar turn inwards before they are closed
  int torso_columns;               // a multiple of 4
  int hole_half;                   // half the armhole's width in columns
  std::vector<double> torso_low;   // y below the armhole; the last is its bottom
  std::vector<double> torso_hole;  // y inside the armhole
  std::vector<double> torso_high;  // y from the armhole's top upwards
  std::vector<double> sleeve;      // t
  int arm_columns;
  std::vector<double> arm_rows;  // t
  bool fingers;
  int thumb_columns;
  std::vector<double> pelvis_rows;  // y, upwards from the crotch's ring
  int crotch_points;                // between front and back
  std::vector<double> leg_rows;     // y, downwards
  int shoe_columns;                 // even
  std::vector<double> shoe_rows;    // into kShoe
};

Detail detail(int triangles) {
  if (triangles == 5000) {
    return {24,
            {1.435, 1.475, 1.505, 1.524, 1.536, 1.548, 1.562, 1.577, 1.590, 1.604, 1.613, 1.628, 1.644, 1.660, 1.682,
             1.712},
            24,
            7,
            true,
            true,
            24,
            2,
            {0.960, 1.008, 1.036, 1.085, 1.135, 1.190, 1.250, 1.308},
            {1.352, 1.398},
            {1.442, 1.455, 1.467, 1.477, 1.486, 1.501},
            {.026, .052, .082, .115, .155, .195, .230},
            10,
            {.150, .235, .265, .300, .335, .375, .430, .490, .530, .560, .587, .617, .636, .646},
            true,
            6,
            {0.858, 0.890, 0.930, 0.968, 1.000, 1.017},
            3,
            {0.785, 0.715, 0.635, 0.570, 0.525, 0.485, 0.445, 0.390, 0.315, 0.215, 0.115, 0.046, 0.028},
            16,
            {0, 1, 2, 3, 4, 5, 6, 8}};
  }
  if (triangles == 2200) {
    return {16,
            {1.440, 1.485, 1.522, 1.540, 1.560, 1.584, 1.602, 1.613, 1.640, 1.668, 1.705},
            14,
            4,
            false,
            true,
            16,
            1,
            {0.965, 1.036, 1.120, 1.220, 1.308},
            {1.370},
            {1.442, 1.464, 1.482, 1.500},
            {.060, .115, .190, .230},
            8,
            {.160, .245, .290, .335, .410, .510, .548, .590, .632, .680, .722},
            false,
            5,
            {0.858, 0.900, 0.955, 1.016},
            2,
            {0.770, 0.670, 0.565, 0.500, 0.440, 0.360, 0.220, 0.100, 0.030},
            10,
            {0, 1.5, 3, 4, 5.5, 8}};
  }
  return {8,
          {1.460, 1.525, 1.552, 1.611, 1.680},
          6,
          2,
          false,
          false,
          8,
          1,
          {0.990, 1.130, 1.308},
          {},
          {1.440, 1.488},
          {.080, .225},
          5,
          {.190, .285, .520, .610, .715},
          false,
          0,
          {0.858, 1.012},
          1,
          {0.740, 0.500, 0.330, 0.040},
          6,
          {0, 3, 8}};
}

// ---------------------------------------------------------------------------------------------------------------
// Pieces.

void build_head(Builder& b, const Detail& d) {
  const auto weights = [&](const dvec3& p) { return head_weights(p, b.full()); };
  std::vector<Ring> rings;
  for (const double y : d.head_rows) {
    Ring ring;
    ring.v = (y - kHeadLow) / (kHeadHigh - kHeadLow);
    for (int i = 0; i < d.head_columns; ++i) {
      const dvec3 p = head_shape(static_cast<double>(i) / d.head_columns, y);
      ring.points.push_back(b.add(p, weights(p)));
    }
    rings.push_back(std::move(ring));
  }
  b.cap(rings.front(), chart_head);
  for (size_t r = 0; r + 1 < rings.size(); ++r) b.band(rings[r], rings[r + 1], chart_head);
  const dvec3 crown{0.0, kHeadHigh + 0.002, -0.010};
  b.tip(rings.back(), b.add(crown, weights(crown)), 1.0, chart_head);
  b.finish(skin);

  if (!d.ears) return;
  for (int side = 0; side < 2; ++side) {
    // An ear: a thick leaf leaning back and out, its root inside the head.
    struct Row {
      double out, scale;
    };
    constexpr Row kRows[] = {{-.006, .70}, {.004, .95}, {.0105, 1.08}, {.0125, .66}};
    std::vector<Ring> ear;
    for (const Row& row : kRows) {
      Ring ring;
      ring.v = (row.out + .006) / .0185;
      for (int i = 0; i < 8; ++i) {
        const SinCos turn = sincos_turns(i / 8.0);
        dvec3 p{0.0728 + row.out, 1.628 + 0.0285 * row.scale * turn.cos,
                -0.008 - row.out * 0.80 + 0.0160 * row.scale * turn.sin * (1.0 + 0.25 * turn.cos)};
        p.z -= 0.004 * turn.cos;
        p = mirrored(p, side);
        ring.points.push_back(b.add(p, weights(p)));
      }
      ear.push_back(std::move(ring));
    }
    b.cap(ear.front(), chart_ear);
    for (size_t r = 0; r + 1 < ear.size(); ++r) b.band(ear[r], ear[r + 1], chart_ear);
    b.cap(ear.back(), chart_ear);
    b.finish(skin);
  }
}

void build_hair(Builder& b, const Detail& d) {
  const auto weights = [&](const dvec3& p) { return head_weights(p, b.full()); };
  std::vector<Ring> rings;
  // Row -1 lies under the scalp and closes the piece; row 0 is the edge.
  for (int row = -1; row < d.hair_rows; ++row) {
    Ring ring;
    const double v = static_cast<double>(row) / d.hair_rows;
    ring.v = std::max(v, 0.0);
    for (int i = 0; i < d.hair_columns; ++i) {
      const double u = static_cast<double>(i) / d.hair_columns;
      dvec3 p = hair_point(u, std::max(v, 0.0));
      if (row < 0) {
        const dvec3 inside{0.0, 1.66, 0.0};
        p = inside + (p - inside) * 0.86;
      }
      ring.points.push_back(b.add(p, weights(p)));
    }
    rings.push_back(std::move(ring));
  }
  b.cap(rings.front(), chart_hair);
  for (size_t r = 0; r + 1 < rings.size(); ++r) b.band(rings[r], rings[r + 1], chart_hair);
  const dvec3 crown = hair_point(0.0, 1.0);
  b.tip(rings.back(), b.add(crown, weights(crown)), 1.0, chart_hair);
  b.finish(hair);
}

void build_shirt(Builder& b, const Detail& d) {
  const int n = d.torso_columns;
  std::vector<double> rows = d.torso_low;
  const size_t bottom = rows.size() - 1;
  rows.insert(rows.end(), d.torso_hole.begin(), d.torso_hole.end());
  const size_t top = rows.size();
  rows.insert(rows.end(), d.torso_high.begin(), d.torso_high.end());
  const auto in_hole = [&](int column, size_t row) {  // the quad right of the column and above the row
    if (row < bottom || row >= top) return -1;
    if (column >= n / 4 - d.hole_half && column < n / 4 + d.hole_half) return 0;
    if (column >= 3 * n / 4 - d.hole_half && column < 3 * n / 4 + d.hole_half) return 1;
    return -1;
  };
  const auto strictly_inside = [&](int column, size_t row) {
    if (row <= bottom || row >= top) return false;
    return std::abs(column - n / 4) < d.hole_half || std::abs(column - 3 * n / 4) < d.hole_half;
  };
  std::vector<Ring> rings;
  for (size_t r = 0; r < rows.size(); ++r) {
    Ring ring;
    ring.v = (rows[r] - kTorsoLow) / (kTorsoHigh - kTorsoLow);
    for (int i = 0; i < n; ++i) {
      const dvec3 p = torso_shape(static_cast<double>(i) / n, rows[r]);
      ring.points.push_back(strictly_inside(i, r) ? -1 : b.add(p, torso_weights(p, false)));
    }
    rings.push_back(std::move(ring));
  }
  b.cap(rings.front(), chart_torso);
  for (size_t r = 0; r + 1 < rings.size(); ++r) {
    for (int i = 0; i < n; ++i) {
      if (in_hole(i, r) >= 0) continue;
      const auto c = static_cast<size_t>(i);
      const size_t next = (c + 1) % static_cast<size_t>(n);
      const double u0 = static_cast<double>(i) / n;
      const double u1 = static_cast<double>(i + 1) / n;
      b.quad({rings[r].points[c], chart_uv(chart_torso, u0, 1 - rings[r].v)},
             {rings[r].points[next], chart_uv(chart_torso, u1, 1 - rings[r].v)},
             {rings[r + 1].points[next], chart_uv(chart_torso, u1, 1 - rings[r + 1].v)},
             {rings[r + 1].points[c], chart_uv(chart_torso, u0, 1 - rings[r + 1].v)});
    }
  }
  // The collar turns inwards and ends below, around the neck.
  if (d.folds) {
    Ring inner;
    inner.v = 1.0;
    for (const int point : rings.back().points) {
      const dvec3 p = b.at(point);
      const dvec3 q{p.x * 0.80, p.y - 0.022, -0.012 + (p.z + 0.012) * 0.80};
      inner.points.push_back(b.add(q, torso_weights(p, false)));
    }
    b.band(rings.back(), inner, chart_torso);
    b.cap(inner, chart_torso);
  } else {
    b.cap(rings.back(), chart_torso);
  }

  for (int side = 0; side < 2; ++side) {
    // The armhole's edge, once around from the middle of its top over the front.
    std::vector<int> edge;
    const int middle = side == 0 ? n / 4 : 3 * n / 4;
    const int step = side == 0 ? 1 : -1;  // towards the front
    const auto point = [&](int column, size_t row) { return rings[row].points[static_cast<size_t>(column)]; };
    for (int k = 0; k < d.hole_half; ++k) edge.push_back(point(middle + step * k, top));
    for (size_t r = top; r > bottom; --r) edge.push_back(point(middle + step * d.hole_half, r));
    for (int k = d.hole_half; k > -d.hole_half; --k) edge.push_back(point(middle + step * k, bottom));
    for (size_t r = bottom; r < top; ++r) edge.push_back(point(middle - step * d.hole_half, r));
    for (int k = d.hole_half; k > 0; --k) edge.push_back(point(middle - step * k, top));
    Ring previous{edge, 1.0};
    const auto columns = static_cast<int>(edge.size());
    const auto sleeve_ring = [&](double t, double shrink, double v) {
      const auto p = along<2>(kSleeve, t);
      Ring ring;
      ring.v = v;
      for (int i = 0; i < columns; ++i) {
        const SinCos turn = sincos_turns(static_cast<double>(i) / columns);
        // Near the shoulder the rings lean with the armhole, whose lower end lies further along the arm.
        const double lean = 0.60 * smooth(0.17, 0.05, t) * p[1];
        const dvec3 q = mirrored(arm_point(t - lean * turn.cos) + kArmUp * (p[1] * shrink * turn.cos) +
                                     kForward * (p[0] * shrink * turn.sin),
                                 side);
        ring.points.push_back(b.add(q, torso_weights(q, true)));
      }
      return ring;
    };
    for (const double t : d.sleeve) {
      Ring ring = sleeve_ring(t, 1.0, 1.0 - t / d.sleeve.back());
      b.band(previous, ring, chart_sleeve);
      previous = std::move(ring);
    }
    if (d.folds) {
      Ring hem = sleeve_ring(d.sleeve.back() - 0.015, 0.62, 0.0);
      b.band(previous, hem, chart_sleeve);
      previous = std::move(hem);
    }
    b.cap(previous, chart_sleeve);
  }
  b.finish(shirt);
}

void build_arm(Builder& b, const Detail& d, int side) {
  const auto ring_at = [&](double t) {
    const auto p = along<4>(kArm, t);
    Ring ring;
    ring.v = 1.0 - (t - 0.14) / (0.722 - 0.14);
    for (int i = 0; i < d.arm_columns; ++i) {
      // From the back edge over the palm's side to the thumb's edge and over the back of the hand.
      const SinCos turn = sincos_turns((i + 0.5) / d.arm_columns);
      const dvec2 round = rounded(turn.sin, -turn.cos, t > kWrist ? 0.20 : 0.0);
      const dvec3 q =
          mirrored(arm_point(t) + kForward * (p[2] + p[0] * round.y) + kPalm * (p[3] + p[1] * round.x), side);
      const bool mitten = t > kKnuckles && b.full();
      ring.points.push_back(b.add(q, mitten ? finger_weights(q, -1) : arm_weights(q, b.full())));
    }
    return ring;
  };
  Ring previous = ring_at(d.arm_rows.front());
  b.cap(previous, chart_arm);
  for (size_t r = 1; r < d.arm_rows.size(); ++r) {
    Ring ring = ring_at(d.arm_rows[r]);
    b.band(previous, ring, chart_arm);
    previous = std::move(ring);
  }
  b.cap(previous, chart_arm);
  b.finish(skin);

  for (int digit = 0; digit < 5; ++digit) {
    const int columns = digit == 0 ? d.thumb_columns : 5;
    if ((digit > 0 && !d.fingers) || columns == 0) continue;
    const auto chain = finger_chain(side, digit);
    const double thick = digit == 0 ? 0.0112 : digit == 4 ? 0.0078 : 0.0090;
    const dvec3 across = glm::normalize(digit == 0 ? mirrored(dvec3(0.45, 0.45, -0.77), side) : kForward);
    const auto weights = [&](const dvec3& p) {
      return b.full() ? finger_weights(p, digit) : Influences{{hand(side), 1.0}};
    };
    struct Row {
      int bone;
      double part, radius;
    };
    constexpr Row kRows[] = {{0, -0.30, 1.05}, {1, 0.0, 1.0}, {2, 0.0, 0.92}, {2, 0.78, 0.72}};
    std::vector<Ring> rings;
    for (const Row& row : kRows) {
      const auto bone = static_cast<size_t>(row.bone);
      const dvec3 direction = glm::normalize(chain[bone + 1] - chain[bone]);
      const dvec3 other = glm::normalize(glm::cross(direction, across));
      const dvec3 sideways = glm::cross(other, direction);
      Ring ring;
      ring.v = std::max(0.0, (row.bone + row.part) / 3.0);
      const dvec3 centre = chain[bone] + (chain[bone + 1] - chain[bone]) * row.part;
      for (int i = 0; i < columns; ++i) {
        const SinCos turn = sincos_turns(static_cast<double>(i) / columns);
        const dvec3 q = centre + (sideways * turn.cos + other * turn.sin) * (thick * row.radius);
        ring.points.push_back(b.add(q, weights(q)));
      }
      rings.push_back(std::move(ring));
    }
    b.cap(rings.front(), chart_finger);
    for (size_t r = 0; r + 1 < rings.size(); ++r) b.band(rings[r], rings[r + 1], chart_finger);
    b.tip(rings.back(), b.add(chain[3], weights(chain[3])), 1.0, chart_finger);
    b.finish(skin);
  }
}

void build_trousers(Builder& b, const Detail& d) {
  const int n = d.torso_columns;
  const auto pelvis_ring = [&](double y, double shrink, double v) {
    Ring ring;
    ring.v = v;
    for (int i = 0; i < n; ++i) {
      dvec3 p = pelvis_shape(static_cast<double>(i) / n, y);
      p.x *= shrink;
      p.z *= shrink;
      ring.points.push_back(b.add(p, leg_weights(p)));
    }
    return ring;
  };
  const double low = d.pelvis_rows.front();
  const double high = d.pelvis_rows.back();
  const auto v_of = [&](double y) { return (y - low) / (high - low); };
  std::vector<Ring> pelvis;
  for (const double y : d.pelvis_rows) pelvis.push_back(pelvis_ring(y, 1.0, v_of(y)));
  for (size_t r = 0; r + 1 < pelvis.size(); ++r) b.band(pelvis[r], pelvis[r + 1], chart_pelvis);
  Ring waist = pelvis.back();
  if (d.folds) {
    waist = pelvis_ring(high - 0.012, 0.84, 1.0);
    b.band(pelvis.back(), waist, chart_pelvis);
  }
  b.cap(waist, chart_pelvis);

  // The crotch's line, from the front to the back, shared by both legs.
  const Ring& split = pelvis.front();
  const dvec3 front = b.at(split.points[static_cast<size_t>(n / 2)]);
  const dvec3 back = b.at(split.points[0]);
  std::vector<int> line;
  for (int i = 1; i <= d.crotch_points; ++i) {
    const double t = static_cast<double>(i) / (d.crotch_points + 1);
    const double z = front.z + (back.z - front.z) * t;
    const dvec3 p{0.0, low - 0.052 * (1.0 - square(square(2.0 * t - 1.0))), z};
    line.push_back(b.add(p, leg_weights(p)));
  }
  for (int side = 0; side < 2; ++side) {
    // Once around the leg, from the back middle over the outside to the front middle, and back along the crotch.
    Ring previous;
    previous.v = 1.0;
    const int half = n / 2;
    for (int i = 0; i <= half; ++i) {
      previous.points.push_back(split.points[static_cast<size_t>(side == 0 ? i : (n - i) % n)]);
    }
    previous.points.insert(previous.points.end(), line.begin(), line.end());
    const auto columns = static_cast<int>(previous.points.size());
    const double outer = static_cast<double>(half) / columns;  // of the way around
    const auto leg_ring = [&](double y, double shrink, double v) {
      const auto p = along<4>(kLeg, y);
      Ring ring;
      ring.v = v;
      for (int i = 0; i < columns; ++i) {
        // The outer arc is centred on the outward direction: a quarter turn from the back.
        const SinCos turn = sincos_turns(0.25 - 0.5 * outer + static_cast<double>(i) / columns);
        const double z = 0.5 * (p[0] + p[1]);
        const dvec2 round = rounded(turn.sin, -turn.cos, 0.08);
        const dvec3 q = mirrored({p[2] + p[3] * shrink * round.x, y, z + 0.5 * (p[0] - p[1]) * shrink * round.y}, side);
        Influences w = leg_weights(q);
        ring.points.push_back(b.add(q, std::move(w)));
      }
      return ring;
    };
    const double hem = d.leg_rows.back();
    for (const double y : d.leg_rows) {
      Ring ring = leg_ring(y, 1.0, (y - hem) / (low - hem));
      b.band(previous, ring, chart_leg);
      previous = std::move(ring);
    }
    if (d.folds) {
      Ring fold = leg_ring(hem + 0.012, 0.70, 0.0);
      b.band(previous, fold, chart_leg);
      previous = std::move(fold);
    }
    b.cap(previous, chart_leg);
  }
  b.finish(trousers);
}

void build_shoe(Builder& b, const Detail& d, int side) {
  std::vector<Ring> rings;
  for (const double row : d.shoe_rows) {
    Ring ring;
    ring.v = row / 8.0;
    for (int i = 0; i < d.shoe_columns; ++i) {
      const dvec3 p = mirrored(shoe_shape(static_cast<double>(i) / d.shoe_columns, row), side);
      ring.points.push_back(b.add(p, shoe_weights(p)));
    }
    rings.push_back(std::move(ring));
  }
  b.cap(rings.front(), [&](size_t i) {
    const dvec3 p = mirrored(b.at(rings.front().points[i]), side);
    return chart_uv(chart_sole, (p.x - 0.04) / 0.13, (0.20 - p.z) / 0.30);
  });
  for (size_t r = 0; r + 1 < rings.size(); ++r) b.band(rings[r], rings[r + 1], chart_shoe);
  b.cap(rings.back(), chart_shoe);
  b.finish(shoes);
}

constexpr Chart kChartTable[kCharts] = {
    {0, 0, 512, 512},      // head
    {512, 0, 256, 256},    // hair
    {0, 512, 512, 512},    // torso
    {512, 256, 256, 192},  // sleeve
    {768, 0, 256, 256},    // arm
    {768, 256, 96, 96},    // finger
    {864, 256, 96, 96},    // ear
    {512, 512, 512, 192},  // pelvis
    {512, 704, 320, 320},  // leg
    {832, 704, 192, 192},  // shoe
    {832, 896, 96, 128},   // sole
};

}  // namespace

const Chart& chart(int id) { return kChartTable[id]; }

dvec2 chart_uv(int id, double u, double v) {
  const Chart& c = kChartTable[id];
  return {(c.x + kGutter + u * (c.width - 2 * kGutter)) / kTextureSide,
          (c.y + kGutter + v * (c.height - 2 * kGutter)) / kTextureSide};
}

dvec3 head_point(double u, double v) { return head_shape(u, kHeadLow + v * (kHeadHigh - kHeadLow)); }

dvec3 torso_point(double u, double v) { return torso_shape(u, kTorsoLow + v * (kTorsoHigh - kTorsoLow)); }

dvec3 hair_point(double u, double v) {
  const dvec3 crown{0.0, kHeight, -0.012};
  if (v >= 1.0) return crown;
  const double edge = hairline(u);
  // Equal steps over the skull's arc, not its height, so that the rows near the crown stay apart.
  const double y = edge + (kHeadHigh - edge) * (v * (2.0 - v)) * 0.985;
  const dvec3 scalp = head_shape(u, y);
  const dvec3 middle{0.0, 1.655, -0.008};
  const dvec3 outward = glm::normalize(scalp - middle);
  const SinCos turn = head_turn(u);
  // Thin at the edge, above all in front; fuller on top and behind.
  const double back = 0.5 + 0.5 * turn.cos;
  const double body = 0.0085 + 0.0060 * back + 0.0035 * smooth(0.35, 0.95, v);
  const double thick = 0.0030 + (body - 0.0030) * smooth(0.0, 0.75 - 0.40 * back, v);
  dvec3 p = scalp + outward * thick;
  p.y = std::min(p.y, kHeight - 0.001);
  return p;
}

std::array<dvec3, 4> finger_chain(int side, int digit) {
  std::array<dvec3, 4> chain{};
  std::array<dvec3, 3> directions{};
  std::array<double, 3> lengths{};
  if (digit == 0) {
    chain[0] = arm_point(kWrist + 0.030) + kForward * 0.028 + kPalm * 0.010;
    directions = {glm::normalize(kArmAxis * 0.72 + kForward * 0.58 + kPalm * 0.38),
                  glm::normalize(kArmAxis * 0.84 + kForward * 0.30 + kPalm * 0.45),
                  glm::normalize(kArmAxis * 0.90 + kForward * 0.12 + kPalm * 0.42)};
    lengths = {0.038, 0.030, 0.026};
  } else {
    constexpr double kSpread[] = {0.0, 0.0305, 0.0105, -0.0100, -0.0290};
    constexpr double kStart[] = {0.0, 0.094, 0.097, 0.094, 0.086};
    constexpr double kLength[] = {0.0, 0.074, 0.082, 0.076, 0.060};
    chain[0] = arm_point(kWrist + kStart[digit]) + kForward * kSpread[digit] + kPalm * 0.006;
    const double fan = kSpread[digit] * 1.2;
    directions = {glm::normalize(kArmAxis * 0.95 + kPalm * 0.31 + kForward * fan),
                  glm::normalize(kArmAxis * 0.80 + kPalm * 0.60 + kForward * fan * 0.5),
                  glm::normalize(kArmAxis * 0.64 + kPalm * 0.77)};
    lengths = {0.46 * kLength[digit], 0.31 * kLength[digit], 0.23 * kLength[digit]};
  }
  for (size_t i = 0; i < 3; ++i) chain[i + 1] = chain[i] + directions[i] * lengths[i];
  for (dvec3& p : chain) p = mirrored(p, side);
  return chain;
}

std::vector<JointPlace> joint_places(int joints) {
  std::vector<JointPlace> out(static_cast<size_t>(joints));
  const bool full = joints == kFullJoints;
  const auto put = [&](int id, const std::string& name, int parent, const dvec3& position) {
    out[static_cast<size_t>(id)] = {name, parent, position};
  };
  put(hips, "hips", -1, {0.0, 0.955, -0.005});
  put(spine, "spine", hips, {0.0, 1.070, -0.010});
  put(chest, "chest", spine, {0.0, 1.210, -0.016});
  put(head, "head", full ? kNeck : chest, {0.0, full ? 1.540 : 1.480, full ? -0.012 : -0.018});
  if (full) put(kNeck, "neck", chest, {0.0, 1.465, -0.020});
  for (int side = 0; side < 2; ++side) {
    const std::string end = side == 0 ? "_l" : "_r";
    const auto at = [&](const dvec3& p) { return mirrored(p, side); };
    put(clavicle(side), "clavicle" + end, chest, at({0.022, 1.425, -0.006}));
    put(upper_arm(side), "upper_arm" + end, clavicle(side), at(kShoulder));
    put(forearm(side), "forearm" + end, upper_arm(side), at(arm_point(kUpperArm)));
    put(hand(side), "hand" + end, forearm(side), at(arm_point(kWrist)));
    put(thigh(side), "thigh" + end, hips, at({kHipX, kHipY, -0.006}));
    put(shin(side), "shin" + end, thigh(side), at({kHipX + 0.004, kKneeY, 0.002}));
    put(foot(side), "foot" + end, shin(side), at({kHipX + 0.006, kAnkleY, kAnkleZ}));
    put(toes(side), "toes" + end, foot(side), at({kHipX + 0.012, kBallY, kBallZ}));
    if (!full) continue;
    put(forearm_twist(side), "forearm_twist" + end, forearm(side), at(arm_point(kUpperArm + 0.5 * kForearm)));
    constexpr const char* kDigits[] = {"thumb", "index", "middle", "ring", "little"};
    for (int digit = 0; digit < 5; ++digit) {
      const auto chain = finger_chain(side, digit);
      for (int bone = 0; bone < 3; ++bone) {
        put(finger(side, digit, bone), std::string(kDigits[digit]) + std::to_string(bone + 1) + end,
            bone == 0 ? hand(side) : finger(side, digit, bone - 1), chain[static_cast<size_t>(bone)]);
      }
    }
  }
  return out;
}

Mesh make_mesh(int triangles, int joints) {
  const Detail d = detail(triangles);
  Builder b(joints);
  build_head(b, d);
  build_hair(b, d);
  build_shirt(b, d);
  build_trousers(b, d);
  for (int side = 0; side < 2; ++side) {
    build_arm(b, d, side);
    build_shoe(b, d, side);
  }
  return b.mesh();
}

}  // namespace crowdbench::scene::mannequin
