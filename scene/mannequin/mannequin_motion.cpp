// The built-in character's clips: foot paths on the ground with two-bone legs hung between hip and ankle, so that a
// foot in stance moves backwards exactly at the ground speed; everything else swings on sines of the phase. Based on:
// the joint angles and phase times of normal walking and running as charted in D. A. Winter, "Biomechanics and Motor
// Control of Human Movement", 4th edition (2009), and J. Perry, "Gait Analysis" (1992), read off coarsely. Differs from
// the source: the foot's path and pitch are given and the hip, knee and ankle angles follow from them. Only + - * / and
// sqrt go into the keys, so that they have the same bytes on every machine.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>

#include "core/portable_math.h"
#include "scene/mannequin/mannequin_body.h"

namespace crowdbench::scene::mannequin {
namespace {

using glm::dquat;
using glm::dvec2;
using glm::dvec3;

constexpr dvec3 kX{1.0, 0.0, 0.0};
constexpr dvec3 kY{0.0, 1.0, 0.0};
constexpr dvec3 kZ{0.0, 0.0, 1.0};

dquat turn(const dvec3& axis, double degrees) {
  const SinCos half = sincos_turns(degrees / 720.0);
  return {half.cos, axis.x * half.sin, axis.y * half.sin, axis.z * half.sin};
}

double sine(double turns) { return sincos_turns(turns).sin; }
double cosine(double turns) { return sincos_turns(turns).cos; }

// A value keyed along [0, 1], Catmull-Rom between keys; the outer slopes are given (per unit of the coordinate).
struct Keyed {
  double at, value;
};
double along(const std::vector<Keyed>& keys, double at, double first_slope, double last_slope) {
  if (at <= keys.front().at) return keys.front().value;
  if (at >= keys.back().at) return keys.back().value;
  size_t i = 0;
  while (keys[i + 1].at < at) ++i;
  const auto slope = [&](size_t k) {
    if (k == 0) return first_slope;
    if (k + 1 == keys.size()) return last_slope;
    return (keys[k + 1].value - keys[k - 1].value) / (keys[k + 1].at - keys[k - 1].at);
  };
  const double h = keys[i + 1].at - keys[i].at;
  const double t = (at - keys[i].at) / h;
  const double tt = t * t;
  const double ttt = tt * t;
  return (2 * ttt - 3 * tt + 1) * keys[i].value + (ttt - 2 * tt + t) * h * slope(i) +
         (3 * tt - 2 * ttt) * keys[i + 1].value + (ttt - tt) * h * slope(i + 1);
}

// Where one foot is: its ankle beside the body's middle line (z forwards, y up), its pitch (toes up is positive) and
// the toes' own pitch, degrees.
struct FootState {
  double z = 0;
  double y = kAnkleY;
  double pitch = 0;
  double toes = 0;
};

struct Gait {
  double seconds;
  double speed;                                      // metres a second
  double stance;                                     // share of the cycle
  double first_ankle;                                // z of the flat foot's ankle at heel strike
  std::vector<Keyed> stance_pitch;                   // over the stance, 0..1
  std::vector<Keyed> swing_pitch, swing_y, swing_z;  // over the swing, without its ends, which follow from the stance
};

// The foot on the ground: it turns over the heel while the toes are up and over the ball once the heel has left.
FootState stance_foot(const Gait& gait, double phase) {
  FootState foot;
  const double flat = gait.first_ankle - gait.speed * gait.seconds * phase;
  foot.pitch = along(gait.stance_pitch, phase / gait.stance, 0.0, -160.0);
  const SinCos a = sincos_turns(-foot.pitch / 360.0);  // about +X
  const auto turned = [&](const dvec2& zy) { return dvec2(zy.y * a.sin + zy.x * a.cos, zy.y * a.cos - zy.x * a.sin); };
  if (foot.pitch >= 0.0) {
    const dvec2 heel{kHeelZ - kAnkleZ, -kAnkleY};
    const dvec2 to = turned(heel);
    foot.z = flat + heel.x - to.x;
    foot.y = -to.y;
  } else {
    const dvec2 ball{kBallZ - kAnkleZ, kBallY - kAnkleY};
    const dvec2 to = turned(ball);
    foot.z = flat + ball.x - to.x;
    foot.y = kBallY - 0.0038 * smooth(0.0, 14.0, -foot.pitch) - to.y;  // the bent sole's curve
    foot.toes = 0.0;
  }
  if (foot.pitch > 0.0) foot.toes = foot.pitch;
  return foot;
}

FootState gait_foot(const Gait& gait, double phase) {
  phase -= std::floor(phase);
  if (phase <= gait.stance) return stance_foot(gait, phase);
  constexpr double kStep = 1e-4;
  const double swing = 1.0 - gait.stance;
  const double s = (phase - gait.stance) / swing;
  const FootState off = stance_foot(gait, gait.stance);
  const FootState before = stance_foot(gait, gait.stance - kStep);
  const FootState on = stance_foot(gait, 0.0);
  const FootState after = stance_foot(gait, kStep);
  const auto path = [&](const std::vector<Keyed>& middle, double FootState::*m) {
    std::vector<Keyed> keys{{0.0, off.*m}};
    keys.insert(keys.end(), middle.begin(), middle.end());
    keys.push_back({1.0, on.*m});
    return along(keys, s, (off.*m - before.*m) / kStep * swing, (after.*m - on.*m) / kStep * swing);
  };
  FootState foot;
  foot.z = path(gait.swing_z, &FootState::z);
  foot.y = path(gait.swing_y, &FootState::y);
  foot.pitch = path(gait.swing_pitch, &FootState::pitch);
  // The toes straighten soon after they leave the ground.
  foot.toes = foot.pitch * smooth(0.0, 0.30, s);
  return foot;
}

// ---------------------------------------------------------------------------------------------------------------

// The figure in one pose: local rotations (all bind rotations are the identity) and the hips' place.
struct Figure {
  dvec3 hips_at{0.0};
  std::vector<dquat> local;
};

class Poser {
 public:
  explicit Poser(int joints) : places_(joint_places(joints)) {}

