#include "bench/experiments/cause_chain.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <set>
#include <unordered_map>

#include "bench/experiments/agent_views.h"

namespace crowdbench::bench {
namespace {

using metrics::Cause;
using metrics::Surfaces;

constexpr double kMostSamples = 16e6;  // of a picture that is drawn for its finest levels
constexpr int kMostSamplesASide = 9;   // a pixel

// How many pixels for one of the frame, along a side, show every agent at its finest level: at most 0.7 texels a pixel
// (renderers/impostor/tiles/level_order.h). 1 where nothing has texels.
int samples_for_finest(const Drawer& test, const scene::Frame& frame) {
  double most = 1;
  const glm::dmat3 rotation = scene::view_rotation(frame.camera);
  for (size_t c = 0; c < frame.agents.size(); ++c) {
    const double texel = test.representation.texel_metres(c);
    if (!(texel > 0)) continue;
    for (const scene::FrameAgent& agent : frame.agents[c]) {
      const double depth = -(rotation * glm::dvec3(agent.position)).z;
      if (depth < frame.camera.near) continue;
      const double pixel = scene::pixel_size_at(frame.camera, depth, frame.height);
      most = std::max(most, 0.75 * pixel / (texel * static_cast<double>(agent.scale)));
    }
  }
  if (most <= 1) return 1;
  return std::min(kMostSamplesASide, 2 * static_cast<int>(std::ceil((most - 1) / 2)) + 1);
}
int samples_that_fit(const scene::Frame& frame) {
  const double room = std::sqrt(kMostSamples / (static_cast<double>(frame.width) * frame.height));
  return std::max(1, 2 * static_cast<int>((room - 1) / 2) + 1);
}

// Agents of the frame drawn apart, group by group; only those wanted.
void draw_apart(const Drawer& drawer, const scene::Frame& frame, const std::set<uint32_t>& wanted,
                const std::function<void(const ImageU32&)>& see) {
  struct Place {
    size_t character, index;
  };
  std::vector<Place> places;
  std::vector<PixelBox> boxes;
  for (size_t c = 0; c < frame.agents.size(); ++c)
    for (size_t i = 0; i < frame.agents[c].size(); ++i) {
      if (!wanted.contains(frame.agents[c][i].id)) continue;
      places.push_back({c, i});
      PixelBox box = projected_bounds(frame, frame.agents[c][i], *drawer.cast.banks[c]);
      if (!box.whole) box = {0, 0, frame.width, frame.height, true};
      boxes.push_back(box);
    }
  const renderers::Target target(drawer.context, frame.width, frame.height, renderers::Pass{.ids = true});
  scene::Frame apart = frame;
  for (const std::vector<size_t>& group : disjoint_groups(boxes)) {
    for (auto& agents : apart.agents) agents.clear();
    for (const size_t i : group)
      apart.agents[places[i].character].push_back(frame.agents[places[i].character][places[i].index]);
    drawer.renderer.draw(apart, drawer.representation, target);
    see(target.read().ids);
  }
}

// 255 where two different agents are shown and each covers the pixel in both pictures when drawn alone. laid: who
// covers what in `before`, of those whom stored views show; `mesh` draws the others.
Image8 agents_in_both(const CauseFrame& of, const Drawer& mesh, const Drawer& test, const Surfaces& before,
                      const Surfaces& after, const StoredViews& laid) {
  std::vector<size_t> places;
  std::set<uint32_t> were, are;  // who is hidden in the other picture
  for (size_t i = 0; i < before.ids.pixels(); ++i) {
    const uint32_t a = before.ids.data[i];
    const uint32_t b = after.ids.data[i];
    if (a == 0 || b == 0 || a == b) continue;
    places.push_back(i);
    were.insert(a);
    are.insert(b);
  }
  Image8 both;
  if (places.empty()) return both;
  both = Image8(before.ids.width, before.ids.height, 1);
  constexpr uint8_t kInTest = 1;
  constexpr uint8_t kInMesh = 2;
  draw_apart(test, of.frame, were, [&](const ImageU32& ids) {
    for (const size_t i : places)
      if (ids.data[i] == before.ids.data[i]) both.data[i] |= kInTest;
  });
  for (const auto& [id, covered] : laid.covered) {
    are.erase(id);
    for (const size_t i : covered)
      if (after.ids.data[i] == id) both.data[i] |= kInMesh;
  }
  draw_apart(mesh, of.posed, are, [&](const ImageU32& ids) {
    for (const size_t i : places)
      if (ids.data[i] == after.ids.data[i]) both.data[i] |= kInMesh;
  });
  for (uint8_t& value : both.data) value = value == (kInTest | kInMesh) ? 255 : 0;
  return both;
}

}  // namespace

StoredWhat stored_by(const renderers::Spec& spec, const scene::Cast& cast) {
  StoredWhat out;
  out.of_several = !spec.components.empty();
  for (const renderers::Spec& component : spec.components) {
    StoredWhat of = stored_by(component, cast);
    out.planes = out.planes || of.planes;
    if (of.of_several)
      std::move(of.components.begin(), of.components.end(), std::back_inserter(out.components));
    else
      out.components.push_back(std::move(of));
  }
  const auto sample = renderers::representation_type(spec.name).view_sampling;
  if (sample == nullptr) return out;
  for (size_t c = 0; c < cast.characters.size(); ++c) {
    out.views.push_back(sample(spec, *cast.characters[c], cast.banks[c]));
    out.planes = out.planes || !out.views.back().surface_depth;
    out.by_part = out.by_part || out.views.back().lies == renderers::ViewLies::by_part;
  }
  return out;
}

void show_stored_frames(scene::Frame& frame, const scene::Cast& cast, const renderers::Representation& representation) {
  for (size_t c = 0; c < frame.agents.size(); ++c)
    for (scene::FrameAgent& agent : frame.agents[c]) {
      const double phase = representation.shown_phase(c, agent.bank_clip, static_cast<double>(agent.phase));
      if (phase == static_cast<double>(agent.phase)) continue;
      agent.pose = cast.banks[c]->sample(agent.bank_clip, phase);
      agent.phase = static_cast<float>(phase);
    }
}

namespace {

constexpr const char* kByPart =
    "of a view it stores a picture of each body part in a key frame, on a plane of its own: none of the whole figure "
    "in "
    "its pose stands for the view";

// Whose views show an agent: of the component that draws most of it.
class WhoseViews {
 public:
  WhoseViews(const CauseFrame& of, const Drawer& test, const StoredWhat& stored) : stored_(stored) {
    if (!stored.of_several) return;
    for (renderers::AgentShares& agent : test.representation.shares(of.frame, renderers::all_agents(of.frame)))
      shares_.emplace(agent.id, std::move(agent.shares));
  }
  const renderers::ViewSampling* of(size_t character, uint32_t id) const {
    const StoredWhat& who = drawn_by(id);
    return who.views.empty() || who.by_part ? nullptr : &who.views[character];
  }
  bool by_part(uint32_t id) const { return drawn_by(id).by_part; }

