// Audit of an impostor's view sampling: how coarse the stored views and frames are, what the published limit would
// cost, and what the coarseness was measured to cost in the picture.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "metrics/registry.h"
#include "renderers/representation.h"
#include "scene/character/character.h"

namespace crowdbench::gl {
class Context;
}

namespace crowdbench::bench {

// Views of a figure that turn by more than this at once are seen to jump: 5.9 degrees near and 6.5 far in Almqvist and
// Vickstroem 2020, of which the middle is taken.
inline constexpr double kSmoothViewStepDeg = 6;

// Means over views of one figure, 120 pixels tall, against the mesh at the identical camera: of every score that all
// views have.
struct AuditError {
  size_t views = 0;
  std::vector<std::pair<const metrics::Score*, double>> means;
  std::optional<double> mean(std::string_view name) const;  // nothing without such a score
};

struct ViewAudit {
  std::string representation;  // canonical text
  std::string grid;
  int views = 0;                                       // captured
  double step_deg_mean = 0, step_deg_max = 0;          // between neighbouring views
  double error_deg_mean = 0, error_deg_max = 0;        // between a direction and the view that stands in for it
  int frames = 0;                                      // a clip
  double pose_step_seconds = 0;                        // of the default clip; 0 for a still pose
  double pose_step_mm_mean = 0, pose_step_mm_max = 0;  // of the vertex that moves farthest
  double texel_mm = 0;
  uint64_t bytes = 0;      // of textures, by the bounds of what is stored
  std::string limit_grid;  // the smallest of the same kind that meets kSmoothViewStepDeg
  int limit_views = 0;
  uint64_t limit_bytes = 0;  // the same, of that grid
  bool meets_limit = false;
  AuditError stored;                     // at stored views of the lowest row, frame 0
  AuditError between;                    // in 30 directions that no grid favours, elevations 2 to 40 degrees, frame 0
  AuditError between_frames;             // in the same directions, half-way between two stored frames
  std::optional<AuditError> unmirrored;  // a mirrored grid: `between`, of the full turn with the same steps
  // Code values of luma by which the picture changes and the mesh's does not, over a quarter of a turn in steps of a
  // degree at 12 degrees of elevation, mean over the silhouettes (metrics::flicker).
  double orbit_flicker = 0;
};

// What of a spec can be audited: itself, or those of its components, at any depth, that store views, in their order;
// the spec itself where none does.
std::vector<renderers::Spec> audited_specs(const renderers::Spec& spec);

// What the type's view grid is of, in the words of its option: "the view grid of each joint, all round". Empty: it has
// none.
std::string view_grid_meaning(const renderers::RepresentationType& type);

// Throws Error where the type stores no views of the whole figure, naming those that do, and what baking throws. The
// views are baked (or read from the cache).
ViewAudit audit_views(gl::Context& context, const std::shared_ptr<const scene::Character>& character,
                      const renderers::Spec& spec, uint64_t bake_budget, bool use_cache);

}  // namespace crowdbench::bench
