#include "renderers/relief/relief.h"

#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <chrono>
#include <cmath>
#include <optional>
#include <tuple>

#include "core/error.h"
#include "core/hash.h"
#include "renderers/bake_cache.h"
#include "renderers/emission.h"
#include "renderers/frame_resources.h"
#include "renderers/gl/objects.h"
#include "renderers/gl/program.h"
#include "renderers/relief/relief.shared.h"
#include "renderers/relief/relief_atlas.h"
#include "renderers/relief/relief_bake.h"
#include "renderers/relief/relief_bends.h"
#include "renderers/relief/relief_cone.h"
#include "renderers/shaders/bindings.shared.h"

namespace crowdbench::renderers {
namespace {

constexpr uint32_t kBakeVersion = 8;
constexpr int kGroup = 64;  // local_size_x of relief.comp

// Distances at which joints may share boxes, from the nearest tier on. A tier is drawn below its height; tier 0, every
// joint on its own, above all.
struct TierPlan {
  double pixels;  // of the character's height
  double texel;   // the most that a texel may cover at that height, in pixels
};
// Rays cross as many texels a pixel whatever the box; the farther, the finer, since an outline is off by half a texel
// of ever thinner limbs.
constexpr std::array<TierPlan, 4> kTiers{{{100, 0.4}, {50, 0.22}, {25, 0.15}, {12.5, 0.12}}};

constexpr double kBendPixels = 240;
constexpr double kPart = 0.27;  // of the height: one of 128 texels is then at most a pixel of a character 480 tall

struct Options {
  ReliefBakeOptions bake;
  std::string capture;
  std::string resolution;
  int depth_bits = 16;
  int search = RELIEF_SEARCH_ADAPTIVE;
  int linear_steps = 256;
  int binary_steps = 7;
  double level_bias = 0;
  bool hull = true;
  double merge = 0;  // pixels
  double bend = 0;   // pixels, of a character kBendPixels tall
  double part = 0;   // of the character's height; 0: no box is parted
  bool part_auto = false;
  uint64_t budget = 0;  // bytes a character; 0: none
  int debug = 0;
  bool floor = false;
};

// One character's bake: a model a tier.
struct Bake {
  CaptureScore capture;
  std::vector<double> tier_pixels;  // of each model after the first
  std::vector<ReliefModel> models;
  std::vector<std::vector<uint8_t>> cones;  // of each model; none unless the search uses them
};

// Metres at scale 1.
double height_of(const scene::Character& character) {
  return character.placement.height > 0 ? character.placement.height : 1.75;
}

double number_of(const char* begin, const char* end, const char* where, const std::string& text, double low,
                 double high, const char* advice) {
  double value = 0;
  const auto [last, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || last != end || !(value >= low && value < high))
    throw Error(where, fmt::format("\"{}\" is not understood", printable(text)), advice);
  return value;
}

// "16+7": linear steps and binary refinements.
std::pair<int, int> parse_steps(const std::string& text) {
  int linear = 0;
  int binary = 0;
  const char* end = text.data() + text.size();
  auto [at, error] = std::from_chars(text.data(), end, linear);
  if (error == std::errc() && at != end && *at == '+') {
    auto [last, second] = std::from_chars(at + 1, end, binary);
    at = last;
    error = second;
  }
  if (error != std::errc() || at != end || linear < 1 || linear > 256 || binary < 0 || binary > 16)
    throw Error("relief: steps", fmt::format("\"{}\" is not LINEAR+BINARY", printable(text)),
                "write 1..256 + 0..16, as in 16+7");
  return {linear, binary};
}

// "bind" or "CLIP@PHASE".
CapturePose parse_capture(const std::string& text, const scene::Character& character) {
  CapturePose pose;
  if (text == "bind") return pose;
  const size_t at = text.rfind('@');
  if (at != std::string::npos)
    pose.phase = number_of(text.data() + at + 1, text.data() + text.size(), "relief: capture", text, 0, 1,
                           "write CLIP@PHASE with a phase in [0, 1), as in walk@0.25");
  pose.clip = scene::require_clip(character, text.substr(0, at));
  return pose;
}

// "none" or "Head@256+3@32": texels a side by joint, each named or counted from 0.
std::vector<int> parse_resolution(const std::string& text, const scene::Character& character) {
  if (text == "none") return {};
  const std::vector<scene::Joint>& joints = character.skeleton.joints;
  std::vector<int> texels(joints.size(), 0);
  for (size_t at = 0; at <= text.size();) {
    const size_t end = std::min(text.find('+', at), text.size());
    const std::string item = text.substr(at, end - at);
    at = end + 1;
    const size_t sign = item.rfind('@');
    const std::string name = item.substr(0, sign);
    int size = 0;
    if (sign != std::string::npos) {
      const char* last = item.data() + item.size();
      const auto [stop, fault] = std::from_chars(item.data() + sign + 1, last, size);
      if (fault != std::errc() || stop != last) size = 0;
    }
    if (size < 16 || size > 256 || !std::has_single_bit(static_cast<unsigned>(size)))
      throw Error("relief: resolution", fmt::format("\"{}\" is not JOINT@TEXELS", printable(item)),
                  "write 16, 32, 64, 128 or 256 texels, as in Head@256+LeftHand@32");
    size_t joint = 0;
    while (joint < joints.size() && joints[joint].name != name) ++joint;
    if (joint == joints.size()) {
      const auto [stop, fault] = std::from_chars(name.data(), name.data() + name.size(), joint);
      if (fault != std::errc() || stop != name.data() + name.size() || joint >= joints.size()) {
        std::vector<std::string> names;
        for (const scene::Joint& j : joints) names.push_back(j.name);
        const std::string near = nearest_name(name, names);
        throw Error("relief: resolution", fmt::format("{} has no joint \"{}\"", character.name, printable(name)),
                    near.empty() ? fmt::format("name one, or count from 0 to {}", joints.size() - 1)
                                 : fmt::format("did you mean \"{}\"?", printable(near)));
      }
    }
    texels[joint] = size;
  }
  return texels;
}

std::string cache_key(const scene::Character& character, const scene::PoseBank& bank, const Options& options,
                      uint64_t share) {
  Sha256 hash;
  hash.text("relief").value(kBakeVersion).text(character.content_hash).text(options.capture);
  hash.value(options.bake.map_size).value(options.bake.rule).value(options.bake.threshold).value(options.bake.by_area);
  hash.value(options.merge).value(options.budget).value(options.search == RELIEF_SEARCH_CONE);
  hash.text(options.resolution).value(options.bend).value(options.part).value(options.part_auto ? share : 0);
  // Which poses were measured.
  if (options.capture == "best" || options.merge > 0 || options.bend > 0)
    for (const scene::Mat3x4& m : bank.matrices()) hash.bytes(&m, sizeof m);
  return hash.hex();
}

// A box as it lies on disk.
struct StoredBox {
  std::array<int32_t, 2> joints{};
  double second = 0;
  int32_t texels = 0;
  int32_t nothing = 0;  // no padding: the same bake is the same bytes
  uint64_t first = 0;
  std::array<double, 16> bind_from_unit{};
  std::array<double, 3> size{};
  std::array<float, 3 * kHullPoints> hull{};
};

StoredBox stored(const ReliefBox& box) {
  StoredBox out{box.joints, box.second, box.texels, 0, box.first, {}, {}, {}};
  for (int i = 0; i < 16; ++i) out.bind_from_unit[static_cast<size_t>(i)] = box.bind_from_unit[i / 4][i % 4];
  for (int a = 0; a < 3; ++a) out.size[static_cast<size_t>(a)] = box.size[a];
  for (size_t i = 0; i < out.hull.size(); ++i) out.hull[i] = box.hull[i / 3][static_cast<int>(i % 3)];
  return out;
}

ReliefBox unstored(const StoredBox& from) {
  ReliefBox box;
  box.joints = from.joints;
  box.second = from.second;
  box.texels = from.texels;
  box.first = from.first;
  for (int i = 0; i < 16; ++i) box.bind_from_unit[i / 4][i % 4] = from.bind_from_unit[static_cast<size_t>(i)];
  for (int a = 0; a < 3; ++a) box.size[a] = from.size[static_cast<size_t>(a)];
  for (size_t i = 0; i < from.hull.size(); ++i) box.hull[i / 3][static_cast<int>(i % 3)] = from.hull[i];
  return box;
}

std::vector<uint8_t> serialise(const Bake& bake) {
  ByteWriter out;
  const CaptureScore& c = bake.capture;
  out.value(c.pose.clip);
  for (const double v : {c.pose.phase, c.silhouette_error, c.box_volume}) out.value(v);
  out.values(bake.tier_pixels);
  out.value(static_cast<uint32_t>(bake.models.size()));
  for (const ReliefModel& m : bake.models) {
    std::vector<StoredBox> boxes;
    for (const ReliefBox& box : m.boxes) boxes.push_back(stored(box));
    out.values(boxes);
    out.values(m.triangles_of_box);
    out.values(m.depth);
    out.values(m.extent);
    out.values(m.colour);
    out.values(m.normal);
    out.value(m.emission_peak);
    if (m.emission_peak > 0) out.values(m.emission);
  }
  for (const std::vector<uint8_t>& cones : bake.cones) out.values(cones);
  return out.bytes();
}

// std::nullopt when the bytes are not a bake of this version.
std::optional<Bake> deserialise(const std::vector<uint8_t>& bytes, size_t joints, bool cones) {
  ByteReader in(bytes);
  Bake bake;
  CaptureScore& c = bake.capture;
  c.pose.clip = in.value<int>();
  for (double* v : {&c.pose.phase, &c.silhouette_error, &c.box_volume}) *v = in.value<double>();
  bake.tier_pixels = in.values<double>();
  const auto count = in.value<uint32_t>();
  for (uint32_t i = 0; i < count && in.ok(); ++i) {
    ReliefModel& m = bake.models.emplace_back();
    for (const StoredBox& box : in.values<StoredBox>()) m.boxes.push_back(unstored(box));
    m.triangles_of_box = in.values<int>();
    m.depth = in.values<uint16_t>();
    m.extent = in.values<uint16_t>();
    m.colour = in.values<uint8_t>();
    m.normal = in.values<uint8_t>();
    m.emission_peak = in.value<float>();
    if (m.emission_peak > 0) m.emission = in.values<uint8_t>();
    size_t texels = 0;
    for (const ReliefBox& box : m.boxes) {
      if (box.texels < 16 || box.texels > 256 || box.first != texels) return std::nullopt;
      for (const int joint : box.joints)
        if (joint < 0 || static_cast<size_t>(joint) >= joints) return std::nullopt;
      texels += ReliefModel::box_texels(box);
    }
    if (m.boxes.empty() || m.triangles_of_box.size() != m.boxes.size() || m.depth.size() != texels * 6 ||
        m.extent.size() != texels * 6 || m.colour.size() != texels * 24 || m.normal.size() != texels * 24 ||
        m.emission.size() != (m.emission_peak > 0 ? texels * 24 : 0))
      return std::nullopt;
  }
  for (uint32_t i = 0; cones && i < count && in.ok(); ++i) {
    bake.cones.push_back(in.values<uint8_t>());
    const AtlasPlan plan = plan_atlas(bake.models[i]);
    if (bake.cones.back().size() != static_cast<size_t>(plan.width) * static_cast<size_t>(plan.height) * 4)
      return std::nullopt;
  }
  if (!in.ok() || !in.at_end() || bake.models.empty() || bake.tier_pixels.size() + 1 != bake.models.size())
    return std::nullopt;
  return bake;
}

// Bytes of a depth texel: two depths, and four cones when they are searched.
uint64_t depth_texel_bytes(const Options& options) {
  return static_cast<uint64_t>(options.depth_bits) / 4 + (options.search == RELIEF_SEARCH_CONE ? 4 : 0);
}

// Colours, normals and, of a character that glows, emission, of two faces to a depth texel.
uint64_t colour_texel_bytes(float emission_peak) { return 2 * 4 * (emission_peak > 0 ? 3 : 2); }

// Of so many texels of one map: three depth maps, six faces, and the levels.
uint64_t maps_bytes(uint64_t texels, float emission_peak, const Options& options) {
  return texels * 3 * (depth_texel_bytes(options) + colour_texel_bytes(emission_peak)) * 3 / 2;
}

uint64_t atlas_bytes(const ReliefModel& model, const Options& options) {
  const AtlasPlan plan = plan_atlas(model);
  return static_cast<uint64_t>(plan.width) * static_cast<uint64_t>(plan.height) *
             (depth_texel_bytes(options) + colour_texel_bytes(model.emission_peak)) +
         static_cast<uint64_t>(plan.width / 2) * static_cast<uint64_t>(plan.height / 2) * 2;
}

// Models of fewer boxes for smaller pictures. `nearest`: how the nearest tier was baked.
void add_tiers(const scene::Character& character, const scene::PoseBank& bank, const Options& options,
               const ReliefBakeOptions& nearest, Bake& bake) {
  ReliefBakeOptions what = nearest;
  what.pieces.clear();
  what.longest = 0;
  JointMerger merger(character, bank, what.capture);
  what.by_area = true;
  for (size_t tier = 0; tier < kTiers.size(); ++tier) {
    const double pixel = character.placement.height / kTiers[tier].pixels;  // metres
    what.carriers = merger.merged(options.merge * pixel);
    what.texel = std::max(nearest.texel, kTiers[tier].texel * pixel);
    // Joints that were given texels have half of them, 64 at least.
    for (size_t joint = 0; joint < what.texels_of_joint.size(); ++joint) {
      const int given = nearest.texels_of_joint[joint];
      what.texels_of_joint[joint] = std::min(given, std::max(64, given >> (tier + 1)));
    }
    ReliefModel model = bake_relief(character, what);
    if (model.boxes.size() < bake.models.back().boxes.size()) {
      bake.tier_pixels.push_back(kTiers[tier].pixels);
      bake.models.push_back(std::move(model));
    }
  }
}

// `share`: bytes of maps that part=auto keeps to.
Bake make_bake(const scene::Character& character, const scene::PoseBank& bank, const Options& options, uint64_t share) {
  Bake bake;
  ReliefBakeOptions what = options.bake;
  if (options.capture == "best")
    bake.capture = choose_capture(score_captures(character, bank, what.rule, what.threshold));
  else
    bake.capture.pose = parse_capture(options.capture, character);
  what.capture = bake.capture.pose;
  what.texels_of_joint = parse_resolution(options.resolution, character);
  const double height = height_of(character);
  if (options.bend > 0)
    what.pieces =
        bend_pieces(character, bank, what.capture, {what.rule, what.threshold, options.bend * height / kBendPixels});
  // Boxes in fewer parts, where the maps would take more than a character's share of the bake budget.
  for (double part = options.part; part > 0; part = options.part_auto && part < 1 ? part * 1.25 : 0) {
    what.longest = part * height;
    if (!options.part_auto || maps_bytes(relief_texels(character, what), emission_peak(character), options) <= share)
      break;
    what.longest = 0;
  }
  bake.models.push_back(bake_relief(character, what));
  // Under a budget the texels grow until the maps fit.
  while (options.budget > 0 && atlas_bytes(bake.models[0], options) > options.budget) {
    if (what.by_area && what.texels_of_joint.empty()) {
      double texel = 0;
      for (const ReliefBox& box : bake.models[0].boxes)
        texel = std::max(texel, std::max({box.size.x, box.size.y, box.size.z}) / box.texels);
      what.texel = std::max(what.texel, texel) * 1.25;
    } else {
      what.map_size /= 2;
      for (int& texels : what.texels_of_joint)
        if (texels > 0) texels = std::max(16, texels / 2);
    }
    if (what.map_size < 16 || what.texel > 1e3)
      throw Error("relief: budget", fmt::format("{} does not fit in {} bytes", character.name, options.budget),
                  "raise the budget");
    bake.models[0] = bake_relief(character, what);
  }
  if (options.merge > 0) add_tiers(character, bank, options, what, bake);
  if (options.search == RELIEF_SEARCH_CONE)
    for (const ReliefModel& model : bake.models) {
      const AtlasPlan plan = plan_atlas(model);
      bake.cones.push_back(derive_cones(model, plan, fill_atlas(model, plan)));
    }
  return bake;
}

// Everything on the GPU for one tier of one character type.
struct Tier {
  size_t boxes = 0;
  int joints = 0;
  int corners = 8;
  bool carve = true;  // the nearest tier: candidates are checked against the other axes
  gl::Texture depth;
  gl::Texture colour;
  gl::Texture normal;
  gl::Texture bounds;
  gl::Texture cones;     // with search=cone
  gl::Texture emission;  // of a character that glows
  float emission_peak = 0;
  uint64_t texels() const { return static_cast<uint64_t>(depth.width()) * static_cast<uint64_t>(depth.height()); }
  uint64_t texture_bytes() const {
    return depth.bytes() + colour.bytes() + normal.bytes() + bounds.bytes() + cones.bytes() + emission.bytes();
  }
  gl::Buffer records;
  gl::Buffer points;
  gl::Buffer indices;
  gl::VertexArray vertices;
  gl::Program pose;
  std::map<Pass, gl::Program> draw;
};

struct Baked {
  std::vector<Tier> tiers;
  std::vector<double> pixels;  // of tiers 1, ...
  std::vector<BakePart> parts;
  uint64_t full_texels = 0;  // of the nearest tier's depth picture, those of level 0
  double height = 0;         // metres at scale 1
  std::string key;
  bool cached = false;
  uint64_t disk_bytes = 0;
  uint64_t nominal_bytes = 0;
  CaptureScore capture;
  double texel = 0;  // metres, tier 0, the largest
};

struct BoxRecord {
  glm::vec4 rows[3];
  glm::uvec4 joints;
  glm::uvec4 maps;
};

class Relief final : public Representation {
 public:
  Relief(const MakeContext& make, Options options) : context_(make.context), options_(std::move(options)) {
    const auto begin = std::chrono::steady_clock::now();
    uint64_t left = make.bake_budget;
    for (size_t c = 0; c < make.cast.characters.size(); ++c)
      add(*make.cast.characters[c], *make.cast.banks[c], make, make.cast.characters.size() - c, left);
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  void draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
            const Pass& pass) override {
    for (size_t c = 0; c < baked_.size(); ++c) {
      Baked& baked = baked_[c];
      if (baked.tiers.size() == 1) {
        draw_tier(baked.tiers[0], c, resources, agents[c], pass);
        continue;
      }
      for (std::vector<uint32_t>& list : lists_) list.clear();
      lists_.resize(std::max(lists_.size(), baked.tiers.size()));
      // The picture may have more rows than the frame asks for (supersampling).
      std::array<int, 4> viewport{};
      glGetIntegerv(GL_VIEWPORT, viewport.data());
      const glm::dmat3 view = scene::view_rotation(frame.camera);
      const glm::vec3 back(glm::transpose(view)[2]);
      for (const uint32_t index : agents[c]) {
        const scene::FrameAgent& agent = frame.agents[c][index];
        const glm::vec3 middle =
            agent.position + glm::vec3(0.0F, 0.5F * agent.scale * static_cast<float>(baked.height), 0.0F);
        const double depth = std::max(static_cast<double>(-glm::dot(back, middle)), frame.camera.near);
        const double tall = agent.scale * baked.height / scene::pixel_size_at(frame.camera, depth, viewport[3]);
        size_t tier = 0;
        while (tier < baked.pixels.size() && tall < baked.pixels[tier]) ++tier;
        lists_[tier].push_back(index);
      }
      for (size_t tier = 0; tier < baked.tiers.size(); ++tier)
        draw_tier(baked.tiers[tier], c, resources, lists_[tier], pass);
    }
  }

