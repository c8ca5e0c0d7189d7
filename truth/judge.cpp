#include "truth/judge.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>

#include "core/progress.h"
#include "truth/posed_agent.h"
#include "truth/surface.h"
#include "truth/view.h"

namespace crowdbench::truth {
namespace {

constexpr int kRings = 4;
constexpr int kDirections = 32;
constexpr double kMaskReach = 1.0;      // pixels
constexpr double kWidest = 0.5;         // pixels: a bound beyond it says nothing
constexpr double kDepthBits = 0x1p-22;  // of a depth
constexpr size_t kOffenders = 64;
constexpr double kSmooth = 0.01;  // of the depth

struct Wrong {
  JudgedPixel pixel;
  double depth_tolerance = 0;  // metres
  bool explained = false;
};

// The bounds of agents by their id, computed when asked for.
class Bounds {
 public:
  Bounds(const scene::Cast& cast, const scene::Frame& frame) : cast_(cast), frame_(frame) {
    for (size_t c = 0; c < frame.agents.size(); ++c)
      for (size_t a = 0; a < frame.agents[c].size(); ++a) where_[frame.agents[c][a].id] = {c, a};
  }
  OutlineBound of(uint32_t id) {
    const auto at = where_.find(id);
    if (at == where_.end()) return {};
    const auto [found, fresh] = known_.try_emplace(id);
    if (fresh) found->second = outline_bound(cast_, frame_, at->second.first, at->second.second);
    return found->second;
  }

 private:
  const scene::Cast& cast_;
  const scene::Frame& frame_;
  std::map<uint32_t, std::pair<size_t, size_t>> where_;
  std::map<uint32_t, OutlineBound> known_;
};

std::vector<Wrong> find_wrong(const scene::Cast& cast, const scene::Frame& frame, const TruthPicture& truth,
                              const ImageU32& ids) {
  Bounds bounds(cast, frame);
  const View view(frame);
  std::vector<Wrong> out;
  Progress progress("comparing with the truth", static_cast<size_t>(ids.height));
  for (int y = 0; y < ids.height; ++y) {
    progress.advance();
    for (int x = 0; x < ids.width; ++x) {
      const uint32_t id = *ids.at(x, y);
      const uint32_t truth_id = *truth.ids.at(x, y);
      if (id == truth_id) continue;
      const OutlineBound a = bounds.of(id);
      const OutlineBound b = bounds.of(truth_id);
      const double depth = *truth.depth.at(x, y);
      Wrong wrong{{x, y, id, truth_id, std::max(a.pixels(), b.pixels())}, 0, false};
      if (std::isfinite(depth))
        wrong.depth_tolerance = depth * (kDepthBits + view.pixel() * (a.weights + a.single + b.weights + b.single));
      out.push_back(wrong);
    }
  }
  return out;
}

// Places on a circle round each pixel that is not yet explained.
std::vector<glm::dvec2> circles(const std::vector<Wrong>& wrong, const std::vector<double>& radii) {
  std::vector<glm::dvec2> out;
  for (const Wrong& one : wrong) {
    if (one.explained) continue;
    const glm::dvec2 centre(one.pixel.x + 0.5, one.pixel.y + 0.5);
    for (const double radius : radii) {
      const double r = radius > 0 ? radius : std::min(one.pixel.bound, kWidest) * -radius;
      for (int i = 0; i < kDirections; ++i) {
        const double angle = 2 * std::numbers::pi * (i + 0.5) / kDirections;
        out.push_back(centre + r * glm::dvec2(std::cos(angle), std::sin(angle)));
      }
    }
  }
  return out;
}

bool is_masked(const scene::Cast& cast, const TruthPoint& point) {
  return point.id != 0 && cast.characters[point.character]->materials[point.material].alpha_cutoff > 0;
}

class Explainer {
 public:
  Explainer(const scene::Cast& cast, const scene::Frame& frame, const TruthOptions& options, std::vector<Wrong>& wrong)
      : cast_(cast), frame_(frame), options_(options), wrong_(wrong) {
    options_.shade = false;
  }