  Figure neutral() const {
    Figure figure;
    figure.hips_at = places_[hips].position;
    figure.local.assign(places_.size(), dquat(1.0, 0.0, 0.0, 0.0));
    return figure;
  }
  bool full() const { return places_.size() == kFullJoints; }
  const std::vector<JointPlace>& places() const { return places_; }

  dquat world(const Figure& figure, int joint) const {
    const int parent = places_[static_cast<size_t>(joint)].parent;
    const dquat& local = figure.local[static_cast<size_t>(joint)];
    return parent < 0 ? local : world(figure, parent) * local;
  }

  // Bends the leg so that its ankle is at `ankle` with the knee towards `forward`; the foot keeps the given turns.
  void place_leg(Figure& figure, int side, const dvec3& ankle, const dvec3& forward, const dquat& foot_turn,
                 const dquat& toes_turn) const {
    const dvec3 hip = figure.hips_at + world(figure, hips) * (bind(thigh(side)) - bind(hips));
    const dvec3 upper = bind(shin(side)) - bind(thigh(side));
    const dvec3 lower = bind(foot(side)) - bind(shin(side));
    const double l1 = glm::length(upper);
    const double l2 = glm::length(lower);
    const dvec3 reach = ankle - hip;
    const double d = std::min(glm::length(reach), (l1 + l2) * 0.9995);  // a knee never locks straight
    const dvec3 down = glm::normalize(reach);
    const double a = (l1 * l1 - l2 * l2 + d * d) / (2.0 * d);
    const double h = std::sqrt(std::max(l1 * l1 - a * a, 0.0));
    const dvec3 out = glm::normalize(forward - down * glm::dot(forward, down));
    const dvec3 knee = down * a + out * h;
    const dvec3 calf = down * d - knee;
    const dquat thigh_world = between(upper, kZ, knee, forward);
    const dquat shin_world = between(lower, kZ, calf, forward);
    set_world(figure, thigh(side), thigh_world);
    set_world(figure, shin(side), shin_world);
    set_world(figure, foot(side), foot_turn);
    set_world(figure, toes(side), toes_turn);
  }

  // Shoulder: forwards swing and angle below the horizontal in degrees; elbow bend towards the front.
  void place_arm(Figure& figure, int side, double swing, double below, double elbow, double wrist) const {
    const double sign = side == 0 ? 1.0 : -1.0;
    const dvec3 axis = arm_axis(side);
    figure.local[static_cast<size_t>(upper_arm(side))] = turn(kX, -swing) * turn(kZ, -sign * (below - 45.0));
    figure.local[static_cast<size_t>(forearm(side))] = turn(glm::cross(axis, kZ), elbow);
    figure.local[static_cast<size_t>(hand(side))] = turn(kZ, -sign * wrist);
  }
  static dvec3 arm_axis(int side) { return side == 0 ? kArmAxis : dvec3(-kArmAxis.x, kArmAxis.y, kArmAxis.z); }