  Footprint footprint() const override {
    Footprint out;
    for (const Baked& baked : baked_) {
      for (const Tier& tier : baked.tiers) {
        out.texture_bytes += tier.texture_bytes();
        out.buffer_bytes += tier.records.size() + tier.indices.size() + tier.points.size();
      }
      out.disk_bytes += baked.disk_bytes;
    }
    out.buffer_bytes += posed_ ? posed_.size() : 0;
    return out;
  }
  BakeInfo bake_info() const override {
    BakeInfo info;
    info.seconds = seconds_;
    info.cached = !baked_.empty();
    uint64_t nominal = 0;
    uint64_t actual = 0;
    Sha256 keys;
    for (const Baked& baked : baked_) {
      info.cached = info.cached && baked.cached;
      keys.text(baked.key);
      nominal += baked.nominal_bytes;
      for (const Tier& tier : baked.tiers) actual += tier.texture_bytes();
    }
    info.cache_key = baked_.size() == 1 ? baked_[0].key : keys.hex();
    info.facts = {{"nominal_bytes", static_cast<double>(nominal)}, {"actual_bytes", static_cast<double>(actual)}};
    if (baked_.size() == 1) {
      info.parts = baked_[0].parts;
      const Tier& nearest = baked_[0].tiers[0];
      const auto bytes = [](uint64_t n) { return static_cast<double>(n); };
      const uint64_t full = nearest.texture_bytes();
      // Of the nearest tier by kind, the kinds adding up with merged_bytes; levels and ids across the kinds.
      info.facts.emplace_back("depth_bytes", bytes(nearest.depth.bytes()));
      info.facts.emplace_back("colour_bytes", bytes(nearest.colour.bytes()));
      info.facts.emplace_back("normal_bytes", bytes(nearest.normal.bytes()));
      info.facts.emplace_back("bounds_bytes", bytes(nearest.bounds.bytes()));
      info.facts.emplace_back("cone_bytes", bytes(nearest.cones.bytes()));
      info.facts.emplace_back("emission_bytes", bytes(nearest.emission.bytes()));
      info.facts.emplace_back("merged_bytes", bytes(actual - full));
      info.facts.emplace_back("id_bytes", bytes((nearest.colour.bytes() + nearest.normal.bytes()) / 4));
      info.facts.emplace_back("level_bytes", bytes(full - full * baked_[0].full_texels / nearest.texels()));
      info.facts.emplace_back("texel_mm", 1000 * baked_[0].texel);
      info.facts.emplace_back("capture_clip", baked_[0].capture.pose.clip);
      info.facts.emplace_back("capture_phase", baked_[0].capture.pose.phase);
      if (baked_[0].capture.box_volume > 0)
        info.facts.emplace_back("capture_silhouette_error", baked_[0].capture.silhouette_error);
      for (size_t i = 0; i < baked_[0].tiers.size(); ++i)
        info.facts.emplace_back(i == 0 ? "boxes" : fmt::format("boxes_below_{:g}_px", baked_[0].pixels[i - 1]),
                                static_cast<double>(baked_[0].tiers[i].boxes));
    }
    return info;
  }
  uint64_t triangles(size_t character) const override {
    const Tier& tier = baked_[character].tiers[0];
    return tier.boxes * (options_.hull ? static_cast<size_t>(tier.corners) - 2 : 12);
  }
  double texel_metres(size_t character) const override { return baked_[character].texel; }

