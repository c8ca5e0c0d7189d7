#include "tests/fuzz/random_character.h"

#include <algorithm>

#include "core/random.h"

namespace crowdbench::fuzz {
namespace {

// The input's bytes, and when they end numbers that follow from all of them: the shortest input is a character too.
class Draws {
 public:
  Draws(const uint8_t* data, size_t size) : data_(data), size_(size) {
    for (size_t i = 0; i < size; ++i) seed_ = mix64(seed_ ^ data[i]);
  }
  uint64_t below(uint64_t n) {
    const uint64_t drawn = at_ < size_ ? data_[at_] : random_bits(seed_, at_, 1);
    ++at_;
    return drawn % n;
  }
  bool one_in(uint64_t n) { return below(n) == 0; }
  // On a lattice of eighths within [-1, 1].
  double place() { return (static_cast<double>(below(17)) - 8) / 8; }
  glm::dvec3 point() {
    const double x = place();
    const double y = place();
    return {x, y, place()};
  }

 private:
  const uint8_t* data_;
  size_t size_, at_ = 0;
  uint64_t seed_ = 1;
};

void add_joints(Draws& draws, double size, scene::Character& made) {
  const uint64_t count = 1 + draws.below(5);
  std::vector<glm::dvec3> at;  // in the bind pose
  for (uint64_t j = 0; j < count; ++j) {
    scene::Node node;
    node.name = "j" + std::to_string(j);
    node.parent = j == 0 ? -1 : static_cast<int>(draws.below(j));
    node.translation = size * draws.point();
    if (draws.one_in(12)) node.scale = {draws.place(), draws.place(), draws.place()};
    at.push_back(node.translation + (j == 0 ? glm::dvec3(0) : at[static_cast<size_t>(node.parent)]));
    scene::Joint joint;
    joint.name = node.name;
    joint.node = static_cast<int>(j);
    if (!draws.one_in(12)) joint.inverse_bind[3] = glm::dvec4(-at.back(), 1.0);
    made.skeleton.nodes.push_back(node);
    made.skeleton.joints.push_back(joint);
  }
  made.skeleton.root_node = 0;
}

void add_vertex(Draws& draws, double size, scene::Character& made) {
  scene::Mesh& mesh = made.mesh;
  mesh.positions.emplace_back(size * draws.point());
  const glm::dvec3 normal = draws.point();
  mesh.normals.emplace_back(glm::length(normal) > 0 ? glm::normalize(normal) : glm::dvec3(0, 0, 1));
  mesh.uvs.emplace_back(draws.place(), draws.place());
  glm::vec4 weights(0.0F);
  glm::u16vec4 joints(0);
  for (int k = 0; k < scene::kInfluences; ++k) {
    joints[k] = static_cast<uint16_t>(draws.below(made.skeleton.joints.size()));
    weights[k] = draws.one_in(2) ? static_cast<float>(draws.below(256)) : 0.0F;
  }
  const float sum = weights.x + weights.y + weights.z + weights.w;
  mesh.joints.push_back(joints);
  mesh.weights.push_back(sum > 0 ? weights / sum : glm::vec4(1, 0, 0, 0));
}

void add_mesh(Draws& draws, double size, scene::Character& made) {
  const uint64_t vertices = 3 + draws.below(22);
  for (uint64_t v = 0; v < vertices; ++v) add_vertex(draws, size, made);
  const uint64_t materials = 1 + draws.below(2);
  for (uint64_t m = 0; m < materials; ++m) {
    scene::Material material;
    material.double_sided = draws.one_in(2);
    material.unlit = draws.one_in(8);
    material.slot = static_cast<uint8_t>(m);
    if (draws.one_in(4)) material.emissive = glm::vec3(1.0F, 0.5F, 0.0F);
    made.materials.push_back(material);
    scene::Primitive primitive;
    primitive.first_index = static_cast<uint32_t>(made.mesh.indices.size());
    primitive.index_count = static_cast<uint32_t>(3 * (1 + draws.below(8)));
    primitive.vertex_count = static_cast<uint32_t>(vertices);
    primitive.material = static_cast<int>(m);
    for (uint32_t i = 0; i < primitive.index_count; ++i)
      made.mesh.indices.push_back(static_cast<uint32_t>(draws.below(vertices)));
    made.mesh.primitives.push_back(primitive);
  }
}

void add_clip(Draws& draws, double size, scene::Character& made) {
  scene::Clip clip;
  clip.name = "move";
  const uint64_t channels = 1 + draws.below(3);
  for (uint64_t c = 0; c < channels; ++c) {
    scene::Channel channel;
    channel.node = static_cast<int>(draws.below(made.skeleton.nodes.size()));
    channel.target = static_cast<scene::Target>(draws.below(3));
    channel.interpolation = draws.one_in(3) ? scene::Interpolation::step : scene::Interpolation::linear;
    const uint64_t keys = 1 + draws.below(4);
    for (uint64_t k = 0; k < keys; ++k) {
      channel.times.push_back(static_cast<double>(k) * (draws.one_in(4) ? 1e-4 : 0.25) +
                              (k > 0 ? channel.times.back() : 0));
      glm::dvec4 value(draws.point(), draws.place());
      if (channel.target == scene::Target::translation) value *= size;
      if (channel.target == scene::Target::rotation)
        value = glm::length(value) > 0 ? glm::normalize(value) : glm::dvec4(0, 0, 0, 1);
      for (int i = 0; i < (channel.target == scene::Target::rotation ? 4 : 3); ++i) channel.values.push_back(value[i]);
    }
    clip.end = std::max(clip.end, channel.times.back());
    clip.channels.push_back(channel);
  }
  made.clips.push_back(clip);
}

}  // namespace

scene::Character random_character(const uint8_t* data, size_t size) {
  Draws draws(data, size);
  scene::Character made;
  made.name = made.source = "random";
  static constexpr double kSizes[] = {1, 1, 1e-3, 1e3};
  const double metres = kSizes[draws.below(4)];
  add_joints(draws, metres, made);
  add_mesh(draws, metres, made);
  if (!draws.one_in(4)) add_clip(draws, metres, made);
  return made;
}

}  // namespace crowdbench::fuzz