 private:
  const StoredWhat& drawn_by(uint32_t id) const {
    const auto found = shares_.find(id);
    if (found == shares_.end() || found->second.empty()) return stored_;
    const auto most = std::max_element(found->second.begin(), found->second.end());
    return stored_.components[static_cast<size_t>(most - found->second.begin())];
  }
  const StoredWhat& stored_;
  std::unordered_map<uint32_t, std::vector<float>> shares_;
};

}  // namespace

CausePictures draw_causes(const CauseFrame& of, const Drawer& mesh, const Drawer& test, const StoredWhat& stored) {
  CausePictures out;
  std::array<std::string, metrics::kCauses> reasons;
  const auto reason = [&](Cause cause) -> std::string& { return reasons[static_cast<size_t>(cause)]; };
  reason(Cause::place) = "both pictures have the same places";

  Surfaces posed = draw_surfaces(mesh, of.posed);
  if (stored.of_several)
    reason(Cause::pose) = "which stored frame each of its components shows is not known of a representation of several";
  else
    out.steps.push_back({Cause::pose, posed.codes});
  const WhoseViews whose(of, test, stored);
  bool stores = false;
  for (size_t c = 0; c < of.posed.agents.size(); ++c)
    for (const scene::FrameAgent& agent : of.posed.agents[c]) {
      if (whose.by_part(agent.id)) reason(Cause::view) = kByPart;
      stores = stores || whose.of(c, agent.id) != nullptr;
    }
  StoredViews laid;
  if (reason(Cause::view).empty() && stores)
    laid = draw_stored_views(mesh, of.posed, [&](size_t c, size_t i) { return whose.of(c, of.posed.agents[c][i].id); });
  const Surfaces& before = laid.covered.empty() ? posed : laid.surfaces;
  if (reason(Cause::view).empty()) out.steps.push_back({Cause::view, before.codes});

  const int wanted = samples_for_finest(test, of.frame);
  out.level_samples =
      stored.of_several || test.representation.has_history() ? 1 : std::min(wanted, samples_that_fit(of.frame));
  const Surfaces after = draw_surfaces(test, of.frame, out.level_samples);
  if (stored.of_several || test.representation.has_history())
    reason(Cause::level) = "at another size it would show another representation";
  else if (out.level_samples < wanted && out.level_samples == 1)
    reason(Cause::level) = "the picture is too large to be drawn as a finer one";

  const Image8 both = agents_in_both(of, mesh, test, before, after, laid);
  metrics::SurfaceSubstitution pixels{before, after, 0, 0, std::nullopt, both};
  pixels.ambient = static_cast<double>(of.frame.light.ambient);
  pixels.diffuse = static_cast<double>(of.frame.light.diffuse);
  if (stored.planes)
    reason(Cause::surface) = "its depths are those of planes, not of the surfaces that are shown";
  else
    pixels.depth_tolerance = 0.01 * of.height;
  for (metrics::CauseStep& step : metrics::substitute_surfaces(pixels)) out.steps.push_back(std::move(step));

  std::vector<const ImageU32*> owners = {&of.reference.ids, &after.ids, &before.ids, &posed.ids};
  Surfaces actual;
  if (reason(Cause::level).empty()) {
    const renderers::Capture drawn = test.renderer.capture(of.frame, test.representation);
    out.steps.push_back({Cause::level, drawn.colour});
    actual.ids = drawn.ids;
    owners.insert(owners.begin() + 1, &actual.ids);
  }
  out.errors = metrics::error_by_cause(of.reference.colour, out.steps, metrics::owners_of(owners));
  out.errors.reasons = std::move(reasons);
  return out;
}

}  // namespace crowdbench::bench
