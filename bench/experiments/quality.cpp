#include "bench/experiments/quality.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>

#include "bench/experiments/cause_chain.h"
#include "bench/experiments/score_rows.h"
#include "bench/stage/truth_capture.h"
#include "core/error.h"
#include "core/progress.h"
#include "metrics/picture_causes.h"
#include "scene/character/cut_out.h"
#include "scene/crowd/crowd.h"
#include "scene/pose/hidden.h"
#include "scene/pose/pose.h"

namespace crowdbench::bench {
namespace {

double field_of_view(const QualityView& view) { return view.fov_y_deg * std::numbers::pi / 180; }

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
  scene::Frame posed(scene::Frame frame, double phase) const {
    frame.agents[0][0].pose = cast.banks[0]->sample(0, phase);
    frame.agents[0][0].phase = static_cast<float>(phase);
    return frame;
  }
  renderers::Capture capture(const scene::Frame& frame, double phase) {
    return renderer->capture(posed(frame, phase), *representation);
  }
  Drawer drawer(gl::Context& context) const { return {context, cast, *renderer, *representation}; }
};

enum class Wrong { silhouette, surface, shading };

// The test's picture with the pixels of one kind taken from the mesh's.
Image8 mended(const QualityPictures& pictures, double height, Wrong wanted) {
  const renderers::Capture& mesh = pictures.reference;
  const renderers::Capture& test = pictures.test;
  Image8 out = test.colour;
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const bool in_mesh = *mesh.ids.at(x, y) != 0;
      const bool in_test = *test.ids.at(x, y) != 0;
      if (!in_mesh && !in_test) continue;
      const double gap =
          std::abs(static_cast<double>(*mesh.depth.at(x, y)) - static_cast<double>(*test.depth.at(x, y)));
      const Wrong kind = in_mesh != in_test ? Wrong::silhouette : gap > 0.01 * height ? Wrong::surface : Wrong::shading;
      if (kind == wanted) std::copy_n(mesh.colour.at(x, y), out.channels, out.at(x, y));
    }
  }
  return out;
}

QualityCauses causes_of(const QualityPictures& pictures, double height, metrics::ScoreTable table,
                        const metrics::ChosenDisplay& display) {
  const metrics::Score* score = metrics::score_by_cause(table);
  if (!score) return {};
  const auto without = [&](Wrong kind) {
    const Image8 picture = mended(pictures, height, kind);
    metrics::Buffers test = buffers_of(pictures.test);
    test.codes = &picture;
    return metrics::score_figure({&score, 1}, buffers_of(pictures.reference), test, {&display}).value(score->name);
  };
  return {without(Wrong::silhouette), without(Wrong::surface), without(Wrong::shading)};
}

// What the scores of a figure may ask for.
constexpr metrics::Needs kOffered =
    metrics::kNeedsCodes | metrics::kNeedsIds | metrics::kNeedsDepth | metrics::kNeedsRegion | metrics::kNeedsDisplay;

// All of one call: what the views have in common is made once.
class Comparison {
 public:
  Comparison(gl::Context& context, const QualitySetup& setup)
      : context_(context), setup_(setup), references_(setup.views.size()) {
    for (const QualityView& view : setup.views) ++views_left_[{view.clip, view.time}];
  }

  // Every view of one representation. Where it is refused, the rows from there on say why, and the Error is kept.
  void run(size_t index, const std::function<void(const QualityRow&, const QualityPictures&)>& seen) {
    std::string text = setup_.representations[index];
    std::map<std::pair<int, double>, Side> sides;
    std::string refused;
    std::optional<renderers::Spec> spec;
    const auto attempt = [&](const auto& step) {
      if (!refused.empty()) return;
      try {
        step();
      } catch (const Error& error) {
        refused = error.what();
        if (!refused_) refused_ = error;
      }
    };
    attempt([&] {
      spec = renderers::parse_spec(text);
      if (!setup_.debug.empty()) renderers::set_debug_view(*spec, setup_.debug);
      text = spec->text();
    });
    for (size_t v = 0; v < setup_.views.size(); ++v) {
      throw_if_interrupted();
      QualityRow row = described(v);
      row.index = index;
      row.representation = text;
      attempt([&] { draw_and_score(v, *spec, sides, index + 1 == setup_.representations.size(), row, seen); });
      row.refused = refused;
      if (refused.empty())
        any_drawn_ = true;
      else
        row.scores.scores = metrics::absent_scores(setup_.table, kOffered, refused);
      rows_.push_back(std::move(row));
    }
  }

