#include "scene/pose/human_bones.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <utility>
#include <vector>

namespace crowdbench::scene {
namespace {

constexpr int kFingerBones = 3;
constexpr int kMostNumber = 1'000'000;

struct NameTokens {
  std::vector<std::string> words;  // lower case, without numbers
  int number = 0;                  // the last one of the name; 0: none
};

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool is_upper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }
char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

// "LForeArm_01" is l, fore, arm and 1: words end at what is no letter, before a capital after a small letter, and
// before the last of several capitals.
NameTokens tokens_of(std::string_view name) {
  if (const size_t space = name.find_last_of(":|"); space != std::string_view::npos) name.remove_prefix(space + 1);
  NameTokens out;
  for (size_t i = 0; i < name.size();) {
    const char c = name[i];
    if (is_digit(c)) {
      const size_t begin = i;
      while (i < name.size() && is_digit(name[i])) ++i;
      int number = 0;
      const auto [stop, fault] = std::from_chars(name.data() + begin, name.data() + i, number);
      out.number = fault == std::errc{} ? std::min(number, kMostNumber) : kMostNumber;
      continue;
    }
    if (!is_letter(c)) {
      ++i;
      continue;
    }
    std::string word;
    for (; i < name.size() && is_letter(name[i]); ++i) {
      const bool after_small = !word.empty() && is_upper(name[i]) && !is_upper(name[i - 1]);
      const bool last_capital = !word.empty() && is_upper(name[i]) && is_upper(name[i - 1]) && i + 1 < name.size() &&
                                is_letter(name[i + 1]) && !is_upper(name[i + 1]);
      if (after_small || last_capital) break;
      word += lower(name[i]);
    }
    out.words.push_back(std::move(word));
  }
  return out;
}

BoneSide take_side(std::vector<std::string>& words) {
  for (const auto& [side, names] :
       {std::pair{BoneSide::left, std::array{"left", "l"}}, std::pair{BoneSide::right, std::array{"right", "r"}}})
    for (const char* name : names)
      if (const auto found = std::ranges::find(words, name); found != words.end()) {
        words.erase(found);
        return side;
      }
  return BoneSide::middle;
}

// What programs put before every name of theirs.
void drop_prefixes(std::vector<std::string>& words) {
  constexpr std::array kPrefixes = {"mixamorig", "def", "j",    "bip",        "c",  "b",
                                    "bone",      "cc",  "base", "valvebiped", "rig"};
  while (words.size() > 1 && std::ranges::find(kPrefixes, words.front()) != kPrefixes.end()) words.erase(words.begin());
}

// What programs put anywhere in a name and says nothing.
void drop_fillers(std::vector<std::string>& words) {
  constexpr std::array kFillers = {"joint", "jnt", "skeleton", "skel"};
  std::erase_if(words, [&](const std::string& word) { return std::ranges::find(kFillers, word) != kFillers.end(); });
}

// A name without its side and what says nothing: "leg_joint_L_2" is "leg" on the left.
struct Core {
  std::string text;
  BoneSide side = BoneSide::middle;
  int number = 0;
};
Core core_of(std::string_view name) {
  NameTokens tokens = tokens_of(name);
  Core out;
  out.side = take_side(tokens.words);
  drop_fillers(tokens.words);
  drop_prefixes(tokens.words);
  for (const std::string& word : tokens.words) out.text += word;
  out.number = tokens.number;
  return out;
}

struct NamedPart {
  std::string_view name;
  BonePart part;
};
constexpr std::array kMiddleNames = {NamedPart{"hips", BonePart::hips}, NamedPart{"hip", BonePart::hips},
                                     NamedPart{"pelvis", BonePart::hips}, NamedPart{"neck", BonePart::neck},
                                     NamedPart{"head", BonePart::head}};
constexpr std::array kSideNames = {
    NamedPart{"shoulder", BonePart::shoulder},  NamedPart{"clavicle", BonePart::shoulder},
    NamedPart{"collar", BonePart::shoulder},    NamedPart{"collarbone", BonePart::shoulder},
    NamedPart{"upperarm", BonePart::upper_arm}, NamedPart{"uparm", BonePart::upper_arm},
    NamedPart{"arm", BonePart::upper_arm},      NamedPart{"lowerarm", BonePart::lower_arm},
    NamedPart{"forearm", BonePart::lower_arm},  NamedPart{"loarm", BonePart::lower_arm},
    NamedPart{"elbow", BonePart::lower_arm},    NamedPart{"hand", BonePart::hand},
    NamedPart{"wrist", BonePart::hand},         NamedPart{"palm", BonePart::hand},
    NamedPart{"upperleg", BonePart::upper_leg}, NamedPart{"upleg", BonePart::upper_leg},
    NamedPart{"thigh", BonePart::upper_leg},    NamedPart{"hip", BonePart::upper_leg},
    NamedPart{"lowerleg", BonePart::lower_leg}, NamedPart{"leg", BonePart::lower_leg},
    NamedPart{"shin", BonePart::lower_leg},     NamedPart{"calf", BonePart::lower_leg},
    NamedPart{"knee", BonePart::lower_leg},     NamedPart{"foot", BonePart::foot},
    NamedPart{"ankle", BonePart::foot},         NamedPart{"toe", BonePart::toes},
    NamedPart{"toes", BonePart::toes},          NamedPart{"toebase", BonePart::toes},
    NamedPart{"ball", BonePart::toes},          NamedPart{"thumb", BonePart::thumb},
    NamedPart{"index", BonePart::index_finger}, NamedPart{"middle", BonePart::middle_finger},
    NamedPart{"ring", BonePart::ring_finger},   NamedPart{"little", BonePart::little_finger},
    NamedPart{"pinky", BonePart::little_finger}};

bool is_finger(BonePart part) { return part >= BonePart::thumb; }

template <size_t N>
std::optional<BonePart> part_named(const std::array<NamedPart, N>& names, std::string_view name) {
  const auto found = std::ranges::find(names, name, &NamedPart::name);
  return found == names.end() ? std::nullopt : std::optional(found->part);
}

// VRM's names of its three thumb bones differ from those of the other fingers, and between its versions.
std::optional<int> vrm_finger_number(std::string_view name, bool thumb) {
  if (name.ends_with("Metacarpal")) return 1;
  if (name.ends_with("Proximal")) return thumb ? 2 : 1;
  if (name.ends_with("Intermediate")) return 2;
  if (name.ends_with("Distal")) return 3;
  return std::nullopt;
}

// "leftUpperArm", "leftIndexProximal" of VRM's `humanoid.humanBones`.
std::optional<Bone> bone_of_vrm(std::string_view name, bool thumb_has_metacarpal) {
  std::string_view stem = name;
  const std::optional<int> number = vrm_finger_number(name, thumb_has_metacarpal);
  if (number)
    for (const std::string_view end : {"Metacarpal", "Proximal", "Intermediate", "Distal"})
      if (stem.ends_with(end)) stem.remove_suffix(end.size());
  std::optional<Bone> bone = bone_of_name(stem);
  if (bone && is_finger(bone->part)) bone->number = number.value_or(1);
  return bone;
}

int depth_of(const Skeleton& skeleton, int node) {
  int depth = 0;
  while ((node = skeleton.nodes[static_cast<size_t>(node)].parent) >= 0) ++depth;
  return depth;
}

bool is_at_or_above(const Skeleton& skeleton, int above, int node) {
  while (node >= 0 && node != above) node = skeleton.nodes[static_cast<size_t>(node)].parent;
  return node == above;
}

class Finder {
 public:
  Finder(const Skeleton& skeleton, const std::vector<bool>& candidates)
      : skeleton_(skeleton), candidates_(candidates) {}

