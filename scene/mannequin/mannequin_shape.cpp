#include "scene/mannequin/mannequin_shape.h"

#include <algorithm>
#include <cmath>

namespace crowdbench::scene::mannequin {
namespace {

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

constexpr Key<1> kNose[] = {{1.592, {0.0}},  {1.600, {.006}}, {1.607, {.019}}, {1.614, {.0215}},
                            {1.628, {.016}}, {1.644, {.008}}, {1.660, {.002}}, {1.672, {0.0}}};

// y: front z, back z, half width, squareness, how far the sides stand above the front.
constexpr Key<5> kTorso[] = {{0.955, {.098, -.106, .150, .10, .000}},  {1.005, {.105, -.106, .155, .10, .000}},
                             {1.035, {.110, -.105, .1555, .10, .000}}, {1.080, {.110, -.100, .152, .10, .000}},
                             {1.130, {.109, -.100, .151, .12, .000}},  {1.190, {.111, -.107, .155, .14, .000}},
                             {1.250, {.116, -.116, .161, .16, .000}},  {1.305, {.116, -.124, .167, .18, .000}},
                             {1.350, {.108, -.126, .170, .18, .002}},  {1.390, {.093, -.122, .169, .16, .006}},
                             {1.420, {.076, -.113, .164, .12, .011}},  {1.446, {.060, -.100, .154, .06, .011}},
                             {1.464, {.051, -.088, .114, .00, .009}},  {1.476, {.050, -.080, .076, .00, .000}},
                             {1.484, {.052, -.078, .065, .00, -.006}}, {1.502, {.057, -.080, .0645, .00, -.006}}};

double bump(double squared_distance) { return squared_distance < 1.0 ? square(1.0 - squared_distance) : 0.0; }

}  // namespace

using glm::dvec2;
using glm::dvec3;

dvec2 rounded(double sine, double cosine, double squareness) {
  const double s2 = sine * sine;
  const double c2 = cosine * cosine;
  const double out = 1.0 + squareness * (1.0 / std::sqrt(std::sqrt(s2 * s2 + c2 * c2)) - 1.0);
  return {sine * out, cosine * out};
}

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

// By the cosine and sine of the angle around (front = 1).
double hairline(double u) {
  const SinCos turn = head_turn(u);
  const double front = -turn.cos;
  if (front > 0.62) return 1.706 - 0.004 * smooth(0.80, 1.00, front);  // a little lower in the middle
  if (front > 0.40) return 1.706 - 0.034 * smooth(0.62, 0.40, front);
  if (front > 0.16) return 1.672 - 0.044 * smooth(0.40, 0.16, front);
  if (front > -0.05) return 1.628 + 0.004 * smooth(0.16, -0.05, front);
  return 1.632 - 0.090 * smooth(-0.05, -0.70, front);
}

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

}  // namespace crowdbench::scene::mannequin