  std::vector<QualityRow> finish() {
    if (!any_drawn_ && refused_) throw Error(*refused_);
    return std::move(rows_);
  }

 private:
  const scene::PoseBank& bank(int clip) {
    auto found = banks_.find(clip);
    if (found == banks_.end())
      found = banks_.emplace(clip, scene::PoseBank(*setup_.character, {clip}, setup_.pose_rate)).first;
    return found->second;
  }
  glm::dvec3 centre(const QualityView& view) {
    const scene::PoseBank& of = bank(view.clip);
    return 0.5 * (glm::dvec3(of.bounds_min()) + glm::dvec3(of.bounds_max()));
  }
  double height(const QualityView& view) {
    const double own = setup_.character->placement.height;
    return own > 0 ? own : bank(view.clip).bounds_max().y - bank(view.clip).bounds_min().y;
  }
  // One for all moments of a clip, so that a figure in motion is seen by a camera that stands.
  double distance(const QualityView& view) {
    const int rows = quality_size(setup_, view.height_px).height;
    auto posed = first_poses_.find(view.clip);
    if (posed == first_poses_.end()) {
      const auto palette = scene::model_matrices(*setup_.character, view.clip, 0.0);
      scene::DrawnExtent extent(*setup_.character);
      posed =
          first_poses_.emplace(view.clip, extent.outer_points(scene::shown_positions(setup_.character->mesh, palette)))
              .first;
    }
    const std::tuple key(view.clip, view.azimuth_deg, view.height_px, view.fov_y_deg);
    const auto [found, fresh] = distances_.try_emplace(key);
    if (fresh) found->second = distance_of_figure(view, centre(view), posed->second, rows);
    return found->second;
  }
  // The mesh at the exact time.
  Side& exact_mesh(int clip, double time) {
    const std::pair<int, double> moment(clip, time);
    auto found = exact_mesh_.find(moment);
    if (found == exact_mesh_.end())
      found = exact_mesh_
                  .emplace(std::piecewise_construct, std::forward_as_tuple(moment),
                           std::forward_as_tuple(
                               context_, setup_,
                               cast_of(setup_.character, scene::PoseBank::exact(*setup_.character, clip, time)),
                               renderers::reference_spec()))
                  .first;
    return found->second;
  }

  QualityRow described(size_t v) {
    QualityRow row;
    row.view = setup_.views[v];
    row.phase = row.view.clip < 0 ? 0.0 : scene::phase_of_time(*setup_.character, row.view.clip, row.view.time);
    row.distance = distance(row.view);
    if (setup_.truth) row.reference = kTruthName;
    return row;
  }

  // One figure at the origin, seen from the view.
  scene::Frame frame_of(const QualityView& view) {
    const QualitySize size = quality_size(setup_, view.height_px);
    scene::Frame frame;
    frame.camera = quality_camera(view, centre(view), distance(view));
    frame.origin = frame.camera.eye;
    frame.width = size.width;
    frame.height = size.height;
    frame.antialiasing = setup_.antialiasing;
    frame.outfits.resize(1);
    for (glm::vec4& colour : frame.outfits[0].colours) colour = glm::vec4(1.0F);
    frame.agents.resize(1);
    scene::FrameAgent agent;
    agent.position = glm::vec3(-frame.origin);
    frame.agents[0] = {agent};
    return frame;
  }