  std::map<Bone, int> find() {
    take_what_the_file_says();
    for (size_t i = 0; i < skeleton_.nodes.size(); ++i) {
      if (!candidates_[i]) continue;
      if (const auto bone = bone_of_name(skeleton_.nodes[i].name)) offer(*bone, static_cast<int>(i));
    }
    find_in_numbered_spine();
    if (said_.empty()) {
      for (const BoneSide side : {BoneSide::left, BoneSide::right}) find_in_limbs(side);
      find_head_in_neck();
      find_hips_between_legs();
    }
    find_spine();
    return std::move(found_);
  }

 private:
  void take_what_the_file_says() {
    const bool metacarpal = std::ranges::any_of(skeleton_.human_bones,
                                                [](const HumanBone& b) { return b.name.ends_with("ThumbMetacarpal"); });
    for (const HumanBone& said : skeleton_.human_bones)
      if (const auto bone = bone_of_vrm(said.name, metacarpal)) said_[*bone] = said.node;
    found_ = said_;
  }

  void offer(const Bone& bone, int node) {
    if (said_.contains(bone)) return;
    const auto [place, fresh] = found_.emplace(bone, node);
    if (!fresh && depth_of(skeleton_, node) < depth_of(skeleton_, place->second)) place->second = node;
  }

