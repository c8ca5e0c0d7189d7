#include "scene/pose/counterparts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"

namespace crowdbench::scene {
namespace {

int require_node(const SkeletonRest& rest, const std::string& name) {
  if (const auto found = find_node(rest.skeleton, name)) return *found;
  std::vector<std::string> names;
  for (const Node& node : rest.skeleton.nodes) names.push_back(node.name);
  const std::string near = nearest_name(name, names);
  throw Error(rest.where, fmt::format("has no node named {} (`bones`)", printable(name, 60)),
              near.empty() ? "its nodes are " + nearest_first(name, names, 12)
                           : fmt::format("did you mean {}?", printable(near, 60)));
}

std::optional<Bone> exact_bone_of(const SkeletonRest& rest, int node) {
  for (const auto& [bone, of] : rest.bones)
    if (of == node) return bone;
  return std::nullopt;
}

// Spines are all alike: their numbers depend on how many there are.
std::optional<Bone> bone_of(const SkeletonRest& rest, int node) {
  std::optional<Bone> bone = exact_bone_of(rest, node);
  if (bone && bone->part == BonePart::spine) bone->number = 0;
  return bone;
}

}  // namespace

Counterparts::Counterparts(SkeletonRest& target, SkeletonRest& source, const std::vector<bool>& animated)
    : target_(target),
      source_(source),
      animated_(animated),
      of_(target.skeleton.nodes.size(), -1),
      how_(target.skeleton.nodes.size(), How::none) {}

void Counterparts::find(const std::vector<std::string>& named) {
  for (const std::string& text : named) take_named(text);
  for (SkeletonRest* rest : {&target_, &source_}) rest->upright = rest->find_upright();
  const bool human = target_.is_human() && source_.is_human();
  take_equal_names(human);
  if (human) take_bones();
  if (count() == 0) nothing_matches();
}

int Counterparts::of(int target_node) const { return of_[at(target_node)]; }

size_t Counterparts::count() const { return of_.size() - static_cast<size_t>(std::ranges::count(of_, -1)); }

bool Counterparts::all_by_name() const {
  return std::ranges::all_of(how_, [](How how) { return how == How::none || how == How::name; });
}

int Counterparts::hips() const {
  const auto found = target_.bones.find({BonePart::hips});
  if (found != target_.bones.end() && of(found->second) >= 0) return found->second;
  for (size_t t = 0; t < of_.size(); ++t)  // parents come first
    if (of_[t] >= 0) return static_cast<int>(t);
  return 0;
}

void Counterparts::leave_out_above(int node) {
  for (size_t t = 0; t < of_.size(); ++t)
    if (is_above(target_.skeleton, static_cast<int>(t), node)) {
      of_[t] = -1;
      how_[t] = How::none;
    }
}

std::string Counterparts::text() const {
  std::string text;
  for (const auto& [how, what] :
       {std::pair{How::told, "as told"}, {How::name, "by name"}, {How::bone, "as bones of a human body"}})
    if (const auto n = std::ranges::count(how_, how); n > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", n, what);
  return text;
}

std::vector<std::string> Counterparts::left_over() const {
  std::vector<std::string> names;
  for (size_t s = 0; s < animated_.size(); ++s)
    if (animated_[s] && std::ranges::find(of_, static_cast<int>(s)) == of_.end())
      names.push_back(source_.skeleton.nodes[s].name.empty() ? fmt::format("node {}", s)
                                                             : printable(source_.skeleton.nodes[s].name, 40));
  return names;
}

void Counterparts::pair(int target, int source, How how) {
  if (of_[at(target)] >= 0 || taken_.contains(source)) return;
  of_[at(target)] = source;
  how_[at(target)] = how;
  taken_.insert(source);
}

// Programs give one name to different bones: "spine" are the hips of one skeleton and the waist of another.
void Counterparts::take_equal_names(bool human) {
  for (size_t s = 0; s < source_.skeleton.nodes.size(); ++s) {
    const std::string& name = source_.skeleton.nodes[s].name;
    if (name.empty() || !animated_[s]) continue;
    const auto t = find_node(target_.skeleton, name);
    if (!t || (human && bone_of(target_, *t) != bone_of(source_, static_cast<int>(s)))) continue;
    pair(*t, static_cast<int>(s), How::name);
  }
}

// A told pair is the same bone in both skeletons, whichever of them has a name for it.
void Counterparts::share_bone(int target, int source) {
  const auto mine = exact_bone_of(target_, target);
  if (const auto theirs = exact_bone_of(source_, source))
    target_.bones[*theirs] = target;
  else if (mine)
    source_.bones[*mine] = source;
}

void Counterparts::take_named(const std::string& text) {
  const size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    throw Error("bones", fmt::format("'{}' is not a pair of nodes", printable(text, 80)),
                "write the character's node, =, the other file's: \"LeftArm=upperarm_l\"");
  const int mine = require_node(target_, text.substr(0, equals));
  const int theirs = require_node(source_, text.substr(equals + 1));
  pair(mine, theirs, How::told);
  share_bone(mine, theirs);
}

void Counterparts::take_bones() {
  int target_spines = 0;
  int source_spines = 0;
  for (const auto& [bone, node] : target_.bones) target_spines += bone.part == BonePart::spine ? 1 : 0;
  for (const auto& [bone, node] : source_.bones) source_spines += bone.part == BonePart::spine ? 1 : 0;
  for (const auto& [bone, node] : target_.bones) {
    Bone wanted = bone;
    // The last one, which arms and neck hang on, plays the last; those below are spread evenly.
    if (bone.part == BonePart::spine && target_spines > 1)
      wanted.number =
          static_cast<int>(std::lround(static_cast<double>(bone.number) * (source_spines - 1) / (target_spines - 1)));
    else if (bone.part == BonePart::spine)
      wanted.number = source_spines - 1;
    const auto found = source_.bones.find(wanted);
    if (found == source_.bones.end()) continue;
    const bool one_name = target_.skeleton.nodes[at(node)].name == source_.skeleton.nodes[at(found->second)].name;
    pair(node, found->second, one_name ? How::name : How::bone);
  }
}

void Counterparts::nothing_matches() const {
  std::string theirs;
  size_t listed = 0;
  for (size_t s = 0; s < animated_.size() && listed < kNodesListed; ++s)
    if (animated_[s] && !source_.skeleton.nodes[s].name.empty())
      theirs += fmt::format("{}{}", listed++ > 0 ? ", " : "", printable(source_.skeleton.nodes[s].name, 40));
  throw Error(source_.where, fmt::format("moves no node that {} has, by name or as a human bone", target_.where),
              fmt::format("say which is which with `bones` (\"mine=theirs\"); it moves {}",
                          theirs.empty() ? "nodes without names" : theirs));
}

}  // namespace crowdbench::scene
