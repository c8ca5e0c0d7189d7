// Based on: Kavan et al. 2008 (body parts that hide little of themselves). Differs from the source: the parts are found
// from the skeleton, not given.
#include "renderers/polypostor/polypostor_parts.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <tuple>

#include "core/error.h"
#include "scene/pose/pose.h"

namespace crowdbench::renderers {
namespace {

constexpr double kHeavy = 0.015;       // of the surface: a subtree that is a limb
constexpr double kTrunk = 0.25;        // of the surface: what a branching of the trunk carries
constexpr double kLeastArea = 0.008;   // of the surface: a segment
constexpr double kLeastLength = 0.06;  // of the height: a segment
constexpr double kRootLength = 0.12;   // of the height: a longer first bone is a segment of its own
constexpr double kFar = 0.2;           // of the height: a lighter subtree so far from every branching is a part
constexpr double kFarArea = 0.003;     // of the surface
constexpr double kCollarReach = 2.5;   // of its length: what a collar bone moves
constexpr double kNothing = 0.01;      // of the height: joints so near are in one place
constexpr size_t kSegments = 3;

struct Tree {
  std::vector<std::vector<int>> children;
  std::vector<double> area, subtree;  // of the surface, by node
  std::vector<glm::dvec3> origin;     // metres
  std::vector<double> own;            // metres: from a node's origin to the farthest vertex that it moves most
  std::vector<double> reach;  // metres: from a node's origin to the farthest that it or a node below moves, at most
  double height = 0;
};

Tree make_tree(const scene::Character& character) {
  const auto& nodes = character.skeleton.nodes;
  const scene::Mesh& mesh = character.mesh;
  Tree tree;
  tree.children.resize(nodes.size());
  tree.area.assign(nodes.size(), 0);
  tree.own.assign(nodes.size(), 0);
  for (size_t n = 0; n < nodes.size(); ++n)
    if (nodes[n].parent >= 0) tree.children[static_cast<size_t>(nodes[n].parent)].push_back(static_cast<int>(n));
  const auto positions = scene::skin_positions(mesh, scene::joint_matrices(character, -1, 0));
  for (const glm::dmat4& m : scene::node_matrices(character, -1, 0)) tree.origin.emplace_back(m[3]);
  double low = INFINITY;
  double high = -INFINITY;
  double total = 0;
  const auto node_of = [&](uint32_t vertex, int k) {
    return static_cast<size_t>(character.skeleton.joints[mesh.joints[vertex][k]].node);
  };
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const glm::dvec3& a = positions[mesh.indices[i]];
    const double area =
        glm::length(glm::cross(positions[mesh.indices[i + 1]] - a, positions[mesh.indices[i + 2]] - a)) / 6;
    for (size_t corner = 0; corner < 3; ++corner) {
      const uint32_t v = mesh.indices[i + corner];
      int most = 0;
      for (int k = 0; k < scene::kInfluences; ++k) {
        tree.area[node_of(v, k)] += area * static_cast<double>(mesh.weights[v][k]);
        if (mesh.weights[v][k] > mesh.weights[v][most]) most = k;
      }
      total += area;
      const size_t node = node_of(v, most);
      tree.own[node] = std::max(tree.own[node], glm::distance(positions[v], tree.origin[node]));
      low = std::min(low, positions[v].y);
      high = std::max(high, positions[v].y);
    }
  }
  tree.height = std::max(high - low, 1e-9);
  for (double& a : tree.area) a /= std::max(total, 1e-30);
  tree.reach = tree.own;
  tree.subtree = tree.area;
  for (size_t n = nodes.size(); n-- > 0;) {
    if (nodes[n].parent < 0) continue;
    const auto parent = static_cast<size_t>(nodes[n].parent);
    tree.subtree[parent] += tree.subtree[n];
    if (tree.subtree[n] > 0)
      tree.reach[parent] =
          std::max(tree.reach[parent], tree.reach[n] + glm::distance(tree.origin[n], tree.origin[parent]));
  }
  return tree;
}

struct Segment {
  std::vector<int> nodes;  // of the chain; what hangs from them follows
  double area = 0, length = 0;
};

class Finder {
 public:
  explicit Finder(const scene::Character& character)
      : nodes_(character.skeleton.nodes), tree_(make_tree(character)), part_(nodes_.size(), 0) {}