  void by_outline(Judgement& out) {
    std::vector<double> radii;  // below 0: of the bound
    for (int ring = 1; ring <= kRings; ++ring) radii.push_back(-static_cast<double>(ring) / kRings);
    const std::vector<TruthPoint> points = cast_points(cast_, frame_, circles(wrong_, radii), options_);
    size_t at = 0;
    for (Wrong& one : wrong_) {
      out.largest_bound = std::max(out.largest_bound, one.pixel.bound);
      const size_t begin = at;
      at += static_cast<size_t>(kRings) * kDirections;
      const auto first = points.begin() + static_cast<std::ptrdiff_t>(begin);
      const auto found = std::find_if(first, points.begin() + static_cast<std::ptrdiff_t>(at),
                                      [&](const TruthPoint& point) { return point.id == one.pixel.id; });
      if (found == points.begin() + static_cast<std::ptrdiff_t>(at)) continue;
      const std::ptrdiff_t ring = (found - first) / kDirections + 1;
      out.worst_distance =
          std::max(out.worst_distance, std::min(one.pixel.bound, kWidest) * static_cast<double>(ring) / kRings);
      one.explained = true;
      ++out.outline;
    }
  }

  void by_depth(Judgement& out, const TruthPicture& truth) {
    std::map<uint32_t, std::vector<Wrong*>> by_id;
    for (Wrong& one : wrong_)
      if (!one.explained) by_id[one.pixel.id].push_back(&one);
    const View view(frame_);
    for (const auto& [id, pixels] : by_id) {
      std::vector<glm::dvec2> places;
      for (const Wrong* one : pixels) places.emplace_back(one->pixel.x + 0.5, one->pixel.y + 0.5);
      std::vector<TruthPoint> points(places.size());
      if (id != 0)
        points = cast_points_at(cast_, frame_, id, places, options_);
      else
        for (size_t i = 0; i < places.size(); ++i)
          points[i].depth = ground_depth(frame_, view, view.direction(places[i])).value_or(points[i].depth);
      for (size_t i = 0; i < pixels.size(); ++i) {
        Wrong& one = *pixels[i];
        if (!(std::abs(points[i].depth - *truth.depth.at(one.pixel.x, one.pixel.y)) <= one.depth_tolerance)) continue;
        one.explained = true;
        ++out.depth;
      }
    }
  }

  void by_mask(Judgement& out) {
    const bool any = std::ranges::any_of(cast_.characters, [](const auto& character) {
      return std::ranges::any_of(character->materials, [](const auto& m) { return m.alpha_cutoff > 0; });
    });
    if (!any) return;
    std::vector<glm::dvec2> centres;
    for (const Wrong& one : wrong_)
      if (!one.explained) centres.emplace_back(one.pixel.x + 0.5, one.pixel.y + 0.5);
    const std::vector<TruthPoint> here = cast_points(cast_, frame_, centres, options_);
    const std::vector<double> radii = {0.25 * kMaskReach, 0.5 * kMaskReach, kMaskReach};
    const std::vector<TruthPoint> there = cast_points(cast_, frame_, circles(wrong_, radii), options_);
    const size_t each = radii.size() * kDirections;
    size_t at = 0;
    for (Wrong& one : wrong_) {
      if (one.explained) continue;
      const std::span<const TruthPoint> round = std::span(there).subspan(at * each, each);
      one.explained = std::ranges::any_of(round, [&](const TruthPoint& point) {
        return point.id == one.pixel.id && (is_masked(cast_, point) || is_masked(cast_, here[at]));
      });
      out.mask += one.explained ? 1U : 0U;
      ++at;
    }
  }

