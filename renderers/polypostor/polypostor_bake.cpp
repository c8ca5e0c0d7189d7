// Based on: Kavan, Dobbyn, Collins, Zara and O'Sullivan 2008, "Polypostors: 2D polygonal impostors for 3D crowds" (an
// image a body part and view, deformed by a polygon whose corners follow the part's contour). Differs from the source:
// parts are found from the skeleton; the key frame is the one whose image looks best in all frames; each part has a
// depth plane; far away fewer parts with fewer corners are drawn; colours and normals apart, lit at run time.
#include "renderers/polypostor/polypostor_bake.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <numeric>
#include <thread>

#include "core/error.h"
#include "core/hash.h"
#include "renderers/bake_cache.h"
#include "renderers/polypostor/polypostor_fit.h"
#include "renderers/polypostor/polypostor_key.h"
#include "renderers/tiles/packing.h"
#include "renderers/tiles/plane.h"
#include "renderers/tiles/tile.h"
#include "renderers/tiles/tile_capture.h"

namespace crowdbench::renderers {
namespace {

constexpr uint32_t kBakeVersion = 15;  // raised whenever the same inputs give other bytes
constexpr uint32_t kFineLevels = 2;    // the levels drawn with all parts; coarser ones have fewer, of four corners
constexpr uint64_t kTexelBytes = 7;
constexpr int kCoarseCorners = 4;
constexpr double kRoom =
    0.5;  // texels of a tier's finest level around an image: bilinear filtering then reads one gutter
constexpr double kSeen = 1;      // texels: a part that shows less is not worth an image
constexpr double kReach = 1.25;  // of the radius: what positions may take

int level_count(int texels) {
  int levels = 1;
  while ((texels >> levels) >= 16) ++levels;
  return levels;
}

// The parts that a range of levels draws.
struct Tier {
  CutCharacter cut;
  std::vector<std::vector<uint32_t>> corners;     // by part: the triangles' vertices
  std::vector<std::vector<glm::vec3>> positions;  // by frame
  std::vector<std::vector<glm::vec3>> normals;    // by frame, of any length
  std::vector<glm::vec3> tones;
  std::vector<std::vector<SurfaceMoments>> moments;  // part, frame
  uint32_t first_level = 0, levels = 0;
  FitOptions fit;
};

// One key image of one part in one view of one clip.
struct Sheet {
  Fit fit;
  TileRect rect;
  std::vector<double> costs;      // one a frame: fit_costs; where one of two sheets is chosen
  std::vector<TilePlane> planes;  // one a frame
};
struct ViewParts {
  std::vector<std::vector<Sheet>> sheets;  // by part: none, one, or one a key
};

struct Plan {
  CaptureSphere sphere;
  double texel = 0;
  double quantum = 0;  // texels
  std::vector<PolypostorClip> clips;
  std::shared_ptr<const scene::PoseBank> moving, still;
  std::vector<const scene::PoseBank*> bank_of;       // by frame
  std::vector<scene::PoseSample> samples;            // by frame
  std::vector<std::vector<scene::Mat3x4>> palettes;  // by frame
  std::vector<Tier> tiers;
};

// Rotated as the positions are: joints scale little.
std::vector<glm::vec3> posed_normals(const scene::Mesh& mesh, const std::vector<scene::Mat3x4>& palette) {
  std::vector<glm::vec3> normals(mesh.normals.size());
  for (size_t v = 0; v < normals.size(); ++v) {
    glm::vec3 sum(0.0F);
    for (int k = 0; k < scene::kInfluences; ++k) {
      const scene::Mat3x4& m = palette[mesh.joints[v][k]];
      const glm::vec3& n = mesh.normals[v];
      sum += mesh.weights[v][k] * glm::vec3(glm::dot(glm::vec3(m.rows[0]), n), glm::dot(glm::vec3(m.rows[1]), n),
                                            glm::dot(glm::vec3(m.rows[2]), n));
    }
    normals[v] = sum;
  }
  return normals;
}

Plan make_plan(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
               const PolypostorBakeOptions& options) {
  Plan plan;
  plan.still = bank;
  std::vector<int> moving_clips;
  for (const scene::BankClip& c : bank->clips())
    if (c.samples > 1) moving_clips.push_back(c.clip);
  if (!moving_clips.empty())
    plan.moving =
        std::make_shared<const scene::PoseBank>(scene::PoseBank::frames(character, moving_clips, options.frames));
  std::vector<std::vector<glm::vec3>> positions;  // by frame
  int next_moving = 0;
  for (size_t c = 0; c < bank->clips().size(); ++c) {
    const bool moves = bank->clips()[c].samples > 1;
    const PolypostorClip clip{static_cast<uint32_t>(plan.samples.size()),
                              moves ? static_cast<uint32_t>(options.frames) : 1U};
    for (uint32_t f = 0; f < clip.frames; ++f) {
      const scene::PoseBank& from = moves ? *plan.moving : *bank;
      plan.bank_of.push_back(&from);
      plan.samples.push_back(moves ? from.sample(next_moving, static_cast<double>(f) / options.frames)
                                   : from.sample(static_cast<int>(c), 0));
      plan.palettes.push_back(from.palette(plan.samples.back()));
      positions.push_back(posed_positions(character.mesh, plan.palettes.back()));
    }
    if (moves) ++next_moving;
    plan.clips.push_back(clip);
  }
  plan.sphere = enclosing_sphere(positions);
  if (!(plan.sphere.radius > 0)) throw Error(character.name, "has no extent to take pictures of", "check the file");
  plan.texel = 2 * plan.sphere.radius / options.texels;
  plan.quantum = kReach * options.texels / 4094.0;

  const BodyParts parts = options.cuts == "auto"
                              ? find_parts(character)
                              : cut_parts(character, options.cuts, "representation 'polypostor', option 'parts'");
  const auto levels = static_cast<uint32_t>(level_count(options.texels));
  const uint32_t fine = std::min(levels, kFineLevels);
  const auto add_tier = [&](const PartMap& map, uint32_t first_level, uint32_t count, int corners) {
    if (map.count > kPolypostorParts)
      throw Error(fmt::format("polypostor bake of {}", character.name),
                  fmt::format("{} parts; {} is the most", map.count, kPolypostorParts), "name fewer joints");
    Tier tier;
    tier.cut = cut_at_parts(character, map);
    tier.first_level = first_level;
    tier.levels = count;
    const double room = kRoom * std::exp2(first_level);
    tier.fit = {corners, room, room, plan.quantum};
    const scene::Mesh& mesh = tier.cut.character->mesh;
    tier.tones = vertex_tones(*tier.cut.character);
    for (const auto& palette : plan.palettes) {
      tier.positions.push_back(posed_positions(mesh, palette));
      tier.normals.push_back(posed_normals(mesh, palette));
    }
    for (const auto& triangles : tier.cut.triangles) {
      auto& of_part = tier.corners.emplace_back();
      for (const uint32_t t : triangles)
        for (uint32_t k = 0; k < 3; ++k) of_part.push_back(mesh.indices[3 * t + k]);
      auto& by_frame = tier.moments.emplace_back();
      for (const auto& posed : tier.positions) by_frame.push_back(surface_moments(posed, of_part));
    }
    plan.tiers.push_back(std::move(tier));
  };
  add_tier(parts.fine, 0, fine, options.corners);
  if (levels > fine) add_tier(parts.coarse, fine, levels - fine, kCoarseCorners);
  return plan;
}

// Where skinning takes points of a view's plane, by the nearest edge of the part's mesh at the key.
class Carrier {
 public:
  Carrier(const Plan& plan, const Tier& tier, const ViewBasis& basis, std::span<const uint32_t> corners,
          size_t first_frame, size_t frames, size_t key)
      : mesh_(tier.cut.character->mesh),
        plan_(plan),
        tier_(tier),
        basis_(basis),
        corners_(corners),
        first_(first_frame),
        frames_(frames),
        key_(key) {}