  // Parts of nodes; `limb_end` says which parts end a limb of three, and on what.
  std::vector<int> run(std::map<int, int>& limb_end) {
    std::vector<uint8_t> trunk(nodes_.size(), 0);
    std::vector<size_t> branchings;
    for (size_t n = nodes_.size(); n-- > 0;) {
      int heavy = 0;
      for (const int c : tree_.children[n]) {
        // What begins where the node does, as a helmet on a head, is no branch.
        const double apart = glm::distance(tree_.origin[n], tree_.origin[static_cast<size_t>(c)]);
        heavy += tree_.subtree[static_cast<size_t>(c)] >= kHeavy && apart > kNothing * tree_.height ? 1 : 0;
        trunk[n] |= trunk[static_cast<size_t>(c)];
      }
      if (heavy < 2 || tree_.subtree[n] < kTrunk) continue;
      trunk[n] = 1;
      branchings.push_back(n);
    }
    // Feet that hang from the root, for example, as rigs have them that are posed by their ends.
    const auto far = [&](size_t n) {
      return tree_.subtree[n] >= kFarArea && !branchings.empty() &&
             std::all_of(branchings.begin(), branchings.end(), [&](size_t b) {
               return glm::distance(tree_.origin[n], tree_.origin[b]) > kFar * tree_.height;
             });
    };
    for (size_t n = 0; n < nodes_.size(); ++n) {
      const int parent = nodes_[n].parent;
      if (trunk[n] != 0 || (parent >= 0 && trunk[static_cast<size_t>(parent)] == 0)) continue;
      if (tree_.subtree[n] >= kHeavy || far(n)) limb(static_cast<int>(n), 0, parent >= 0, limb_end);
    }
    return part_;
  }

 private:
  struct Chain {
    std::vector<int> nodes;
    std::vector<std::pair<int, size_t>> branches;  // heavy ones: node, position of its parent in the chain
  };
  // From `root` along the heaviest children.
  Chain chain_from(int root) const {
    Chain chain{{root}, {}};
    for (;;) {
      const auto& children = tree_.children[static_cast<size_t>(chain.nodes.back())];
      int heaviest = -1;
      for (const int c : children)
        if (heaviest < 0 || tree_.subtree[static_cast<size_t>(c)] > tree_.subtree[static_cast<size_t>(heaviest)])
          heaviest = c;
      for (const int c : children)
        if (c != heaviest && tree_.subtree[static_cast<size_t>(c)] >= kHeavy)
          chain.branches.emplace_back(c, chain.nodes.size() - 1);
      if (heaviest < 0 || tree_.subtree[static_cast<size_t>(heaviest)] < kLeastArea) return chain;
      chain.nodes.push_back(heaviest);
    }
  }

  // A segment a node, with what hangs from it but for the next one and the branches.
  std::vector<Segment> segments_of(const Chain& chain) const {
    std::vector<Segment> segments;
    for (size_t i = 0; i < chain.nodes.size(); ++i) {
      const auto n = static_cast<size_t>(chain.nodes[i]);
      Segment s{{chain.nodes[i]}, tree_.subtree[n], tree_.reach[n]};
      if (i + 1 < chain.nodes.size()) {
        s.area -= tree_.subtree[static_cast<size_t>(chain.nodes[i + 1])];
        s.length = glm::distance(tree_.origin[n], tree_.origin[static_cast<size_t>(chain.nodes[i + 1])]);
      }
      for (const auto& [b, at] : chain.branches)
        if (at == i) s.area -= tree_.subtree[static_cast<size_t>(b)];
      segments.push_back(s);
    }
    return segments;
  }

  // Collar bones and necks move with the trunk; a head that wears a helmet is no neck.
  void leave_to_trunk(std::vector<Segment>& segments) const {
    while (segments.size() > 1 &&
           tree_.own[static_cast<size_t>(segments[0].nodes[0])] < kCollarReach * segments[0].length &&
           segments[0].length < kRootLength * tree_.height && segments[0].length < 0.6 * segments[1].length)
      segments.erase(segments.begin());
  }

  static void join(std::vector<Segment>& segments, size_t into, size_t from) {
    Segment& a = segments[into];
    Segment& b = segments[from];
    a.nodes.insert(into < from ? a.nodes.end() : a.nodes.begin(), b.nodes.begin(), b.nodes.end());
    a.area += b.area;
    a.length += b.length;
    segments.erase(segments.begin() + static_cast<std::ptrdiff_t>(from));
  }

