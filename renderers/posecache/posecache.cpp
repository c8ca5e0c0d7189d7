// Based on: W. Lister, R. G. Laycock and A. M. Day, "A key-pose caching system for rendering an animated crowd in
// real-time" (2010). Differs from the source: README.md.
#include "renderers/posecache/posecache.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <bit>
#include <chrono>

#include "core/error.h"
#include "renderers/bake/bake_loader.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/impostor/tiles/stored_frames.h"
#include "renderers/mesh/mesh_draw.h"
#include "renderers/mesh/skinned_buffer.h"
#include "renderers/posecache/cache_trade.h"
#include "renderers/posecache/pose_slots.h"
#include "renderers/shaders/bindings.shared.h"
#include "scene/cast/cast.h"

namespace crowdbench::renderers {
namespace {

constexpr uint64_t kSlotBits = 16;  // of a place in the record of a blend

struct PoseCacheOptions {
  uint32_t poses = 0;  // places of a character's cache
  double mib = 0;      // instead; 0: as `poses` says
  uint32_t keys = 0;   // of a clip that moves; 0: as many as the bank has samples
  KeyRule choice = KeyRule::greedy;
  double keep = 0;
  int passes = 1;
  bool misses = false;  // draw nobody else
  bool floor = false;
};

// `poses` of mesh.vert: the places of two key poses, and how much of the second.
struct BlendRecord {
  uint32_t slots = 0;
  uint32_t blend = 0;  // a float's bits
};

// One character: its key poses, which of them are skinned, and where.
struct CharacterCache {
  CharacterMesh mesh;
  uint32_t places = 0;
  std::vector<KeyCircle> circles;
  PoseSlots slots;
  SkinnedBuffer skinned;
  KeyDemand demand;
  // Of the frame before, and so far of the frame at hand: what was chosen.
  KeySet before, now;
};

// Who is drawn how, of one character.
struct Shown {
  std::vector<uint32_t> hits, misses;
  std::vector<BlendRecord> blends;  // one a hit
};

class PoseCacheRepresentation : public Representation {
 public:
  PoseCacheRepresentation(const MakeContext& make, const PoseCacheOptions& options)
      : context_(make.context),
        options_(options),
        blended_(make.context, options.floor ? MeshUse::shared_pose : MeshUse::cached_poses, options.passes),
        skinned_(make.context, MeshUse::skinned, options.passes) {
    const auto start = std::chrono::steady_clock::now();
    for (size_t c = 0; c < make.cast.characters.size(); ++c) {
      banks_.push_back(make.cast.banks[c]);
      add(*make.cast.characters[c], *banks_[c]);
    }
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  void draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
            const Pass& pass) override {
    begin(frame);
    for (size_t c = 0; c < caches_.size(); ++c) {
      CharacterCache& cache = caches_[c];
      if (agents[c].empty() || cache.mesh.groups.empty()) continue;
      if (!options_.floor)
        draw_character(c, frame.agents[c], agents[c], resources, pass);
      else if (!options_.misses)
        draw_floor(c, agents[c], resources, pass);
    }
    MeshDraw::done();
  }

  bool has_history() const override { return options_.keep > 0 && !options_.floor; }

  void advance(const scene::Frame& frame, const AgentLists& agents) override {
    begin(frame);
    for (size_t c = 0; c < caches_.size(); ++c)
      if (!agents[c].empty()) (void)choose(caches_[c], frame.agents[c], agents[c]);
  }

  Footprint footprint() const override {
    Footprint out;
    out.buffer_bytes = palettes_.size() + blends_.size();
    out.upload_bytes_per_frame = blends_.size();
    for (const CharacterCache& c : caches_) {
      out.texture_bytes += c.mesh.texture_bytes();
      out.buffer_bytes += c.mesh.buffer_bytes() + c.skinned.bytes();
    }
    return out;
  }

  BakeInfo bake_info() const override {
    BakeInfo info;
    info.seconds = seconds_;
    info.facts = facts_;
    return info;
  }

