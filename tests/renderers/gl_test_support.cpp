#include "gl_test_support.h"

#include <cmath>
#include <numbers>

#include "core/portable_math.h"
#include "scene/cast/cast.h"
#include "scene/mannequin/mannequin.h"

namespace crowdbench::renderers::testing {
namespace {

// A material, a mesh vertex by vertex; every quad is two triangles, counter-clockwise from outside.
struct Builder {
  scene::Character character;

  void vertex(const glm::vec3& p, const glm::vec3& n, uint16_t joint) {
    scene::Mesh& m = character.mesh;
    m.positions.push_back(p);
    m.normals.push_back(n);
    m.uvs.emplace_back(0.0F);
    m.joints.emplace_back(joint, 0, 0, 0);
    m.weights.emplace_back(1.0F, 0.0F, 0.0F, 0.0F);
  }
  void quad(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d, uint16_t joint) {
    const glm::vec3 n = glm::normalize(glm::cross(b - a, d - a));
    const auto first = static_cast<uint32_t>(character.mesh.positions.size());
    for (const glm::vec3& p : {a, b, c, d}) vertex(p, n, joint);
    for (const uint32_t i : {0U, 1U, 2U, 0U, 2U, 3U}) character.mesh.indices.push_back(first + i);
  }
  void box(const glm::vec3& low, const glm::vec3& high, uint16_t joint) {
    const auto corner = [&](int x, int y, int z) {
      return glm::vec3(x ? high.x : low.x, y ? high.y : low.y, z ? high.z : low.z);
    };
    quad(corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1), joint);
    quad(corner(1, 0, 0), corner(0, 0, 0), corner(0, 1, 0), corner(1, 1, 0), joint);
    quad(corner(1, 0, 1), corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1), joint);
    quad(corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0), joint);
    quad(corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0), corner(0, 1, 0), joint);
    quad(corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1), joint);
  }
  void joint(const std::string& name, int parent, const glm::dvec3& translation, const glm::dvec3& bind_origin) {
    scene::Node node;
    node.name = name;
    node.parent = parent;
    node.translation = translation;
    scene::Joint entry;
    entry.name = name;
    entry.node = static_cast<int>(character.skeleton.nodes.size());
    entry.inverse_bind[3] = glm::dvec4(-bind_origin, 1.0);
    character.skeleton.nodes.push_back(node);
    character.skeleton.joints.push_back(entry);
    character.skeleton.root_node = 0;
  }
  scene::Character finish(const glm::vec4& colour) {
    scene::Material material;
    material.base_colour = colour;
    character.materials.push_back(material);
    scene::Primitive primitive;
    primitive.index_count = static_cast<uint32_t>(character.mesh.indices.size());
    primitive.vertex_count = static_cast<uint32_t>(character.mesh.positions.size());
    character.mesh.primitives.push_back(primitive);
    character.motion.resize(character.clips.size());
    character.content_hash = character.name;
    return std::move(character);
  }
};

}  // namespace

gl::Context& context() {
  static gl::Context one(gl::ContextOptions{.device = {}, .debug = true});
  return one;
}

void GlTest::SetUp() {
  context().make_current();
  context().take_debug_messages();
}

void GlTest::TearDown() {
  for (const std::string& message : context().take_debug_messages()) ADD_FAILURE() << "OpenGL: " << message;
}

scene::Character card(float width, float height, const glm::vec4& colour) {
  Builder b;
  b.character.name = "card";
  b.joint("root", -1, {}, {});
  b.quad({-width / 2, 0, 0}, {width / 2, 0, 0}, {width / 2, height, 0}, {-width / 2, height, 0}, 0);
  return b.finish(colour);
}

scene::Character card_of_two_joints() {
  scene::Character c = card(2, 1);
  c.skeleton.nodes.push_back(c.skeleton.nodes[0]);
  c.skeleton.nodes[1].parent = 0;
  c.skeleton.joints.push_back(c.skeleton.joints[0]);
  c.skeleton.joints[1].node = 1;
  for (size_t v = 0; v < 4; ++v) {
    const float h = c.mesh.positions[v].y;
    c.mesh.joints[v] = {0, 1, 0, 0};
    c.mesh.weights[v] = {1 - h, h, 0.0F, 0.0F};
  }
  return c;
}