  // Rigify has no name for hips, neck and head: all are numbers of its spine, 0, 4 and 6.
  void find_in_numbered_spine() {
    std::map<int, int> spine;
    for (size_t i = 0; i < skeleton_.nodes.size(); ++i) {
      if (!candidates_[i]) continue;
      NameTokens name = tokens_of(skeleton_.nodes[i].name);
      drop_prefixes(name.words);
      if (name.words.size() == 1 && name.words.front() == "spine") spine.emplace(name.number, static_cast<int>(i));
    }
    if (!spine.contains(0)) return;
    const auto leg = found_.find({BonePart::upper_leg, BoneSide::left, 0});
    if (!found_.contains({BonePart::hips}) && leg != found_.end() && is_at_or_above(skeleton_, spine[0], leg->second))
      found_[{BonePart::hips}] = spine[0];
    if (!found_.contains({BonePart::neck}) && spine.contains(4) && spine.contains(6))
      found_[{BonePart::neck}] = spine[4];
    if (!found_.contains({BonePart::head}) && spine.contains(6)) found_[{BonePart::head}] = spine[6];
  }

  // Nodes whose names differ by number alone and that hang one on another, from the body outwards; empty where they do
  // not.
  std::vector<int> chain_of(std::string_view text, BoneSide side) const {
    std::vector<int> chain;
    for (size_t i = 0; i < skeleton_.nodes.size(); ++i) {  // parents come first
      if (!candidates_[i]) continue;
      const Core core = core_of(skeleton_.nodes[i].name);
      if (core.text != text || core.side != side) continue;
      if (!chain.empty() && !is_at_or_above(skeleton_, chain.back(), static_cast<int>(i))) return {};
      chain.push_back(static_cast<int>(i));
    }
    return chain;
  }

  // Limbs whose bones are all of one name, numbered this way or that: what hangs on what says which is which.
  void find_in_limbs(BoneSide side) {
    if (!found_.contains({BonePart::upper_leg, side})) {
      const std::vector<int> legs = chain_of("leg", side);
      constexpr std::array kParts = {BonePart::upper_leg, BonePart::lower_leg, BonePart::foot, BonePart::toes};
      if (!legs.empty()) found_.erase({BonePart::lower_leg, side});  // "leg", where it is the only one
      for (size_t i = 0; i < std::min(legs.size(), kParts.size()); ++i) found_.try_emplace({kParts[i], side}, legs[i]);
    }
    if (found_.contains({BonePart::lower_arm, side})) return;
    const std::vector<int> arms = chain_of("arm", side);
    if (arms.size() < 2) return;
    constexpr std::array kParts = {BonePart::shoulder, BonePart::upper_arm, BonePart::lower_arm, BonePart::hand};
    const size_t first = arms.size() < kParts.size() ? 1 : 0;
    found_.erase({BonePart::upper_arm, side});
    for (size_t i = 0; i < arms.size() && first + i < kParts.size(); ++i)
      found_.try_emplace({kParts[first + i], side}, arms[i]);
  }

  void find_head_in_neck() {
    const std::vector<int> necks = chain_of("neck", BoneSide::middle);
    if (necks.size() > 1) found_.try_emplace({BonePart::head}, necks.back());
  }

  // What both legs hang on.
  void find_hips_between_legs() {
    const auto left = found_.find({BonePart::upper_leg, BoneSide::left});
    const auto right = found_.find({BonePart::upper_leg, BoneSide::right});
    if (found_.contains({BonePart::hips}) || left == found_.end() || right == found_.end()) return;
    int node = skeleton_.nodes[static_cast<size_t>(left->second)].parent;
    while (node >= 0 && !is_at_or_above(skeleton_, node, right->second))
      node = skeleton_.nodes[static_cast<size_t>(node)].parent;
    if (node >= 0) found_[{BonePart::hips}] = node;
  }