  void draw_and_score(size_t v, const renderers::Spec& spec, std::map<std::pair<int, double>, Side>& sides, bool last,
                      QualityRow& row, const std::function<void(const QualityRow&, const QualityPictures&)>& seen) {
    const QualityView& view = setup_.views[v];
    Side& mesh = exact_mesh(view.clip, view.time);
    const std::pair<int, double> key(view.clip, setup_.exact_pose ? view.time : 0.0);
    auto side = sides.find(key);
    if (side == sides.end())
      side = sides
                 .emplace(std::piecewise_construct, std::forward_as_tuple(key),
                          std::forward_as_tuple(
                              context_, setup_,
                              setup_.exact_pose ? mesh.cast : cast_of(setup_.character, bank(view.clip)), spec))
                 .first;
    const scene::Frame frame = frame_of(view);
    QualityPictures pictures;
    if (references_[v].colour.empty())
      references_[v] = setup_.truth ? capture_of(truth::cast_truth(mesh.cast, mesh.posed(frame, row.phase)))
                                    : mesh.capture(frame, row.phase);
    // After the last representation nobody will ask again.
    pictures.reference = last ? std::move(references_[v]) : references_[v];
    pictures.test = side->second.capture(frame, row.phase);
    row.scores = metrics::score_figure(setup_.table, buffers_of(pictures.reference), buffers_of(pictures.test),
                                       {&setup_.display, setup_.maps});
    if (setup_.causes) {
      row.causes = causes_of(pictures, height(view), setup_.table, setup_.display);
      put_errors(view, spec, side->second, frame, row, pictures);
    } else if (setup_.read_causes) {
      row.errors = metrics::causes_of_pictures(
                       {pictures.reference.colour, pictures.test.colour, pictures.reference.ids, pictures.test.ids})
                       .errors;
    }
    if (seen) seen(row, pictures);
    for (metrics::Scored& one : row.scores.scores) one.result.map.reset();
    if (last && --views_left_.at({view.clip, view.time}) == 0) exact_mesh_.erase({view.clip, view.time});
  }

  // The mesh in the pose that the side shows: exactly, where that is a stored frame, else blended as its bank has it.
  // The phase is of the mesh's own bank.
  std::pair<Side*, double> shown_mesh(const QualityView& view, const Side& side, bool of_several, double phase) {
    if (setup_.exact_pose || view.clip < 0 || of_several) return {&exact_mesh(view.clip, view.time), phase};
    const double shown = side.representation->shown_phase(0, 0, phase);
    if (std::abs(shown - phase) < 1e-6) {
      if (side.cast.banks[0]->sample(0, phase).blend == 0.0F) return {&exact_mesh(view.clip, view.time), phase};
      return {&banked_mesh(view.clip), phase};
    }
    const scene::Clip& clip = setup_.character->clips[static_cast<size_t>(view.clip)];
    const double seconds = shown * scene::cycle_seconds(*setup_.character, view.clip);
    // What closes a loop is after the file's last key.
    if (seconds > clip.duration()) return {&banked_mesh(view.clip), shown};
    return {&exact_mesh(view.clip, clip.start + seconds), shown};
  }
  Side& banked_mesh(int clip) {
    auto found = banked_mesh_.find(clip);
    if (found == banked_mesh_.end())
      found = banked_mesh_
                  .emplace(std::piecewise_construct, std::forward_as_tuple(clip),
                           std::forward_as_tuple(context_, setup_, cast_of(setup_.character, bank(clip)),
                                                 renderers::reference_spec()))
                  .first;
    return found->second;
  }
  void put_errors(const QualityView& view, const renderers::Spec& spec, Side& side, const scene::Frame& frame,
                  QualityRow& row, QualityPictures& pictures) {
    auto stored = stored_.find({spec.text(), view.clip});
    if (stored == stored_.end())
      stored = stored_.emplace(std::pair(spec.text(), view.clip), stored_by(spec, side.cast)).first;
    scene::Frame sharp = frame;  // causes are told apart by what one sample a pixel shows
    sharp.antialiasing = {};
    const bool same = frame.antialiasing == sharp.antialiasing;
    std::optional<renderers::Capture> anew;
    const renderers::Capture& reference =
        same ? pictures.reference : anew.emplace(exact_mesh(view.clip, view.time).capture(sharp, row.phase));
    const auto [mesh, phase] = shown_mesh(view, side, stored->second.of_several, row.phase);
    const scene::Frame posed = mesh->posed(sharp, phase);
    const scene::Frame shown = side.posed(sharp, row.phase);
    CausePictures drawn = draw_causes({reference, posed, shown, height(view)}, mesh->drawer(context_),
                                      side.drawer(context_), stored->second);
    row.errors = std::move(drawn.errors);
    pictures.steps = std::move(drawn.steps);
  }

