#include "scene/crowd/crowd.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "core/error.h"
#include "core/hash.h"
#include "pillar_cast.h"
#include "scene/crowd/crowd_stage.h"

namespace crowdbench::scene {
namespace {

Scenario scenario_of(uint32_t agents, PlacementKind placement = PlacementKind::jittered) {
  Scenario s;
  s.crowd.agents = agents;
  s.crowd.placement = placement;
  return s;
}

Crowd crowd_of(const Scenario& s, const Cast& cast) { return make_crowd(s, cast, stage_view(s)); }

struct At {
  double x, z;
};

// The smallest distance of any two, by a grid of cells as wide as the distance that is asked about.
double nearest_pair(std::vector<At> places, double enough) {
  std::sort(places.begin(), places.end(), [](const At& a, const At& b) { return a.x < b.x; });
  double best = enough;
  for (size_t i = 0; i < places.size(); ++i)
    for (size_t j = i + 1; j < places.size() && places[j].x - places[i].x < best; ++j)
      best = std::min(best, std::hypot(places[j].x - places[i].x, places[j].z - places[i].z));
  return best;
}

std::vector<At> places_of(const Crowd& crowd) {
  std::vector<At> places;
  for (size_t i = 0; i < crowd.size(); ++i) places.push_back({crowd.x[i], crowd.z[i]});
  return places;
}

std::vector<FrameAgent> agents_at(const Scenario& s, const Cast& cast, const Crowd& crowd, uint64_t tick,
                                  bool cull = false) {
  std::vector<FrameAgent> all;
  for (const auto& kind : make_frame(s, cast, crowd, s.camera.at(0), tick, cull).agents)
    all.insert(all.end(), kind.begin(), kind.end());
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return all;
}

std::string bytes_of(const Crowd& c) {
  return Sha256()
      .values(c.x)
      .values(c.z)
      .values(c.heading_sin)
      .values(c.heading_cos)
      .values(c.character)
      .values(c.bank_clip)
      .values(c.phase)
      .values(c.speed)
      .values(c.scale)
      .values(c.outfit)
      .value(c.period)
      .hex();
}

TEST(Crowd, GridCellsAreOneSpacingApartAndFillASquare) {
  for (const uint32_t n : {1U, 2U, 4U, 9U, 10U, 100U, 1024U}) {
    const Scenario s = scenario_of(n, PlacementKind::grid);
    const Crowd crowd = crowd_of(s, pillar_cast());
    ASSERT_EQ(crowd.size(), n);
    EXPECT_NEAR(nearest_pair(places_of(crowd), 100.0), n == 1 ? 100.0 : 1.2, 1e-9) << n;
    double reach = 0;
    for (const At& at : places_of(crowd)) reach = std::max({reach, std::abs(at.x), std::abs(at.z)});
    const double cells = std::ceil(std::sqrt(n));
    EXPECT_NEAR(reach, (cells - 1) / 2 * 1.2, 1e-9) << n;
  }
}

TEST(Crowd, JitteredStaysAPersonsBreadthApart) {
  for (const Stage stage : {Stage::plaza, Stage::view})
    for (const double spacing : {0.7, 1.2, 5.0}) {
      Scenario s = scenario_of(3000);
      s.crowd.stage = stage;
      s.crowd.spacing = spacing;
      const double nearest = nearest_pair(places_of(crowd_of(s, pillar_cast())), 100.0);
      EXPECT_GE(nearest, 0.49 - 1e-12) << spacing;
      EXPECT_LT(nearest, spacing > 2 ? 3.5 : 0.60) << spacing;  // it is jittered
    }
}

TEST(Crowd, TheViewStageFillsTheGroundInViewFromItsMiddle) {
  const Cast cast = pillar_cast();
  for (const PlacementKind placement : {PlacementKind::grid, PlacementKind::jittered, PlacementKind::poisson}) {
    Scenario s = scenario_of(500, placement);
    s.crowd.stage = Stage::view;
    s.crowd.stage_near = 5;
    s.crowd.stage_far = 30;
    s.camera.keys[0].camera.eye = {3.0, 6.0, 20.0};
    s.camera.keys[0].camera.target = {0.0, 0.0, 5.0};
    const glm::dvec3 eye = s.camera.keys[0].camera.eye;
    const ViewGround ground(stage_view(s), 0.8 * 1.75 - eye.y);
    s.crowd.spacing = std::sqrt(ground.area() / 500);
    const Crowd crowd = crowd_of(s, cast);
    ASSERT_EQ(crowd.size(), 500U);
    int quarters[4] = {};
    for (size_t i = 0; i < crowd.size(); ++i) {
      const GroundPoint at{crowd.x[i] - eye.x, crowd.z[i] - eye.z};
      EXPECT_LT(ground.norm(at), 1.25);
      const GroundPoint middle = ground.at(0, 0);
      ++quarters[(at.x > middle.x) + 2 * (at.z > middle.z)];
    }
    for (const int quarter : quarters) EXPECT_GT(quarter, 60);
    const double apart = nearest_pair(places_of(crowd), 100.0);
    EXPECT_GE(apart, placement == PlacementKind::grid      ? s.crowd.spacing - 1e-9
                     : placement == PlacementKind::poisson ? 0.75 * s.crowd.spacing
                                                           : 0.49);
  }
}

TEST(Crowd, PoissonStaysThreeQuartersOfASpacingApartAtTheDensityOfTheGrid) {
  for (const uint32_t n : {1U, 10U, 1000U, 20000U}) {
    const Scenario s = scenario_of(n, PlacementKind::poisson);
    const Crowd crowd = crowd_of(s, pillar_cast());
    ASSERT_EQ(crowd.size(), n);
    if (n > 1) {
      EXPECT_GE(nearest_pair(places_of(crowd), 100.0), 0.75 * 1.2);
    }
    double reach = 0;
    for (const At& at : places_of(crowd)) reach = std::max({reach, std::abs(at.x), std::abs(at.z)});
    EXPECT_LE(reach, std::sqrt(n) * 1.2 / 2 * 1.0001) << n;
  }
}

TEST(Crowd, LanesStaySevenTenthsOfASpacingApart) {
  for (const uint32_t n : {1U, 2U, 7U, 500U}) {
    Scenario s = scenario_of(n, PlacementKind::lanes);
    s.crowd.spacing = 0.7;
    const Crowd crowd = crowd_of(s, pillar_cast());
    ASSERT_EQ(crowd.size(), n);
    EXPECT_GE(nearest_pair(places_of(crowd), 100.0), 0.7 * 0.7 - 1e-12) << n;
  }
}

TEST(Crowd, WhoAnAgentIsDoesNotDependOnHowManyThereAre) {
  const Cast cast = pillar_cast(1.4, 3);
  for (const PlacementKind placement : {PlacementKind::grid, PlacementKind::jittered, PlacementKind::poisson}) {
    const Crowd few = crowd_of(scenario_of(100, placement), cast);
    const Crowd many = crowd_of(scenario_of(1024, placement), cast);
    ASSERT_EQ(few.size(), 100U);
    ASSERT_EQ(many.size(), 1024U);
    for (size_t i = 0; i < few.size(); ++i) {
      EXPECT_EQ(few.character[i], many.character[i]);
      EXPECT_EQ(few.bank_clip[i], many.bank_clip[i]);
      EXPECT_EQ(few.phase[i], many.phase[i]);
      EXPECT_EQ(few.speed[i], many.speed[i]);
      EXPECT_EQ(few.scale[i], many.scale[i]);
      EXPECT_EQ(few.outfit[i], many.outfit[i]);
      EXPECT_EQ(few.heading_sin[i], many.heading_sin[i]);
      if (placement != PlacementKind::poisson) {  // both squares have even sides, so the same middle
        EXPECT_EQ(few.x[i], many.x[i]);
        EXPECT_EQ(few.z[i], many.z[i]);
      }
    }
  }
}

TEST(Crowd, AttributesFillTheirRanges) {
  Scenario s = scenario_of(20000);
  s.crowd.scale_variation = 0.2;
  s.crowd.speed_variation = 0.3;
  s.crowd.outfits = 5;
  Cast cast = pillar_cast(1.4, 2);
  cast.shares = {0.25, 0.75};
  const Crowd c = crowd_of(s, cast);
  double scale_low = 9;
  double scale_high = 0;
  double speed_low = 9;
  double speed_high = 0;
  double second = 0;
  std::set<uint32_t> outfits;
  for (size_t i = 0; i < c.size(); ++i) {
    scale_low = std::min(scale_low, c.scale[i]);
    scale_high = std::max(scale_high, c.scale[i]);
    speed_low = std::min(speed_low, c.speed[i]);
    speed_high = std::max(speed_high, c.speed[i]);
    second += c.character[i] == 1;
    outfits.insert(c.outfit[i]);
    EXPECT_NEAR(c.heading_sin[i] * c.heading_sin[i] + c.heading_cos[i] * c.heading_cos[i], 1.0, 1e-14);
    EXPECT_TRUE(c.phase[i] >= 0 && c.phase[i] < 1);
  }
  EXPECT_NEAR(scale_low, 0.8, 1e-3);
  EXPECT_NEAR(scale_high, 1.2, 1e-3);
  EXPECT_NEAR(speed_low, 0.7, 1e-3);
  EXPECT_NEAR(speed_high, 1.3, 1e-3);
  EXPECT_NEAR(second / 20000, 0.75, 5 * 0.433 / 141.4);
  EXPECT_EQ(outfits.size(), 5U);
}

TEST(Crowd, BytesArePinned) {
  const Cast cast = pillar_cast(1.4, 2);
  EXPECT_EQ(bytes_of(crowd_of(scenario_of(1000), cast)),
            "a2bf3a19a92c176593360aa0875e2e53cd20500bbdbdac53a2eb9b08da573a2b");
  EXPECT_EQ(bytes_of(crowd_of(scenario_of(1000, PlacementKind::poisson), cast)),
            "e9305d32068c2431f548423f83e4add18ff73ceac53942a63dd1a5d25898ce02");
  Scenario lanes = scenario_of(1000);
  lanes.crowd.motion = MotionKind::lanes;
  EXPECT_EQ(bytes_of(crowd_of(lanes, cast)), "da7bb4d6a0d6f3ece80872dd4c53cbacbc0ae996eb2a5af7cd4d717d8ec2c8db");
  Scenario frustum = scenario_of(1000);
  frustum.crowd.stage = Stage::frustum;
  frustum.seed = std::numeric_limits<uint64_t>::max();
  EXPECT_EQ(bytes_of(crowd_of(frustum, cast)), "a78d3c4d9fbb187a93c49da24b62006401c2a3838e26c359ce303ae05ee25ab7");
}

TEST(Crowd, AFrameDependsOnItsTickAlone) {
  const Cast cast = pillar_cast(1.4, 2);
  for (const MotionKind motion : {MotionKind::treadmill, MotionKind::lanes, MotionKind::free}) {
    Scenario s = scenario_of(200);
    s.crowd.motion = motion;
    const Crowd crowd = crowd_of(s, cast);
    const auto first = agents_at(s, cast, crowd, 1234);
    for (uint64_t tick = 0; tick < 50; ++tick) agents_at(s, cast, crowd, tick);
    const auto again = agents_at(s, cast, crowd_of(s, cast), 1234);
    ASSERT_EQ(first.size(), 200U);
    ASSERT_EQ(again.size(), 200U);
    for (size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(first[i].position, again[i].position);
      EXPECT_EQ(first[i].phase, again[i].phase);
      EXPECT_EQ(first[i].pose.a, again[i].pose.a);
      EXPECT_EQ(first[i].pose.blend, again[i].pose.blend);
    }
  }
}

TEST(Crowd, OnATreadmillClipsPlayAndPlacesStay) {
  const Cast cast = pillar_cast();
  const Scenario s = scenario_of(50);
  const Crowd crowd = crowd_of(s, cast);
  const auto start = agents_at(s, cast, crowd, 0);
  const auto later = agents_at(s, cast, crowd, 17);
  ASSERT_EQ(start.size(), 50U);
  ASSERT_EQ(later.size(), 50U);
  for (size_t i = 0; i < start.size(); ++i) {
    EXPECT_EQ(start[i].position, later[i].position);
    const double seconds = cast.banks[0]->clips()[crowd.bank_clip[i]].seconds;
    const double played = crowd.phase[i] + crowd.speed[i] * (17.0 / 30.0) / seconds;
    EXPECT_NEAR(later[i].phase, played - std::floor(played), 1e-6);
  }
}

// Feet do not slide: the distance of one cycle is the clip's own, times the agent's size.
TEST(Crowd, WalkersAdvanceAtTheirClipsGroundSpeed) {
  const Cast cast = pillar_cast(1.5);
  for (const MotionKind motion : {MotionKind::lanes, MotionKind::free}) {
    Scenario s = scenario_of(300);
    s.crowd.motion = motion;
    s.crowd.scale_variation = 0.2;
    s.tick_rate = 100;
    const Crowd crowd = crowd_of(s, cast);
    const auto start = agents_at(s, cast, crowd, 0);
    const auto later = agents_at(s, cast, crowd, 1);
    int checked = 0;
    for (size_t i = 0; i < start.size(); ++i) {
      const BankClip& clip = cast.banks[0]->clips()[crowd.bank_clip[i]];
      const double distance =
          std::hypot(later[i].position.x - start[i].position.x, later[i].position.z - start[i].position.z);
      if (distance > 1) continue;  // wrapped
      const double cycles = crowd.speed[i] * 0.01 / clip.seconds;
      EXPECT_NEAR(distance, cycles * clip.ground_speed * clip.seconds * crowd.scale[i], 2e-6);
      if (distance > 0) {
        EXPECT_NEAR((later[i].position.x - start[i].position.x) / distance, crowd.heading_sin[i], 2e-4);
      }
      ++checked;
    }
    EXPECT_GT(checked, 280);
  }
}

TEST(Crowd, NoTwoOverlapInLanesAtAnyTick) {
  const Cast cast = pillar_cast(1.4, 2);
  Scenario s = scenario_of(400);
  s.crowd.motion = MotionKind::lanes;
  s.crowd.spacing = 0.7;
  const Crowd crowd = crowd_of(s, cast);
  std::set<double> speeds;
  for (size_t i = 0; i < crowd.size(); ++i) speeds.insert(crowd.speed[i]);
  EXPECT_GT(speeds.size(), 100U);
  for (const uint64_t tick : {0ULL, 1ULL, 7ULL, 100ULL, 1000ULL, 12345ULL, 98765ULL, 30'000'000ULL, 30'000'001ULL}) {
    std::vector<At> places;
    for (const FrameAgent& agent : agents_at(s, cast, crowd, tick))
      places.push_back({agent.position.x, agent.position.z});
    ASSERT_EQ(places.size(), 400U);
    EXPECT_GE(nearest_pair(places, 100.0), 0.49 - 1e-4) << tick;  // float positions
  }
}

TEST(Crowd, LanesWrapOutOfTheView) {
  const Cast cast = pillar_cast();
  Scenario s = scenario_of(100);
  s.crowd.motion = MotionKind::lanes;
  const Crowd crowd = crowd_of(s, cast);
  std::set<uint32_t> shown_before;
  std::vector<FrameAgent> before = agents_at(s, cast, crowd, 0);
  int jumps = 0;
  size_t most_shown = 0;
  for (uint64_t tick = 1; tick < 600; ++tick) {
    std::set<uint32_t> shown;
    for (const FrameAgent& agent : agents_at(s, cast, crowd, tick, true)) shown.insert(agent.id);
    most_shown = std::max(most_shown, shown.size());
    const std::vector<FrameAgent> now = agents_at(s, cast, crowd, tick);
    for (size_t i = 0; i < now.size(); ++i) {
      if (glm::length(now[i].position - before[i].position) < 1) continue;
      ++jumps;
      EXPECT_EQ(shown.count(now[i].id), 0U) << "appears in view at tick " << tick;
      EXPECT_EQ(shown_before.count(now[i].id), 0U) << "vanishes from view at tick " << tick;
    }
    before = now;
    shown_before = shown;
  }
  EXPECT_GT(jumps, 50);
  EXPECT_GT(most_shown, 20U);
}

TEST(Crowd, LanesNeedAClipThatMoves) {
  Scenario s = scenario_of(10);
  s.crowd.motion = MotionKind::lanes;
  EXPECT_THROW(crowd_of(s, pillar_cast(0.0)), Error);
}

TEST(Crowd, AMillionSecondsLaterLanesAreStillInStep) {
  const Cast cast = pillar_cast();
  Scenario s = scenario_of(64);
  s.crowd.motion = MotionKind::lanes;
  s.crowd.heading_deg = 0;
  const Crowd crowd = crowd_of(s, cast);
  const auto a = agents_at(s, cast, crowd, 0);
  const auto b = agents_at(s, cast, crowd, 30'000'000);
  ASSERT_EQ(a.size(), 64U);
  ASSERT_EQ(b.size(), 64U);
  EXPECT_GT(std::abs(b[0].position.z - a[0].position.z), 1e-3F);  // they walk
  // Agents 0, 8, 16, ... share a lane; their distances modulo the period must have stayed.
  for (size_t i = 8; i < 64; i += 8) {
    const double gap = (b[i].position.z - a[i].position.z) - (b[0].position.z - a[0].position.z);
    const double off = std::abs(gap - std::round(gap / crowd.period) * crowd.period);
    EXPECT_LT(off, 2e-5);
  }
}

TEST(Crowd, FarFromTheOriginTheFrameIsTheSame) {
  const Cast cast = pillar_cast();
  // Cells of a view are picked by their place in it: rounding in the world would pick others, metres off.
  for (const Stage stage : {Stage::plaza, Stage::view, Stage::frustum}) {
    Scenario s = scenario_of(200);
    s.crowd.stage = stage;
    // Which doubles hold exactly at the distance, too: else the view itself is another.
    for (CameraKey& key : s.camera.keys) {
      key.camera.eye = {0.0, 3.0, 9.0};
      key.camera.target = {0.0, 0.875, 0.0};
    }
    const auto near = agents_at(s, cast, crowd_of(s, cast), 3);
    s.crowd.centre = {1e7, -500.0, 1e7};
    for (CameraKey& key : s.camera.keys) {
      key.camera.eye += s.crowd.centre;
      key.camera.target += s.crowd.centre;
    }
    const auto far = agents_at(s, cast, crowd_of(s, cast), 3);
    ASSERT_EQ(near.size(), far.size());
    ASSERT_GT(near.size(), 50U);
    for (size_t i = 0; i < near.size(); ++i)
      ASSERT_LT(glm::length(near[i].position - far[i].position), 1e-5F) << static_cast<int>(stage) << ' ' << i;
  }
}

TEST(Crowd, CullingDropsNobodyWhoIsSeen) {
  const Cast cast = pillar_cast();
  Scenario s = scenario_of(2500);
  s.camera.keys[0].camera.eye = {3.0, 2.0, 4.0};
  s.camera.keys[0].camera.target = {-1.0, 0.5, -5.0};
  s.camera.keys[0].camera.far = 30.0;
  const Camera camera = s.camera.at(0);
  const Crowd crowd = crowd_of(s, cast);
  std::set<uint32_t> kept;
  for (const FrameAgent& agent : agents_at(s, cast, crowd, 0, true)) kept.insert(agent.id);
  const glm::dmat4 project = projection(camera, 4.0 / 3.0);
  const glm::dmat3 rotation = view_rotation(camera);
  size_t seen = 0;
  size_t all_out = 0;
  for (const FrameAgent& agent : agents_at(s, cast, crowd, 0)) {
    // Points all through the box of the body: one of them inside the frustum means that the agent may be seen.
    bool inside = false;
    for (int i = 0; i < 9 * 9 * 9; ++i) {
      const glm::vec3 model(-0.25F + 0.0625F * (i % 9), 1.75F * (i / 9 % 9) / 8.0F, -0.15F + 0.0375F * (i / 81));
      const glm::vec3 m = model * agent.scale;
      const glm::vec3 world = agent.position + glm::vec3(m.x * agent.heading.y + m.z * agent.heading.x, m.y,
                                                         m.z * agent.heading.y - m.x * agent.heading.x);
      const glm::dvec4 clip = project * glm::dvec4(rotation * glm::dvec3(world), 1.0);
      inside = inside || (std::abs(clip.x) < clip.w && std::abs(clip.y) < clip.w && clip.z < clip.w && clip.z > 0);
    }
    seen += inside;
    all_out += !kept.count(agent.id);
    if (inside) {
      EXPECT_EQ(kept.count(agent.id), 1U) << agent.id;
    }
  }
  EXPECT_GT(seen, 100U);
  EXPECT_GT(all_out, 1000U);
  EXPECT_LT(kept.size(), seen * 3 / 2);  // and it does cull
}

TEST(Crowd, TheFrustumStageKeepsBodiesOnScreen) {
  const Cast cast = pillar_cast();
  for (const double eye_height : {2.5, 8.0, 100.0}) {
    Scenario s = scenario_of(1000);
    s.crowd.stage = Stage::frustum;
    s.camera.keys[0].camera.eye = {0.0, eye_height, 0.0};
    s.camera.keys[0].camera.target = {0.0, 0.9, eye_height > 50 ? -1e-4 : -2.5 * eye_height};
    const StageView view = stage_view(s);
    const Crowd crowd = make_crowd(s, cast, view);
    const Camera camera = s.camera.at(0);
    int on_screen = 0;
    for (size_t i = 0; i < crowd.size(); ++i) {
      const glm::dvec3 middle{crowd.x[i], 1.4, crowd.z[i]};  // at 0.8 of the body, which is kept in view
      const glm::dvec4 clip =
          projection(camera, 4.0 / 3.0) * glm::dvec4(view_rotation(camera) * (middle - camera.eye), 1.0);
      EXPECT_LE(std::abs(clip.x), clip.w * 1.001);
      on_screen += std::abs(clip.y) <= clip.w * 1.001;
      if (eye_height < 50) {
        EXPECT_GE(clip.w, view.near_depth - 1e-6);
        EXPECT_LE(clip.w, view.far_depth + 1e-6);
      }
    }
    EXPECT_EQ(on_screen, 1000) << eye_height;
  }
}

TEST(Crowd, NoAgentsAndAMillion) {
  const Cast cast = pillar_cast();
  const Scenario none = scenario_of(0);
  const Crowd empty = crowd_of(none, cast);
  EXPECT_EQ(empty.size(), 0U);
  EXPECT_EQ(agents_at(none, cast, empty, 5).size(), 0U);
  for (const MotionKind motion : {MotionKind::lanes, MotionKind::free}) {
    Scenario s = none;
    s.crowd.motion = motion;
    EXPECT_EQ(agents_at(s, cast, crowd_of(s, cast), 5).size(), 0U);
  }
  Scenario s = scenario_of(1'000'000);
  const Crowd crowd = crowd_of(s, cast);
  const Frame frame = make_frame(s, cast, crowd, s.camera.at(0), 0, false);
  ASSERT_EQ(frame.agents[0].size(), 1'000'000U);
  EXPECT_EQ(frame.agents[0].back().id, 1'000'000U);
}

TEST(Outfits, TheFirstIsWhiteAndTheRestAreMildAndSeeded) {
  const auto outfits = make_outfits(7, 300);
  ASSERT_EQ(outfits.size(), 300U);
  for (const glm::vec4& colour : outfits[0].colours) EXPECT_EQ(colour, glm::vec4(1.0F));
  std::set<float> shirts;
  for (size_t row = 1; row < outfits.size(); ++row) {
    for (const glm::vec4& c : outfits[row].colours) {
      const float luminance = 0.2126F * c.r + 0.7152F * c.g + 0.0722F * c.b;
      EXPECT_GE(luminance, 0.3F);
      EXPECT_LE(luminance, 1.36F);
      EXPECT_EQ(c.a, 1.0F);
    }
    shirts.insert(outfits[row].colours[2].r);
    // Skin stays skin: red is never below green, nor green below blue.
    EXPECT_GE(outfits[row].colours[0].r, outfits[row].colours[0].g);
    EXPECT_GE(outfits[row].colours[0].g, outfits[row].colours[0].b);
  }
  EXPECT_GT(shirts.size(), 250U);
  EXPECT_EQ(make_outfits(7, 10)[5].colours[2], outfits[5].colours[2]);
  EXPECT_NE(make_outfits(8, 10)[5].colours[2], outfits[5].colours[2]);
}

}  // namespace
}  // namespace crowdbench::scene
