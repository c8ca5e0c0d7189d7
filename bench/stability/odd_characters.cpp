#include "bench/stability/odd_characters.h"

#include <cmath>
#include <memory>

#include "scene/pose/normalise.h"

namespace crowdbench::bench {
namespace {

// A character of boxes, each on a joint of its own or on the first.
class Boxes {
 public:
  explicit Boxes(std::string name) {
    made_.name = made_.source = std::move(name);
    made_.materials.emplace_back();
    made_.materials.back().base_colour = {0.6F, 0.4F, 0.2F, 1.0F};
  }
  // at: of the joint, in its parent's space; bind: the same in the space of the mesh.
  uint16_t joint(int parent, const glm::dvec3& at, const glm::dvec3& bind) {
    const size_t index = made_.skeleton.nodes.size();
    scene::Node node;
    node.name = "j" + std::to_string(index);
    node.parent = parent;
    node.translation = at;
    scene::Joint entry;
    entry.name = node.name;
    entry.node = static_cast<int>(index);
    entry.inverse_bind[3] = glm::dvec4(-bind, 1.0);
    made_.skeleton.nodes.push_back(node);
    made_.skeleton.joints.push_back(entry);
    made_.skeleton.root_node = 0;
    return static_cast<uint16_t>(index);
  }
  void triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, uint16_t joint) {
    scene::Mesh& mesh = made_.mesh;
    const glm::vec3 across = glm::cross(b - a, c - a);
    const float area = glm::length(across);
    for (const glm::vec3& p : {a, b, c}) {
      mesh.indices.push_back(static_cast<uint32_t>(mesh.positions.size()));
      mesh.positions.push_back(p);
      mesh.normals.push_back(area > 0 ? across / area : glm::vec3(0, 0, 1));
      mesh.uvs.emplace_back(0.0F);
      mesh.joints.emplace_back(joint, 0, 0, 0);
      mesh.weights.emplace_back(1.0F, 0.0F, 0.0F, 0.0F);
    }
  }
  void box(const glm::vec3& low, const glm::vec3& high, uint16_t joint) {
    const auto at = [&](int corner) {
      return glm::vec3((corner & 1) != 0 ? high.x : low.x, (corner & 2) != 0 ? high.y : low.y,
                       (corner & 4) != 0 ? high.z : low.z);
    };
    static constexpr int kFaces[6][4] = {{4, 5, 7, 6}, {1, 0, 2, 3}, {5, 1, 3, 7},
                                         {0, 4, 6, 2}, {6, 7, 3, 2}, {0, 1, 5, 4}};
    for (const auto& face : kFaces) {
      triangle(at(face[0]), at(face[1]), at(face[2]), joint);
      triangle(at(face[0]), at(face[2]), at(face[3]), joint);
    }
  }
  // One channel over a second; the first value again at its end.
  void clip(scene::Target target, int node, const std::vector<double>& first, const std::vector<double>& middle) {
    scene::Clip clip;
    clip.name = "move";
    clip.end = 1;
    scene::Channel channel;
    channel.node = node;
    channel.target = target;
    channel.times = {0, 0.5, 1};
    for (const auto* values : {&first, &middle, &first})
      channel.values.insert(channel.values.end(), values->begin(), values->end());
    clip.channels.push_back(channel);
    made_.clips.push_back(clip);
  }
  scene::Character finish() {
    scene::Primitive primitive;
    primitive.index_count = static_cast<uint32_t>(made_.mesh.indices.size());
    primitive.vertex_count = static_cast<uint32_t>(made_.mesh.positions.size());
    made_.mesh.primitives.push_back(primitive);
    scene::NormaliseOptions as_it_is;
    as_it_is.height.reset();
    scene::normalise(made_, as_it_is);
    return std::move(made_);
  }
  scene::Character& made() { return made_; }