  uint64_t triangles(size_t character) const override { return caches_[character].mesh.triangles; }

 private:
  void add(const scene::Character& character, const scene::PoseBank& bank) {
    const MeshUse use = options_.floor ? MeshUse::shared_pose : MeshUse::cached_poses;
    CharacterMesh mesh = upload_mesh(context_, character, bank.joints(), use, {});
    std::vector<KeyCircle> circles = key_circles(bank, options_.keys);
    if (options_.keys > 0)  // else every sample of the bank
      warn_of_bake(
          "key poses",
          coarse_clip_text(
              character, bank, [&](const scene::BankClip&) { return static_cast<int>(options_.keys); },
              [](const scene::BankClip&) { return std::string("leave keys out: all of its samples are shown"); }));
    const uint32_t keys = key_count(circles);
    const uint64_t pose_bytes = std::max<uint64_t>(mesh.vertex_count, 1) * kSkinnedVertexBytes;
    uint64_t wanted = options_.mib > 0 ? static_cast<uint64_t>(options_.mib * (1 << 20)) / pose_bytes : options_.poses;
    if (options_.floor) wanted = 1;
    if (wanted == 0)
      throw Error("pose cache",
                  fmt::format("one pose of {} takes {} bytes, more than mib allows", character.name, pose_bytes),
                  "raise mib");
    wanted = std::min({wanted, uint64_t{keys}, uint64_t{1} << kSlotBits});
    SkinnedBuffer skinned(context_, wanted * pose_bytes);
    const uint32_t places = std::min(static_cast<uint32_t>(wanted), skinned.capacity(mesh));
    if (!mesh.groups.empty()) skinned.reserve(mesh, places);
    state_facts(character, bank, circles, places, pose_bytes);
    KeyDemand demand{circles, {}, KeySet(keys, 0), options_.keep};
    caches_.push_back({std::move(mesh), places, std::move(circles), PoseSlots(keys, places), std::move(skinned),
                       std::move(demand), KeySet(keys, 0), KeySet(keys, 0)});
    const size_t bytes = size_t{places} * static_cast<size_t>(bank.joints()) * sizeof(scene::Mat3x4);
    if (palettes_.size() >= bytes) return;
    palette_texels_ = gl::Texture();
    palettes_ = gl::Buffer(context_, bytes);
    palette_texels_ = gl::Texture::make_buffer(context_, GL_RGBA32F, palettes_);
  }

  // Sums over the characters, of errors the largest.
  void state_facts(const scene::Character& character, const scene::PoseBank& bank,
                   const std::vector<KeyCircle>& circles, uint32_t places, uint64_t pose_bytes) {
    constexpr double kMillimetres = 1000;
    const auto state = [&](const std::string& name, double value, bool largest = false) {
      for (auto& [known, sum] : facts_)
        if (known == name) {
          sum = largest ? std::max(sum, value) : sum + value;
          return;
        }
      facts_.emplace_back(name, value);
    };
    const BlendError error = blend_error(character, bank, circles);
    state("key_poses", key_count(circles));
    state("places", places);
    state("cache_mib", static_cast<double>(places * pose_bytes) / (1 << 20));
    state("pose_error_rms_mm", error.rms * kMillimetres, true);
    state("pose_error_max_mm", error.max * kMillimetres, true);
    for (const uint32_t agents : {100U, 1000U}) {
      const CacheTrade trade = cache_trade(bank, circles, places, options_.choice, options_.keep, agents);
      state(fmt::format("hits_of_{}", agents), trade.hits);
      state(fmt::format("key_poses_skinned_of_{}", agents), trade.skinned);
    }
  }