 private:
  void add(const scene::Character& character, const scene::PoseBank& bank, const MakeContext& make,
           size_t characters_left, uint64_t& left) {
    const auto n = static_cast<uint64_t>(options_.bake.map_size);
    const std::vector<int> given = parse_resolution(options_.resolution, character);
    if (options_.budget == 0) {
      uint64_t texels = character.skeleton.joints.size() * n * n;
      for (const int side : given)
        if (side > 0) texels += static_cast<uint64_t>(side * side) - n * n;
      const uint64_t bytes = maps_bytes(texels, emission_peak(character), options_);
      if (bytes > left)
        throw Error(
            "relief",
            fmt::format("{} joints at {} texels need up to {} MiB, more than the {} MiB left of the bake budget",
                        character.skeleton.joints.size(), n, bytes >> 20, left >> 20),
            n > 32 ? "lower it: relief:map=" + std::to_string(n / 2) + ", or raise --bake-budget"
                   : "raise --bake-budget");
    }
    const BakeCache cache(cache_directory() / "bakes", make.use_cache);
    const uint64_t share = std::bit_floor(left / std::max<size_t>(characters_left, 1));
    const std::string key = cache_key(character, bank, options_, share);
    std::optional<Bake> bake;
    if (!make.rebake)
      if (const auto stored = cache.load("relief", key))
        bake = deserialise(*stored, character.skeleton.joints.size(), options_.search == RELIEF_SEARCH_CONE);
    const bool cached = bake.has_value();
    if (!bake) {
      bake = make_bake(character, bank, options_, share);
      cache.store("relief", key, serialise(*bake));
    }
    Baked& baked = baked_.emplace_back();
    baked.key = key;
    baked.cached = cached;
    baked.disk_bytes = cache.enabled() ? cache.disk_bytes("relief", key) : 0;
    baked.nominal_bytes = relief_nominal_bytes(character.skeleton.joints.size(), options_.bake.map_size);
    baked.capture = bake->capture;
    baked.height = height_of(character);
    baked.pixels = bake->tier_pixels;
    for (const ReliefBox& box : bake->models[0].boxes)
      baked.texel = std::max(baked.texel, std::max({box.size.x, box.size.y, box.size.z}) / box.texels);
    baked.full_texels = 3 * bake->models[0].texels();
    baked.parts = parts_of(character, bake->models[0]);
    for (size_t i = 0; i < bake->models.size(); ++i) {
      baked.tiers.push_back(upload(character, *bake, i));
      const Tier& tier = baked.tiers.back();
      left -= std::min(left, tier.texture_bytes());
    }
  }