  // Spreads a turn of the head over the neck where there is one.
  void place_head(Figure& figure, const dquat& local) const {
    if (!full()) {
      figure.local[head] = local;
      return;
    }
    const dquat half = glm::normalize(dquat(1.0 + local.w, local.x, local.y, local.z));
    figure.local[kNeck] = half;
    figure.local[head] = half;
  }

  void curl_fingers(Figure& figure, int side, double degrees) const {
    if (!full()) return;
    for (int digit = 1; digit < 5; ++digit) {
      for (int bone = 0; bone < 3; ++bone) {
        figure.local[static_cast<size_t>(finger(side, digit, bone))] =
            turn(side == 0 ? -kZ : kZ, degrees * (bone == 1 ? 1.2 : 0.9));
      }
    }
  }

 private:
  const dvec3& bind(int joint) const { return places_[static_cast<size_t>(joint)].position; }

  // The turn that carries a direction (and, as nearly as it can, a hint across it) to another.
  static dquat between(const dvec3& from, const dvec3& from_hint, const dvec3& to, const dvec3& to_hint) {
    const auto frame = [](const dvec3& direction, const dvec3& hint) {
      const dvec3 y = glm::normalize(direction);
      const dvec3 x = glm::normalize(glm::cross(hint, y));
      return glm::dmat3(x, y, glm::cross(x, y));
    };
    return glm::normalize(glm::quat_cast(frame(to, to_hint) * glm::transpose(frame(from, from_hint))));
  }
  void set_world(Figure& figure, int joint, const dquat& value) const {
    const int parent = places_[static_cast<size_t>(joint)].parent;
    figure.local[static_cast<size_t>(joint)] = glm::conjugate(world(figure, parent)) * value;
  }