  // Small ones with their neighbours, until all are large enough and there are at most kSegments.
  void join_small(std::vector<Segment>& segments) const {
    while (segments.size() > 1) {
      size_t worst = 0;
      double least = INFINITY;
      for (size_t i = 0; i < segments.size(); ++i) {
        const double size = std::min(segments[i].area / kLeastArea, segments[i].length / (kLeastLength * tree_.height));
        if (size < least) {
          least = size;
          worst = i;
        }
      }
      if (least >= 1 && segments.size() <= kSegments) break;
      if (worst == 0)
        join(segments, 1, 0);
      else
        join(segments, worst - 1, worst);
    }
  }

  // The limb that begins at `root`, cut into segments; heavy side branches are limbs of their own.
  void limb(int root, int above, bool hangs, std::map<int, int>& limb_end) {
    const Chain chain = chain_from(root);
    std::vector<Segment> segments = segments_of(chain);
    if (hangs) leave_to_trunk(segments);
    join_small(segments);
    std::vector<int> part_of_segment;
    for (const Segment& s : segments) {
      part_of_segment.push_back(next_);
      mark(s.nodes.front(), next_++);
    }
    if (segments.size() >= kSegments) limb_end[part_of_segment.back()] = part_of_segment[segments.size() - 2];
    for (const auto& [b, at] : chain.branches) {
      const int parent_part = part_[static_cast<size_t>(chain.nodes[at])];
      limb(b, parent_part == 0 ? above : parent_part, true, limb_end);
    }
  }

  void mark(int node, int part) {
    part_[static_cast<size_t>(node)] = part;
    for (const int c : tree_.children[static_cast<size_t>(node)]) mark(c, part);
  }

  const std::vector<scene::Node>& nodes_;
  Tree tree_;
  std::vector<int> part_;
  int next_ = 1;
};

// Parts of joints, numbered without gaps; parts that no triangle needs go to another.
PartMap number(const scene::Character& character, const std::vector<int>& part_of_node) {
  PartMap map;
  std::vector<int> wanted;
  for (const scene::Joint& j : character.skeleton.joints) wanted.push_back(part_of_node[static_cast<size_t>(j.node)]);
  std::map<int, double> weight;
  for (size_t v = 0; v < character.mesh.positions.size(); ++v)
    for (int k = 0; k < scene::kInfluences; ++k)
      weight[wanted[character.mesh.joints[v][k]]] += static_cast<double>(character.mesh.weights[v][k]);
  std::map<int, int> numbers;
  for (const auto& [part, sum] : weight)
    if (sum > 0) numbers.emplace(part, static_cast<int>(numbers.size()));
  for (const int p : wanted) {
    const auto found = numbers.find(p);
    map.part_of.push_back(found == numbers.end() ? 0 : found->second);
  }
  map.count = static_cast<int>(numbers.size());
  return map;
}

// Cuts a mesh primitive by primitive: what belongs to a primitive stays together.
class Cutter {
 public:
  Cutter(const scene::Mesh& from, scene::Mesh& to, const PartMap& parts, const CutAccuracy& accuracy)
      : from_(from), to_(to), parts_(parts), accuracy_(accuracy) {}

  void run(std::vector<std::vector<uint32_t>>& triangles) {
    scene::Mesh empty;
    empty.primitives = from_.primitives;
    to_ = std::move(empty);
    for (scene::Primitive& primitive : to_.primitives) {
      const scene::Primitive source = primitive;
      primitive.first_vertex = static_cast<uint32_t>(to_.positions.size());
      primitive.first_index = static_cast<uint32_t>(to_.indices.size());
      moved_ = primitive.first_vertex - source.first_vertex;
      edges_.clear();
      leaving_.clear();
      for (uint32_t v = source.first_vertex; v < source.first_vertex + source.vertex_count; ++v) copy(v);
      for (uint32_t i = source.first_index; i < source.first_index + source.index_count; i += 3) {
        const std::array<uint32_t, 3> triangle = {from_.indices[i] + moved_, from_.indices[i + 1] + moved_,
                                                  from_.indices[i + 2] + moved_};
        int most = 0;
        float largest = 0;  // share of the triangle's middle
        for (int part = 0; part < parts_.count; ++part) {
          const float middle = (share(triangle[0], part) + share(triangle[1], part) + share(triangle[2], part)) / 3;
          if (middle <= largest) continue;
          largest = middle;
          most = part;
        }
        if (largest < kBorderWeight)
          add(triangle, triangles[static_cast<size_t>(most)]);
        else
          for (int part = 0; part < parts_.count; ++part) cut(part, triangle, triangles[static_cast<size_t>(part)]);
      }
      primitive.vertex_count = static_cast<uint32_t>(to_.positions.size()) - primitive.first_vertex;
      primitive.index_count = static_cast<uint32_t>(to_.indices.size()) - primitive.first_index;
    }
  }

