// Based on: D. Luebke et al., "Level of Detail for 3D Graphics" (2003), chapter 4: levels chosen by the screen-space
// error of an object, taken at one depth. Differs from the source: the error is measured over poses of the clips in
// use.
#include "renderers/mesh/mesh_lods.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "renderers/mesh/mesh.h"

namespace crowdbench::renderers {
namespace {

constexpr size_t kMostLevels = 16;

Error not_levels(const std::string& lods, const std::string& why) {
  return {"representation 'mesh', option 'lods'", fmt::format("'{}': {}", lods, why),
          "give triangles, shares below 1 or own, from fine to coarse: 2000/500/125"};
}

// Of levels that the files hold, as many as all characters have.
size_t own_levels(const scene::Cast& cast) {
  size_t least = std::numeric_limits<size_t>::max();
  for (const auto& character : cast.characters) least = std::min(least, character->levels.size());
  return cast.characters.empty() ? 0 : least;
}

Spec level_spec(const char* key, std::string value) {
  Spec spec;
  spec.name = mesh_type.name;
  spec.options.emplace_back(key, std::move(value));
  return spec;
}

// own: levels that all files hold.
std::vector<Spec> specs_of(const std::string& lods, size_t own) {
  std::vector<Spec> out;
  double before = std::numeric_limits<double>::infinity();  // of the same key
  const char* key_before = "";
  for (size_t first = 0; first <= lods.size();) {
    const size_t end = std::min(lods.find('/', first), lods.size());
    const std::string one = lods.substr(first, end - first);
    first = end + 1;
    if (one == "own") {
      if (own == 0) throw not_levels(lods, "not every character's file holds levels of its own");
      for (size_t lod = 1; lod <= own; ++lod) out.push_back(level_spec("lod", std::to_string(lod)));
      key_before = "";
      continue;
    }
    double value = 0;
    const auto [stop, error] = std::from_chars(one.data(), one.data() + one.size(), value);
    const bool whole = value >= 1 && std::floor(value) == value && value <= 4'000'000;
    if (error != std::errc() || stop != one.data() + one.size() || !(whole || (value > 0 && value < 1)))
      throw not_levels(lods, fmt::format("'{}' is not a level", one));
    const char* key = whole ? "triangles" : "ratio";
    if (key == std::string(key_before) && !(value < before)) throw not_levels(lods, "not from fine to coarse");
    key_before = key;
    before = value;
    out.push_back(level_spec(key, one));
  }
  if (out.size() > kMostLevels)
    throw not_levels(lods, fmt::format("{} levels; {} is the most", out.size(), kMostLevels));
  return out;
}

}  // namespace

std::vector<Spec> lod_specs(const std::string& lods, const scene::Cast& cast) {
  return specs_of(lods, own_levels(cast));
}

void check_lods(const std::string& value, const std::string& /*where*/) {
  if (value != "none") (void)specs_of(value, 1);
}

size_t coarsest_within(std::span<const double> errors, double metres_a_pixel, double pixels) {
  for (size_t level = errors.size(); level > 0; --level)
    if (errors[level - 1] <= pixels * metres_a_pixel) return level;
  return 0;
}

PixelScale pixel_scale(const scene::Frame& frame) {
  return {glm::vec3(-glm::transpose(scene::view_rotation(frame.camera))[2]),
          scene::pixel_size_at(frame.camera, 1, frame.height)};
}

double metres_a_pixel(const PixelScale& scale, const scene::FrameAgent& agent, double height) {
  const glm::vec3 middle = agent.position + glm::vec3(0.0F, static_cast<float>(height) / 2 * agent.scale, 0.0F);
  const auto depth = static_cast<double>(glm::dot(middle, scale.forward));
  return depth > 0 ? depth * scale.metres / static_cast<double>(agent.scale) : 0;
}

MeshLods::MeshLods(std::vector<std::unique_ptr<Representation>> levels, std::vector<std::string> names,
                   const scene::Cast& cast, double pixels)
    : levels_(std::move(levels)),
      names_(std::move(names)),
      errors_(cast.characters.size()),
      pixels_(pixels),
      drawn_(levels_.size()) {
  for (size_t level = 1; level < levels_.size(); ++level) {
    const BakeInfo info = levels_[level]->bake_info();
    for (size_t c = 0; c < errors_.size(); ++c) errors_[c].push_back(info.levels.at(c).error.max);
  }
  for (const auto& character : cast.characters) heights_.push_back(character->placement.height);
}

size_t MeshLods::level_of(const PixelScale& scale, size_t character, const scene::FrameAgent& agent) const {
  if (agent.id < held_.size() && held_[agent.id] >= 0) return static_cast<size_t>(held_[agent.id]);
  return coarsest_within(errors_[character], metres_a_pixel(scale, agent, heights_[character]), pixels_);
}

void MeshLods::draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
                    const Pass& pass) {
  const PixelScale scale = pixel_scale(frame);
  split_.resize(levels_.size());
  for (AgentLists& lists : split_) {
    lists.resize(agents.size());
    for (auto& list : lists) list.clear();
  }
  for (size_t c = 0; c < agents.size(); ++c)
    for (const uint32_t i : agents[c]) split_[level_of(scale, c, frame.agents[c][i])][c].push_back(i);
  // Finer ones stand nearer: they hide the others.
  for (size_t level = 0; level < levels_.size(); ++level) {
    drawn_[level] = 0;
    for (const auto& list : split_[level]) drawn_[level] += list.size();
    if (drawn_[level] > 0) levels_[level]->draw(frame, resources, split_[level], pass);
  }
}

