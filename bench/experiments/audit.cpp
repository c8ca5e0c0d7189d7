#include "bench/experiments/audit.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "bench/experiments/quality.h"
#include "core/error.h"
#include "metrics/temporal.h"
#include "renderers/impostor/views/view_options.h"
#include "renderers/impostor/views/view_sampling.h"
#include "scene/pose/pose.h"

namespace crowdbench::bench {
namespace {

constexpr double kDegrees = std::numbers::pi / 180;
constexpr int kDirections = 30;

// Equal pictures have no finite PSNR: they count as 100 dB.
constexpr double kMostCounted = 100;

AuditError mean_of(std::span<const QualityRow> rows) {
  AuditError out;
  out.views = rows.size();
  if (rows.empty()) return out;
  for (size_t s = 0; s < rows[0].scores.scores.size(); ++s) {
    const metrics::Score* score = rows[0].scores.scores[s].score;
    double sum = 0;
    size_t count = 0;
    for (const QualityRow& row : rows)
      if (const auto& value = row.scores.scores[s].result.value) {
        sum += std::isinf(score->greatest) ? std::min(*value, kMostCounted) : *value;
        ++count;
      }
    if (count == rows.size()) out.means.emplace_back(score, sum / static_cast<double>(count));
  }
  return out;
}

// The same grid without mirroring: the steps of its half turn, all around.
renderers::Spec unmirrored(const renderers::Spec& spec, const renderers::ViewGrid& grid) {
  renderers::ViewGrid full = grid;
  full.mirrored = false;
  full.azimuths = 2 * (grid.azimuths - 1);
  return with_view_grid(spec, full);
}

int captured_views(const renderers::ViewGrid& grid) {
  int views = 0;
  for (int v = 0; v < grid.size(); ++v) views += grid.reachable(v) ? 1 : 0;
  return views;
}

std::string names_of_those_with_views() {
  std::vector<std::string> names;
  for (const renderers::RepresentationType& type : renderers::representation_types())
    if (type.view_sampling != nullptr) names.push_back(type.name);
  return fmt::format("{}", fmt::join(names, " or "));
}

// The middle of every figure's picture, so that an orbit's pictures fit in memory.
metrics::Box middle(const Image8& image) {
  const int side = std::min({image.width, image.height, 240});
  return {(image.width - side) / 2, (image.height - side) / 2, side, side};
}

}  // namespace

std::optional<double> AuditError::mean(std::string_view name) const {
  for (const auto& [score, value] : means)
    if (score->name == name) return value;
  return std::nullopt;
}

std::string view_grid_meaning(const renderers::RepresentationType& type) {
  for (const renderers::OptionDoc& option : type.options)
    if (option.key == renderers::views_option().key) return option.meaning.substr(0, option.meaning.find(':'));
  return {};
}

std::vector<renderers::Spec> audited_specs(const renderers::Spec& spec) {
  std::vector<renderers::Spec> out;
  for (const renderers::Spec& component : spec.components)
    for (const renderers::Spec& one : audited_specs(component))
      if (renderers::representation_type(one.name).view_sampling != nullptr) out.push_back(one);
  if (out.empty()) out.push_back(spec);
  return out;
}

ViewAudit audit_views(gl::Context& context, const std::shared_ptr<const scene::Character>& character,
                      const renderers::Spec& spec, uint64_t bake_budget, bool use_cache) {
  const renderers::RepresentationType& type = renderers::representation_type(spec.name);
  const auto sample = type.view_sampling;
  if (sample == nullptr) {
    const std::string meaning = view_grid_meaning(type);
    throw Error("--audit",
                meaning.empty() ? fmt::format("'{}' has no grid of stored views to audit", spec.name)
                                : fmt::format("'{}' has no grid of views of the whole figure to audit: its own is {}",
                                              spec.name, meaning),
                "audit " + names_of_those_with_views());
  }
  const int clip = character->placement.default_clip;
  const auto bank = std::make_shared<const scene::PoseBank>(*character, std::vector<int>{clip});

  const renderers::ViewSampling sampling = sample(spec, *character, bank);
  const renderers::ViewGrid& grid = sampling.grid;
  ViewAudit out;
  out.representation = spec.text();
  out.grid = grid.text();
  out.views = captured_views(grid);
  const renderers::ViewSteps steps = compute_view_steps(grid);
  out.step_deg_mean = steps.mean / kDegrees;
  out.step_deg_max = steps.largest / kDegrees;
  const renderers::ViewErrors errors = compute_view_errors(grid);
  out.error_deg_mean = errors.mean / kDegrees;
  out.error_deg_max = errors.largest / kDegrees;
  const double cycle = clip < 0 ? 0.0 : scene::cycle_seconds(*character, clip);
  out.frames = cycle > 0 ? sampling.frames : 1;
  out.pose_step_seconds = cycle > 0 ? cycle / sampling.frames : 0.0;
  out.pose_step_mm_mean = sampling.pose_step_mean * 1000;
  out.pose_step_mm_max = sampling.pose_step_largest * 1000;
  out.texel_mm = sampling.texel * 1000;
  out.bytes = sampling.texture_bytes;
  out.meets_limit = out.step_deg_max <= kSmoothViewStepDeg * (1 + 1e-9);
  const renderers::ViewGrid limit = out.meets_limit ? grid : grid_for_step(grid, kSmoothViewStepDeg * kDegrees);
  out.limit_grid = limit.text();
  out.limit_views = captured_views(limit);
  out.limit_bytes = out.meets_limit ? out.bytes : sample(with_view_grid(spec, limit), *character, bank).texture_bytes;

  QualitySetup setup;
  setup.character = character;
  setup.bake_budget = bake_budget;
  setup.use_cache = use_cache;
  QualityView view;
  view.clip = clip;
  view.time = clip < 0 ? 0.0 : character->clips[static_cast<size_t>(clip)].start;
  std::vector<QualityView> directions;
  for (int i = 0; i < kDirections; ++i) {
    view.azimuth_deg = std::fmod(i * 137.50776405, 360.0);
    view.elevation_deg = 2 + 38.0 * i / (kDirections - 1);
    directions.push_back(view);
  }
  // Stored views nearest to the horizon, evenly taken.
  std::vector<QualityView> stored;
  for (int i = 0; i < 12; ++i) {
    const double azimuth = i * 30 * kDegrees;
    const double low = grid.el_min;
    const renderers::ViewPick pick =
        grid.pick({std::sin(azimuth) * std::cos(low), std::sin(low), std::cos(azimuth) * std::cos(low)});
    const glm::dvec3 d = grid.basis(pick.view).to_eye;
    view.azimuth_deg = std::atan2(pick.mirrored ? -d.x : d.x, d.z) / kDegrees;
    view.elevation_deg = std::asin(std::clamp(d.y, -1.0, 1.0)) / kDegrees;
    stored.push_back(view);
  }

  std::vector<QualityView> late = directions;
  for (QualityView& v : late) v.time += out.pose_step_seconds / 2;
  std::vector<QualityView> orbit;
  view.elevation_deg = 12;
  for (int i = 0; i < 90; ++i) {
    view.azimuth_deg = i;
    orbit.push_back(view);
  }

  // One call, so that the views are baked or read once.
  for (const auto* views : {&directions, &late, &stored, &orbit})
    setup.views.insert(setup.views.end(), views->begin(), views->end());
  setup.representations = {spec.text()};
  const size_t first_of_orbit = setup.views.size() - orbit.size();
  std::vector<Image8> reference;
  std::vector<Image8> test;
  std::vector<metrics::Mask> silhouettes;
  size_t seen = 0;
  const std::vector<QualityRow> rows =
      compute_quality(context, setup, [&](const QualityRow&, const QualityPictures& p) {
        if (seen++ < first_of_orbit) return;
        const metrics::Box box = middle(p.reference.colour);
        reference.push_back(metrics::crop(p.reference.colour, box));
        test.push_back(metrics::crop(p.test.colour, box));
        silhouettes.push_back(
            metrics::crop(metrics::union_of(metrics::mask_of(p.reference.ids), metrics::mask_of(p.test.ids)), box));
      });
  const std::span all(rows);
  out.between = mean_of(all.subspan(0, directions.size()));
  out.between_frames = mean_of(all.subspan(directions.size(), late.size()));
  out.stored = mean_of(all.subspan(directions.size() + late.size(), stored.size()));
  out.orbit_flicker = metrics::flicker(reference, test, silhouettes).value_or(0);

  if (grid.mirrored) {
    setup.representations = {unmirrored(spec, grid).text()};
    setup.views = directions;
    out.unmirrored = mean_of(compute_quality(context, setup));
  }
  return out;
}

}  // namespace crowdbench::bench