  // A frame of the same tick is the same moment again; one at most kMostTicks later continues; any other begins anew.
  void begin(const scene::Frame& frame) {
    constexpr uint64_t kMostTicks = 8;
    if (!has_history() || (begun_ && frame.tick == tick_)) return;
    const bool follows = begun_ && frame.tick > tick_ && frame.tick - tick_ <= kMostTicks;
    for (CharacterCache& cache : caches_) {
      std::swap(cache.before, cache.now);
      std::ranges::fill(cache.now, uint8_t{0});
      // At a beginning none costs more than another.
      if (!follows) std::ranges::fill(cache.before, uint8_t{1});
      cache.demand.cached = cache.before;
    }
    begun_ = true;
    tick_ = frame.tick;
  }

  KeySet choose(CharacterCache& cache, const std::vector<scene::FrameAgent>& all, const std::vector<uint32_t>& listed) {
    cache.demand.agents.assign(cache.before.size(), 0);
    for (const uint32_t i : listed)
      ++cache.demand.agents[key_place(cache.circles[static_cast<size_t>(all[i].bank_clip)], all[i].phase).key];
    KeySet set = choose_keys(cache.demand, cache.places, options_.choice);
    if (has_history())
      for (size_t key = 0; key < set.size(); ++key) cache.now[key] |= set[key];
    return set;
  }

  void draw_character(size_t c, const std::vector<scene::FrameAgent>& all, const std::vector<uint32_t>& listed,
                      const FrameResources& resources, const Pass& pass) {
    CharacterCache& cache = caches_[c];
    const KeySet set = choose(cache, all, listed);
    const std::vector<PoseSlots::Fill> fills = cache.slots.take(set);
    split(cache, set, all, listed);
    if (!shown_.hits.empty() && !options_.misses) {
      resources.draw_listed(c, shown_.hits, [&](uint32_t count) {
        skin(c, fills);
        write_blends();
        cache.skinned.bind();
        blend_texels_.bind(CB_TEXTURE_BLENDS);
        blended_.draw(cache.mesh, pass, resources.list(), 0, count);
      });
    } else {
      skin(c, fills);
    }
    resources.draw_posed(c, shown_.misses, [&](uint32_t first, uint32_t count) {
      skinned_.draw(cache.mesh, pass, resources.list(), first, count);
    });
  }

  void split(const CharacterCache& cache, const KeySet& set, const std::vector<scene::FrameAgent>& all,
             const std::vector<uint32_t>& listed) {
    shown_.hits.clear();
    shown_.misses.clear();
    shown_.blends.clear();
    for (const uint32_t i : listed) {
      const KeyCircle& circle = cache.circles[static_cast<size_t>(all[i].bank_clip)];
      const KeyPlace place = key_place(circle, all[i].phase);
      const uint32_t next = circle.next(place.key);
      if (!set[place.key] || !set[next]) {
        shown_.misses.push_back(i);
        continue;
      }
      shown_.hits.push_back(i);
      shown_.blends.push_back(
          {cache.slots.slot(place.key) | cache.slots.slot(next) << kSlotBits, std::bit_cast<uint32_t>(place.blend)});
    }
  }

  // Key poses into their places, those of neighbouring places at once.
  void skin(size_t c, const std::vector<PoseSlots::Fill>& fills) {
    if (fills.empty()) return;
    CharacterCache& cache = caches_[c];
    rows_.clear();
    for (const PoseSlots::Fill& fill : fills) {
      const std::vector<scene::Mat3x4> palette = key_palette(c, fill.key);
      rows_.insert(rows_.end(), palette.begin(), palette.end());
    }
    palettes_.write(rows_);
    palette_texels_.bind(CB_TEXTURE_PALETTE);
    for (size_t from = 0; from < fills.size();) {
      size_t end = from + 1;
      while (end < fills.size() && fills[end].slot == fills[end - 1].slot + 1) ++end;
      cache.skinned.skin(cache.mesh, static_cast<uint32_t>(from), static_cast<uint32_t>(end - from), fills[from].slot);
      from = end;
    }
  }

