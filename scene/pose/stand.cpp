#include "scene/pose/stand.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "scene/pose/hidden.h"
#include "scene/pose/human_bones.h"
#include "scene/pose/pose.h"

namespace crowdbench::scene {
namespace {

constexpr double kApart = 0.1;       // of the height: a root that stands farther from the body is not where it is
constexpr double kSoleBand = 0.05;   // of the height above the lowest point: these vertices can touch the ground
constexpr double kSameLevel = 0.01;  // of the height
constexpr size_t kStays = 6;         // one of so many equal stretches of a cycle
constexpr double kBoundsRate = 30.0;

// The node whose travel is the character's: the skin's root, or without a skin the first joint's topmost ancestor.
int travelling_node(const Skeleton& skeleton) {
  if (skeleton.root_node >= 0) return skeleton.root_node;
  if (skeleton.joints.empty()) return -1;
  int node = skeleton.joints.front().node;
  while (skeleton.nodes[static_cast<size_t>(node)].parent >= 0) node = skeleton.nodes[static_cast<size_t>(node)].parent;
  return node;
}

// By joint: what hangs on a hand. The hand itself may be a paw.
std::vector<bool> in_hands(const Skeleton& skeleton) {
  std::vector<bool> hand(skeleton.nodes.size(), false);
  for (const auto& [bone, node] : find_human_bones(skeleton, bone_candidates(skeleton)))
    if (bone.part == BonePart::hand) hand[static_cast<size_t>(node)] = true;
  std::vector<bool> out;
  for (const Joint& joint : skeleton.joints) {
    int up = skeleton.nodes[static_cast<size_t>(joint.node)].parent;
    while (up >= 0 && !hand[static_cast<size_t>(up)]) up = skeleton.nodes[static_cast<size_t>(up)].parent;
    out.push_back(up >= 0);
  }
  return out;
}

uint16_t strongest_joint(const Mesh& mesh, size_t v) {
  int best = 0;
  for (int i = 1; i < kInfluences; ++i)
    if (mesh.weights[v][i] > mesh.weights[v][best]) best = i;
  return mesh.joints[v][best];
}

// Of which a corner is drawn.
std::vector<bool> find_drawn(const Character& character) {
  const Mesh& mesh = character.mesh;
  std::vector<bool> drawn(mesh.positions.size(), false);
  for (const Primitive& p : mesh.primitives) {
    const CutOut cut_out(character, character.materials[static_cast<size_t>(p.material)]);
    for (size_t i = p.first_index; i + 2 < p.first_index + p.index_count; i += 3)
      for (int k = 0; k < 3; ++k) {
        TrianglePlace corner(0.0);
        corner[k] = 1;
        const uint32_t* t = &mesh.indices[i];
        if (!drawn[t[k]]) drawn[t[k]] = cut_out.there(t, corner);
      }
  }
  return drawn;
}

std::vector<double> heights_of(std::span<const glm::dvec3> posed) {
  std::vector<double> out(posed.size());
  for (size_t v = 0; v < posed.size(); ++v) out[v] = posed[v].y;
  return out;
}

// Of the vertices that count.
struct HeightRange {
  double low = std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::lowest();
  template <typename Counts>
  HeightRange(std::span<const double> heights, const Counts& counts) {
    for (uint32_t v = 0; v < heights.size(); ++v) {
      if (!counts(v)) continue;
      low = std::min(low, heights[v]);
      high = std::max(high, heights[v]);
    }
  }
};

}  // namespace

std::vector<bool> find_held(const Character& character, std::span<const glm::dvec3> bind) {
  const Mesh& mesh = character.mesh;
  const Skeleton& skeleton = character.skeleton;
  const size_t n = mesh.positions.size();
  const auto rigid = [&](size_t v) { return skeleton.joints[mesh.joints[v][0]].rigid; };
  std::vector<bool> held(n, false);
  if (skeleton.root_node < 0) return held;
  const std::vector<double> heights = heights_of(bind);
  const HeightRange skin(heights, [&](size_t v) { return !rigid(v); });
  const HeightRange all(heights, [](size_t) { return true; });
  const bool rigid_feet = skin.low - all.low > kSoleBand * (all.high - all.low);
  const std::vector<bool> hands = in_hands(skeleton);
  for (size_t v = 0; v < n; ++v) held[v] = (rigid(v) && !rigid_feet) || hands[strongest_joint(mesh, v)];
  if (std::ranges::count(held, false) == 0) held.assign(n, false);
  return held;
}

namespace {

// The lowest point of the whole body, which what it holds cannot be.
double lowest_of_body(const std::vector<double>& heights, const std::vector<bool>& held, DrawnExtent& extent) {
  const double high = *std::ranges::max_element(heights);
  std::vector<double> depths(heights.size());
  for (size_t v = 0; v < heights.size(); ++v) depths[v] = held[v] ? -high : -heights[v];
  return -extent.most(depths);
}

double cycle_of(const Character& character, int clip) { return clip < 0 ? 0.0 : cycle_seconds(character, clip); }

double ground_of(const std::vector<double>& soles, const std::vector<double>& body, double height) {
  const double by_soles = supporting_height(soles, height);
  const double by_body = supporting_height(body, height);
  const double lower = by_soles - by_body;
  return lower <= kSameLevel * height || lower > kSoleBand * height ? by_body : by_soles;
}

// The skin's root, posed by itself: what hangs on other nodes takes no part.
class RootPath {
 public:
  // clip: -1 for the rest pose.
  RootPath(const Character& character, int clip) : cycle_(cycle_of(character, clip)) {
    const Skeleton& skeleton = character.skeleton;
    std::vector<int> path;
    for (int node = travelling_node(skeleton); node >= 0; node = skeleton.nodes[static_cast<size_t>(node)].parent)
      path.insert(path.begin(), node);
    std::vector<int> place(skeleton.nodes.size(), -1);
    for (const int node : path) {
      place[static_cast<size_t>(node)] = static_cast<int>(path_.skeleton.nodes.size());
      path_.skeleton.nodes.push_back(skeleton.nodes[static_cast<size_t>(node)]);
      path_.skeleton.nodes.back().parent = static_cast<int>(path_.skeleton.nodes.size()) - 2;
    }
    if (clip < 0) return;
    const Clip& all = character.clips[static_cast<size_t>(clip)];
    Clip& curves = path_.clips.emplace_back();
    curves.start = all.start;
    curves.end = all.end;
    for (const Channel& channel : all.channels) {
      if (place[static_cast<size_t>(channel.node)] < 0) continue;
      curves.channels.push_back(channel);
      curves.channels.back().node = place[static_cast<size_t>(channel.node)];
    }
    if (cycle_ > 0) motion_ = character.motion[static_cast<size_t>(clip)];
  }

