#include "bench/experiments/pop_map.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/progress.h"
#include "core/statistics.h"
#include "metrics/ssim.h"
#include "renderers/gl/context.h"
#include "renderers/shaders/dither.shared.h"
#include "scene/crowd/crowd.h"

namespace crowdbench::bench {
namespace {

// mae over the union; ssim_union over the crop around it, as metrics::score_figure has them.
PopScore score(const Image8& a, const Image8& b, const metrics::Mask& either) {
  PopScore out;
  const auto box = metrics::crop_box(either, either);
  if (!box) return out;
  const metrics::Mask mask = metrics::crop(either, *box);
  const Image8 left = metrics::crop(a, *box);
  const Image8 right = metrics::crop(b, *box);
  if (const auto difference = metrics::difference(left, right, &mask)) out.mae = difference->mae;
  if (const auto map = metrics::ssim(metrics::luma601(left), metrics::luma601(right))) {
    double sum = 0;
    size_t count = 0;
    for (int y = 0; y < map->map.height; ++y)
      for (int x = 0; x < map->map.width; ++x)
        if (mask.at(x + metrics::kSsimRadius, y + metrics::kSsimRadius)[0] != 0) {
          sum += map->map.at(x, y)[0];
          ++count;
        }
    if (count > 0) out.ssim_union = sum / static_cast<double>(count);
  }
  return out;
}

PopScores score_switch(const renderers::Capture& from, const renderers::Capture& to, int fade) {
  const metrics::Mask either = metrics::union_of(metrics::mask_of(from.ids), metrics::mask_of(to.ids));
  PopScores out;
  out.cut = score(from.colour, to.colour, either);
  const std::vector<Image8> pictures = fade_pictures(from.colour, to.colour, fade);
  for (size_t i = 1; i < pictures.size(); ++i) {
    const PopScore step = score(pictures[i - 1], pictures[i], either);
    if (step.mae) out.fade_step.mae = std::max(out.fade_step.mae.value_or(0), *step.mae);
    if (step.ssim_union) out.fade_step.ssim_union = std::min(out.fade_step.ssim_union.value_or(1), *step.ssim_union);
  }
  return out;
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

std::optional<PopStatistic> summarise_pops(const std::vector<PopCell>& cells, PopMeasure measure, bool matched,
                                           bool fade) {
  std::vector<double> values;
  PopStatistic out;
  const bool high_is_bad = measure == PopMeasure::mae;
  for (size_t i = 0; i < cells.size(); ++i) {
    const PopScores& scores = matched ? cells[i].matched : cells[i].own;
    const PopScore& one = fade ? scores.fade_step : scores.cut;
    const std::optional<double>& value = high_is_bad ? one.mae : one.ssim_union;
    if (!value) continue;
    if (values.empty() || (high_is_bad ? *value > out.worst : *value < out.worst)) {
      out.worst = *value;
      out.worst_cell = i;
    }
    values.push_back(*value);
    out.mean += *value;
  }
  if (values.empty()) return std::nullopt;
  out.mean /= static_cast<double>(values.size());
  out.tail = quantile(values, high_is_bad ? 0.95 : 0.05);
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
  const auto mesh = renderers::make_representation(make, renderers::parse_spec("mesh"));
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
          frame.camera = quality_camera({size.height_px, azimuth, elevation, request.clip, 0}, centre, height, side);
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
          cell.own = score_switch(pictures.mesh, pictures.impostor, request.fade);
          cell.matched = score_switch(pictures.matched, pictures.impostor, request.fade);
          if (seen) seen(cell, pictures);
          cells.push_back(cell);
        }
  return cells;
}

}  // namespace crowdbench::bench