 private:
  void copy(uint32_t v) {
    to_.positions.push_back(from_.positions[v]);
    to_.normals.push_back(from_.normals[v]);
    to_.uvs.push_back(from_.uvs[v]);
    if (!from_.emissive_uvs.empty()) to_.emissive_uvs.push_back(from_.emissive_uvs[v]);
    if (!from_.colours.empty()) to_.colours.push_back(from_.colours[v]);
    to_.joints.push_back(from_.joints[v]);
    to_.weights.push_back(from_.weights[v]);
  }

  float share(uint32_t v, int part) const {
    float sum = 0;
    for (int k = 0; k < scene::kInfluences; ++k)
      if (parts_.part_of[to_.joints[v][k]] == part) sum += to_.weights[v][k];
    return sum;
  }

  // A vertex's place as the weights of another one carry it.
  glm::vec3 carried(const std::vector<scene::Mat3x4>& palette, uint32_t by, uint32_t v) const {
    const glm::vec4 p(to_.positions[v], 1.0F);
    glm::vec3 out(0.0F);
    for (int k = 0; k < scene::kInfluences; ++k)
      for (int row = 0; row < 3; ++row)
        out[row] += to_.weights[by][k] * glm::dot(palette[to_.joints[by][k]].rows[row], p);
    return out;
  }

  // From a to b, where on the edge the part's weight is the border's.
  float border_on(int part, uint32_t a, uint32_t b) const {
    const float at_a = share(a, part);
    return std::clamp((kBorderWeight - at_a) / (share(b, part) - at_a), 0.0F, 1.0F);
  }

  // Whether a corner there would leave the surface: by t (1 - t) (A - B) (a - b), A and B being what carries the ends.
  bool leaves_surface(int part, uint32_t a, uint32_t b) {
    if (a > b) std::swap(a, b);
    const auto [found, fresh] = leaving_.try_emplace({part, a, b}, false);
    if (!fresh) return found->second;
    const float t = border_on(part, a, b);
    for (const auto& palette : accuracy_.palettes) {
      const glm::vec3 apart =
          carried(palette, a, a) - carried(palette, a, b) - carried(palette, b, a) + carried(palette, b, b);
      if (t * (1 - t) * glm::length(apart) > static_cast<float>(accuracy_.metres)) found->second = true;
    }
    return found->second;
  }

  // The corner on the edge from a to b where the part's weight is the border's.
  uint32_t corner_between(int part, uint32_t a, uint32_t b) {
    if (a > b) std::swap(a, b);
    const auto [found, fresh] = edges_.try_emplace({part, a, b}, static_cast<uint32_t>(to_.positions.size()));
    if (!fresh) return found->second;
    const float t = border_on(part, a, b);
    const auto between = [&](auto& values) { values.push_back(values[a] + t * (values[b] - values[a])); };
    between(to_.positions);
    const glm::vec3 normal = glm::mix(to_.normals[a], to_.normals[b], t);
    const float length = glm::length(normal);
    to_.normals.push_back(length > 1e-6F ? normal / length : to_.normals[a]);
    between(to_.uvs);
    if (!to_.emissive_uvs.empty()) between(to_.emissive_uvs);
    if (!to_.colours.empty()) between(to_.colours);
    std::map<uint16_t, float> weights;
    for (int k = 0; k < scene::kInfluences; ++k) {
      weights[to_.joints[a][k]] += (1 - t) * to_.weights[a][k];
      weights[to_.joints[b][k]] += t * to_.weights[b][k];
    }
    std::vector<std::pair<float, uint16_t>> order;
    for (const auto& [joint, weight] : weights) order.emplace_back(-weight, joint);
    std::sort(order.begin(), order.end());
    order.resize(scene::kInfluences, {0.0F, uint16_t{0}});
    glm::u16vec4 joints(0);
    glm::vec4 kept(0.0F);
    for (int k = 0; k < scene::kInfluences; ++k) {
      kept[k] = -order[static_cast<size_t>(k)].first;
      if (kept[k] > 0) joints[k] = order[static_cast<size_t>(k)].second;
    }
    to_.joints.push_back(joints);
    to_.weights.push_back(kept / (kept.x + kept.y + kept.z + kept.w));
    return found->second;
  }

