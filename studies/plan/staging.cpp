#include "studies/plan/staging.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/hash.h"
#include "scene/cast/load_cast.h"
#include "scene/scenario/scenario_writer.h"
#include "studies/stimuli/bodies.h"

namespace crowdbench::studies {
namespace {

constexpr int kDrawingVersion = 1;  // raised when the same plan is to be drawn anew

// Metres of the characters' heights, by share.
double mean_height(const scene::Cast& cast) {
  double height = 0;
  for (size_t c = 0; c < cast.characters.size(); ++c) height += cast.shares[c] * cast.characters[c]->placement.height;
  return height;
}

}  // namespace

const scene::Cast& Staging::cast(const StudyCondition& condition) {
  scene::Scenario characters;
  characters.characters = condition.scenario.characters;
  characters.pose_rate = condition.scenario.pose_rate;
  std::unique_ptr<scene::Cast>& cast = casts_[scene::to_toml(characters)];
  if (!cast) try {
      cast = std::make_unique<scene::Cast>(scene::load_cast(condition.scenario, plan_.folder));
    } catch (const Error& error) {
      throw Error(plan_.where, fmt::format("{}: {}: {}", condition.name, error.where, error.wrong), error.advice);
    }
  return *cast;
}

double Staging::texel_metres(const StudyCondition& condition) {
  const auto [found, fresh] = texels_.emplace(condition.id, 0.0);
  if (fresh) {
    const auto made = renderers::make_representation({context_, cast(condition)}, condition.test);
    found->second = made->texel_metres(0);
    bake_seconds_ += made->bake_info().seconds;
  }
  if (found->second <= 0)
    throw Error(
        plan_.where,
        fmt::format("{}: '{}' has no texels that pixels could be counted by", condition.name, condition.test.text()),
        "use `height_px`");
  return found->second;
}

void Staging::place_camera(const StudyCondition& condition, scene::Scenario& scenario) {
  if (!condition.height_px && !condition.pixels_per_texel) return;
  scene::Camera& camera = scenario.camera.keys[0].camera;
  // What covers one pixel at one metre's distance, in metres.
  const double pixel = scene::pixel_size_at(camera, 1.0, scenario.height);
  const double distance = condition.height_px ? mean_height(cast(condition)) / (pixel * *condition.height_px)
                                              : texel_metres(condition) / (pixel * *condition.pixels_per_texel);
  const glm::dvec3 away = camera.eye - camera.target;
  if (glm::length(away) < 1e-6)
    throw Error(plan_.where, "the camera's eye is at its target, so that it cannot move away from it",
                "give [scenario] camera.eye and camera.target");
  camera.eye = camera.target + away * (distance / glm::length(away));
  // Lanes end out of what is seen up to this depth.
  scenario.crowd.stage_far = std::max(scenario.crowd.stage_far, 4 * distance);
}

scene::Scenario Staging::scenario(const PlannedHalf& half) {
  const StudyCondition& condition = plan_.conditions[half.condition];
  scene::Scenario scenario = half.scenario;
  if (condition.spacing_by_bodies) {
    scenario.crowd.spacing = spacing_of_bodies(scenario, cast(condition));
    if (scenario.crowd.spacing > 100)
      throw Error(plan_.where,
                  fmt::format("{}: bodies need {:.0f} m between neighbours", condition.name, scenario.crowd.spacing),
                  "check the characters' height, or give crowd.spacing");
  }
  place_camera(condition, scenario);
  return scenario;
}

std::string Staging::key(const PlannedHalf& half) {
  Sha256 digest;
  digest.value(kDrawingVersion).text(half.key).text(scene::to_toml(scenario(half)));
  digest.value(plan_.stimulus.largest_px).value(plan_.stimulus.intersect);
  for (const auto& character : cast(plan_.conditions[half.condition]).characters) digest.text(character->content_hash);
  digest.text(context_.renderer()).text(context_.version());
  return digest.hex().substr(0, 16);
}

}  // namespace crowdbench::studies