  std::vector<JointPlace> places_;
};

// ---------------------------------------------------------------------------------------------------------------

const Gait& walk_gait() {
  static const Gait gait{1.06,
                         1.25,
                         0.61,
                         0.305,
                         {{0.0, 20.0},
                          {0.07, 11.0},
                          {0.16, 0.0},
                          {0.50, 0.0},
                          {0.62, -5.0},
                          {0.74, -14.0},
                          {0.84, -26.0},
                          {0.92, -40.0},
                          {1.0, -58.0}},
                         {{0.14, -66.0}, {0.38, -36.0}, {0.60, -4.0}, {0.80, 15.0}},
                         {{0.20, 0.212}, {0.42, 0.166}, {0.64, 0.118}, {0.86, 0.112}},
                         {{0.22, -0.270}, {0.48, 0.005}, {0.72, 0.195}, {0.90, 0.267}}};
  return gait;
}

const Gait& run_gait() {
  static const Gait gait{0.70,
                         3.0,
                         0.34,
                         0.205,
                         {{0.0, 8.0}, {0.16, 0.0}, {0.48, 0.0}, {0.66, -12.0}, {0.84, -32.0}, {1.0, -56.0}},
                         {{0.22, -82.0}, {0.45, -58.0}, {0.66, -18.0}, {0.86, 6.0}},
                         {{0.24, 0.400}, {0.44, 0.430}, {0.64, 0.300}, {0.82, 0.190}, {0.93, 0.122}},
                         {{0.24, -0.430}, {0.44, -0.190}, {0.64, 0.120}, {0.82, 0.275}, {0.93, 0.262}}};
  return gait;
}

void place_gait_legs(const Poser& poser, Figure& figure, const Gait& gait, double phase, double half_width,
                     double toe_out) {
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? 1.0 : -1.0;
    const FootState state = gait_foot(gait, side == 0 ? phase : phase + 0.5);
    const dquat out = turn(kY, sign * toe_out);
    poser.place_leg(figure, side, {sign * half_width, state.y, state.z + kAnkleZ}, out * kZ,
                    out * turn(kX, -state.pitch), out * turn(kX, -state.toes));
  }
}

// Phase 0 is the left heel's strike.
Figure walk_figure(const Poser& poser, double phase) {
  Figure f = poser.neutral();
  const double twice = cosine(2.0 * (phase - 0.30));
  f.hips_at += dvec3(0.017 * cosine(phase - 0.30), -0.0270 + 0.0135 * twice, 0.006 * sine(2.0 * phase));
  const double yaw = -6.0 * cosine(phase - 0.01);
  const double roll = 3.6 * cosine(phase - 0.21);
  f.local[hips] = turn(kY, yaw) * turn(kZ, roll) * turn(kX, 3.0);
  f.local[spine] = turn(kY, -0.8 * yaw) * turn(kZ, -0.75 * roll) * turn(kX, -1.0);
  f.local[chest] = turn(kY, -1.1 * yaw) * turn(kZ, -0.55 * roll) * turn(kX, 1.0 - 0.8 * twice);
  poser.place_head(f, turn(kY, 0.8 * yaw) * turn(kZ, 0.25 * roll) * turn(kX, -2.0 + 0.9 * twice));
  place_gait_legs(poser, f, walk_gait(), phase, 0.072, 5.0);
  for (int side = 0; side < 2; ++side) {
    const double p = side == 0 ? phase : phase + 0.5;
    const double forward = -cosine(p - 0.02);  // 1 when this arm is in front: opposite to its leg
    const double sign = side == 0 ? 1.0 : -1.0;
    f.local[static_cast<size_t>(clavicle(side))] = turn(kY, -sign * 3.0 * forward) * turn(kZ, -sign * 4.0);
    poser.place_arm(f, side, -1.0 + 20.0 * forward, 80.0, 19.0 - 11.0 * cosine(p - 0.07), 6.0);
  }
  return f;
}

Figure run_figure(const Poser& poser, double phase) {
  Figure f = poser.neutral();
  const double twice = cosine(2.0 * (phase - 0.17));
  f.hips_at += dvec3(0.010 * cosine(phase - 0.17), -0.056 - 0.026 * twice, 0.0);
  const double yaw = -9.0 * cosine(phase + 0.02);
  const double roll = 4.0 * cosine(phase - 0.15);
  f.local[hips] = turn(kY, yaw) * turn(kZ, roll) * turn(kX, 8.0);
  f.local[spine] = turn(kY, -0.9 * yaw) * turn(kZ, -0.7 * roll) * turn(kX, 3.0);
  f.local[chest] = turn(kY, -1.3 * yaw) * turn(kZ, -0.5 * roll) * turn(kX, 1.0 + 1.5 * twice);
  poser.place_head(f, turn(kY, 1.1 * yaw) * turn(kZ, 0.2 * roll) * turn(kX, -9.0 - 1.0 * twice));
  place_gait_legs(poser, f, run_gait(), phase, 0.055, 4.0);
  for (int side = 0; side < 2; ++side) {
    const double p = side == 0 ? phase : phase + 0.5;
    const double forward = -cosine(p + 0.02);
    const double sign = side == 0 ? 1.0 : -1.0;
    f.local[static_cast<size_t>(clavicle(side))] = turn(kY, -sign * 6.0 * forward) * turn(kZ, -sign * 2.0);
    poser.place_arm(f, side, -12.0 + 40.0 * forward, 76.0, 92.0 + 14.0 * forward, 4.0);
    // Forearms swing slightly across the body.
    auto& upper = f.local[static_cast<size_t>(upper_arm(side))];
    upper = upper * turn(Poser::arm_axis(side), sign * -22.0);
    poser.curl_fingers(f, side, 28.0);
  }
  return f;
}

Figure idle_figure(const Poser& poser, double phase) {
  Figure f = poser.neutral();
  const double shift = sine(phase);
  const double breath = sine(2.0 * phase);
  f.hips_at += dvec3(0.012 + 0.014 * shift, -0.006 - 0.002 * shift * shift, -0.004);
  f.local[hips] = turn(kZ, 1.2 + 1.4 * shift) * turn(kY, 2.0 * shift);
  f.local[spine] = turn(kZ, -0.8 - 0.9 * shift) * turn(kX, 0.4 * breath);
  f.local[chest] = turn(kZ, -0.4 - 0.5 * shift) * turn(kY, -1.5 * shift) * turn(kX, -0.9 * breath);
  poser.place_head(f, turn(kY, 5.0 * sine(phase + 0.13)) * turn(kX, 1.0 + 0.5 * breath));
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? 1.0 : -1.0;
    const dquat out = turn(kY, sign * (side == 0 ? 9.0 : 13.0));
    poser.place_leg(f, side, {sign * 0.098, kAnkleY, kAnkleZ + (side == 0 ? -0.012 : 0.022)}, out * kZ, out, out);
    f.local[static_cast<size_t>(clavicle(side))] = turn(kZ, sign * (-4.0 + 0.9 * breath));
    poser.place_arm(f, side, 1.0 + 1.2 * sine(phase + 0.2 * side), 80.5 - 0.6 * breath, 13.0 + 1.5 * shift, 5.0);
  }
  return f;
}

