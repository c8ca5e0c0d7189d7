// From a condition to what is drawn: the cast loaded, spacing and camera found. Internal to studies/plan.
#pragma once
#include <map>
#include <memory>
#include <string>

#include "renderers/gl/context.h"
#include "scene/cast/cast.h"
#include "scene/scenario/scenario.h"
#include "studies/plan/design.h"
#include "studies/plan/plan.h"

namespace crowdbench::studies {

class Staging {
 public:
  // Both must outlive it.
  Staging(gl::Context& context, const StudyPlan& plan) : context_(context), plan_(plan) {}

  const scene::Cast& cast(const StudyCondition& condition);
  // The half's scenario with spacing and camera as they are drawn. Throws Error.
  scene::Scenario scenario(const PlannedHalf& half);
  // PlannedHalf::key with what the files of characters and the machine's renderer add to it, 16 digits.
  std::string key(const PlannedHalf& half);
  // That finding cameras by texels has spent on bakes.
  double bake_seconds() const { return bake_seconds_; }

 private:
  void place_camera(const StudyCondition& condition, scene::Scenario& scenario);
  double texel_metres(const StudyCondition& condition);

  gl::Context& context_;
  const StudyPlan& plan_;
  std::map<std::string, std::unique_ptr<scene::Cast>> casts_;
  std::map<std::string, double> texels_;  // by condition
  double bake_seconds_ = 0;
};

}  // namespace crowdbench::studies