  // Adds what a triangle has of the part: nothing, itself, or a triangle or two.
  void cut(int part, const std::array<uint32_t, 3>& triangle, std::vector<uint32_t>& triangles) {
    std::array<uint32_t, 4> polygon{};
    size_t corners = 0;
    float middle = 0;
    bool leaves = false;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t a = triangle[k];
      const uint32_t b = triangle[(k + 1) % 3];
      middle += share(a, part) / 3;
      if ((share(a, part) >= kBorderWeight) != (share(b, part) >= kBorderWeight))
        leaves = leaves || leaves_surface(part, a, b);
    }
    if (leaves) {
      if (middle >= kBorderWeight) add(triangle, triangles);
      return;
    }
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t a = triangle[k];
      const uint32_t b = triangle[(k + 1) % 3];
      const bool in_a = share(a, part) >= kBorderWeight;
      const bool in_b = share(b, part) >= kBorderWeight;
      if (in_a) polygon[corners++] = a;
      if (in_a != in_b) polygon[corners++] = corner_between(part, a, b);
    }
    for (size_t k = 2; k < corners; ++k) add({polygon[0], polygon[k - 1], polygon[k]}, triangles);
  }

  void add(const std::array<uint32_t, 3>& triangle, std::vector<uint32_t>& triangles) {
    triangles.push_back(static_cast<uint32_t>(to_.indices.size() / 3));
    to_.indices.insert(to_.indices.end(), triangle.begin(), triangle.end());
  }

  const scene::Mesh& from_;
  scene::Mesh& to_;
  const PartMap& parts_;
  const CutAccuracy& accuracy_;
  uint32_t moved_ = 0;  // from a vertex of `from` to the same one of `to`
  std::map<std::tuple<int, uint32_t, uint32_t>, uint32_t> edges_;
  std::map<std::tuple<int, uint32_t, uint32_t>, bool> leaving_;
};

}  // namespace

BodyParts find_parts(const scene::Character& character) {
  std::map<int, int> limb_end;
  std::vector<int> parts = Finder(character).run(limb_end);
  BodyParts out;
  out.fine = number(character, parts);
  for (int& p : parts)
    if (const auto end = limb_end.find(p); end != limb_end.end()) p = end->second;
  out.coarse = number(character, parts);
  return out;
}

BodyParts cut_parts(const scene::Character& character, const std::string& cuts, const std::string& where) {
  const auto& skeleton = character.skeleton;
  std::vector<int> begins(skeleton.nodes.size(), 0);
  int next = 1;
  for (size_t at = 0; at <= cuts.size();) {
    const size_t end = std::min(cuts.find('+', at), cuts.size());
    const std::string text = cuts.substr(at, end - at);
    at = end + 1;
    auto found = std::find_if(skeleton.joints.begin(), skeleton.joints.end(),
                              [&](const scene::Joint& j) { return j.name == text; });
    size_t index = 0;
    const auto [stop, fault] = std::from_chars(text.data(), text.data() + text.size(), index);
    if (found == skeleton.joints.end() && fault == std::errc{} && stop == text.data() + text.size() &&
        index < skeleton.joints.size())
      found = skeleton.joints.begin() + static_cast<std::ptrdiff_t>(index);
    if (found == skeleton.joints.end()) {
      std::vector<std::string> names;
      for (const scene::Joint& j : skeleton.joints) names.push_back(j.name);
      const std::string near = nearest_name(text, names);
      throw Error(where, fmt::format("{} has no joint '{}'", character.name, printable(text)),
                  near.empty() ? fmt::format("name joints, or count them from 0 to {}", skeleton.joints.size() - 1)
                               : fmt::format("did you mean '{}'?", near));
    }
    begins[static_cast<size_t>(found->node)] = next++;
  }
  std::vector<int> parts(skeleton.nodes.size(), 0);
  for (size_t n = 0; n < parts.size(); ++n) {
    const int parent = skeleton.nodes[n].parent;
    parts[n] = begins[n] > 0 ? begins[n] : parent >= 0 ? parts[static_cast<size_t>(parent)] : 0;
  }
  const PartMap map = number(character, parts);
  return {map, map};
}

CutCharacter cut_at_parts(const scene::Character& character, const PartMap& parts, const CutAccuracy& accuracy) {
  auto cut = std::make_shared<scene::Character>(character);
  CutCharacter out;
  out.triangles.resize(static_cast<size_t>(parts.count));
  Cutter cutter(character.mesh, cut->mesh, parts, accuracy);
  cutter.run(out.triangles);
  out.character = std::move(cut);
  return out;
}

}  // namespace crowdbench::renderers
