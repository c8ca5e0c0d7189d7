// Based on: Dobbyn, Hamill, O'Conor and O'Sullivan 2005, "Geopostors" (the pixel-to-texel ratio as the switch's rule).
// Differs from the source: its printed equations take an inverse tangent where the geometry needs a tangent, and the
// last of them is inverted; see switch_distance.h for ours, which pictures confirm.
#include "bench/experiments/switch_distance.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "core/error.h"
#include "core/progress.h"
#include "renderers/frame/capture.h"
#include "scene/crowd/crowd.h"

namespace crowdbench::bench {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr size_t kLeastPixels = 12;

// One agent on a stage of its own, drawn as texel coordinates.
class Probe {
 public:
  Probe(gl::Context& context, const SwitchRequest& request, const scene::Cast& cast)
      : request_(request), renderer_(context, cast), target_(context, request.width, request.height, kPass) {
    renderers::MakeContext make{.context = context, .cast = cast};
    make.bake_budget = request.bake_budget;
    make.use_cache = request.use_cache;
    representation_ = renderers::make_representation(make, request.representation);
    const scene::PoseBank& bank = *cast.banks[0];
    centre_ = 0.5 * request.scale * (glm::dvec3(bank.bounds_min()) + glm::dvec3(bank.bounds_max()));
    extent_ = request.scale * (glm::dvec3(bank.bounds_max()) - glm::dvec3(bank.bounds_min()));
    pose_ = bank.sample(0, 0.0);
    if (!(texel() > 0))
      throw Error(fmt::format("representation '{}'", request.representation.text()), "it has no texels",
                  "use " + renderers::default_impostor().text());
  }

  double texel() const { return representation_->texel_metres(0); }
  const glm::dvec3& extent() const { return extent_; }

  bool measures() const { return representation_->shows_texels(); }

  // Pixels a texel at the agent's middle, which lies at that eye-space depth.
  std::optional<TexelFootprint> footprint(double depth) {
    const double azimuth = request_.azimuth_deg * kRadians;
    const double elevation = request_.elevation_deg * kRadians;
    const double off = request_.off_axis_deg * kRadians;
    const glm::dvec3 to_eye(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                            std::cos(azimuth) * std::cos(elevation));
    scene::Frame frame;
    frame.width = request_.width;
    frame.height = request_.height;
    frame.camera.up = {-std::sin(azimuth) * std::sin(elevation), std::cos(elevation),
                       -std::cos(azimuth) * std::sin(elevation)};
    frame.camera.eye = centre_ + depth / std::cos(off) * to_eye;
    // Turned to the left, so that the agent stands to the right.
    const glm::dvec3 forward = glm::dmat3(glm::rotate(glm::dmat4(1.0), off, frame.camera.up)) * -to_eye;
    frame.camera.target = frame.camera.eye + forward;
    frame.camera.fov_y = request_.fov_y_deg * kRadians;
    frame.camera.near = 1e-3;
    frame.origin = frame.camera.eye;
    frame.outfits.resize(1);
    for (glm::vec4& colour : frame.outfits[0].colours) colour = glm::vec4(1.0F);
    scene::FrameAgent agent;
    agent.position = glm::vec3(-frame.origin);
    agent.scale = static_cast<float>(request_.scale);
    agent.pose = pose_;
    frame.agents = {{agent}};
    renderer_.draw(frame, *representation_, target_);
    const renderers::Capture drawn = target_.read();
    const double pixels = request_.height / (2 * std::tan(frame.camera.fov_y / 2));  // of a metre at depth 1
    const double radius = std::max(3.0, 0.15 * extent_.y * pixels / depth);
    return fit_texel_footprint(drawn.linear, drawn.ids, request_.width / 2.0 + pixels * std::tan(off),
                               request_.height / 2.0, radius);
  }

 private:
  static constexpr renderers::Pass kPass{.ids = true, .linear = true, .texels = true};
  const SwitchRequest& request_;
  renderers::Renderer renderer_;
  renderers::Target target_;
  std::unique_ptr<renderers::Representation> representation_;
  glm::dvec3 centre_{0.0}, extent_{0.0};
  scene::PoseSample pose_;
};

}  // namespace

double derive_switch_depth(double ratio, double texel, int rows, double fov_y) {
  return texel * rows / (2 * ratio * std::tan(fov_y / 2));
}

EngineSizes engine_sizes(const glm::dvec3& bounds, double distance, double fov_y, double aspect) {
  const double tangent = std::tan(fov_y / 2);
  EngineSizes sizes;
  sizes.unity_height = std::max({bounds.x, bounds.y, bounds.z}) / (2 * distance * tangent);
  sizes.unreal_size = std::max(1 / (aspect * tangent), 1 / tangent) * glm::length(bounds) / 2 / distance;
  sizes.godot_metres = distance;
  return sizes;
}