 private:
  scene::Character made_;
};

constexpr glm::vec3 kLow(-0.3F, 0.0F, -0.2F);
constexpr glm::vec3 kHigh(0.3F, 1.0F, 0.2F);

Boxes one_box(std::string name, const glm::vec3& low = kLow, const glm::vec3& high = kHigh) {
  Boxes boxes(std::move(name));
  boxes.box(low, high, boxes.joint(-1, {}, {}));
  return boxes;
}

scene::Character one_triangle() {
  Boxes boxes("one_triangle");
  const uint16_t joint = boxes.joint(-1, {}, {});
  boxes.triangle({-0.5F, 0, 0}, {0.5F, 0, 0}, {0, 1, 0}, joint);
  boxes.made().materials[0].double_sided = true;
  return boxes.finish();
}
scene::Character one_joint() { return one_box("one_joint").finish(); }
scene::Character idle_joint() {
  Boxes boxes = one_box("idle_joint");
  boxes.joint(0, {0, 5, 0}, {0, 5, 0});
  return boxes.finish();
}
scene::Character no_area() {
  Boxes boxes = one_box("no_area");
  boxes.triangle({0, 0.5F, 0}, {0, 0.5F, 0}, {0, 0.5F, 0}, 0);     // a point
  boxes.triangle({-0.3F, 0, 0}, {0, 0, 0}, {0.3F, 0, 0}, 0);       // a line
  boxes.triangle({0, 1, 0.2F}, {0, 1, 0.2F}, {0.1F, 1, 0.2F}, 0);  // two corners in one place
  return boxes.finish();
}
scene::Character needle() { return one_box("needle", {-0.008F, 0, -0.008F}, {0.008F, 1, 0.008F}).finish(); }
scene::Character sheet() { return one_box("sheet", {-0.3F, 0, 0}, {0.3F, 1, 0}).finish(); }

scene::Character two_boxes(std::string name, scene::Target target, const std::vector<double>& first,
                           const std::vector<double>& middle) {
  Boxes boxes = one_box(std::move(name), {-0.3F, 0, -0.2F}, {0.3F, 0.5F, 0.2F});
  boxes.box({-0.3F, 0.5F, -0.2F}, {0.3F, 1.0F, 0.2F}, boxes.joint(0, {0, 0.5, 0}, {0, 0.5, 0}));
  boxes.clip(target, 1, first, middle);
  return boxes.finish();
}
scene::Character scaled_to_nothing() {
  return two_boxes("scaled_to_nothing", scene::Target::scale, {0, 0, 0}, {1, 1, 1});
}
scene::Character mirrored() {
  scene::Character made = two_boxes("mirrored", scene::Target::scale, {-1, 1, 1}, {-1, 1.25, 1});
  made.materials[0].double_sided = true;  // culling goes by the rest pose
  return made;
}
scene::Character opposite_quaternions() {
  return two_boxes("opposite_quaternions", scene::Target::rotation, {0, 0, 0, 1}, {0, 0, 0, -1});
}

scene::Character many_joints() {
  constexpr int kJoints = 255;
  Boxes boxes("joints_255");
  const double step = 1.0 / kJoints;
  for (int i = 0; i < kJoints; ++i) {
    const uint16_t joint = boxes.joint(i - 1, {0, i == 0 ? 0 : step, 0}, {0, i * step, 0});
    boxes.box({-0.2F, static_cast<float>(i * step), -0.2F}, {0.2F, static_cast<float>((i + 1) * step), 0.2F}, joint);
  }
  return boxes.finish();
}

scene::Character tiny() { return one_box("scale_1e-3", kLow * 1e-3F, kHigh * 1e-3F).finish(); }
scene::Character huge() { return one_box("scale_1e3", kLow * 1e3F, kHigh * 1e3F).finish(); }

// A ball, upper half on a joint of its own.
scene::Character many_triangles() {
  constexpr int kAround = 388;
  constexpr int kUp = 388;  // 2 x 388 x 387 triangles
  Boxes boxes("triangles_300k");
  const uint16_t lower = boxes.joint(-1, {}, {});
  const uint16_t upper = boxes.joint(0, {0, 0.5, 0}, {0, 0.5, 0});
  const auto at = [](int i, int j) {
    constexpr double kPi = 3.14159265358979323846;
    const double azimuth = 2 * kPi * (i % kAround) / kAround;
    const double up = kPi * j / kUp;
    return glm::vec3(0.5 *
                     glm::dvec3(std::sin(azimuth) * std::sin(up), 1 - std::cos(up), std::cos(azimuth) * std::sin(up)));
  };
  for (int j = 0; j < kUp; ++j)
    for (int i = 0; i < kAround; ++i) {
      const uint16_t joint = 2 * j < kUp ? lower : upper;
      if (j + 1 < kUp) boxes.triangle(at(i, j), at(i + 1, j + 1), at(i, j + 1), joint);
      if (j > 0) boxes.triangle(at(i, j), at(i + 1, j), at(i + 1, j + 1), joint);
    }
  return boxes.finish();
}

// A wall of 50 x 100, each brick on a joint of its own.
scene::Character many_boxes() {
  constexpr int kAcross = 50;
  constexpr int kUp = 100;
  constexpr double kSide = 0.02;
  Boxes boxes("boxes_5000");
  boxes.joint(-1, {}, {});
  for (int y = 0; y < kUp; ++y)
    for (int x = 0; x < kAcross; ++x) {
      const glm::dvec3 low((x - 0.5 * kAcross) * kSide, y * kSide, -0.1);
      const uint16_t joint = x + y == 0 ? uint16_t{0} : boxes.joint(0, low, low);
      boxes.box(glm::vec3(low), glm::vec3(low + glm::dvec3(kSide, kSide, 0.2)), joint);
    }
  return boxes.finish();
}

}  // namespace

const std::vector<OddCharacter>& large_characters() {
  static const std::vector<OddCharacter> all = {
      {"triangles_300k", "a ball of 300,312 triangles on two joints", many_triangles},
      {"boxes_5000", "a wall of 5,000 bricks on as many joints", many_boxes},
  };
  return all;
}

const std::vector<OddCharacter>& odd_characters() {
  static const std::vector<OddCharacter> all = {
      {"one_triangle", "one triangle, seen from both sides", one_triangle},
      {"one_joint", "a box on one joint, no clip", one_joint},
      {"idle_joint", "a joint that moves no triangle, five units above", idle_joint},
      {"no_area", "triangles that are a point, a line, and two corners in one place", no_area},
      {"needle", "16 mm thick, two pixels, and a metre tall", needle},
      {"sheet", "a box without depth", sheet},
      {"scaled_to_nothing", "a joint whose scale is 0 in the pose that is drawn", scaled_to_nothing},
      {"mirrored", "a joint of negative scale", mirrored},
      {"opposite_quaternions", "keys q and -q: the shortest arc stays where it is", opposite_quaternions},
      {"joints_255", "a chain of 255 joints", many_joints},
      {"scale_1e-3", "a millimetre tall", tiny},
      {"scale_1e3", "a kilometre tall", huge},
  };
  return all;
}

scene::Cast odd_cast(const OddCharacter& odd) {
  scene::Cast cast;
  auto shared = std::make_shared<const scene::Character>(odd.make());
  const std::vector<int> clips = shared->clips.empty() ? std::vector<int>{-1} : std::vector<int>{0};
  cast.banks.push_back(std::make_shared<const scene::PoseBank>(*shared, clips));
  cast.characters.push_back(std::move(shared));
  cast.shares.push_back(1.0);
  return cast;
}

}  // namespace crowdbench::bench