  std::vector<scene::Mat3x4> key_palette(size_t c, uint32_t key) const {
    const std::vector<KeyCircle>& circles = caches_[c].circles;
    const auto after = std::upper_bound(circles.begin(), circles.end(), key,
                                        [](uint32_t k, const KeyCircle& circle) { return k < circle.first; });
    const auto clip = static_cast<int>(after - circles.begin()) - 1;
    const KeyCircle& circle = circles[static_cast<size_t>(clip)];
    return banks_[c]->palette(banks_[c]->sample(clip, static_cast<double>(key - circle.first) / circle.keys));
  }

  void write_blends() {
    const size_t bytes = shown_.blends.size() * sizeof(BlendRecord);
    if (blends_.size() < bytes) {
      blend_texels_ = gl::Texture();
      blends_ = gl::Buffer();
      blends_ = gl::Buffer(context_, std::bit_ceil(bytes));
      blend_texels_ = gl::Texture::make_buffer(context_, GL_RG32UI, blends_);
    }
    blends_.write(shown_.blends);
  }

  void draw_floor(size_t c, const std::vector<uint32_t>& listed, const FrameResources& resources, const Pass& pass) {
    CharacterCache& cache = caches_[c];
    KeySet first(cache.before.size(), 0);
    first[0] = 1;
    resources.draw_listed(c, listed, [&](uint32_t count) {
      skin(c, cache.slots.take(first));
      cache.skinned.bind();
      blended_.draw(cache.mesh, pass, resources.list(), 0, count);
    });
  }

  gl::Context& context_;
  PoseCacheOptions options_;
  MeshDraw blended_, skinned_;
  std::vector<std::shared_ptr<const scene::PoseBank>> banks_;
  std::vector<CharacterCache> caches_;
  gl::Buffer palettes_;  // of what is being skinned
  gl::Texture palette_texels_;
  gl::Buffer blends_;
  gl::Texture blend_texels_;
  std::vector<std::pair<std::string, double>> facts_;
  double seconds_ = 0;
  bool begun_ = false;
  uint64_t tick_ = 0;
  // Of the character being drawn.
  Shown shown_;
  std::vector<scene::Mat3x4> rows_;
};

}  // namespace

const RepresentationType posecache_type = {
    .name = "posecache",
    .summary = "a cache of skinned key poses, of a fixed size, that agents are blended from; the others are skinned",
    .options =
        {{"poses", "1..65536", "32", "that a character's cache holds, at most"},
         {"mib", "0..4096", "0", "instead: MiB of skinned poses, a character; 0: as poses says"},
         {"keys", "0..1024", "0", "key poses of a clip, evenly over its phases; 0: the pose bank's samples"},
         {"choice", "greedy|popular|exact", "greedy",
          "which key poses are held where not all fit: by what each adds, by agents beside them, or the best set"},
         {"keep", "0..1000", "0",
          "agents by which a key pose counts less that the tick before did not hold; above 0 the picture "
          "depends on the ticks before"},
         {"passes", "1..16", "1", "times that a frame draws the triangles: all but the last write depth alone"},
         {"debug", "none|misses", "none", "misses: only the agents that are not blended"}},
    .make = [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      const OptionReader reader(posecache_type, spec);
      PoseCacheOptions options;
      options.poses = static_cast<uint32_t>(reader.integer("poses", 1, 65536));
      options.mib = reader.number("mib", 0, 4096);
      options.keys = static_cast<uint32_t>(reader.integer("keys", 0, 1024));
      options.choice = static_cast<KeyRule>(reader.choice("choice", {"greedy", "popular", "exact"}));
      options.keep = reader.number("keep", 0, 1000);
      options.passes = static_cast<int>(reader.integer("passes", 1, 16));
      options.misses = reader.choice("debug", {"none", "misses"}) == 1;
      options.floor = reader.flag("floor");
      return std::make_unique<PoseCacheRepresentation>(context, options);
    },
    .floor = "every agent in its character's first key pose, without choosing and without blending",
    .suits = {.new_clips = "yes: key poses are skinned when they are first shown",
              .close_by = "neighbours may share a pose; misses are skinned as the mesh",
              .from_above = "yes",
              .shadows = "as the mesh"},
};

}  // namespace crowdbench::renderers
