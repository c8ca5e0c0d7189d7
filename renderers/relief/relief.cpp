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
#include "renderers/bake/bake_cache.h"
#include "renderers/bake/bake_loader.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/gl/objects.h"
#include "renderers/gl/per_sample.h"
#include "renderers/gl/program.h"
#include "renderers/relief/relief.shared.h"
#include "renderers/relief/relief_atlas.h"
#include "renderers/relief/relief_bake.h"
#include "renderers/relief/relief_tiers.h"
#include "renderers/shaders/bindings.shared.h"

namespace crowdbench::renderers {
namespace {

constexpr int kGroup = 64;      // local_size_x of relief.comp
constexpr double kPart = 0.27;  // of the height: one of 128 texels is then at most a pixel of a character 480 tall

// Of the silhouette, what rigid boxes may miss over the clips (CaptureScore) before it is said.
constexpr double kTornSilhouette = 0.01;

struct Options {
  ReliefTierOptions bake;
  int search = RELIEF_SEARCH_ADAPTIVE;
  int linear_steps = 256;
  int binary_steps = 7;
  double level_bias = 0;
  bool hull = true;
  int debug = 0;
  bool floor = false;
};

// "16+7": linear steps and binary refinements.
std::pair<int, int> parse_steps(const std::string& text, const std::string& where) {
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
    throw Error(where, fmt::format("\"{}\" is not LINEAR+BINARY", printable(text)), "write 1..256 + 0..16, as in 16+7");
  return {linear, binary};
}

struct RuleChoice {
  TriangleRule rule = TriangleRule::threshold;
  std::optional<double> threshold;
};

// "dominant", "any", "threshold" or "threshold1.2".
RuleChoice parse_rule(const std::string& text, const std::string& where) {
  constexpr std::string_view kThreshold = "threshold";
  if (text == "dominant") return {TriangleRule::dominant, {}};
  if (text == "any") return {TriangleRule::any, {}};
  if (text == kThreshold) return {};
  if (text.starts_with(kThreshold))
    return {TriangleRule::threshold, number_of(text.data() + kThreshold.size(), text.data() + text.size(), where, text,
                                               0, 3, "write threshold1.2 (a summed weight, 0..3)")};
  const std::string near = nearest_name(text, {"dominant", "any", std::string(kThreshold)});
  throw Error(where, fmt::format("'{}' is not one of dominant, any, threshold[W]", printable(text)),
              near.empty() ? "" : fmt::format("did you mean '{}'?", near));
}

void check_rule(const std::string& value, const std::string& where) { (void)parse_rule(value, where); }
void check_steps(const std::string& value, const std::string& where) { (void)parse_steps(value, where); }

// Everything on the GPU for one tier of one character type.
struct Tier {
  size_t boxes = 0;
  int joints = 0;
  int corners = 8;
  bool textured = false;
  bool carve = true;  // the nearest tier, and patches: candidates are checked against the other axes
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
  std::vector<BakeItem> items;
  uint64_t full_texels = 0;  // of the nearest tier's depth picture, those of level 0
  double height = 0;         // metres at scale 1
  std::string key;
  bool cached = false;
  double made_seconds = 0;
  uint64_t disk_bytes = 0;
  uint64_t nominal_bytes = 0;
  CaptureScore capture;
  double texel = 0;      // metres, tier 0, the largest
  double deviation = 0;  // ReliefTiers::deviation
  double loose = 0;      // ReliefTiers::loose
};

struct BoxRecord {
  glm::vec4 rows[3];
  glm::uvec4 maps;
  std::array<uint32_t, kShares> joints;
  std::array<float, kShares> weights;
  glm::mat4 movers[kShares];
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
    const gl::PerSampleScope by_sample(pass.samples);
    for (size_t c = 0; c < baked_.size(); ++c) {
      Baked& baked = baked_[c];
      if (baked.tiers.size() == 1) {
        draw_tier(baked.tiers[0], c, resources, agents[c], pass);
        continue;
      }
      for (std::vector<uint32_t>& list : lists_) list.clear();
      lists_.resize(std::max(lists_.size(), baked.tiers.size()));
      const glm::dmat3 view = scene::view_rotation(frame.camera);
      const glm::vec3 back(glm::transpose(view)[2]);
      for (const uint32_t index : agents[c]) {
        const scene::FrameAgent& agent = frame.agents[c][index];
        const glm::vec3 middle =
            agent.position + glm::vec3(0.0F, 0.5F * agent.scale * static_cast<float>(baked.height), 0.0F);
        const double depth = std::max(static_cast<double>(-glm::dot(back, middle)), frame.camera.near);
        const double tall = agent.scale * baked.height / scene::pixel_size_at(frame.camera, depth, frame.height);
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
      info.made_seconds += baked.made_seconds;
      keys.text(baked.key);
      nominal += baked.nominal_bytes;
      for (const Tier& tier : baked.tiers) actual += tier.texture_bytes();
    }
    info.cache_key = baked_.size() == 1 ? baked_[0].key : keys.hex();
    info.facts = {{"nominal_bytes", static_cast<double>(nominal)}, {"actual_bytes", static_cast<double>(actual)}};
    if (baked_.size() == 1) {
      info.items = baked_[0].items;
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
      info.facts.emplace_back("skin_deviation_px", baked_[0].deviation / baked_[0].height * kBendPixels);
      info.facts.emplace_back("skin_loose", baked_[0].loose);
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
    const BakeCache cache(bake_folder(), make.use_cache);
    const ReliefAllowance allowance{std::bit_floor(left / std::max<size_t>(characters_left, 1)), left};
    const std::string key = relief_key(character, bank, options_.bake, allowance);
    std::optional<ReliefTiers> bake;
    double made_seconds = 0;
    if (!make.rebake)
      if (const auto stored = cache.load("relief", key)) {
        bake = deserialise_tiers(stored->payload, character.skeleton.joints.size(), options_.bake.cones);
        made_seconds = stored->made_seconds;
      }
    const bool cached = bake.has_value();
    if (cached) require_room(character, bake->models[0].texels(), options_.bake, allowance);
    if (!bake) {
      const auto start = std::chrono::steady_clock::now();
      bake =
          bake_tiers(character, bank, options_.bake, allowance, bake_progress(make.policy(), "relief", character.name));
      made_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      cache.store("relief", key, serialise(*bake), made_seconds);
    }
    warn_of_misses(character, *bake);
    Baked& baked = baked_.emplace_back();
    baked.key = key;
    baked.cached = cached;
    baked.made_seconds = made_seconds;
    baked.disk_bytes = cache.enabled() ? cache.disk_bytes("relief", key) : 0;
    baked.nominal_bytes = relief_nominal_bytes(character.skeleton.joints.size(), options_.bake.maps.map_size);
    baked.capture = bake->capture;
    baked.deviation = bake->deviation;
    baked.loose = bake->loose;
    baked.height = relief_height(character);
    baked.pixels = bake->tier_pixels;
    for (const ReliefBox& box : bake->models[0].boxes)
      baked.texel = std::max(baked.texel, std::max({box.size.x, box.size.y, box.size.z}) / box.texels);
    baked.full_texels = bake->models[0].depth_maps() * bake->models[0].texels();
    baked.items = items_of(character, bake->models[0]);
    for (size_t i = 0; i < bake->models.size(); ++i) {
      baked.tiers.push_back(upload(character, *bake, i));
      const Tier& tier = baked.tiers.back();
      left -= std::min(left, tier.texture_bytes());
    }
  }

  // What the boxes miss of the skin in the character's own clips, where it is more than was asked for.
  void warn_of_misses(const scene::Character& character, const ReliefTiers& bake) const {
    const ReliefTierOptions& asked = options_.bake;
    if (asked.bend <= 0 && bake.capture.silhouette_error > kTornSilhouette)
      fmt::print(stderr,
                 "crowdbench: warning: relief: rigid boxes miss {:.1f} % of the silhouette of {} over its clips, more "
                 "than {:.0f} %; {} follows its skin\n",
                 100 * bake.capture.silhouette_error, printable(character.name), 100 * kTornSilhouette,
                 asked.maps.cube ? "projection=box" : "bend=1");
    const double deviation = bake.deviation / relief_height(character) * kBendPixels;
    if (asked.bend <= 0 || deviation <= asked.bend) return;
    const bool more_cells = asked.cells < 1024 && bake.models[0].boxes.size() >= static_cast<size_t>(asked.cells);
    fmt::print(
        stderr,
        "crowdbench: warning: relief: the boxes of {} leave its skin by up to {:.1f} pixels of a figure {:g} tall "
        "in its clips ({:.1f} % of it by more than bend={:g}); {} holds more of it\n",
        printable(character.name), deviation, kBendPixels, 100 * bake.loose, asked.bend,
        more_cells ? fmt::format("cells={}", std::min(2 * asked.cells, 1024)) : "another pose (capture=bind)");
  }

  // Every joint, with all boxes that stand along its axes; those without triangles have none. A triangle counts in
  // every box that holds it.
  std::vector<BakeItem> items_of(const scene::Character& character, const ReliefModel& model) const {
    std::vector<BakeItem> items;
    for (const scene::Joint& joint : character.skeleton.joints)
      items.push_back({joint.name, {{"texels", 0}, {"triangles", 0}, {"longest_m", 0}, {"bytes", 0}, {"boxes", 0}}});
    for (size_t i = 0; i < model.boxes.size(); ++i) {
      const ReliefBox& box = model.boxes[i];
      auto& facts = items[static_cast<size_t>(box.joint())].facts;
      facts[0].second = std::max<double>(facts[0].second, box.texels);
      facts[1].second += model.triangles_of_box[i];
      facts[2].second = std::max({facts[2].second, box.size.x, box.size.y, box.size.z});
      // Its place in the pictures, levels and all: 3 n x 1.5 n of the depth picture.
      const uint64_t bytes =
          ReliefModel::box_texels(box) * 9 / 4 *
          (2 * (depth_texel_bytes(options_.bake) + colour_texel_bytes(model.emission_peak)) + (model.cube ? 0 : 1));
      facts[3].second += static_cast<double>(bytes);
      facts[4].second += 1;
    }
    return items;
  }

  Tier upload(const scene::Character& character, const ReliefTiers& bake, size_t index) {
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
    tier.textured = !character.mesh.uvs.empty() && std::ranges::any_of(character.materials, [](const auto& m) {
      return m.base_colour_image >= 0 || m.emissive_image >= 0;
    });
    tier.carve = index == 0 || model.patches;
    tier.corners = tier.carve ? 8 : 4;
    tier.depth = gl::Texture::make_2d(context_, options_.bake.depth_bits == 8 ? GL_RG8 : GL_RG16,
                                      model.cube ? 2 * plan.width : plan.width, plan.height);
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
    if (!atlas.bounds.empty()) {
      tier.bounds = gl::Texture::make_2d(context_, GL_RG8, plan.width / 2, plan.height / 2);
      tier.bounds.write(0, 0, GL_RG, GL_UNSIGNED_BYTE, atlas.bounds.data());
    }

    std::vector<BoxRecord> records;
    std::vector<glm::vec4> points;
    for (size_t i = 0; i < model.boxes.size(); ++i) {
      const ReliefBox& box = model.boxes[i];
      BoxRecord record{};
      for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
          record.rows[row][column] = static_cast<float>(box.bind_from_unit[column][row]);
      for (size_t k = 0; k < kShares; ++k) {
        record.joints[k] = static_cast<uint32_t>(box.movers[k].joint);
        record.weights[k] = static_cast<float>(box.movers[k].weight);
        record.movers[k] = glm::mat4(box.movers[k].bind_from_unit);
      }
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
                    {"COLOUR_FINER", std::to_string(tier.textured || !tier.carve ? RELIEF_FINER : RELIEF_FINER_PLAIN)},
                    // Half a depth step: a surface stored exactly on a face must not be missed by rounding.
                    {"SLACK", options_.bake.depth_bits == 8 ? "0.002" : "0.00001"}};
    if (options_.hull) {
      all.emplace_back("HULL", "");
      all.emplace_back("CORNERS", std::to_string(tier.corners));
    }
    if (tier.carve && !options_.floor) all.emplace_back("CARVE", "");
    if (!options_.floor) all.emplace_back("ATTRIBUTE", "");
    if (options_.bake.maps.cube) all.emplace_back("CUBE", "");
    if (options_.debug > 0) all.emplace_back("DEBUG", std::to_string(options_.debug));
    if (options_.floor) all.emplace_back("RELIEF_FLOOR", "");
    return all;
  }
  // PosedBox in relief_records.glsl.
  size_t posed_bytes(const Tier& tier) const {
    return 16 * (14 + (options_.hull ? static_cast<size_t>(tier.corners) / 2 : 0));
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
      if (tier.bounds) tier.bounds.bind(RELIEF_TEXTURE_BOUNDS);
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
  options.bake.maps.map_size =
      static_cast<int>(std::array{32, 64, 128, 256}[read.choice("map", {"32", "64", "128", "256"})]);
  const RuleChoice rule = parse_rule(read.text("rule"), read.where("rule"));
  options.bake.maps.rule = rule.rule;
  options.bake.maps.threshold = rule.threshold.value_or(options.bake.maps.threshold);
  options.bake.capture = read.text("capture");
  options.bake.maps.by_area = read.choice("size", {"uniform", "by_area"}) == 1;
  options.bake.resolution = read.text("resolution");
  options.bake.budget = static_cast<uint64_t>(read.number("budget", 0, 65536) * (1 << 20));
  options.bake.depth_bits = read.choice("depth", {"8", "16"}) == 0 ? 8 : 16;
  options.search = static_cast<int>(read.choice("search", {"adaptive", "linear", "cone"}));
  options.bake.cones = options.search == RELIEF_SEARCH_CONE;
  std::tie(options.linear_steps, options.binary_steps) = parse_steps(read.text("steps"), read.where("steps"));
  options.level_bias = read.number("bias", -4.0, 4.0);
  options.hull = read.choice("proxy", {"hull", "box"}) == 0;
  options.bake.merge = read.text("merge") == "auto" ? (options.hull ? 0.25 : 0.0) : read.number("merge", 0.0, 16.0);
  options.bake.cells = static_cast<int>(read.integer("cells", 16, 1024));
  options.bake.maps.cube = read.choice("projection", {"box", "cube"}) == 1;
  const std::string bend = read.text("bend");
  options.bake.bend = bend == "auto"    ? (options.bake.maps.cube ? 0.0 : 1.0)
                      : bend == "rigid" ? 0.0
                                        : read.number("bend", 0.05, 64.0);
  if (options.bake.maps.cube && (options.bake.bend > 0 || options.search != RELIEF_SEARCH_ADAPTIVE))
    throw Error("relief: projection", "cube has stiff boxes and a search of its own",
                "leave bend and search as they are, or take projection=box");
  options.bake.part_auto = read.text("part") == "auto" && options.bake.merge > 0 && !options.bake.maps.cube;
  options.bake.part = options.bake.part_auto        ? kPart
                      : read.text("part") == "auto" ? 0.0
                                                    : read.number("part", 0.0, 4.0);
  options.debug = static_cast<int>(read.choice("debug", {"none", "boxes", "steps", "hit-face", "misses"}));
  options.floor = read.flag("floor");
  return std::make_unique<Relief>(context, std::move(options));
}

}  // namespace

const RepresentationType relief_type = {
    .name = "relief",
    .summary = "bone-relief impostors: one box a joint, dual-depth maps on its faces, a ray search a pixel",
    .options =
        {{"map", "32|64|128|256", "128", "texels a side of each face's maps"},
         {"rule", "dominant|any|threshold[W]", "threshold1.2",
          "which triangles a joint captures; threshold: a weight above W, summed over the three corners", check_rule},
         {"capture", "best|bind|CLIP[@PHASE]", "best",
          "pose in which the mesh is captured; best: least silhouette error", check_capture},
         {"size", "uniform|by_area", "uniform", "by_area: boxes smaller than the largest get maps of fewer texels"},
         {"resolution", "none|JOINT@TEXELS[+...]", "none",
          "texels a side of single joints, by name or number, whatever map and size say: Head@256+LeftHand@32",
          check_resolution},
         {"budget", "0..65536", "0", "MiB of maps at full detail, met by coarser texels; 0: none"},
         {"depth", "8|16", "16", "bits of a stored depth"},
         {"search", "adaptive|linear|cone", "adaptive",
          "adaptive: two intervals a texel crossed; linear: the source's fixed steps; cone: adaptive, past what "
          "relaxed "
          "cone maps show to be air"},
         {"steps", "LINEAR+BINARY", "256+7",
          "most adaptive steps, or the linear steps of search=linear; binary refinements of linear and cone",
          check_steps},
         {"bias", "-4..4", "-3", "mip levels added to one texel a pixel of a depth, for the silhouette"},
         {"proxy", "hull|box", "hull", "hull: the outline of a prism around the joint; box: the back faces of its box"},
         {"merge", "auto|0..16", "auto",
          "pixels that joints sharing a box may deviate; auto: 0.25 with proxy=hull, else 0"},
         {"bend", "auto|rigid|0.05..64", "auto",
          "pixels, of a character 240 tall, that skin may deviate from boxes that bend with it before it is cut into "
          "more; rigid: one stiff box a joint, as the source has them; auto: 1, or rigid with projection=cube"},
         {"projection", "box|cube", "box",
          "what a box's faces see: box, along its axes; cube, from its middle outward, as a cube map, where each place "
          "of the skin belongs to one face"},
         {"cells", "16..1024", "256", "boxes that skin may be cut into, at most"},
         {"part", "auto|0..4", "auto",
          "longest box, in heights of the character: longer ones are captured in sections; 0: whole; auto: 0.27 "
          "with merge (more where the bake budget asks for it), else and with projection=cube 0"},
         {"debug", "none|boxes|steps|hit-face|misses", "none",
          "shows how the picture comes about instead of the picture"}},
    .make = make_relief,
    .floor = "the same proxies with one tap a pixel and no choice of face",
    .suits = {.new_clips = "yes: boxes follow the joints; what is merged was chosen by the clips of the bake",
              .close_by = "texels are seen",
              .from_above = "yes: captured from six sides",
              .shadows = "every pixel has its depth"},
};

}  // namespace crowdbench::renderers