Figure wave_figure(const Poser& poser, double phase) {
  Figure f = poser.neutral();
  const double shift = sine(phase);
  const double beat = sine(3.0 * phase);
  const double late = sine(3.0 * phase - 0.12);
  f.hips_at += dvec3(0.014 + 0.006 * shift, -0.006, -0.004);
  f.local[hips] = turn(kZ, 1.5 + 0.5 * shift) * turn(kY, 1.0 * shift);
  f.local[spine] = turn(kZ, 1.2 - 0.4 * shift);
  f.local[chest] = turn(kZ, 1.0 - 0.6 * late) * turn(kX, -1.0);
  poser.place_head(f, turn(kZ, -2.0 + 1.2 * late) * turn(kY, -4.0) * turn(kX, -1.0));
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? 1.0 : -1.0;
    const dquat out = turn(kY, sign * (side == 0 ? 9.0 : 13.0));
    poser.place_leg(f, side, {sign * 0.098, kAnkleY, kAnkleZ + (side == 0 ? -0.012 : 0.022)}, out * kZ, out, out);
  }
  f.local[static_cast<size_t>(clavicle(0))] = turn(kZ, -4.0);
  poser.place_arm(f, 0, 1.5 + shift, 80.0, 14.0, 5.0);
  // The right arm is raised sideways and turned out, so that the elbow bends upwards and the palm shows.
  const dvec3 axis = Poser::arm_axis(1);
  f.local[static_cast<size_t>(clavicle(1))] = turn(kZ, -9.0);
  f.local[static_cast<size_t>(upper_arm(1))] = turn(kY, 14.0) * turn(kZ, -38.0 - 3.0 * late) * turn(axis, 80.0);
  f.local[static_cast<size_t>(forearm(1))] = turn(glm::cross(axis, kZ), 84.0 + 21.0 * beat);
  f.local[static_cast<size_t>(hand(1))] = turn(kX, -7.0 * late);
  poser.curl_fingers(f, 1, -14.0);
  return f;
}

Clip make_clip(const std::string& name, double seconds, int keys, const Poser& poser,
               const std::vector<int>& node_of_joint, const std::function<Figure(double)>& figure_at) {
  std::vector<Figure> figures;
  for (int k = 0; k < keys; ++k) figures.push_back(figure_at(static_cast<double>(k) / keys));
  figures.push_back(figures.front());
  Clip clip;
  clip.name = name;
  clip.start = 0.0;
  clip.end = seconds;
  std::vector<double> times;
  for (int k = 0; k <= keys; ++k) times.push_back(k == keys ? seconds : seconds * k / keys);
  Channel place{node_of_joint[hips], Target::translation, Interpolation::linear, times, {}};
  for (const Figure& f : figures) place.values.insert(place.values.end(), {f.hips_at.x, f.hips_at.y, f.hips_at.z});
  clip.channels.push_back(std::move(place));
  for (size_t j = 0; j < poser.places().size(); ++j) {
    Channel channel{node_of_joint[j], Target::rotation, Interpolation::linear, times, {}};
    dquat previous{1.0, 0.0, 0.0, 0.0};
    bool turns = false;
    for (const Figure& f : figures) {
      dquat q = f.local[j];
      if (glm::dot(q, previous) < 0.0) q = -q;
      previous = q;
      turns = turns || q.w < 1.0 - 1e-12;
      channel.values.insert(channel.values.end(), {q.x, q.y, q.z, q.w});
    }
    if (turns) clip.channels.push_back(std::move(channel));
  }
  return clip;
}

}  // namespace

std::vector<Clip> make_clips(int joints, const std::vector<int>& node_of_joint) {
  const Poser poser(joints);
  std::vector<Clip> clips;
  // A walk starts in the middle of the left foot's stance, where the body is highest: the pose that its height is
  // measured in.
  clips.push_back(make_clip("walk", walk_gait().seconds, 36, poser, node_of_joint,
                            [&](double p) { return walk_figure(poser, p + 0.30); }));
  clips.push_back(
      make_clip("run", run_gait().seconds, 32, poser, node_of_joint, [&](double p) { return run_figure(poser, p); }));
  clips.push_back(make_clip("idle", 3.2, 24, poser, node_of_joint, [&](double p) { return idle_figure(poser, p); }));
  clips.push_back(make_clip("wave", 2.0, 36, poser, node_of_joint, [&](double p) { return wave_figure(poser, p); }));
  return clips;
}

}  // namespace crowdbench::scene::mannequin