  Polyline operator()(const glm::dvec2& p) const {
    const auto& positions = tier_.positions[key_];
    double least = INFINITY;
    std::array<uint32_t, 2> edge{};
    double along = 0;
    double height = 0;
    for (size_t i = 0; i < corners_.size(); ++i) {
      const uint32_t v = corners_[i];
      const uint32_t w = corners_[i % 3 == 2 ? i - 2 : i + 1];
      const glm::dvec3 a = seen(positions[v]);
      const glm::dvec3 b = seen(positions[w]);
      const glm::dvec2 ab(b - a);
      const double square = glm::dot(ab, ab);
      const double t = square > 0 ? std::clamp(glm::dot(p - glm::dvec2(a), ab) / square, 0.0, 1.0) : 0.0;
      const glm::dvec2 off = glm::dvec2(a) + ab * t - p;
      const double distance = glm::dot(off, off);
      if (distance >= least) continue;
      least = distance;
      edge = {v, w};
      along = t;
      height = a.z + (b.z - a.z) * t;
    }
    const glm::dvec3 point =
        plan_.sphere.centre + plan_.texel * (p.x * basis_.right + p.y * basis_.up + height * basis_.to_eye);
    const std::array<glm::dvec3, 2> bound = {unposed(edge[0], point), unposed(edge[1], point)};
    Polyline out;
    for (size_t f = first_; f < first_ + frames_; ++f) {
      const glm::dvec3 there = glm::mix(glm::dvec3(skin(edge[0], f) * glm::dvec4(bound[0], 1)),
                                        glm::dvec3(skin(edge[1], f) * glm::dvec4(bound[1], 1)), along);
      out.emplace_back(seen(glm::vec3(there)));
    }
    return out;
  }