 private:
  const scene::Cast& cast_;
  const scene::Frame& frame_;
  TruthOptions options_;
  std::vector<Wrong>& wrong_;
};

// Whether a pixel and its neighbours show one agent in both, without a step in depth.
bool is_inner(const TruthPicture& truth, const ImageU32& ids, int x, int y) {
  const uint32_t id = *truth.ids.at(x, y);
  const double depth = *truth.depth.at(x, y);
  if (id == 0 || x == 0 || y == 0 || x + 1 == ids.width || y + 1 == ids.height) return false;
  for (int j = y - 1; j <= y + 1; ++j)
    for (int i = x - 1; i <= x + 1; ++i)
      if (*truth.ids.at(i, j) != id || *ids.at(i, j) != id || std::abs(*truth.depth.at(i, j) - depth) > kSmooth * depth)
        return false;
  return true;
}

void compare_inside(const TruthPicture& truth, const JudgedPicture& picture, Judgement& out) {
  const bool coloured = !picture.colour.empty() && !truth.colour.empty();
  double sum = 0;
  for (int y = 0; y < picture.ids.height; ++y)
    for (int x = 0; x < picture.ids.width; ++x) {
      if (!is_inner(truth, picture.ids, x, y)) continue;
      ++out.inner;
      const double depth = *truth.depth.at(x, y);
      if (!picture.depth.empty())
        out.worst_depth =
            std::max(out.worst_depth, std::abs(static_cast<double>(*picture.depth.at(x, y)) - depth) / depth);
      if (!coloured) continue;
      for (int c = 0; c < 3; ++c) {
        const int off = std::abs(int{picture.colour.at(x, y)[c]} - int{truth.colour.at(x, y)[c]});
        sum += off;
        if (off <= out.worst_colour) continue;
        out.worst_colour = off;
        out.worst_x = x;
        out.worst_y = y;
      }
    }
  if (out.inner > 0) out.mean_colour = sum / (3.0 * static_cast<double>(out.inner));
}

}  // namespace

OutlineBound outline_bound(const scene::Cast& cast, const scene::Frame& frame, size_t character, size_t agent) {
  const scene::Mesh& mesh = cast.characters[character]->mesh;
  const View view(frame);
  const AgentPose pose(*cast.characters[character], *cast.banks[character], frame.agents[character][agent]);
  glm::dvec3 low(std::numeric_limits<double>::infinity());
  glm::dvec3 high = -low;
  double nearest = low.x;
  double farthest = 0;
  double spread = 0;
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::dvec3 position = pose.position(v);
    low = glm::min(low, position);
    high = glm::max(high, position);
    nearest = std::min(nearest, view.depth(position));
    farthest = std::max(farthest, glm::length(position));
    spread = std::max(spread, pose.spread(v));
  }
  OutlineBound out;
  if (mesh.positions.empty()) return out;
  constexpr double kOperations = 24;
  const double pixel = view.pixel() * std::max(nearest, view.near());
  out.snap = std::numbers::sqrt2 / 256;
  out.weights = 2.0 / 65535 * spread / pixel;
  out.single = kOperations * 0x1p-24 * (farthest + glm::length(high - low)) / pixel;
  return out;
}

Judgement judge(const scene::Cast& cast, const scene::Frame& frame, const TruthPicture& truth,
                const JudgedPicture& picture, const TruthOptions& options) {
  assert(picture.ids.width == truth.ids.width && picture.ids.height == truth.ids.height);
  Judgement out;
  out.pixels = picture.ids.data.size();
  out.covered = static_cast<uint64_t>(std::ranges::count_if(truth.ids.data, [](uint32_t id) { return id != 0; }));
  std::vector<Wrong> wrong = find_wrong(cast, frame, truth, picture.ids);
  out.wrong = wrong.size();
  if (!wrong.empty()) {
    Explainer explainer(cast, frame, options, wrong);
    explainer.by_outline(out);
    explainer.by_depth(out, truth);
    explainer.by_mask(out);
  }
  for (const Wrong& one : wrong) {
    if (one.explained) continue;
    ++out.unexplained;
    if (out.offenders.size() < kOffenders) out.offenders.push_back(one.pixel);
  }
  compare_inside(truth, picture, out);
  return out;
}

}  // namespace crowdbench::truth