  gl::Context& context_;
  const QualitySetup& setup_;
  std::map<std::pair<int, double>, Side> exact_mesh_;    // moments that views of the last representation still ask for
  std::map<std::pair<int, double>, size_t> views_left_;  // of the last representation, by clip and time
  std::map<int, Side> banked_mesh_;                      // by clip
  std::map<std::pair<std::string, int>, StoredWhat> stored_;  // by representation and clip
  std::map<int, scene::PoseBank> banks_;
  std::map<int, std::vector<glm::dvec3>> first_poses_;                   // by clip
  std::map<std::tuple<int, double, double, double>, double> distances_;  // by clip, azimuth, height and lens
  std::vector<renderers::Capture> references_;  // by view; the reference does not depend on the representation
  std::vector<QualityRow> rows_;
  std::optional<Error> refused_;  // the first
  bool any_drawn_ = false;
};

}  // namespace

QualitySize quality_size(const QualitySetup& setup, double height_px) {
  const int rows = std::max(setup.rows, 2 * static_cast<int>(std::ceil(0.75 * height_px)));
  return {rows * 4 / 3, rows};
}

double distance_of_height(const QualityView& view, double height, int rows) {
  return height * rows / (view.height_px * 2 * std::tan(field_of_view(view) / 2));
}

double distance_of_figure(const QualityView& view, const glm::dvec3& centre, std::span<const glm::dvec3> positions,
                          int rows) {
  const double azimuth = view.azimuth_deg * std::numbers::pi / 180;
  const glm::dvec3 towards(std::sin(azimuth), 0.0, std::cos(azimuth));
  double low = std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::lowest();
  double nearest = 0;  // above 0: before the centre
  for (const glm::dvec3& p : positions) {
    low = std::min(low, p.y);
    high = std::max(high, p.y);
    nearest = std::max(nearest, glm::dot(p - centre, towards));
  }
  if (!(high > low)) return distance_of_height(view, 1.0, rows);
  // Rows covered from a distance, over what is asked for; falls with the distance.
  const auto covered = [&](double distance) {
    double bottom = std::numeric_limits<double>::max();
    double top = std::numeric_limits<double>::lowest();
    for (const glm::dvec3& p : positions) {
      const double tangent = (p.y - centre.y) / (distance - glm::dot(p - centre, towards));
      bottom = std::min(bottom, tangent);
      top = std::max(top, tangent);
    }
    return (top - bottom) * rows / (view.height_px * 2 * std::tan(field_of_view(view) / 2));
  };
  // The eye stays before the figure.
  double distance = distance_of_height(view, high - low, rows);
  constexpr double kClose = 1.05;
  for (int i = 0; i < 40; ++i) {
    distance = std::max(distance, kClose * nearest);
    const double ratio = covered(distance);
    if (std::abs(ratio - 1) < 1e-9) break;
    distance = nearest + (distance - nearest) * ratio;
  }
  return std::max(distance, kClose * nearest);
}

scene::Camera quality_camera(const QualityView& view, const glm::dvec3& centre, double distance) {
  const double azimuth = view.azimuth_deg * std::numbers::pi / 180;
  const double elevation = view.elevation_deg * std::numbers::pi / 180;
  const double sa = std::sin(azimuth);
  const double ca = std::cos(azimuth);
  const double se = std::sin(elevation);
  const double ce = std::cos(elevation);
  scene::Camera camera;
  camera.target = centre;
  camera.eye = centre + distance * glm::dvec3(sa * ce, se, ca * ce);
  // The direction in which elevation grows: upright, and defined straight above too.
  camera.up = {-sa * se, ce, -ca * se};
  camera.fov_y = field_of_view(view);
  camera.near = std::min(0.1, distance / 100);
  return camera;
}

std::vector<QualityRow> compute_quality(gl::Context& context, const QualitySetup& setup,
                                        const std::function<void(const QualityRow&, const QualityPictures&)>& seen) {
  Comparison comparison(context, setup);
  for (size_t i = 0; i < setup.representations.size(); ++i) comparison.run(i, seen);
  return comparison.finish();
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
      throw bad("is not a list of numbers");
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
      if (second == std::string_view::npos) throw bad("is not a range");
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
