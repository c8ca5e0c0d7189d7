// What steps and what does not, by tracks of soles that are made by hand.
#include "scene/pose/stance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace crowdbench::scene {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kPoses = 25;

// One point of a sole at a time of [0, 1].
using Point = std::function<glm::dvec3(double)>;

// A figure of 2 units over two seconds.
SoleTracks tracks_of(const std::vector<Point>& points) {
  SoleTracks out{{}, 2, 2};
  for (int i = 0; i < kPoses; ++i) {
    auto& pose = out.poses.emplace_back();
    for (const Point& point : points) pose.push_back(point(i / (kPoses - 1.0)));
  }
  return out;
}

// Back by `stride` on the ground in the first half of the cycle, forward in an arc of that height in the second; begun
// at `phase`. Two of them, half a cycle apart, go by a stride in a second.
Point stepping(double x, double stride, double height, double phase) {
  return [=](double t) {
    const double at = t + phase - std::floor(t + phase);
    if (at <= 0.5) return glm::dvec3(x, 0, stride * (0.5 - 2 * at));
    const double swing = 2 * at - 1;
    return glm::dvec3(x, height * std::sin(kPi * swing), stride * (swing - 0.5));
  };
}
Point standing(double x, double z = 0) {
  return [=](double) { return glm::dvec3(x, 0, z); };
}
// About (0, 1, 0) in the plane of x = const, by the angle of that time, from (x, y, z).
Point turning(const glm::dvec3& from, const std::function<double(double)>& angle) {
  return [=](double t) {
    const double c = std::cos(angle(t));
    const double s = std::sin(angle(t));
    const double y = from.y - 1;
    return glm::dvec3(from.x, 1 + y * c - from.z * s, y * s + from.z * c);
  };
}

void expect_velocity(const std::vector<Point>& points, double x, double z) {
  const std::optional<glm::dvec2> velocity = stance_velocity(tracks_of(points));
  ASSERT_TRUE(velocity);
  EXPECT_NEAR(velocity->x, x, 1e-9);
  EXPECT_NEAR(velocity->y, z, 1e-9);
}

TEST(Stance, FeetThatTakeTurnsGoAStrideASecond) {
  for (const double stride : {0.6, 1.2, -0.8})
    expect_velocity({stepping(-0.1, stride, 0.2, 0), stepping(0.1, stride, 0.2, 0.5)}, 0, stride);
  // Sidewards: x for z.
  const auto aside = [](const Point& point) -> Point {
    return [=](double t) {
      const glm::dvec3 p = point(t);
      return glm::dvec3(p.z, p.y, p.x);
    };
  };
  expect_velocity({aside(stepping(-0.1, 0.6, 0.2, 0)), aside(stepping(0.1, 0.6, 0.2, 0.5))}, 0.6, 0);
}

// On one leg, and with a foot that is dragged along: one foot that steps is enough.
TEST(Stance, OneFootThatStepsIsEnough) {
  expect_velocity({stepping(0, 0.6, 0.2, 0)}, 0, 0.6);
  expect_velocity({stepping(-0.1, 0.6, 0.2, 0), stepping(0.1, 0.6, 0, 0.5)}, 0, 0.6);
}

TEST(Stance, WhoStandsOnOneFootGoesNowhere) {
  expect_velocity({standing(-0.1), stepping(0.1, 0.6, 0.2, 0)}, 0, 0);
  // On a heel, while the toes tap.
  expect_velocity({standing(-0.1), [](double t) { return glm::dvec3(-0.1, 0.1 * std::sin(kPi * t), 0.2); }}, 0, 0);
}

TEST(Stance, WhatComesBackByItsWayOrNotAtAllGoesNowhere) {
  const auto swing = [](double t) { return 0.3 * std::sin(2 * kPi * t); };
  const auto once = [](double t) { return 0.3 * t; };
  for (const auto& angle : {std::function<double(double)>(swing), std::function<double(double)>(once)}) {
    expect_velocity({turning({-0.1, 0, 0}, angle), turning({0.1, 0, 0}, angle)}, 0, 0);
    expect_velocity({turning({-0.1, 0, -0.1}, angle), turning({0.1, 0, 0.2}, angle)}, 0, 0);
  }
  // Slowly back and fast forward, on the ground all along.
  expect_velocity({stepping(-0.1, 0.6, 0, 0), stepping(0.1, 0.6, 0, 0)}, 0, 0);
  // Back, and there it ends.
  expect_velocity({[](double t) { return glm::dvec3(0, 0, -t); }, [](double t) { return glm::dvec3(0.1, 0, -t); }}, 0,
                  0);
}

TEST(Stance, WithoutContactNothingIsKnown) {
  // Up and down by the height between any two poses.
  int pose = 0;
  EXPECT_FALSE(stance_velocity(tracks_of({[&](double) { return glm::dvec3(0, pose++ % 2, 0); }})));
  EXPECT_FALSE(stance_velocity(tracks_of({})));
}

}  // namespace
}  // namespace crowdbench::scene
