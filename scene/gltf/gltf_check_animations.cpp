// What a glTF document says of animations.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "core/error.h"
#include "scene/gltf/gltf_check.h"
#include "scene/gltf/gltf_data.h"

namespace crowdbench::scene {
namespace {

using nlohmann::json;

const json& list_of(const GltfCheck& check, const json& object, const std::string& path, const char* key) {
  const json* list = check.member(object, key);
  if (!list) check.fail(path, fmt::format("has no {}", key));
  if (!list->is_array()) check.fail(path + "/" + key, fmt::format("is {}, not an array", list->type_name()));
  return *list;
}

void check_channel(GltfCheck& check, const GltfData& data, const json& channel, const std::string& path,
                   const std::vector<GltfCurve>& curves, std::set<std::pair<int, Target>>& targets, size_t& numbers,
                   GltfAnimation& out) {
  check.require_object(channel, path);
  const uint64_t sampler = check.required_integer(channel, path, "sampler", 0, UINT64_MAX);
  if (sampler >= curves.size())
    check.fail(path + "/sampler", fmt::format("is {}, but there are {} samplers", sampler, curves.size()));
  const json* target = check.member(channel, "target");
  if (!target) check.fail(path, "has no target");
  const std::string at = path + "/target";
  check.require_object(*target, at);
  const std::string* what = check.text_or_none(*target, at, "path");
  if (!what) check.fail(at, "has no path");
  const auto node = check.index_or_none(*target, at, "node", "nodes");
  if (*what == "weights") {
    check.warn_once(path, kMorphTargets);
    return;
  }
  if (*what == "pointer" || !node) {
    check.warn_once(path, "has no node to move and is ignored");
    return;
  }
  if (*what != "translation" && *what != "rotation" && *what != "scale")
    check.fail(at + "/path", fmt::format("is {}, not translation, rotation, scale or weights", printable(*what, 20)));
  const Target moved = *what == "rotation" ? Target::rotation : *what == "scale" ? Target::scale : Target::translation;
  if (!targets.emplace(*node, moved).second)
    check.fail(at, fmt::format("is the second channel of this clip for the {} of node {}", *what, *node));
  const GltfCurve& curve = curves[sampler];
  const AccessorView& input = data.accessor(curve.input);
  const std::string sampler_path = path.substr(0, path.rfind("/channels/")) + fmt::format("/samplers/{}", sampler);
  if (*what == "rotation")
    data.require_format(curve.output, sampler_path + "/output", {4},
                        {{kF32, 0}, {kI8, 1}, {kU8, 1}, {kI16, 1}, {kU16, 1}});
  else
    data.require_format(curve.output, sampler_path + "/output", {3}, {{kF32, 0}});
  const AccessorView& output = data.accessor(curve.output);
  const size_t per_key = curve.interpolation == Interpolation::cubic_spline ? 3 : 1;
  if (output.count != input.count * per_key)
    check.fail(sampler_path,
               fmt::format("output has {} values, {} keys need {}", output.count, input.count, input.count * per_key));
  numbers += input.count + output.count * static_cast<size_t>(output.components);
  if (numbers > check.limits.keys)
    check.fail(path, fmt::format("brings the animations to {} numbers, the limit is {}", numbers, check.limits.keys));
  out.channels.push_back({*node, moved, curve});
}

void check_animation(GltfCheck& check, const GltfData& data, const json& animation, const std::string& path,
                     size_t& numbers) {
  GltfAnimation out;
  out.name = check.name_of(animation, path);
  std::vector<GltfCurve> curves;
  const json& samplers = list_of(check, animation, path, "samplers");
  for (size_t i = 0; i < samplers.size(); ++i) {
    const std::string at = check.item(path + "/samplers", i);
    check.require_object(samplers[i], at);
    const int input = check.required_index(samplers[i], at, "input", "accessors");
    const int output = check.required_index(samplers[i], at, "output", "accessors");
    data.require_format(input, at + "/input", {1}, {{kF32, 0}});
    std::string interpolation = "LINEAR";
    if (const std::string* given = check.text_or_none(samplers[i], at, "interpolation")) interpolation = *given;
    if (interpolation != "LINEAR" && interpolation != "STEP" && interpolation != "CUBICSPLINE")
      check.fail(at + "/interpolation",
                 fmt::format("is {}, not LINEAR, STEP or CUBICSPLINE", printable(interpolation, 20)));
    curves.push_back({input, output,
                      interpolation == "STEP"          ? Interpolation::step
                      : interpolation == "CUBICSPLINE" ? Interpolation::cubic_spline
                                                       : Interpolation::linear});
  }
  std::set<std::pair<int, Target>> targets;
  const json& channels = list_of(check, animation, path, "channels");
  for (size_t i = 0; i < channels.size(); ++i)
    check_channel(check, data, channels[i], check.item(path + "/channels", i), curves, targets, numbers, out);
  check.plan.model.animations.push_back(std::move(out));
}

}  // namespace

void check_animations(GltfCheck& check, const GltfData& data) {
  if (check.count_of("animations") > check.limits.clips)
    check.fail("/animations",
               fmt::format("has {} clips, the limit is {}", check.count_of("animations"), check.limits.clips));
  size_t numbers = 0;
  check.each("animations", [&](const json& animation, const std::string& path) {
    check_animation(check, data, animation, path, numbers);
  });
}

}  // namespace crowdbench::scene