scene::Character two_bones() {
  Builder b;
  b.character.name = "two_bones";
  b.joint("lower", -1, {}, {});
  b.joint("upper", 0, {0, 1, 0}, {0, 1, 0});
  b.box({-0.1F, 0, -0.1F}, {0.1F, 1, 0.1F}, 0);
  b.box({-0.1F, 1, -0.1F}, {0.1F, 1.8F, 0.1F}, 1);
  scene::Clip clip;
  clip.name = "bend";
  clip.start = 0;
  clip.end = 1;
  scene::Channel channel;
  channel.node = 1;
  channel.target = scene::Target::rotation;
  const double s = std::sqrt(0.5);
  channel.times = {0.0, 0.5, 1.0};
  channel.values = {0, 0, 0, 1, s, 0, 0, s, 0, 0, 0, 1};
  clip.channels.push_back(channel);
  b.character.clips.push_back(clip);
  return b.finish(glm::vec4(1.0F));
}

scene::Cast cast_of(scene::Character character, double rate) {
  scene::Cast cast;
  auto shared = std::make_shared<const scene::Character>(std::move(character));
  const std::vector<int> clips = shared->clips.empty() ? std::vector<int>{-1} : std::vector<int>{0};
  cast.banks.push_back(std::make_shared<const scene::PoseBank>(*shared, clips, rate));
  cast.characters.push_back(std::move(shared));
  cast.shares.push_back(1.0);
  return cast;
}

scene::Frame frame_of_one(double distance, double eye_height, int width, int height, double fov_y_deg) {
  scene::Frame frame;
  frame.camera.eye = {0, eye_height, distance};
  frame.camera.target = {0, eye_height, 0};
  frame.camera.fov_y = fov_y_deg * 3.14159265358979323846 / 180.0;
  frame.origin = frame.camera.eye;
  frame.width = width;
  frame.height = height;
  scene::Outfit white;
  for (glm::vec4& c : white.colours) c = glm::vec4(1.0F);
  frame.outfits.push_back(white);
  frame.agents.resize(1);
  return frame;
}

void add_agent(scene::Frame& frame, const scene::Cast& cast, const glm::dvec3& place, uint32_t id, double phase,
               float heading_turns, float scale) {
  scene::FrameAgent agent;
  agent.position = glm::vec3(place - frame.origin);
  agent.scale = scale;
  const SinCos heading = sincos_turns(heading_turns);
  agent.heading = {static_cast<float>(heading.sin), static_cast<float>(heading.cos)};
  agent.pose = cast.banks[0]->sample(0, phase);
  agent.phase = static_cast<float>(phase);
  agent.id = id;
  frame.agents[0].push_back(agent);
}

const scene::Cast& walker() {
  static const scene::Cast cast = cast_of(scene::make_mannequin({.triangles = 500}));
  return cast;
}

scene::Frame row_of_walkers(const std::vector<double>& phases) {
  scene::Frame frame = frame_of_one(14, 1.2, 480, 96, 14);
  for (size_t i = 0; i < phases.size(); ++i)
    add_agent(frame, walker(), {0.9 * static_cast<double>(i % 20) - 8.5, 0, 0}, static_cast<uint32_t>(i + 1), phases[i],
              0.13F * static_cast<float>(i), 0.8F + 0.02F * static_cast<float>(i));
  return frame;
}

std::unique_ptr<Representation> make(const scene::Cast& cast, const std::string& spec, const MakeOptions& how) {
  return make_representation(
      {.context = context(), .cast = cast, .bake_budget = how.budget, .use_cache = how.use_cache, .progress = false},
      parse_spec(spec));
}

double fact(const std::vector<std::pair<std::string, double>>& facts, const std::string& name) {
  for (const auto& [key, value] : facts)
    if (key == name) return value;
  ADD_FAILURE() << "no fact " << name;
  return 0;
}

scene::Frame frame_from(const scene::Cast& cast, const Viewpoint& view) {
  constexpr double kDegrees = std::numbers::pi / 180;
  const double azimuth = view.azimuth * kDegrees;
  const double elevation = view.elevation * kDegrees;
  scene::Frame frame = frame_of_one(5, 1, 200, 200, view.fov);
  const double distance = 1.75 * 200 / 120 / (2 * std::tan(frame.camera.fov_y / 2));
  const glm::dvec3 d{std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                     std::cos(azimuth) * std::cos(elevation)};
  const scene::PoseBank& bank = *cast.banks[0];
  frame.camera.target = view.around.value_or(0.5 * (glm::dvec3(bank.bounds_min()) + glm::dvec3(bank.bounds_max())));
  frame.camera.eye = frame.camera.target + distance * d;
  frame.camera.up = {-std::sin(azimuth) * std::sin(elevation), std::cos(elevation),
                     -std::cos(azimuth) * std::sin(elevation)};
  frame.origin = frame.camera.eye;
  add_agent(frame, cast, {0, 0, 0}, 1, view.phase, view.heading);
  return frame;
}

}  // namespace crowdbench::renderers::testing
