#include "bench/experiments/agent_views.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <unordered_map>

#include "core/progress.h"

namespace crowdbench::bench {
namespace {

// Relative to the eye, in world axes: a place in the agent's model space, metres at scale 1.
glm::dvec3 placed(const scene::FrameAgent& agent, const glm::vec3& model) {
  const glm::vec3 m = agent.scale * model;
  const glm::vec3 turned(m.x * agent.heading.y + m.z * agent.heading.x, m.y,
                         m.z * agent.heading.y - m.x * agent.heading.x);
  return {agent.position + turned};
}

bool overlap(const PixelBox& a, const PixelBox& b) {
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}

using PixelCounts = std::unordered_map<uint32_t, uint64_t>;

void count_ids(const ImageU32& ids, PixelCounts& counts) {
  for (const uint32_t id : ids.data)
    if (id != 0) ++counts[id];
}

double height_of(const scene::Cast& cast, size_t character) {
  const double own = cast.characters[character]->placement.height;
  const scene::PoseBank& bank = *cast.banks[character];
  return own > 0 ? own : static_cast<double>(bank.bounds_max().y - bank.bounds_min().y);
}

// An agent of the frame and where it stands in there.
struct Listed {
  size_t character = 0;
  const scene::FrameAgent* agent = nullptr;
};

// By ascending id.
std::vector<Listed> listed(const scene::Frame& frame) {
  std::vector<Listed> out;
  for (size_t c = 0; c < frame.agents.size(); ++c)
    for (const scene::FrameAgent& agent : frame.agents[c]) out.push_back({c, &agent});
  std::sort(out.begin(), out.end(), [](const Listed& a, const Listed& b) { return a.agent->id < b.agent->id; });
  return out;
}

AgentView view_of(const scene::Frame& frame, const scene::Cast& cast, const Listed& of) {
  const scene::PoseBank& bank = *cast.banks[of.character];
  AgentView view;
  view.tick = frame.tick;
  view.id = of.agent->id;
  view.character = of.character;
  view.scale = static_cast<double>(of.agent->scale);
  const glm::dvec3 middle = placed(*of.agent, 0.5F * (bank.bounds_min() + bank.bounds_max()));
  view.distance = glm::length(middle);
  view.depth = -(scene::view_rotation(frame.camera) * middle).z;
  if (view.depth > 0) view.pixels_per_metre = 1 / scene::pixel_size_at(frame.camera, view.depth, frame.height);
  view.height_px = height_of(cast, of.character) * view.scale * view.pixels_per_metre;
  return view;
}

AgentState state_of(const AgentView& view, const PixelBox& box, double least_visible) {
  if (!box.whole) return AgentState::cut_off;
  if (view.alone_px == 0) return AgentState::no_pixel;
  const double share = static_cast<double>(view.visible_px) / static_cast<double>(view.alone_px);
  return view.visible_px == 0 || share < least_visible ? AgentState::occluded : AgentState::counted;
}

}  // namespace

const char* state_name(AgentState state) {
  switch (state) {
    case AgentState::counted: return "counted";
    case AgentState::occluded: return "occluded";
    case AgentState::cut_off: return "cut_off";
    case AgentState::no_pixel: return "no_pixel";
  }
  assert(false);
  return "";
}

PixelBox projected_bounds(const scene::Frame& frame, const scene::FrameAgent& agent, const scene::PoseBank& bank) {
  const glm::dmat3 rotation = scene::view_rotation(frame.camera);
  const double tall = std::tan(frame.camera.fov_y / 2);
  const double wide = tall * frame.width / frame.height;
  const glm::vec3 low = bank.bounds_min();
  const glm::vec3 high = bank.bounds_max();
  glm::dvec2 least{1e300};
  glm::dvec2 most{-1e300};
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 q =
        rotation * placed(agent, {(corner & 1) != 0 ? high.x : low.x, (corner & 2) != 0 ? high.y : low.y,
                                  (corner & 4) != 0 ? high.z : low.z});
    if (-q.z < frame.camera.near) return {};
    const glm::dvec2 at{(1 + q.x / (-q.z * wide)) / 2 * frame.width, (1 - q.y / (-q.z * tall)) / 2 * frame.height};
    least = glm::min(least, at);
    most = glm::max(most, at);
  }
  if (least.x < 0 || least.y < 0 || most.x > frame.width || most.y > frame.height) return {};
  return {static_cast<int>(std::floor(least.x)), static_cast<int>(std::floor(least.y)),
          static_cast<int>(std::floor(most.x)) + 1, static_cast<int>(std::floor(most.y)) + 1, true};
}

std::vector<std::vector<size_t>> disjoint_groups(const std::vector<PixelBox>& boxes) {
  std::vector<std::vector<size_t>> groups;
  for (size_t i = 0; i < boxes.size(); ++i) {
    if (!boxes[i].whole) continue;
    const auto room = std::find_if(groups.begin(), groups.end(), [&](const std::vector<size_t>& group) {
      return std::none_of(group.begin(), group.end(), [&](size_t other) { return overlap(boxes[i], boxes[other]); });
    });
    if (room == groups.end())
      groups.push_back({i});
    else
      room->push_back(i);
  }
  return groups;
}

std::vector<AgentView> view_agents(gl::Context& context, renderers::Renderer& renderer,
                                   renderers::Representation& representation, const scene::Frame& frame,
                                   const scene::Cast& cast, const ImageU32& ids, double least_visible) {
  const std::vector<Listed> agents = listed(frame);
  std::vector<PixelBox> boxes;
  for (const Listed& of : agents) boxes.push_back(projected_bounds(frame, *of.agent, *cast.banks[of.character]));
  const std::vector<std::vector<size_t>> groups = disjoint_groups(boxes);
  PixelCounts alone;
  {
    const renderers::Target target(context, frame.width, frame.height, renderers::Pass{.ids = true});
    Progress progress("drawing agents apart", groups.size());
    scene::Frame apart = frame;
    for (const std::vector<size_t>& group : groups) {
      for (auto& of_character : apart.agents) of_character.clear();
      for (const size_t i : group) apart.agents[agents[i].character].push_back(*agents[i].agent);
      renderer.draw(apart, representation, target);
      count_ids(target.read().ids, alone);
      progress.advance();
    }
  }
  PixelCounts visible;
  count_ids(ids, visible);
  const auto count = [](const PixelCounts& counts, uint32_t id) {
    const auto found = counts.find(id);
    return found == counts.end() ? 0 : found->second;
  };
  std::vector<AgentView> out;
  for (size_t i = 0; i < agents.size(); ++i) {
    AgentView& view = out.emplace_back(view_of(frame, cast, agents[i]));
    view.alone_px = count(alone, view.id);
    view.visible_px = count(visible, view.id);
    view.state = state_of(view, boxes[i], least_visible);
  }
  return out;
}

}  // namespace crowdbench::bench
