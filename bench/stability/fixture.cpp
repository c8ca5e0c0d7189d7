#include "bench/stability/fixture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "core/portable_math.h"
#include "scene/cast/load_cast.h"

namespace crowdbench::bench {
namespace {

constexpr int kAround = 8;     // pixels on each side of the worst
constexpr int kEnlarged = 16;  // times

std::string code_text(const uint8_t* pixel) { return fmt::format("#{:02x}{:02x}{:02x}", pixel[0], pixel[1], pixel[2]); }

int pixel_difference(const uint8_t* a, const uint8_t* b) {
  return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
}

}  // namespace

Fixture::Fixture(gl::Context& context, bool small, bool full, bool use_cache)
    : context_(context), small_(small), full_(full), use_cache_(use_cache), spec_(renderers::reference_spec()) {}

Fixture::~Fixture() = default;

void Fixture::ask(const renderers::Spec& spec) {
  if (spec.text() == spec_.text()) return;
  spec_ = spec;
  representation_.reset();
}

const renderers::RepresentationType& Fixture::type() const { return renderers::representation_type(spec_.name); }

const scene::Cast& Fixture::walker() {
  if (!walker_) {
    scene::Scenario scenario;
    scenario.characters.front().source = "mannequin:triangles=500";
    walker_ = scene::load_cast(scenario);
  }
  return *walker_;
}

renderers::Representation& Fixture::representation() {
  if (!representation_)
    representation_ =
        renderers::make_representation({.context = context_, .cast = walker(), .use_cache = use_cache_}, spec_);
  return *representation_;
}

renderers::Representation& Fixture::mesh() {
  if (!mesh_)
    mesh_ = renderers::make_representation({.context = context_, .cast = walker()}, renderers::reference_spec());
  return *mesh_;
}

renderers::Capture Fixture::draw(const scene::Frame& frame, bool linear) {
  if (!renderer_) renderer_ = std::make_unique<renderers::Renderer>(context_, walker());
  return renderer_->capture(frame, representation(), {.linear = linear});
}

void Fixture::replace(std::unique_ptr<renderers::Representation> representation) {
  representation_ = std::move(representation);
}

renderers::Capture Fixture::draw_mesh(const scene::Frame& frame) {
  if (!renderer_) renderer_ = std::make_unique<renderers::Renderer>(context_, walker());
  return renderer_->capture(frame, mesh());
}

renderers::Capture Fixture::draw_stored(const scene::Frame& frame, const renderers::DepthStorage& storage) {
  if (!renderer_) renderer_ = std::make_unique<renderers::Renderer>(context_, walker());
  return renderers::capture_stored(context_, *renderer_, frame, representation(), storage);
}

scene::Frame empty_frame(const glm::dvec3& eye, const glm::dvec3& target, double fov_deg, int width, int height) {
  scene::Frame frame;
  frame.camera.eye = eye;
  frame.camera.target = target;
  frame.camera.fov_y = fov_deg * 3.14159265358979323846 / 180;
  frame.origin = eye;
  frame.width = width;
  frame.height = height;
  scene::Outfit white;
  for (glm::vec4& colour : white.colours) colour = glm::vec4(1.0F);
  frame.outfits.push_back(white);
  frame.agents.resize(1);
  return frame;
}

void add_agent(scene::Frame& frame, const scene::Cast& cast, const glm::dvec3& place, double phase,
               double heading_turns, double scale) {
  scene::FrameAgent agent;
  agent.position = glm::vec3(place - frame.origin);
  agent.scale = static_cast<float>(scale);
  const SinCos heading = sincos_turns(heading_turns);
  agent.heading = {static_cast<float>(heading.sin), static_cast<float>(heading.cos)};
  agent.pose = cast.banks[0]->sample(0, phase);
  agent.phase = static_cast<float>(phase);
  agent.id = static_cast<uint32_t>(frame.agents[0].size()) + 1;
  frame.agents[0].push_back(agent);
}

Image8 enlarged(const Image8& picture, int x, int y) {
  const int side = 2 * kAround + 1;
  Image8 out(side * kEnlarged, side * kEnlarged, 3);
  for (int row = 0; row < out.height; ++row)
    for (int column = 0; column < out.width; ++column) {
      const int i = column / kEnlarged - kAround;
      const int j = row / kEnlarged - kAround;
      uint8_t* to = out.at(column, row);
      const int within_x = column % kEnlarged;
      const int within_y = row % kEnlarged;
      const bool rim = within_x == 0 || within_y == 0 || within_x == kEnlarged - 1 || within_y == kEnlarged - 1;
      const bool inside = x + i >= 0 && y + j >= 0 && x + i < picture.width && y + j < picture.height;
      for (int c = 0; c < 3; ++c) to[c] = inside ? picture.at(x + i, y + j)[c] : 255;
      if (i == 0 && j == 0 && rim) {
        to[0] = 255;
        to[1] = to[2] = 0;
      }
    }
  return out;
}

Found largest_difference(const Image8& expected, const Image8& got) {
  Found found;
  int worst = 0;
  int x = 0;
  int y = 0;
  uint64_t different = 0;
  for (int row = 0; row < expected.height; ++row)
    for (int column = 0; column < expected.width; ++column) {
      const int difference = pixel_difference(expected.at(column, row), got.at(column, row));
      different += difference > 0 ? 1U : 0U;
      if (difference <= worst) continue;
      worst = difference;
      x = column;
      y = row;
    }
  found.measured = worst;
  if (worst == 0) return found;
  found.place = fmt::format("pixel ({}, {})", x, y);
  found.expected = code_text(expected.at(x, y));
  found.got = code_text(got.at(x, y));
  found.note = fmt::format("{} of {} pixels differ", different, expected.pixels());
  found.before = enlarged(expected, x, y);
  found.after = enlarged(got, x, y);
  return found;
}

Insane insane_pixels(const renderers::Capture& capture, const scene::Frame& frame) {
  std::set<uint32_t> ids = {0};
  for (const auto& agents : frame.agents)
    for (const scene::FrameAgent& agent : agents) ids.insert(agent.id);
  // A depth is 24 bits of a ratio with the near plane, read back by a division: two spacings of a float.
  const double near = frame.camera.near * (1 - 0x1p-22);
  const double far = frame.camera.far > 0 ? frame.camera.far * (1 + 0x1p-22) : std::numeric_limits<double>::infinity();
  Insane out;
  for (int y = 0; y < capture.ids.height; ++y)
    for (int x = 0; x < capture.ids.width; ++x) {
      const double depth = static_cast<double>(*capture.depth.at(x, y));
      const uint32_t id = *capture.ids.at(x, y);
      const bool strange = !ids.contains(id);
      const bool lost = id != 0 && !std::isfinite(depth);
      const bool out_of_range = std::isnan(depth) || (std::isfinite(depth) && (depth < near || depth > far));
      bool no_colour = false;
      if (!capture.linear.empty())
        for (int c = 0; c < 3; ++c) no_colour = no_colour || !std::isfinite(capture.linear.at(x, y)[c]);
      if (!strange && !lost && !out_of_range && !no_colour) continue;
      if (out.pixels++ > 0) continue;
      out.x = x;
      out.y = y;
      out.what = fmt::format("id {}, depth {:g} m{}", id, depth, no_colour ? ", a colour that is not a number" : "");
    }
  return out;
}

StepChange step_change(const Image8& before, const Image8& after) {
  StepChange out;
  int worst = 0;
  for (int y = 0; y < before.height; ++y)
    for (int x = 0; x < before.width; ++x) {
      const uint8_t* here = before.at(x, y);
      if (x + 1 < before.width && pixel_difference(here, before.at(x + 1, y)) > kSeen) ++out.edges;
      if (y + 1 < before.height && pixel_difference(here, before.at(x, y + 1)) > kSeen) ++out.edges;
      const int change = pixel_difference(here, after.at(x, y));
      out.changed += change > kSeen ? 1U : 0U;
      if (change <= worst) continue;
      worst = change;
      out.x = x;
      out.y = y;
    }
  return out;
}

double step_bound(uint64_t edges, double pixels) {
  const double mean = 2 * static_cast<double>(edges) * std::min(pixels, 1.0);
  return std::floor(mean + 6 * std::sqrt(mean) + 3);
}

}  // namespace crowdbench::bench