  // Every joint, with all boxes that stand along its axes; those without triangles have none. A triangle counts in
  // every box that holds it.
  std::vector<BakePart> parts_of(const scene::Character& character, const ReliefModel& model) const {
    std::vector<BakePart> parts;
    for (const scene::Joint& joint : character.skeleton.joints)
      parts.push_back({joint.name, {{"texels", 0}, {"triangles", 0}, {"longest_m", 0}, {"bytes", 0}, {"boxes", 0}}});
    for (size_t i = 0; i < model.boxes.size(); ++i) {
      const ReliefBox& box = model.boxes[i];
      auto& facts = parts[static_cast<size_t>(box.joints[0])].facts;
      facts[0].second = std::max<double>(facts[0].second, box.texels);
      facts[1].second += model.triangles_of_box[i];
      facts[2].second = std::max({facts[2].second, box.size.x, box.size.y, box.size.z});
      // Its place in the pictures, levels and all: 3 n x 1.5 n of the depth picture.
      const uint64_t bytes = ReliefModel::box_texels(box) * 9 / 4 *
                             (2 * (depth_texel_bytes(options_) + colour_texel_bytes(model.emission_peak)) + 1);
      facts[3].second += static_cast<double>(bytes);
      facts[4].second += 1;
    }
    return parts;
  }

