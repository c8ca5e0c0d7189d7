#include "renderers/impostor/views/view_sampling.h"

#include <algorithm>

namespace crowdbench::renderers {

void set_pose_steps(ViewSampling& sampling, std::span<const double> steps) {
  sampling.pose_step_largest = sampling.pose_step_mean = 0;
  for (const double step : steps) {
    sampling.pose_step_largest = std::max(sampling.pose_step_largest, step);
    sampling.pose_step_mean += step / static_cast<double>(steps.size());
  }
}

}  // namespace crowdbench::renderers