  // The nodes between hips and neck, however many and whatever their names.
  void find_spine() {
    const auto hips = found_.find({BonePart::hips});
    auto top = found_.find({BonePart::neck});
    if (top == found_.end()) top = found_.find({BonePart::head});
    if (hips == found_.end() || top == found_.end()) return;
    std::vector<int> chain;
    for (int node = skeleton_.nodes[static_cast<size_t>(top->second)].parent;
         node >= 0 && !is_at_or_above(skeleton_, node, hips->second);
         node = skeleton_.nodes[static_cast<size_t>(node)].parent)
      chain.push_back(node);
    std::ranges::reverse(chain);
    for (size_t i = 0; i < chain.size(); ++i)
      found_[{BonePart::spine, BoneSide::middle, static_cast<int>(i)}] = chain[i];
  }

  const Skeleton& skeleton_;
  const std::vector<bool>& candidates_;
  std::map<Bone, int> said_;
  std::map<Bone, int> found_;
};

}  // namespace

std::string bone_text(const Bone& bone) {
  constexpr std::array kParts = {"hips",        "spine",        "neck",  "head",         "shoulder",
                                 "upper arm",   "lower arm",    "hand",  "upper leg",    "lower leg",
                                 "foot",        "toes",         "thumb", "index finger", "middle finger",
                                 "ring finger", "little finger"};
  const char* side = bone.side == BoneSide::left ? "left " : bone.side == BoneSide::right ? "right " : "";
  const std::string number = bone.number == 0 ? "" : fmt::format(" {}", bone.number);
  return fmt::format("{}{}{}", side, kParts[static_cast<size_t>(bone.part)], number);
}

std::optional<Bone> bone_of_name(std::string_view name) {
  const auto [core, side, last_number] = core_of(name);
  if (side == BoneSide::middle) {
    const auto part = part_named(kMiddleNames, core);
    return part ? std::optional(Bone{*part, side, 0}) : std::nullopt;
  }
  auto part = part_named(kSideNames, core);
  // Fingers: "hand index", "f index", "index finger".
  for (const std::string_view before : {"hand", "finger", "f"})
    if (!part && core.starts_with(before)) part = part_named(kSideNames, std::string_view(core).substr(before.size()));
  if (!part && core.ends_with("finger")) part = part_named(kSideNames, core.substr(0, core.size() - 6));
  if (!part) return std::nullopt;
  if (!is_finger(*part)) return Bone{*part, side, 0};
  const int number = std::max(last_number, 1);
  return number <= kFingerBones ? std::optional(Bone{*part, side, number}) : std::nullopt;
}

std::map<Bone, int> find_human_bones(const Skeleton& skeleton, const std::vector<bool>& candidates) {
  return Finder(skeleton, candidates).find();
}

std::vector<bool> bone_candidates(const Skeleton& skeleton) {
  std::vector<bool> out(skeleton.nodes.size(), false);
  bool skinned = false;
  for (const Joint& joint : skeleton.joints) {
    if (joint.rigid) continue;
    skinned = true;
    for (int node = joint.node; node >= 0; node = skeleton.nodes[static_cast<size_t>(node)].parent)
      out[static_cast<size_t>(node)] = true;
  }
  if (!skinned) out.assign(out.size(), true);
  return out;
}

std::optional<Bone> bone_above(const Bone& bone) {
  switch (bone.part) {
    case BonePart::hips: return std::nullopt;
    case BonePart::lower_arm: return Bone{BonePart::upper_arm, bone.side, 0};
    case BonePart::hand: return Bone{BonePart::lower_arm, bone.side, 0};
    case BonePart::upper_leg: return Bone{BonePart::hips};
    case BonePart::lower_leg: return Bone{BonePart::upper_leg, bone.side, 0};
    case BonePart::foot: return Bone{BonePart::lower_leg, bone.side, 0};
    case BonePart::toes: return Bone{BonePart::foot, bone.side, 0};
    case BonePart::upper_arm: return Bone{BonePart::shoulder, bone.side, 0};
    case BonePart::head: return Bone{BonePart::neck};
    case BonePart::spine:
    case BonePart::neck:
    case BonePart::shoulder: return Bone{BonePart::hips};
    default: break;
  }
  return bone.number > 1 ? Bone{bone.part, bone.side, bone.number - 1} : Bone{BonePart::hand, bone.side, 0};
}

}  // namespace crowdbench::scene