 private:
  glm::dvec3 seen(const glm::vec3& p) const {  // texels
    const glm::dvec3 d = (glm::dvec3(p) - plan_.sphere.centre) / plan_.texel;
    return {glm::dot(d, basis_.right), glm::dot(d, basis_.up), glm::dot(d, basis_.to_eye)};
  }
  glm::dmat4 skin(uint32_t vertex, size_t frame) const {
    glm::dmat4 m(0.0);
    for (int k = 0; k < scene::kInfluences; ++k) {
      const scene::Mat3x4& joint = plan_.palettes[frame][mesh_.joints[vertex][k]];
      for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
          m[column][row] +=
              static_cast<double>(mesh_.weights[vertex][k]) * static_cast<double>(joint.rows[row][column]);
    }
    m[3][3] = 1;
    return m;
  }
  glm::dvec3 unposed(uint32_t vertex, const glm::dvec3& p) const {
    const glm::dmat4 m = skin(vertex, key_);
    if (std::abs(glm::determinant(glm::dmat3(m))) < 1e-18) return glm::dvec3(mesh_.positions[vertex]);
    return glm::dvec3(glm::inverse(m) * glm::dvec4(p, 1));
  }

  const scene::Mesh& mesh_;
  const Plan& plan_;
  const Tier& tier_;
  const ViewBasis& basis_;
  std::span<const uint32_t> corners_;
  size_t first_, frames_, key_;
};

TileRect rect_around(const Polyline& contour) {
  glm::dvec2 low(INFINITY);
  glm::dvec2 high(-INFINITY);
  for (const glm::dvec2& p : contour) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const glm::ivec2 first(glm::floor(low));
  const glm::ivec2 last(glm::ceil(high));
  return {first.x, first.y, last.x - first.x, last.y - first.y};
}

// What a view sees of one part through a clip.
struct SeenPart {
  std::vector<Polyline> contours;           // by frame
  std::vector<double> areas;                // by frame, texels
  std::vector<std::vector<double>> errors;  // by key and frame: look_error; empty where the key does not show the part
};

// looks: whether keys are to be compared.
std::vector<SeenPart> see_parts(const Plan& plan, const Tier& tier, const PolypostorClip& clip, const ViewBasis& basis,
                                bool looks) {
  std::vector<std::vector<glm::dvec3>> positions;  // by frame and vertex: view axes, texels
  std::vector<std::vector<glm::vec3>> normals;     // view axes
  const glm::mat3 to_view = glm::transpose(glm::mat3(basis.right, basis.up, basis.to_eye));
  for (uint32_t f = 0; f < clip.frames; ++f) {
    auto& points = positions.emplace_back();
    for (const glm::vec3& p : tier.positions[clip.first_frame + f]) {
      const glm::dvec3 d = (glm::dvec3(p) - plan.sphere.centre) / plan.texel;
      points.emplace_back(glm::dot(d, basis.right), glm::dot(d, basis.up), glm::dot(d, basis.to_eye));
    }
    auto& turned = normals.emplace_back();
    for (const glm::vec3& n : tier.normals[clip.first_frame + f]) turned.push_back(to_view * n);
  }
  std::vector<SeenPart> out;
  for (const auto& corners : tier.corners) {
    SeenPart& part = out.emplace_back();
    std::vector<PartLook> images;
    std::vector<glm::dvec2> flat;
    for (uint32_t f = 0; f < clip.frames; ++f) {
      flat.clear();
      for (const uint32_t v : corners) flat.emplace_back(positions[f][v]);
      const PartMask mask = rasterise(flat);
      part.areas.push_back(facing_area(mask));
      part.contours.push_back(part.areas.back() > 0 ? trace_contour(mask) : Polyline{});
      if (looks) images.push_back(look_at_part(corners, positions[f], normals[f], tier.tones));
    }
    part.errors.resize(clip.frames);
    if (!looks) continue;
    for (uint32_t k = 0; k < clip.frames; ++k)
      for (uint32_t f = 0; f < clip.frames && part.areas[k] >= kSeen; ++f)
        part.errors[k].push_back(f == k ? 0.0 : look_error(images[k], images[f], corners, positions[k], positions[f]));
  }
  return out;
}

// What a frame costs that a fit shows: by its looks, and by the texels between its outline and the frame's own.
std::vector<double> fit_costs(const SeenPart& part, const Fit& fit) {
  constexpr double kOutline = 3;  // square texel between the outlines
  std::vector<double> costs = part.errors[fit.key];
  for (size_t f = 0; f < costs.size(); ++f) costs[f] += kOutline * fit.errors[f] * perimeter(part.contours[f]);
  return costs;
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

// The fits whose images of a part are kept: none, one, or two.
std::vector<Fit> fit_keys(const SeenPart& part, KeyChoice choice, const std::function<Fit(size_t)>& fit) {
  constexpr size_t kTried = 6;
  const size_t frames = part.areas.size();
  std::vector<size_t> keys;
  for (size_t k = 0; k < frames; ++k)
    if (part.areas[k] >= kSeen) keys.push_back(k);
  std::vector<Fit> out;
  const auto keep = [&](Fit one) {
    if (!one.polygon.empty()) out.push_back(std::move(one));
  };
  if (keys.empty()) return out;
  if (choice == KeyChoice::first) {
    keep(fit(keys[0]));
    return out;
  }
  if (choice == KeyChoice::two_keys && keys.size() > 1) {
    // The pair that looks best, each step between stored frames shown by the better one.
    std::array<size_t, 2> best{};
    double least = INFINITY;
    for (size_t i = 0; i < keys.size(); ++i)
      for (size_t j = 0; j < i; ++j) {
        double cost = 0;
        for (size_t f = 0; f < frames; ++f) {
          const size_t next = (f + 1) % frames;
          cost += std::min(part.errors[keys[i]][f] + part.errors[keys[i]][next],
                           part.errors[keys[j]][f] + part.errors[keys[j]][next]);
        }
        if (cost >= least) continue;
        least = cost;
        best = {keys[j], keys[i]};
      }
    for (const size_t k : best) keep(fit(k));
    return out;
  }
  // By their looks first; of the best of those, by what their polygons make of them.
  std::stable_sort(keys.begin(), keys.end(),
                   [&](size_t a, size_t b) { return sum(part.errors[a]) < sum(part.errors[b]); });
  keys.resize(std::min(keys.size(), kTried));
  double least = INFINITY;
  for (const size_t k : keys) {
    Fit one = fit(k);
    if (one.polygon.empty()) continue;
    const double cost = sum(fit_costs(part, one));
    if (cost >= least) continue;
    least = cost;
    out.clear();
    out.push_back(std::move(one));
  }
  return out;
}

ViewParts fit_view(const Plan& plan, const Tier& tier, const PolypostorClip& clip, const ViewBasis& basis,
                   KeyChoice choice) {
  const std::vector<SeenPart> seen = see_parts(plan, tier, clip, basis, choice != KeyChoice::first);
  ViewParts out;
  out.sheets.resize(seen.size());
  for (size_t part = 0; part < seen.size(); ++part) {
    const auto fit = [&](size_t key) {
      return fit_part(
          seen[part].contours, key,
          Carrier(plan, tier, basis, tier.corners[part], clip.first_frame, clip.frames, clip.first_frame + key),
          tier.fit);
    };
    for (Fit& one : fit_keys(seen[part], choice, fit)) {
      Sheet sheet;
      sheet.rect = rect_around(seen[part].contours[one.key]);
      if (choice == KeyChoice::two_keys) sheet.costs = fit_costs(seen[part], one);
      sheet.fit = std::move(one);
      for (uint32_t f = 0; f < clip.frames; ++f)
        sheet.planes.push_back(fit_plane(tier.moments[part][clip.first_frame + f], plan.sphere.centre, basis));
      out.sheets[part].push_back(std::move(sheet));
    }
  }
  return out;
}

// Runs `work(i)` for every i below `count` on all threads; the first exception is thrown here.
template <typename Work>
void parallel(size_t count, unsigned threads, const Work& work, const std::function<void(size_t)>& advanced) {
  std::atomic<size_t> next = 0;
  std::atomic<size_t> done = 0;
  std::mutex mutex;
  std::exception_ptr fault;
  const auto run = [&](bool reports) {
    for (size_t i = next++; i < count; i = next++) {
      try {
        work(i);
        ++done;
        if (reports && advanced) advanced(done);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!fault) fault = std::current_exception();
        next = count;
      }
    }
  };
  std::vector<std::thread> others;
  for (unsigned t = 1; t < threads; ++t) others.emplace_back(run, false);
  run(true);
  for (std::thread& t : others) t.join();
  if (fault) std::rethrow_exception(fault);
}

// The character with the triangles of one part only, drawn from both sides: where a part is cut off its inside shows,
// and closes what would be a gap when its neighbour moves away.
std::shared_ptr<const scene::Character> only_part(const scene::Character& character,
                                                  const std::vector<uint32_t>& triangles) {
  auto part = std::make_shared<scene::Character>(character);
  for (scene::Material& material : part->materials) material.double_sided = true;
  scene::Mesh& mesh = part->mesh;
  mesh.indices.clear();
  size_t next = 0;
  for (scene::Primitive& primitive : mesh.primitives) {
    const uint32_t end = (primitive.first_index + primitive.index_count) / 3;
    const auto first = static_cast<uint32_t>(mesh.indices.size());
    // Triangles are ascending, and so are the primitives' ranges.
    while (next < triangles.size() && triangles[next] < end) {
      for (uint32_t k = 0; k < 3; ++k) mesh.indices.push_back(character.mesh.indices[3 * triangles[next] + k]);
      ++next;
    }
    primitive.first_index = first;
    primitive.index_count = static_cast<uint32_t>(mesh.indices.size()) - first;
  }
  return part;
}

uint32_t pack_position(const glm::dvec2& p, double z, double quantum, double unit_z) {
  const auto code = [](double v, double zero, double most) {
    return static_cast<uint32_t>(std::clamp(std::round(v + zero), 0.0, most));
  };
  return code(p.x / quantum, 2048, 4095) | code(p.y / quantum, 2048, 4095) << 12U | code(z / unit_z, 128, 255) << 24U;
}

uint32_t pack_turn(const glm::dvec2& turn) {
  const auto code = [](double v) {
    return static_cast<uint32_t>(static_cast<uint16_t>(static_cast<int16_t>(std::lround(v * 32767))));
  };
  return code(turn.x) | code(turn.y) << 16U;
}

// A sheet's place in the list of all tiles: levels follow each other.
struct SheetTiles {
  size_t first = 0;
};

// Copies a tile with the gutters of the sides asked for. Neighbours share one gutter between them, filled by whoever
// comes last; a tile's own texels are written after all gutters.
void copy_tile(const Tile& tile, const PackPlace& place, bool gutters, PolypostorBake& bake) {
  for (int row = 0; row < tile.rows(); ++row)
    for (int column = 0; column < tile.stride(); ++column) {
      const bool own = column >= kTileGutter && row >= kTileGutter && column < tile.stride() - kTileGutter &&
                       row < tile.rows() - kTileGutter;
      const int x = place.x + column - kTileGutter;
      const int y = place.y + row - kTileGutter;
      if (own == gutters || x < 0 || y < 0) continue;
      const size_t from = static_cast<size_t>(row) * static_cast<size_t>(tile.stride()) + static_cast<size_t>(column);
      const size_t to = (static_cast<size_t>(place.layer) * static_cast<size_t>(bake.height) + static_cast<size_t>(y)) *
                            static_cast<size_t>(bake.width) +
                        static_cast<size_t>(x);
      std::copy_n(&tile.albedo[4 * from], 4, &bake.albedo[4 * to]);
      std::copy_n(&tile.surface[4 * from], 2, &bake.normals[2 * to]);
      bake.materials[to] = tile.surface[4 * from + 2];
    }
}

// In layers of the size that wastes least.
Packing pack_tightly(std::span<const PackSize> sizes) {
  constexpr int kSmallest = 256;
  constexpr int kLargest = 1024;
  constexpr int kStep = 32;
  Packing best;
  uint64_t least = std::numeric_limits<uint64_t>::max();
  for (int side = kLargest; side >= kSmallest; side -= kStep) {
    Packing tried = pack_tiles(sizes, side);
    const uint64_t texels =
        static_cast<uint64_t>(tried.width) * static_cast<uint64_t>(tried.height) * static_cast<uint64_t>(tried.layers);
    if (texels >= least) continue;
    least = texels;
    best = std::move(tried);
  }
  return best;
}

// Which of a part's sheets shows the way from frame f to the next.
size_t sheet_for(const std::vector<Sheet>& sheets, size_t f, size_t frames) {
  size_t best = 0;
  if (sheets.size() < 2) return best;
  double least = INFINITY;
  for (size_t s = 0; s < sheets.size(); ++s) {
    const double cost = sheets[s].costs[f] + sheets[s].costs[(f + 1) % frames];
    if (cost < least) {
      least = cost;
      best = s;
    }
  }
  return best;
}

}  // namespace

std::string polypostor_cache_key(const scene::Character& character, const scene::PoseBank& bank,
                                 const PolypostorBakeOptions& options, const std::string& gl_renderer,
                                 const std::string& gl_version) {
  Sha256 hash;
  hash.text("polypostor").value(kBakeVersion).text(character.content_hash).text(gl_renderer).text(gl_version);
  hash.text(options.grid.text()).value(options.grid.el_min).text(options.cuts);
  hash.value(options.frames).value(options.texels).value(options.corners).value(options.key);
  for (const scene::BankClip& c : bank.clips()) {
    hash.value(c.clip).value(c.samples > 1);
    if (c.samples > 1) continue;
    for (const scene::Mat3x4& m : bank.palette(bank.sample(static_cast<int>(&c - bank.clips().data()), 0)))
      hash.bytes(&m, sizeof m);
  }
  return hash.hex();
}

PolypostorBake bake_polypostor(gl::Context& context, const std::shared_ptr<const scene::Character>& character,
                               const std::shared_ptr<const scene::PoseBank>& bank, const PolypostorBakeOptions& options,
                               uint64_t budget, const std::function<void(size_t, size_t)>& progress) {
  const Plan plan = make_plan(*character, bank, options);
  const auto views = static_cast<size_t>(options.grid.size());
  const size_t clips = plan.clips.size();
  const size_t tiers = plan.tiers.size();

  // Polygons of every tier, clip and view.
  std::vector<ViewParts> fitted(tiers * clips * views);
  const unsigned threads =
      options.threads > 0 ? options.threads : std::clamp(std::thread::hardware_concurrency(), 1U, 8U);
  const size_t total = fitted.size() + fitted.size() / 4 + 1;  // images take about a fifth of the time
  parallel(
      fitted.size(), threads,
      [&](size_t i) {
        const size_t view = i % views;
        if (!options.grid.reachable(static_cast<int>(view))) return;
        fitted[i] = fit_view(plan, plan.tiers[i / (clips * views)], plan.clips[i / views % clips],
                             options.grid.basis(static_cast<int>(view)), options.key);
      },
      [&](size_t done) {
        if (progress) progress(done, total);
      });

  // Their key images.
  std::vector<Tile> tiles;
  std::vector<std::vector<std::vector<SheetTiles>>> places(fitted.size());
  for (size_t i = 0; i < fitted.size(); ++i) {
    const Tier& tier = plan.tiers[i / (clips * views)];
    for (const auto& sheets : fitted[i].sheets) {
      auto& of_part = places[i].emplace_back();
      for (size_t s = 0; s < sheets.size(); ++s) {
        of_part.push_back({tiles.size()});
        tiles.resize(tiles.size() + tier.levels);
      }
    }
  }
  uint64_t texels = 0;
  for (size_t i = 0; i < fitted.size(); ++i) {
    const Tier& tier = plan.tiers[i / (clips * views)];
    for (const auto& sheets : fitted[i].sheets)
      for (const Sheet& sheet : sheets)
        for (uint32_t l = tier.first_level; l < tier.first_level + tier.levels; ++l) {
          const auto side = [&](int v) { return static_cast<uint64_t>((v >> l) + 1 + kTileGutter); };
          texels += side(sheet.rect.width) * side(sheet.rect.height);
        }
  }
  if (texels * kTexelBytes > budget)
    throw Error(
        fmt::format("polypostor bake of {}", character->name),
        fmt::format("{} clip{}, {} views and {} texels need about {:.0f} MiB, the budget is {:.0f}", clips,
                    clips == 1 ? "" : "s", views, options.texels, static_cast<double>(texels * kTexelBytes) / (1 << 20),
                    static_cast<double>(budget) / (1 << 20)),
        "lower texels or views, use fewer clips or characters, or raise --bake-budget");

  for (size_t t = 0; t < tiers; ++t) {
    const Tier& tier = plan.tiers[t];
    const auto& triangles = tier.cut.triangles;
    for (size_t part = 0; part < triangles.size(); ++part) {
      for (const bool moving : {true, false}) {
        std::vector<CaptureTile> wanted;
        std::vector<size_t> to;
        for (size_t c = 0; c < clips; ++c) {
          if ((plan.bank_of[plan.clips[c].first_frame] == plan.moving.get()) != moving) continue;
          for (size_t v = 0; v < views; ++v) {
            const size_t i = (t * clips + c) * views + v;
            if (fitted[i].sheets.empty()) continue;
            const auto& sheets = fitted[i].sheets[part];
            for (size_t s = 0; s < sheets.size(); ++s) {
              wanted.push_back({plan.samples[plan.clips[c].first_frame + sheets[s].fit.key],
                                options.grid.basis(static_cast<int>(v)), sheets[s].rect});
              to.push_back(places[i][part][s].first);
            }
          }
        }
        if (wanted.empty()) continue;
        TileCapture capture(context, only_part(*tier.cut.character, triangles[part]), moving ? plan.moving : plan.still,
                            plan.sphere.centre, plan.texel, plan.sphere.radius, 0);
        capture.capture(wanted, [&](std::span<const size_t> page, std::span<const std::vector<CapturedTexel>> images) {
          parallel(page.size(), threads,
                   [&](size_t k) {
                     std::vector<Tile> levels = build_tile_levels(
                         wanted[page[k]].rect, images[k], static_cast<int>(tier.first_level + tier.levels), false);
                     for (uint32_t l = 0; l < tier.levels; ++l)
                       tiles[to[page[k]] + l] = std::move(levels[tier.first_level + l]);
                   },
                   {});
          if (progress)
            progress(fitted.size() + fitted.size() / 4 * (t * triangles.size() + part) / (tiers * triangles.size()),
                     total);
        });
      }
    }
  }

  PolypostorBake bake;
  bake.centre = {static_cast<float>(plan.sphere.centre.x), static_cast<float>(plan.sphere.centre.y),
                 static_cast<float>(plan.sphere.centre.z)};
  bake.radius = static_cast<float>(plan.sphere.radius);
  bake.texel = static_cast<float>(plan.texel);
  bake.unit = static_cast<float>(plan.quantum * plan.texel);
  bake.unit_z = static_cast<float>(kReach * plan.sphere.radius / 127);
  bake.frames = static_cast<uint32_t>(plan.samples.size());
  bake.views = static_cast<uint32_t>(views);
  bake.levels = plan.tiers.back().first_level + plan.tiers.back().levels;
  bake.ranges_by_frame = options.key == KeyChoice::two_keys ? 1 : 0;
  bake.clips = plan.clips;

  std::vector<PackSize> sizes;
  for (const Tile& tile : tiles)
    sizes.push_back(tile.rect.width == 0 ? PackSize{}
                                         : PackSize{tile.stride() - kTileGutter, tile.rows() - kTileGutter});
  const Packing packing = pack_tightly(sizes);
  bake.width = packing.width;
  bake.height = packing.height;
  bake.layers = packing.layers;
  const size_t page_texels =
      static_cast<size_t>(bake.width) * static_cast<size_t>(bake.height) * static_cast<size_t>(bake.layers);
  bake.albedo.assign(4 * page_texels, 0);
  bake.normals.assign(2 * page_texels, 0);
  bake.materials.assign(page_texels, 0);
  for (const bool gutters : {true, false})
    for (size_t i = 0; i < tiles.size(); ++i)
      if (packing.places[i].layer >= 0) copy_tile(tiles[i], packing.places[i], gutters, bake);

  bake.sets.resize(bake.levels * clips * views);
  double seen = 0;
  double corners = 0;
  double errors = 0;
  for (size_t i = 0; i < fitted.size(); ++i) {
    const Tier& tier = plan.tiers[i / (clips * views)];
    const size_t frames = plan.clips[i / views % clips].frames;
    const ViewParts& parts = fitted[i];
    size_t vertices = 0;
    size_t sheet_count = 0;
    for (const auto& sheets : parts.sheets)
      for (const Sheet& sheet : sheets) {
        vertices += sheet.fit.polygon.size();
        ++sheet_count;
      }
    PolypostorSet set;
    set.first_word = static_cast<uint32_t>(bake.words.size());
    set.words = static_cast<uint32_t>(vertices + sheet_count);
    set.first_range = static_cast<uint32_t>(bake.ranges.size());
    for (size_t f = 0; f < frames; ++f) {
      for (const auto& sheets : parts.sheets)
        for (const Sheet& sheet : sheets)
          for (const glm::dvec2& p : sheet.fit.poses[f]) {
            const TilePlane& plane = sheet.planes[f];
            const double z = (plane.slope_x * p.x + plane.slope_y * p.y) * plan.texel + plane.height;
            bake.words.push_back(pack_position(p, z, plan.quantum, static_cast<double>(bake.unit_z)));
          }
      for (const auto& sheets : parts.sheets)
        for (const Sheet& sheet : sheets) bake.words.push_back(pack_turn(sheet.fit.turns[f]));
    }
    for (size_t f = 0; f < (bake.ranges_by_frame != 0 ? frames : 1); ++f) {
      PolypostorRange range{static_cast<uint32_t>(bake.indices.size()), 0};
      size_t base = 0;
      for (const auto& sheets : parts.sheets) {
        const size_t shown = sheets.empty() ? 0 : sheet_for(sheets, f, frames);
        for (size_t s = 0; s < sheets.size(); ++s) {
          if (s == shown)
            for (const Triangle& t : sheets[s].fit.triangles)
              for (const uint16_t corner : t) bake.indices.push_back(static_cast<uint16_t>(base + corner));
          base += sheets[s].fit.polygon.size();
        }
      }
      range.indices = static_cast<uint32_t>(bake.indices.size()) - range.first_index;
      bake.ranges.push_back(range);
    }
    for (uint32_t l = 0; l < tier.levels; ++l) {
      set.first_vertex = static_cast<uint32_t>(bake.vertices.size());
      size_t local = 0;
      size_t sheet_index = 0;
      for (size_t part = 0; part < parts.sheets.size(); ++part)
        for (size_t s = 0; s < parts.sheets[part].size(); ++s) {
          const size_t tile = places[i][part][s].first + l;
          const PackPlace& place = packing.places[tile];
          const TileRect& rect = tiles[tile].rect;
          for (const glm::dvec2& p : parts.sheets[part][s].fit.polygon) {
            const glm::dvec2 at = p / std::exp2(static_cast<double>(tier.first_level + l)) +
                                  glm::dvec2(place.x - rect.x, place.y - rect.y);
            const auto code = [](double v) {
              return static_cast<uint16_t>(std::clamp(std::round(v * 65535), 0.0, 65535.0));
            };
            bake.vertices.push_back({code(at.x / bake.width), code(at.y / bake.height),
                                     static_cast<uint16_t>(std::max(place.layer, 0) | static_cast<int>(part) << 11),
                                     static_cast<uint16_t>(vertices + sheet_index - local)});
            ++local;
          }
          ++sheet_index;
        }
      bake.sets[((tier.first_level + l) * clips + i / views % clips) * views + i % views] = set;
    }
    if (i < clips * views) {
      bake.parts = static_cast<double>(tier.corners.size());
      for (const auto& sheets : parts.sheets)
        for (const Sheet& sheet : sheets) {
          ++seen;
          corners += static_cast<double>(sheet.fit.polygon.size());
          for (const double e : sheet.fit.errors) errors += e / static_cast<double>(frames);
          bake.repaired += static_cast<double>(sheet.fit.repaired);
        }
    }
  }
  bake.parts_seen = seen / static_cast<double>(clips * views);
  bake.corners_seen = corners / std::max(seen, 1.0);
  bake.outline_error = errors / std::max(seen, 1.0);
  if (progress) progress(total, total);
  return bake;
}

std::vector<uint8_t> serialise(const PolypostorBake& bake) {
  ByteWriter out;
  out.reserve(bake.texture_bytes() + (size_t{1} << 20));
  out.value(bake.centre);
  for (const float v : {bake.radius, bake.texel, bake.unit, bake.unit_z}) out.value(v);
  for (const uint32_t v : {bake.frames, bake.views, bake.levels, bake.ranges_by_frame}) out.value(v);
  for (const int v : {bake.width, bake.height, bake.layers}) out.value(v);
  for (const double v : {bake.parts, bake.parts_seen, bake.corners_seen, bake.outline_error, bake.repaired})
    out.value(v);
  out.values(bake.clips);
  out.values(bake.albedo);
  out.values(bake.normals);
  out.values(bake.materials);
  out.values(bake.sets);
  out.values(bake.ranges);
  out.values(bake.indices);
  out.values(bake.vertices);
  out.values(bake.words);
  return out.bytes();
}

std::optional<PolypostorBake> deserialise_polypostor(std::span<const uint8_t> bytes) {
  ByteReader in(bytes);
  PolypostorBake bake;
  bake.centre = in.value<std::array<float, 3>>();
  for (float* v : {&bake.radius, &bake.texel, &bake.unit, &bake.unit_z}) *v = in.value<float>();
  for (uint32_t* v : {&bake.frames, &bake.views, &bake.levels, &bake.ranges_by_frame}) *v = in.value<uint32_t>();
  for (int* v : {&bake.width, &bake.height, &bake.layers}) *v = in.value<int>();
  for (double* v : {&bake.parts, &bake.parts_seen, &bake.corners_seen, &bake.outline_error, &bake.repaired})
    *v = in.value<double>();
  bake.clips = in.values<PolypostorClip>();
  bake.albedo = in.values<uint8_t>();
  bake.normals = in.values<uint8_t>();
  bake.materials = in.values<uint8_t>();
  bake.sets = in.values<PolypostorSet>();
  bake.ranges = in.values<PolypostorRange>();
  bake.indices = in.values<uint16_t>();
  bake.vertices = in.values<PolypostorVertex>();
  bake.words = in.values<uint32_t>();
  if (!in.ok() || !in.at_end() || bake.width < 0 || bake.height < 0 || bake.layers < 0 || bake.clips.empty())
    return std::nullopt;
  const uint64_t texels =
      static_cast<uint64_t>(bake.width) * static_cast<uint64_t>(bake.height) * static_cast<uint64_t>(bake.layers);
  if (bake.albedo.size() != 4 * texels || bake.normals.size() != 2 * texels || bake.materials.size() != texels ||
      bake.sets.size() != uint64_t{bake.levels} * bake.clips.size() * bake.views)
    return std::nullopt;
  // What the GPU will follow must lead nowhere else.
  for (size_t i = 0; i < bake.sets.size(); ++i) {
    const PolypostorSet& set = bake.sets[i];
    const PolypostorClip& clip = bake.clips[i / bake.views % bake.clips.size()];
    const uint64_t ranges = bake.ranges_by_frame != 0 ? clip.frames : 1;
    if (clip.frames == 0 || uint64_t{clip.first_frame} + clip.frames > bake.frames ||
        set.first_word + uint64_t{set.words} * clip.frames > bake.words.size() ||
        set.first_range + ranges > bake.ranges.size() || set.first_vertex > bake.vertices.size())
      return std::nullopt;
    for (uint64_t r = set.first_range; r < set.first_range + ranges; ++r) {
      const PolypostorRange& range = bake.ranges[r];
      if (uint64_t{range.first_index} + range.indices > bake.indices.size()) return std::nullopt;
      for (uint32_t k = range.first_index; k < range.first_index + range.indices; ++k) {
        const uint64_t vertex = set.first_vertex + uint64_t{bake.indices[k]};
        if (vertex >= bake.vertices.size() || bake.indices[k] + uint64_t{bake.vertices[vertex].turn} >= set.words)
          return std::nullopt;
      }
    }
  }
  return bake;
}

}  // namespace crowdbench::renderers
