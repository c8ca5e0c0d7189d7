#include "bench/experiments/quality.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>

#include "core/error.h"
#include "core/progress.h"
#include "scene/crowd/crowd.h"
#include "scene/pose/pose.h"

namespace crowdbench::bench {
namespace {

constexpr double kFieldOfView = 30 * std::numbers::pi / 180;

scene::Cast cast_of(const std::shared_ptr<const scene::Character>& character, scene::PoseBank bank) {
  scene::Cast cast;
  cast.characters = {character};
  cast.banks = {std::make_shared<const scene::PoseBank>(std::move(bank))};
  cast.shares = {1.0};
  return cast;
}

// A cast with a representation of it, and a renderer: what draws one side of the comparison.
struct Side {
  scene::Cast cast;
  std::unique_ptr<renderers::Renderer> renderer;
  std::unique_ptr<renderers::Representation> representation;

  Side(gl::Context& context, const QualitySetup& setup, scene::Cast cast_, const renderers::Spec& spec)
      : cast(std::move(cast_)), renderer(std::make_unique<renderers::Renderer>(context, cast)) {
    renderers::MakeContext make{.context = context, .cast = cast};
    make.bake_budget = setup.bake_budget;
    make.use_cache = setup.use_cache;
    representation = renderers::make_representation(make, spec);
  }
  renderers::Capture capture(scene::Frame frame, double phase) {
    frame.agents[0][0].pose = cast.banks[0]->sample(0, phase);
    frame.agents[0][0].phase = static_cast<float>(phase);
    return renderer->capture(frame, *representation);
  }
};

QualityCauses causes_of(const QualityPictures& pictures, double height) {
  const renderers::Capture& mesh = pictures.reference;
  const renderers::Capture& test = pictures.test;
  enum Kind { silhouette, surface, shading };
  const auto without = [&](Kind wanted) {
    Image8 mended = test.colour;
    for (int y = 0; y < mended.height; ++y) {
      for (int x = 0; x < mended.width; ++x) {
        const bool in_mesh = *mesh.ids.at(x, y) != 0;
        const bool in_test = *test.ids.at(x, y) != 0;
        if (!in_mesh && !in_test) continue;
        const double gap =
            std::abs(static_cast<double>(*mesh.depth.at(x, y)) - static_cast<double>(*test.depth.at(x, y)));
        const Kind kind = in_mesh != in_test ? silhouette : gap > 0.01 * height ? surface : shading;
        if (kind == wanted) std::copy_n(mesh.colour.at(x, y), mended.channels, mended.at(x, y));
      }
    }
    return metrics::score_figure(mesh.colour, mended, metrics::mask_of(mesh.ids), metrics::mask_of(test.ids)).ssim;
  };
  return {without(silhouette), without(surface), without(shading)};
}

}  // namespace

QualitySize quality_size(const QualitySetup& setup, double height_px) {
  const int rows = std::max(setup.rows, 2 * static_cast<int>(std::ceil(0.75 * height_px)));
  return {rows * 4 / 3, rows};
}

scene::Camera quality_camera(const QualityView& view, const glm::dvec3& centre, double height, int rows) {
  const double azimuth = view.azimuth_deg * std::numbers::pi / 180;
  const double elevation = view.elevation_deg * std::numbers::pi / 180;
  const double distance = height * rows / (view.height_px * 2 * std::tan(kFieldOfView / 2));
  const double sa = std::sin(azimuth);
  const double ca = std::cos(azimuth);
  const double se = std::sin(elevation);
  const double ce = std::cos(elevation);
  scene::Camera camera;
  camera.target = centre;
  camera.eye = centre + distance * glm::dvec3(sa * ce, se, ca * ce);
  // The direction in which elevation grows: upright, and defined straight above too.
  camera.up = {-sa * se, ce, -ca * se};
  camera.fov_y = kFieldOfView;
  camera.near = std::min(0.1, distance / 100);
  return camera;
}

std::vector<QualityRow> compute_quality(gl::Context& context, const QualitySetup& setup,
                                        const std::function<void(const QualityRow&, const QualityPictures&)>& seen) {
  const scene::Character& character = *setup.character;
  std::vector<renderers::Spec> specs;
  for (const std::string& text : setup.representations) specs.push_back(renderers::parse_spec(text));

  // The reference does not depend on the representation, so every view of it is drawn once.
  const renderers::Spec mesh = renderers::parse_spec("mesh");
  std::map<std::pair<int, double>, Side> exact_mesh;
  std::map<int, scene::PoseBank> banks;
  std::vector<QualityRow> rows;
  std::vector<renderers::Capture> references(setup.views.size());
  for (size_t s = 0; s < specs.size(); ++s) {
    std::map<std::pair<int, double>, Side> sides;
    for (size_t v = 0; v < setup.views.size(); ++v) {
      throw_if_interrupted();
      const QualityView& view = setup.views[v];
      const std::pair<int, double> moment(view.clip, view.time);
      auto reference = exact_mesh.find(moment);
      if (reference == exact_mesh.end())
        reference =
            exact_mesh
                .emplace(std::piecewise_construct, std::forward_as_tuple(moment),
                         std::forward_as_tuple(
                             context, setup,
                             cast_of(setup.character, scene::PoseBank::exact(character, view.clip, view.time)), mesh))
                .first;
      auto bank = banks.find(view.clip);
      if (bank == banks.end())
        bank = banks.emplace(view.clip, scene::PoseBank(character, {view.clip}, setup.pose_rate)).first;
      const std::pair<int, double> key(view.clip, setup.exact_pose ? view.time : 0.0);
      auto side = sides.find(key);
      if (side == sides.end())
        side = sides
                   .emplace(std::piecewise_construct, std::forward_as_tuple(key),
                            std::forward_as_tuple(
                                context, setup,
                                setup.exact_pose ? reference->second.cast : cast_of(setup.character, bank->second),
                                specs[s]))
                   .first;

      QualityRow row;
      row.representation = specs[s].text();
      row.view = view;
      row.phase = view.clip < 0 ? 0.0 : scene::phase_of_time(character, view.clip, view.time);
      const QualitySize size = quality_size(setup, view.height_px);
      const glm::dvec3 centre = 0.5 * (glm::dvec3(bank->second.bounds_min()) + glm::dvec3(bank->second.bounds_max()));
      const double height = character.placement.height > 0 ? character.placement.height
                                                           : bank->second.bounds_max().y - bank->second.bounds_min().y;
      scene::Frame frame;
      frame.camera = quality_camera(view, centre, height, size.height);
      frame.origin = frame.camera.eye;
      frame.width = size.width;
      frame.height = size.height;
      frame.outfits.resize(1);
      for (glm::vec4& colour : frame.outfits[0].colours) colour = glm::vec4(1.0F);
      frame.agents.resize(1);
      scene::FrameAgent agent;
      agent.position = glm::vec3(-frame.origin);
      frame.agents[0] = {agent};
      row.distance = glm::distance(frame.camera.eye, centre);

      QualityPictures pictures;
      if (references[v].colour.empty()) references[v] = reference->second.capture(frame, row.phase);
      if (s + 1 == specs.size())
        pictures.reference = std::move(references[v]);  // nobody will ask again
      else
        pictures.reference = references[v];
      pictures.test = side->second.capture(frame, row.phase);
      row.scores = metrics::score_figure(pictures.reference.colour, pictures.test.colour,
                                         metrics::mask_of(pictures.reference.ids), metrics::mask_of(pictures.test.ids));
      if (setup.causes) row.causes = causes_of(pictures, height);
      if (seen) seen(row, pictures);
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

std::vector<double> parse_numbers(const std::string& text, const std::string& option, double low, double high) {
  constexpr size_t kMost = 10'000;
  const auto bad = [&](const std::string& wrong) {
    return Error(option, fmt::format("'{}' {}", printable(text, 80), wrong), "write 30, 30,60,120 or first:last:step");
  };
  std::vector<double> values;
  std::string_view rest = text;
  const auto number = [&](std::string_view digits) {
    double value = 0;
    const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (fault != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value))
      throw bad("is no list of numbers");
    return value;
  };
  while (true) {
    const size_t comma = rest.find(',');
    std::string_view item = rest.substr(0, comma);
    const size_t colon = item.find(':');
    if (colon == std::string_view::npos) {
      values.push_back(number(item));
    } else {
      const size_t second = item.find(':', colon + 1);
      if (second == std::string_view::npos) throw bad("is no range");
      const double first = number(item.substr(0, colon));
      const double last = number(item.substr(colon + 1, second - colon - 1));
      const double step = number(item.substr(second + 1));
      if (step == 0 || (last - first) / step < 0) throw bad("is a range that never ends");
      const double count = std::floor((last - first) / step + 1e-9);
      if (count >= static_cast<double>(kMost)) throw bad(fmt::format("has more than {} values", kMost));
      for (double i = 0; i <= count; ++i) values.push_back(first + i * step);
    }
    if (values.size() > kMost) throw bad(fmt::format("has more than {} values", kMost));
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  for (const double v : values)
    if (!(v >= low && v <= high)) throw bad(fmt::format("holds {}, the range is {} to {}", v, low, high));
  return values;
}

}  // namespace crowdbench::bench