  Tier upload(const scene::Character& character, const Bake& bake, size_t index) {
    const ReliefModel& model = bake.models[index];
    const AtlasPlan plan = plan_atlas(model);
    if (2 * plan.width > context_.limits().texture_size || plan.height > context_.limits().texture_size)
      throw Error(
          "relief",
          fmt::format("{} joints of {} need a picture of {} x {}, larger than this device's {}", model.boxes.size(),
                      character.name, 2 * plan.width, plan.height, context_.limits().texture_size),
          "lower map");
    const Atlas atlas = fill_atlas(model, plan);
    Tier tier;
    tier.boxes = model.boxes.size();
    tier.joints = static_cast<int>(character.skeleton.joints.size());
    tier.corners = index == 0 ? 8 : 4;
    tier.carve = index == 0;
    tier.depth = gl::Texture::make_2d(context_, options_.depth_bits == 8 ? GL_RG8 : GL_RG16, plan.width, plan.height);
    tier.depth.write(0, 0, GL_RG, GL_UNSIGNED_SHORT, atlas.depth.data());
    if (!bake.cones.empty()) {
      tier.cones = gl::Texture::make_2d(context_, GL_RGBA8, plan.width, plan.height);
      tier.cones.write(0, 0, GL_RGBA, GL_UNSIGNED_BYTE, bake.cones[index].data());
    }
    tier.colour = gl::Texture::make_2d(context_, GL_SRGB8_ALPHA8, 2 * plan.width, plan.height);
    tier.colour.write(0, 0, GL_RGBA, GL_UNSIGNED_BYTE, atlas.colour.data());
    tier.emission_peak = model.emission_peak;
    if (tier.emission_peak > 0) {
      tier.emission = gl::Texture::make_2d(context_, GL_SRGB8_ALPHA8, 2 * plan.width, plan.height);
      tier.emission.write(0, 0, GL_RGBA, GL_UNSIGNED_BYTE, atlas.emission.data());
    }
    for (const gl::Texture* filtered : {&tier.colour, &tier.emission})
      for (const unsigned which : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        if (*filtered) glTextureParameteri(filtered->name(), which, GL_LINEAR);
    tier.normal = gl::Texture::make_2d(context_, GL_RGBA8, 2 * plan.width, plan.height);
    tier.normal.write(0, 0, GL_RGBA, GL_UNSIGNED_BYTE, atlas.normal.data());
    tier.bounds = gl::Texture::make_2d(context_, GL_RG8, plan.width / 2, plan.height / 2);
    tier.bounds.write(0, 0, GL_RG, GL_UNSIGNED_BYTE, atlas.bounds.data());

    std::vector<BoxRecord> records;
    std::vector<glm::vec4> points;
    for (size_t i = 0; i < model.boxes.size(); ++i) {
      const ReliefBox& box = model.boxes[i];
      BoxRecord record{};
      for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
          record.rows[row][column] = static_cast<float>(box.bind_from_unit[column][row]);
      record.joints = {box.joints[0], box.joints[1], std::bit_cast<uint32_t>(static_cast<float>(box.second)), 0};
      record.maps = {plan.left[i], plan.top[i], box.texels, atlas_levels(box.texels)};
      records.push_back(record);
      for (const glm::vec3& p : box.hull) points.emplace_back(p, 1.0F);
    }
    tier.records = gl::Buffer(context_, records);
    if (options_.hull) tier.points = gl::Buffer(context_, points);
    std::vector<uint32_t> indices;
    if (options_.hull) {
      const auto corners = static_cast<uint32_t>(tier.corners);
      for (uint32_t box = 0; box < tier.boxes; ++box)
        for (uint32_t k = 2; k < corners; ++k)
          for (const uint32_t corner : {0U, k - 1, k}) indices.push_back(box * corners + corner);
    } else {
      // Two triangles a face, counter-clockwise from outside, corners as bits (x, y, z).
      static constexpr std::array<uint32_t, 36> kCube{0, 4, 2, 2, 4, 6, 1, 3, 5, 5, 3, 7, 0, 1, 4, 4, 1, 5,
                                                      2, 6, 3, 3, 6, 7, 0, 2, 1, 1, 2, 3, 4, 5, 6, 6, 5, 7};
      for (uint32_t box = 0; box < tier.boxes; ++box)
        for (const uint32_t corner : kCube) indices.push_back(box * 8 + corner);
    }
    tier.indices = gl::Buffer(context_, indices);
    tier.vertices = gl::VertexArray(context_);
    glVertexArrayElementBuffer(tier.vertices.name(), tier.indices.name());
    tier.pose = gl::Program(context_, {"renderers/relief/relief.comp"}, defines(tier));
    return tier;
  }

  gl::Defines defines(const Tier& tier) const {
    gl::Defines all{{"BOXES", std::to_string(tier.boxes)},
                    {"JOINTS", std::to_string(tier.joints)},
                    {"LEVEL_BIAS", fmt::format("{:.4f}", options_.level_bias)},
                    {"SEARCH", std::to_string(options_.search)},
                    {"STEPS", std::to_string(options_.linear_steps)},
                    {"BINARY", std::to_string(options_.binary_steps)},
                    // Half a depth step: a surface stored exactly on a face must not be missed by rounding.
                    {"SLACK", options_.depth_bits == 8 ? "0.002" : "0.00001"}};
    if (options_.hull) {
      all.emplace_back("HULL", "");
      all.emplace_back("CORNERS", std::to_string(tier.corners));
    }
    if (tier.carve && !options_.floor) all.emplace_back("CARVE", "");
    if (!options_.floor) all.emplace_back("ATTRIBUTE", "");
    if (options_.debug > 0) all.emplace_back("DEBUG", std::to_string(options_.debug));
    if (options_.floor) all.emplace_back("RELIEF_FLOOR", "");
    return all;
  }
  // PosedBox in relief_records.glsl.
  size_t posed_bytes(const Tier& tier) const {
    return 16 * (10 + (options_.hull ? static_cast<size_t>(tier.corners) / 2 : 0));
  }

  void draw_tier(Tier& tier, size_t character, const FrameResources& resources, const std::vector<uint32_t>& list,
                 const Pass& pass) {
    if (list.empty()) return;
    resources.draw_posed(character, list, [&](uint32_t first, uint32_t count) { draw_some(tier, first, count, pass); });
  }

  void draw_some(Tier& tier, uint32_t first, uint32_t count, const Pass& pass) {
    auto found = tier.draw.find(pass);
    if (found == tier.draw.end()) {
      gl::Defines all = defines(tier);
      if (pass.ids) all.emplace_back("CB_IDS", "");
      if (pass.touched) all.emplace_back("CB_TOUCHED", "");
      if (pass.dithered) all.emplace_back("CB_DITHER", "");
      if (tier.emission) all.emplace_back("CB_EMISSIVE", "");
      found = tier.draw
                  .emplace(pass,
                           gl::Program(context_, {"renderers/relief/relief.vert", "renderers/relief/relief.frag"}, all))
                  .first;
    }
    const uint32_t fit = static_cast<uint32_t>(
        std::max<int64_t>(1, context_.limits().storage_block / static_cast<int64_t>(tier.boxes * posed_bytes(tier))));
    for (uint32_t done = 0; done < count; done += fit) {
      const uint32_t some = std::min(fit, count - done);
      const size_t bytes = size_t{some} * tier.boxes * posed_bytes(tier);
      if (!posed_ || posed_.size() < bytes) posed_ = gl::Buffer(context_, bytes);
      tier.records.bind(GL_SHADER_STORAGE_BUFFER, RELIEF_STORAGE_BOXES);
      if (options_.hull) tier.points.bind(GL_SHADER_STORAGE_BUFFER, RELIEF_STORAGE_POINTS);
      posed_.bind(GL_SHADER_STORAGE_BUFFER, RELIEF_STORAGE_POSED);
      tier.pose.set(RELIEF_LOCATION_COUNT, some);
      tier.pose.set(RELIEF_LOCATION_OFFSET, done);
      tier.pose.use();
      glDispatchCompute((some * static_cast<uint32_t>(tier.boxes) + kGroup - 1) / kGroup, 1, 1);
      glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);

      found->second.set(RELIEF_LOCATION_FIRST, first + done);
      found->second.use();
      if (tier.emission) {
        found->second.set(RELIEF_LOCATION_PEAK, tier.emission_peak);
        tier.emission.bind(RELIEF_TEXTURE_EMISSION);
      }
      tier.depth.bind(RELIEF_TEXTURE_DEPTH);
      tier.colour.bind(RELIEF_TEXTURE_COLOUR);
      tier.normal.bind(RELIEF_TEXTURE_NORMAL);
      tier.bounds.bind(RELIEF_TEXTURE_BOUNDS);
      if (tier.cones) tier.cones.bind(RELIEF_TEXTURE_CONES);
      tier.vertices.bind();
      if (options_.hull) {
        glDisable(GL_CULL_FACE);
      } else {
        glEnable(GL_CULL_FACE);
        glCullFace(GL_FRONT);
      }
      glDrawElementsInstanced(GL_TRIANGLES, static_cast<int>(tier.indices.size() / sizeof(uint32_t)), GL_UNSIGNED_INT,
                              nullptr, static_cast<int>(some));
      glEnable(GL_CULL_FACE);
      glCullFace(GL_BACK);
    }
  }