  bool empty() const { return path_.skeleton.nodes.empty(); }

  // At a phase, its travel undone. Only where there is a root.
  glm::dvec3 at(double phase) const {
    const int clip = path_.clips.empty() ? -1 : 0;
    if (cycle_ <= 0) return place_of(clip, clip < 0 ? 0.0 : path_.clips[0].start);
    const Clip& curves = path_.clips[0];
    const double progress = std::min(phase * cycle_ / curves.duration(), 1.0);
    return glm::dvec3(travel_undone(motion_, progress) *
                      glm::dvec4(place_of(clip, curves.start + progress * curves.duration()), 1.0));
  }

 private:
  glm::dvec3 place_of(int clip, double time) const { return glm::dvec3(node_matrices(path_, clip, time).back()[3]); }

  Character path_;  // its nodes, from the top of the hierarchy, and what moves them
  ClipMotion motion_;
  double cycle_;
};

double extent_of(std::vector<double> heights, DrawnExtent& extent) {
  const double high = extent.most(heights);
  for (double& height : heights) height = -height;
  return high + extent.most(heights);
}

}  // namespace

glm::dvec3 skin_one(const Mesh& mesh, uint32_t v, const std::vector<glm::dmat4>& palette) {
  const glm::dvec4 position(mesh.positions[v], 1.0);
  glm::dvec4 sum(0.0);
  for (int i = 0; i < kInfluences; ++i) {
    const double weight = mesh.weights[v][i];
    if (weight != 0.0) sum += weight * (palette[mesh.joints[v][i]] * position);
  }
  return glm::dvec3(sum);
}

double settled(double value, double height) {
  int exponent = 0;
  std::frexp(height, &exponent);
  return std::ldexp(std::nearbyint(std::ldexp(value, 30 - exponent)), exponent - 30);
}

double posed_height(DrawnExtent& extent, std::span<const glm::dvec3> posed) {
  return extent_of(heights_of(posed), extent);
}

std::vector<uint32_t> find_soles(const Character& character, std::span<const glm::dvec3> bind,
                                 const std::vector<bool>& held, std::span<const uint32_t> unseen) {
  std::vector<bool> counts = find_drawn(character);
  for (size_t v = 0; v < counts.size(); ++v) counts[v] = counts[v] && !held[v];
  for (const uint32_t v : unseen) counts[v] = false;
  if (std::ranges::count(counts, true) == 0) counts.assign(counts.size(), true);
  const std::vector<double> heights = heights_of(bind);
  const HeightRange range(heights, [&](size_t v) { return counts[v]; });
  std::vector<uint32_t> soles;
  for (uint32_t v = 0; v < counts.size(); ++v)
    if (counts[v] && heights[v] <= range.low + kSoleBand * (range.high - range.low)) soles.push_back(v);
  return soles;
}

double supporting_height(std::vector<double> lowest, double figure_height) {
  std::ranges::sort(lowest);
  const size_t enough = (lowest.size() + kStays - 1) / kStays;
  for (size_t i = 0; i + enough <= lowest.size(); ++i)
    if (lowest[i + enough - 1] <= lowest[i] + kSameLevel * figure_height) return lowest[i];
  return lowest.front();
}

Stand measure_stand(const Character& character, const Body& body, const std::vector<bool>& held,
                    const std::vector<uint32_t>& soles, double bind_height) {
  const Mesh& mesh = character.mesh;
  const int clip = character.placement.upright_clip;
  const double cycle = cycle_of(character, clip);
  const int samples = cycle > 0.0 ? std::clamp(static_cast<int>(std::ceil(cycle * kBoundsRate)), 2, 150) : 1;
  const RootPath root(character, clip);
  DrawnExtent extent(character);
  Stand out;
  glm::dvec3 root_middle{0.0};
  glm::dvec3 body_middle{0.0};
  std::vector<double> lowest_soles;
  std::vector<double> lowest_body;
  for (int i = 0; i < samples; ++i) {
    const double phase = static_cast<double>(i) / samples;
    const auto palette = model_matrices(character, clip, phase);
    const std::vector<double> heights = shown_heights(mesh, palette);
    if (i == 0) out.height = extent_of(heights, extent);
    double sole = std::numeric_limits<double>::max();
    for (const uint32_t v : soles) sole = std::min(sole, heights[v]);
    lowest_soles.push_back(sole);
    lowest_body.push_back(lowest_of_body(heights, held, extent));
    body_middle += body.centre(palette) / static_cast<double>(samples);
    if (!root.empty()) root_middle += root.at(phase) / static_cast<double>(samples);
  }
  out.ground = ground_of(lowest_soles, lowest_body, bind_height);
  // A root that stands apart from the body, or falls behind it within a cycle, is not where the character is.
  const auto near = [&](const glm::dvec3& apart) {
    return glm::length(glm::dvec2(apart.x, apart.z)) <= kApart * bind_height;
  };
  const bool leads = !root.empty() && near(root_middle - body_middle) && near(root.at(1) - root.at(0));
  out.pivot = leads ? root_middle : body_middle;
  out.height = settled(out.height, bind_height);
  out.ground = settled(out.ground, bind_height);
  for (int axis = 0; axis < 3; ++axis) out.pivot[axis] = settled(out.pivot[axis], bind_height);
  return out;
}

}  // namespace crowdbench::scene