Footprint MeshLods::footprint() const {
  Footprint out;
  for (const auto& level : levels_) {
    const Footprint one = level->footprint();
    out.texture_bytes += one.texture_bytes;
    out.buffer_bytes += one.buffer_bytes;
    out.upload_bytes_per_frame += one.upload_bytes_per_frame;
    out.disk_bytes += one.disk_bytes;
  }
  return out;
}

BakeInfo MeshLods::bake_info() const {
  constexpr double kMillimetres = 1000;
  BakeInfo out;
  out.cached = true;
  for (size_t level = 1; level < levels_.size(); ++level) {
    const BakeInfo one = levels_[level]->bake_info();
    out.seconds += one.seconds;
    out.made_seconds += one.made_seconds;
    out.cached = out.cached && one.cached;
    out.cache_key += (out.cache_key.empty() ? "" : "+") + one.cache_key;
    out.notes.insert(out.notes.end(), one.notes.begin(), one.notes.end());
    out.levels.insert(out.levels.end(), one.levels.begin(), one.levels.end());
    // Of all characters the first to change over, and the last error.
    double triangles = 0;
    double error = 0;
    double below = std::numeric_limits<double>::infinity();
    for (const LevelInfo& info : one.levels) {
      triangles += static_cast<double>(info.triangles);
      error = std::max(error, info.error.max);
      if (const double one_pixel = info.pixels(1); one_pixel > 0) below = std::min(below, pixels_ / one_pixel);
    }
    const std::string name = fmt::format("level{}_", level);
    out.facts.emplace_back(name + "triangles", triangles);
    out.facts.emplace_back(name + "error_max_mm", error * kMillimetres);
    if (std::isfinite(below)) out.facts.emplace_back(name + "below_px", below);
  }
  return out;
}

std::vector<AgentShares> MeshLods::shares(const scene::Frame& frame, const AgentLists& agents) {
  const PixelScale scale = pixel_scale(frame);
  std::vector<AgentShares> out;
  for (size_t c = 0; c < agents.size(); ++c)
    for (const uint32_t i : agents[c]) {
      AgentShares one{frame.agents[c][i].id, std::vector<float>(levels_.size(), 0.0F)};
      one.shares[level_of(scale, c, frame.agents[c][i])] = 1;
      out.push_back(std::move(one));
    }
  return out;
}

void MeshLods::hold(const std::vector<AgentShares>& held) {
  held_.clear();
  for (const AgentShares& agent : held) {
    if (agent.id >= held_.size()) held_.resize(agent.id + 1, -1);
    held_[agent.id] =
        static_cast<int>(std::max_element(agent.shares.begin(), agent.shares.end()) - agent.shares.begin());
  }
}

std::unique_ptr<Representation> make_mesh_lods(const MakeContext& context, const Spec& spec, double pixels) {
  const OptionReader reader(mesh_type, spec);
  std::vector<Spec> specs = lod_specs(reader.text("lods"), context.cast);
  Spec whole;
  whole.name = mesh_type.name;
  specs.insert(specs.begin(), whole);
  std::vector<std::unique_ptr<Representation>> levels;
  std::vector<std::string> names;
  for (Spec& one : specs) {
    names.push_back(one.text());
    for (const auto& [key, value] : spec.options)
      if (key == "floor" || key == "passes") one.options.emplace_back(key, value);
    levels.push_back(mesh_type.make(context, one));
  }
  return std::make_unique<MeshLods>(std::move(levels), std::move(names), context.cast, pixels);
}

}  // namespace crowdbench::renderers
