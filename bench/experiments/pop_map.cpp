#include "bench/experiments/pop_map.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/progress.h"
#include "core/statistics.h"
#include "metrics/silhouette.h"
#include "renderers/gl/context.h"
#include "renderers/shaders/dither.shared.h"
#include "scene/crowd/crowd.h"

namespace crowdbench::bench {
namespace {

using Scores = std::vector<const metrics::Score*>;
using Values = std::vector<std::optional<double>>;

// Over the crop around the region, as metrics::score_figure has them.
Values score(const Scores& scores, const Image8& a, const Image8& b, const metrics::Mask& either,
             const metrics::ChosenDisplay& display) {
  Values values(scores.size());
  const auto box = metrics::crop_box(either, either);
  if (!box) return values;
  const metrics::Mask region = metrics::crop(either, *box);
  const Image8 left = metrics::crop(a, *box);
  const Image8 right = metrics::crop(b, *box);
  metrics::ScoreInput input;
  input.reference.codes = &left;
  input.test.codes = &right;
  input.region = &region;
  metrics::look_at(display, input);
  metrics::Shared shared;
  const auto scored = metrics::score_pictures(scores, input, shared);
  for (size_t i = 0; i < values.size(); ++i) values[i] = scored[i].result.value;
  return values;
}

PopScores score_switch(const Scores& scores, const renderers::Capture& from, const renderers::Capture& to,
                       const PopRequest& request) {
  const metrics::Mask either = metrics::union_of(metrics::mask_of(from.ids), metrics::mask_of(to.ids));
  PopScores out;
  out.cut = score(scores, from.colour, to.colour, either, request.display);
  out.fade_step.resize(scores.size());
  const std::vector<Image8> pictures = fade_pictures(from.colour, to.colour, request.fade);
  for (size_t i = 1; i < pictures.size(); ++i) {
    const Values step = score(scores, pictures[i - 1], pictures[i], either, request.display);
    for (size_t s = 0; s < scores.size(); ++s)
      if (step[s] && (!out.fade_step[s] || metrics::is_worse(*scores[s], *step[s], *out.fade_step[s])))
        out.fade_step[s] = step[s];
  }
  return out;
}

// The quantile of values of which some may be infinite: what lies between a finite value and infinity is infinite.
double quantile_with_infinity(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  if (std::isfinite(values.front()) && std::isfinite(values.back())) return quantile(values, q);
  const double position = q * static_cast<double>(values.size() - 1);
  const double low = values[static_cast<size_t>(std::floor(position))];
  const double high = values[static_cast<size_t>(std::ceil(position))];
  if (low == high || std::isinf(low)) return low;
  return std::isinf(high) ? high : low + (position - std::floor(position)) * (high - low);
}

}  // namespace

std::vector<Image8> fade_pictures(const Image8& a, const Image8& b, int fade) {
  std::vector<Image8> out;
  for (int step = 0; step <= fade + 1; ++step) {
    const double share = static_cast<double>(step) / (fade + 1);
    Image8 mixed = a;
    for (int y = 0; y < a.height; ++y)
      for (int x = 0; x < a.width; ++x) {
        const auto rank = renderers::dither_rank(static_cast<unsigned>(x), static_cast<unsigned>(a.height - 1 - y));
        if ((rank + 0.5) / CB_DITHER_RANKS < share) std::copy_n(b.at(x, y), b.channels, mixed.at(x, y));
      }
    out.push_back(std::move(mixed));
  }
  return out;
}

std::vector<const metrics::Score*> pop_scores(metrics::ScoreTable table) {
  std::vector<const metrics::Score*> out;
  for (const metrics::Score* score : table)
    if (score->compute &&
        (score->needs & ~(metrics::kNeedsCodes | metrics::kNeedsRegion | metrics::kNeedsDisplay)) == 0)
      out.push_back(score);
  return out;
}

std::vector<const metrics::Score*> usual_pop_scores(metrics::ScoreTable table) {
  std::vector<const metrics::Score*> out = pop_scores(table);
  std::erase_if(out, [](const metrics::Score* score) {
    return score->scope != metrics::Scope::region && (score->uses & metrics::kInTables) == 0;
  });
  return out;
}

const char* tail_name(const metrics::Score& score) {
  return score.direction == metrics::Direction::lower_is_better ? "p95" : "p05";
}

std::optional<PopStatistic> summarise_pops(const std::vector<PopCell>& cells, const metrics::Score& score, size_t place,
                                           bool matched, bool fade) {
  std::vector<double> values;
  PopStatistic out;
  for (size_t i = 0; i < cells.size(); ++i) {
    const PopScores& scores = matched ? cells[i].matched : cells[i].own;
    const Values& of_kind = fade ? scores.fade_step : scores.cut;
    if (place >= of_kind.size() || !of_kind[place]) continue;
    const double value = *of_kind[place];
    if (values.empty() || metrics::is_worse(score, value, out.worst)) {
      out.worst = value;
      out.worst_cell = i;
    }
    values.push_back(value);
    out.mean += value;
  }
  if (values.empty()) return std::nullopt;
  out.mean /= static_cast<double>(values.size());
  out.tail = quantile_with_infinity(values, score.direction == metrics::Direction::lower_is_better ? 0.95 : 0.05);
  return out;
}

std::vector<PopCell> compute_pop_map(gl::Context& context, const PopRequest& request,
                                     const std::function<void(const PopCell&, const PopPictures&)>& seen) {
  scene::Cast cast;
  cast.characters = {request.character};
  cast.banks = {
      std::make_shared<const scene::PoseBank>(*request.character, std::vector<int>{request.clip}, request.pose_rate)};
  cast.shares = {1.0};
  const scene::PoseBank& bank = *cast.banks[0];
  renderers::MakeContext make{.context = context, .cast = cast};
  make.bake_budget = request.bake_budget;
  make.use_cache = request.use_cache;
  const auto mesh = renderers::make_representation(make, renderers::reference_spec());
  const auto impostor = renderers::make_representation(make, request.representation);
  renderers::Renderer renderer(context, cast);

  const double own_height = request.character->placement.height;
  const double height = own_height > 0 ? own_height : static_cast<double>(bank.bounds_max().y - bank.bounds_min().y);
  const double texel = impostor->texel_metres(0);
  struct Size {
    double ratio, height_px;
  };
  std::vector<Size> sizes;
  for (const double px : request.heights_px) sizes.push_back({px * texel / height, px});
  if (sizes.empty()) {
    if (!(texel > 0))
      throw Error(fmt::format("representation '{}'", request.representation.text()), "it has no texels to go by",
                  "give --height-px instead of --ratio");
    for (const double ratio : request.ratios) sizes.push_back({ratio, ratio * height / texel});
  }

  const glm::dvec3 centre = 0.5 * (glm::dvec3(bank.bounds_min()) + glm::dvec3(bank.bounds_max()));
  const Scores scores = pop_scores(request.table);
  std::vector<PopCell> cells;
  for (const Size& size : sizes)
    for (const double elevation : request.elevations_deg)
      for (const double azimuth : request.azimuths_deg)
        for (const double phase : request.phases) {
          throw_if_interrupted();
          PopCell cell{azimuth,    elevation,      phase, impostor->shown_phase(0, 0, phase),
                       size.ratio, size.height_px, {},    {}};
          // The picture holds the figure from every side, and no more.
          const int side = std::max(32, 2 * static_cast<int>(std::ceil(0.75 * size.height_px)));
          scene::Frame frame;
          frame.width = side;
          frame.height = side;
          frame.antialiasing = request.antialiasing;
          const QualityView view{size.height_px, azimuth, elevation, request.clip, 0};
          frame.camera = quality_camera(view, centre, distance_of_height(view, height, side));
          frame.origin = frame.camera.eye;
          frame.outfits.resize(1);
          for (glm::vec4& colour : frame.outfits[0].colours) colour = glm::vec4(1.0F);
          scene::FrameAgent agent;
          agent.position = glm::vec3(-frame.origin);
          const auto at = [&](double p) {
            agent.phase = static_cast<float>(p);
            agent.pose = bank.sample(0, p);
            frame.agents = {{agent}};
            return frame;
          };
          PopPictures pictures;
          pictures.mesh = renderer.capture(at(phase), *mesh);
          pictures.matched = renderer.capture(at(cell.shown_phase), *mesh);
          pictures.impostor = renderer.capture(at(phase), *impostor);
          cell.own = score_switch(scores, pictures.mesh, pictures.impostor, request);
          cell.matched = score_switch(scores, pictures.matched, pictures.impostor, request);
          if (seen) seen(cell, pictures);
          cells.push_back(cell);
        }
  return cells;
}

}  // namespace crowdbench::bench
