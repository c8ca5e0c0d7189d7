// Takes as clips. Assimp has sampled every curve at its keys; between them values go straight, as in glTF.
#include <cmath>
#include <nlohmann/json.hpp>

#include "scene/assimp/module/conversion.h"

namespace crowdbench::scene::assimp_module {
namespace {

constexpr double kAssumedTicks = 25;  // a second, where the file does not say

// Assimp names a COLLADA animation "parent_child", and a child without a name after its parent.
std::string clip_name(const aiAnimation& in, Format format) {
  const std::string name = in.mName.C_Str();
  const size_t half = name.size() / 2;
  const bool twice = name.size() % 2 == 1 && name[half] == '_' && name.substr(0, half) == name.substr(half + 1);
  return format == Format::collada && twice ? name.substr(0, half) : name;
}

class Animations {
 public:
  explicit Animations(Conversion& c) : c_(c) {}

  void run() {
    for (unsigned a = 0; a < c_.scene.mNumAnimations; ++a) convert(*c_.scene.mAnimations[a]);
    if (unknown_ > 0) c_.warn(fmt::format("{} animated nodes are not in the scene and are left out", unknown_));
    if (backward_ > 0)
      c_.warn(fmt::format("{} animation keys that lie before the one in front are left out", backward_));
  }

 private:
  void convert(const aiAnimation& in) {
    clip_ = clip_name(in, c_.request.format);
    ticks_ = in.mTicksPerSecond;
    if (!std::isfinite(ticks_) || ticks_ <= 0) {
      ticks_ = kAssumedTicks;
      c_.warn(
          fmt::format("clip {} does not say how long a tick is: {} a second are assumed", shown(clip_), kAssumedTicks));
    }
    out_ = {{"name", clip_}, {"samplers", nlohmann::json::array()}, {"channels", nlohmann::json::array()}};
    moved_.clear();
    for (unsigned i = 0; i < in.mNumChannels; ++i) add_node(*in.mChannels[i]);
    if (in.mNumMorphMeshChannels + in.mNumMeshChannels > 0) c_.lost.insert("animated blend shapes");
    if (out_["channels"].empty()) {
      c_.warn(fmt::format("clip {} moves nothing and is left out", shown(clip_)));
      return;
    }
    c_.label("animations", c_.glb.add("animations", std::move(out_)), "clip " + shown(clip_));
  }

  void add_node(const aiNodeAnim& in) {
    const int node = c_.node_named(in.mNodeName);
    if (node < 0 || !moved_.insert(node).second) {
      ++unknown_;
      return;
    }
    const auto vector = [](const aiVectorKey& key, std::vector<float>& out) {
      out.insert(out.end(), {key.mValue.x, key.mValue.y, key.mValue.z});
    };
    const auto quaternion = [](const aiQuatKey& key, std::vector<float>& out) {
      out.insert(out.end(), {key.mValue.x, key.mValue.y, key.mValue.z, key.mValue.w});
    };
    add_channel(node, "translation", "VEC3", 3, in.mPositionKeys, in.mNumPositionKeys, vector);
    add_channel(node, "rotation", "VEC4", 4, in.mRotationKeys, in.mNumRotationKeys, quaternion);
    add_channel(node, "scale", "VEC3", 3, in.mScalingKeys, in.mNumScalingKeys, vector);
  }

  template <typename Key, typename Append>
  void add_channel(int node, const char* path, const char* type, size_t components, const Key* keys, size_t count,
                   const Append& append) {
    std::vector<float> times;
    std::vector<float> values;
    for (size_t i = 0; i < count; ++i) {
      const auto time = static_cast<float>(keys[i].mTime / ticks_);
      if (!times.empty() && time < times.back()) {
        ++backward_;
        continue;
      }
      if (!times.empty() && time == times.back())  // the later of two at one time holds from there on
        values.resize(values.size() - components);
      else
        times.push_back(time);
      append(keys[i], values);
    }
    if (times.empty()) return;
    const std::string what = fmt::format("{} of node {} in clip {}", path,
                                         shown(c_.nodes[static_cast<size_t>(node)]->mName.C_Str()), shown(clip_));
    const int output = c_.glb.accessor(values, type, times.size());
    c_.label("accessors", output, what);
    out_["channels"].push_back({{"sampler", out_["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
    out_["samplers"].push_back({{"input", times_accessor(times, what)}, {"output", output}});
  }

  // Channels mostly share their key times.
  int times_accessor(const std::vector<float>& times, const std::string& what) {
    const auto found = times_.find(times);
    if (found != times_.end()) return found->second;
    const int index = c_.glb.accessor(times, "SCALAR", times.size());
    c_.label("accessors", index, "key times of " + what);
    times_.emplace(times, index);
    return index;
  }

  Conversion& c_;
  std::string clip_;
  double ticks_ = kAssumedTicks;
  nlohmann::json out_;
  std::set<int> moved_;  // nodes, by the clip
  std::map<std::vector<float>, int> times_;
  size_t unknown_ = 0;
  size_t backward_ = 0;
};

}  // namespace

void convert_animations(Conversion& c) { Animations(c).run(); }

}  // namespace crowdbench::scene::assimp_module