std::optional<TexelFootprint> fit_texel_footprint(const ImageF& texels, const ImageU32& ids, double x, double y,
                                                  double radius) {
  const auto limit = [](double v, int side) { return std::clamp(static_cast<int>(std::floor(v)), 0, side); };
  const int x0 = limit(x - radius, ids.width);
  const int x1 = limit(x + radius + 1, ids.width);
  const int y0 = limit(y - radius, ids.height);
  const int y1 = limit(y + radius + 1, ids.height);
  struct Sample {
    double x, y, u, v;
  };
  std::vector<Sample> samples;
  Sample mean{0, 0, 0, 0};
  for (int j = y0; j < y1; ++j)
    for (int i = x0; i < x1; ++i) {
      if (ids.at(i, j)[0] == 0 || std::hypot(i + 0.5 - x, j + 0.5 - y) > radius) continue;
      const float* texel = texels.at(i, j);
      samples.push_back({i + 0.5, j + 0.5, static_cast<double>(texel[0]), static_cast<double>(texel[1])});
      mean.x += samples.back().x;
      mean.y += samples.back().y;
      mean.u += samples.back().u;
      mean.v += samples.back().v;
    }
  if (samples.size() < kLeastPixels) return std::nullopt;
  const auto n = static_cast<double>(samples.size());
  double xx = 0;
  double xy = 0;
  double yy = 0;
  glm::dvec2 with_x(0.0);
  glm::dvec2 with_y(0.0);
  for (const Sample& s : samples) {
    const double dx = s.x - mean.x / n;
    const double dy = s.y - mean.y / n;
    const glm::dvec2 d(s.u - mean.u / n, s.v - mean.v / n);
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
    with_x += dx * d;
    with_y += dy * d;
  }
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > 1e-6 * xx * yy)) return std::nullopt;
  const double along_x = glm::length((yy * with_x - xy * with_y) / determinant);  // texels a pixel
  const double along_y = glm::length((xx * with_y - xy * with_x) / determinant);
  if (!(along_x > 0 && along_y > 0)) return std::nullopt;
  return TexelFootprint{1 / along_x, 1 / along_y};
}

SwitchReport measure_switch_distance(gl::Context& context, const SwitchRequest& request) {
  const double fov = request.fov_y_deg * kRadians;
  const double aspect = static_cast<double>(request.width) / request.height;
  const double off = request.off_axis_deg * kRadians;
  if (std::tan(off) > std::tan(fov / 2) * aspect)
    throw Error("--off-axis-deg",
                fmt::format("{} degrees lie outside a picture that reaches {:.1f}", request.off_axis_deg,
                            std::atan(std::tan(fov / 2) * aspect) / kRadians),
                "give less, or a wider field of view");
  scene::Cast cast;
  cast.characters = {request.character};
  cast.banks = {std::make_shared<const scene::PoseBank>(*request.character, std::vector<int>{request.clip})};
  cast.shares = {1.0};
  Probe probe(context, request, cast);

  SwitchReport report;
  report.texel = probe.texel();
  report.measured = probe.measures();
  report.height =
      request.character->placement.height > 0 ? request.character->placement.height : probe.extent().y / request.scale;
  for (const double ratio : request.ratios) {
    SwitchRow row;
    row.ratio = ratio;
    row.depth = derive_switch_depth(ratio, report.texel * request.scale, request.height, fov);
    row.distance = row.depth / std::cos(off);
    row.height_px = report.height * request.scale * request.height / (2 * row.depth * std::tan(fov / 2));
    row.stretch = 1 / std::cos(off);
    row.engines = engine_sizes(probe.extent(), row.distance, fov, aspect);
    // From a place that the derivation has no part in; a footprint falls with the depth, nearly as its inverse.
    double depth = 8 * glm::length(probe.extent());
    constexpr int kMostPictures = 12;
    constexpr double kClose = 1e-4;
    for (int i = 0; i < kMostPictures && probe.measures(); ++i) {
      throw_if_interrupted();
      const std::optional<TexelFootprint> found = probe.footprint(depth);
      if (!found) break;
      const double step = found->across_y / ratio;
      if (std::abs(step - 1) < kClose) {
        row.measured_depth = depth * step;
        row.measured_stretch = found->across_x / found->across_y;
        break;
      }
      depth *= step;
    }
    report.rows.push_back(row);
  }
  return report;
}

}  // namespace crowdbench::bench