  gl::Context& context_;
  Options options_;
  std::vector<Baked> baked_;
  std::vector<std::vector<uint32_t>> lists_;  // of one character's agents, by tier
  gl::Buffer posed_;
  double seconds_ = 0;
};

std::unique_ptr<Representation> make_relief(const MakeContext& context, const Spec& spec) {
  const OptionReader read(relief_type, spec);
  Options options;
  options.bake.map_size =
      static_cast<int>(std::array{32, 64, 128, 256}[read.choice("map", {"32", "64", "128", "256"})]);
  const std::string rule = read.text("rule");
  const std::string_view threshold = "threshold";
  if (rule.rfind(threshold, 0) == 0) {
    options.bake.rule = TriangleRule::threshold;
    if (rule.size() > threshold.size())
      options.bake.threshold = number_of(rule.data() + threshold.size(), rule.data() + rule.size(), "relief: rule",
                                         rule, 0, 3, "write threshold1.2 (a summed weight, 0..3)");
  } else {
    options.bake.rule = read.choice("rule", {"dominant", "any"}) == 0 ? TriangleRule::dominant : TriangleRule::any;
  }
  options.capture = read.text("capture");
  options.bake.by_area = read.choice("size", {"uniform", "by_area"}) == 1;
  options.resolution = read.text("resolution");
  options.budget = static_cast<uint64_t>(read.number("budget", 0, 65536) * (1 << 20));
  options.depth_bits = read.choice("depth", {"8", "16"}) == 0 ? 8 : 16;
  options.search = static_cast<int>(read.choice("search", {"adaptive", "linear", "cone"}));
  std::tie(options.linear_steps, options.binary_steps) = parse_steps(read.text("steps"));
  options.level_bias = read.number("bias", -4.0, 4.0);
  options.hull = read.choice("proxy", {"hull", "box"}) == 0;
  options.merge = read.text("merge") == "auto" ? (options.hull ? 0.25 : 0.0) : read.number("merge", 0.0, 16.0);
  options.bend = read.number("bend", 0.0, 64.0);
  options.part_auto = read.text("part") == "auto" && options.merge > 0;
  options.part = options.part_auto ? kPart : read.text("part") == "auto" ? 0.0 : read.number("part", 0.0, 4.0);
  options.debug = static_cast<int>(read.choice("debug", {"none", "boxes", "steps", "hit-face", "misses"}));
  options.floor = read.flag("floor");
  return std::make_unique<Relief>(context, std::move(options));
}

}  // namespace

const RepresentationType relief_type{
    "relief",
    "bone-relief impostors: one box a joint, dual-depth maps on its faces, a ray search a pixel",
    {{"map", "32|64|128|256", "128", "texels a side of each face's maps"},
     {"rule", "dominant|any|threshold[W]", "threshold1.2",
      "which triangles a joint captures; threshold: a weight above W, summed over the three corners"},
     {"capture", "best|bind|CLIP[@PHASE]", "best", "pose in which the mesh is captured; best: least silhouette error"},
     {"size", "uniform|by_area", "uniform", "by_area: boxes smaller than the largest get maps of fewer texels"},
     {"resolution", "none|JOINT@TEXELS[+...]", "none",
      "texels a side of single joints, by name or number, whatever map and size say: Head@256+LeftHand@32"},
     {"budget", "0..65536", "0", "MiB of maps at full detail, met by coarser texels; 0: none"},
     {"depth", "8|16", "16", "bits of a stored depth"},
     {"search", "adaptive|linear|cone", "adaptive",
      "adaptive: two intervals a texel crossed; linear: the source's fixed steps; cone: adaptive, past what relaxed "
      "cone maps show to be air"},
     {"steps", "LINEAR+BINARY", "256+7",
      "most adaptive steps, or the linear steps of search=linear; binary refinements of linear and cone"},
     {"bias", "-4..4", "-3", "mip levels added to one texel a pixel of a depth, for the silhouette"},
     {"proxy", "hull|box", "hull", "hull: the outline of a prism around the joint; box: the back faces of its box"},
     {"merge", "auto|0..16", "auto", "pixels that joints sharing a box may stray; auto: 0.25 with proxy=hull, else 0"},
     {"bend", "0..64", "0",
      "pixels, of a character 240 tall, that skin may stray before bends get boxes of their own; 0: one box a joint"},
     {"part", "auto|0..4", "auto",
      "longest box, in heights of the character: longer ones are captured in parts; 0: whole; auto: 0.27 with merge "
      "(more "
      "where the bake budget asks for it), else 0"},
     {"debug", "none|boxes|steps|hit-face|misses", "none", "shows how the picture comes about instead of the picture"}},
    make_relief};

}  // namespace crowdbench::renderers
