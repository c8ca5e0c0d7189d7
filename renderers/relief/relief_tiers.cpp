// Differs from Beacco et al. 2011: one box a joint at every distance there; here boxes in parts nearby, and joints that
// share boxes far away.
#include "renderers/relief/relief_tiers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/hash.h"
#include "renderers/bake/bake_cache.h"
#include "renderers/bake/bake_loader.h"
#include "renderers/bake/emission.h"
#include "renderers/relief/relief_atlas.h"
#include "renderers/relief/relief_cells.h"
#include "renderers/relief/relief_cone.h"

namespace crowdbench::renderers {
namespace {

constexpr uint32_t kBakeVersion = 21;

// Distances at which joints may share boxes, from the nearest tier on. A tier is drawn below its height; tier 0, every
// joint on its own, above all.
struct TierPlan {
  double pixels;  // of the character's height
  double texel;   // the most that a texel may cover at that height, in pixels
};
// Rays cross as many texels a pixel whatever the box; the farther, the finer, since an outline is off by half a texel
// of ever thinner limbs.
constexpr std::array<TierPlan, 4> kTiers{{{100, 0.4}, {50, 0.22}, {25, 0.15}, {12.5, 0.12}}};

constexpr double kFarBend = 3.0;  // pixels that skin may deviate from a farther tier's boxes, at its largest
// Silhouette error of rigid boxes over the clips (CaptureScore) up to which skin counts as stiff.
constexpr double kStiff = 0.006;
// Taller figures have the nearest tier's cells wherever skin is cut.
constexpr double kWholePixels = 50;
// A farther tier has at most this many times the boxes of the one before, or it is not worth its bytes.
constexpr double kFewer = 0.75;
constexpr double kCutTexel = 0.5;  // of a whole box's largest texel, what cut skin makes do with
// Texels that cut skin may take nearby, of those that rigid boxes of the same character would.
constexpr double kMore = 1.85;
constexpr double kSkirt = 1.5;  // texels of a box's neighbours that it captures too

constexpr const char* kCapture = "representation 'relief', option 'capture'";
constexpr const char* kResolution = "representation 'relief', option 'resolution'";

// "walk@0.25": the clip's name, and the phase.
std::pair<std::string, double> split_capture(const std::string& text, const std::string& where) {
  const size_t at = text.rfind('@');
  if (at == std::string::npos) return {text, 0.0};
  return {text.substr(0, at), number_of(text.data() + at + 1, text.data() + text.size(), where, text, 0, 1,
                                        "write CLIP@PHASE with a phase in [0, 1), as in walk@0.25")};
}

// "bind" or "CLIP@PHASE".
CapturePose parse_capture(const std::string& text, const scene::Character& character) {
  CapturePose pose;
  if (text == "bind") return pose;
  const auto [clip, phase] = split_capture(text, kCapture);
  pose.phase = phase;
  try {
    pose.clip = scene::require_clip(character, clip);
  } catch (const Error& error) {
    throw Error(kCapture, fmt::format("{}: {}", error.where, error.wrong), error.advice);
  }
  return pose;
}

// "Head@256+3@32": a joint's name or number, and texels a side.
std::vector<std::pair<std::string, int>> split_resolution(const std::string& text, const std::string& where) {
  std::vector<std::pair<std::string, int>> items;
  for (size_t at = 0; at <= text.size();) {
    const size_t end = std::min(text.find('+', at), text.size());
    const std::string item = text.substr(at, end - at);
    at = end + 1;
    const size_t sign = item.rfind('@');
    int size = 0;
    if (sign != std::string::npos) {
      const char* last = item.data() + item.size();
      const auto [stop, fault] = std::from_chars(item.data() + sign + 1, last, size);
      if (fault != std::errc() || stop != last) size = 0;
    }
    if (size < 16 || size > 256 || !std::has_single_bit(static_cast<unsigned>(size)))
      throw Error(where, fmt::format("\"{}\" is not JOINT@TEXELS", printable(item)),
                  "write 16, 32, 64, 128 or 256 texels, as in Head@256+LeftHand@32");
    items.emplace_back(item.substr(0, sign), size);
  }
  return items;
}

// Texels a side by joint, each named or counted from 0.
std::vector<int> parse_resolution(const std::string& text, const scene::Character& character) {
  if (text == "none") return {};
  const std::vector<scene::Joint>& joints = character.skeleton.joints;
  std::vector<int> texels(joints.size(), 0);
  for (const auto& [name, size] : split_resolution(text, kResolution)) {
    size_t joint = 0;
    while (joint < joints.size() && joints[joint].name != name) ++joint;
    if (joint == joints.size()) {
      const auto [stop, fault] = std::from_chars(name.data(), name.data() + name.size(), joint);
      if (fault != std::errc() || stop != name.data() + name.size() || joint >= joints.size()) {
        std::vector<std::string> names;
        for (const scene::Joint& j : joints) names.push_back(j.name);
        const std::string near = nearest_name(name, names);
        throw Error(kResolution, fmt::format("{} has no joint \"{}\"", character.name, printable(name)),
                    near.empty() ? fmt::format("name one, or count from 0 to {}", joints.size() - 1)
                                 : fmt::format("did you mean \"{}\"?", printable(near)));
      }
    }
    texels[joint] = size;
  }
  return texels;
}

// A box as it lies on disk.
struct StoredBox {
  std::array<int32_t, kShares> joints{};
  std::array<double, kShares> weights{};
  std::array<double, 16 * kShares> movers{};
  int32_t texels = 0;
  int32_t nothing = 0;  // no padding: the same bake is the same bytes
  uint64_t first = 0;
  std::array<double, 16> bind_from_unit{};
  std::array<double, 3> size{};
  std::array<float, 3 * kHullPoints> hull{};
};

StoredBox stored(const ReliefBox& box) {
  StoredBox out{{}, {}, {}, box.texels, 0, box.first, {}, {}, {}};
  for (size_t k = 0; k < kShares; ++k) {
    out.joints[k] = box.movers[k].joint;
    out.weights[k] = box.movers[k].weight;
    for (int i = 0; i < 16; ++i)
      out.movers[16 * k + static_cast<size_t>(i)] = box.movers[k].bind_from_unit[i / 4][i % 4];
  }
  for (int i = 0; i < 16; ++i) out.bind_from_unit[static_cast<size_t>(i)] = box.bind_from_unit[i / 4][i % 4];
  for (int a = 0; a < 3; ++a) out.size[static_cast<size_t>(a)] = box.size[a];
  for (size_t i = 0; i < out.hull.size(); ++i) out.hull[i] = box.hull[i / 3][static_cast<int>(i % 3)];
  return out;
}

ReliefBox unstored(const StoredBox& from) {
  ReliefBox box;
  for (size_t k = 0; k < kShares; ++k) {
    box.movers[k].joint = from.joints[k];
    box.movers[k].weight = from.weights[k];
    for (int i = 0; i < 16; ++i)
      box.movers[k].bind_from_unit[i / 4][i % 4] = from.movers[16 * k + static_cast<size_t>(i)];
  }
  box.texels = from.texels;
  box.first = from.first;
  for (int i = 0; i < 16; ++i) box.bind_from_unit[i / 4][i % 4] = from.bind_from_unit[static_cast<size_t>(i)];
  for (int a = 0; a < 3; ++a) box.size[a] = from.size[static_cast<size_t>(a)];
  for (size_t i = 0; i < from.hull.size(); ++i) box.hull[i / 3][static_cast<int>(i % 3)] = from.hull[i];
  return box;
}

// Of so many texels of one map: three depth maps, six faces, and the levels.
uint64_t maps_bytes(uint64_t texels, float emission_peak, const ReliefTierOptions& options) {
  return texels * 3 * (depth_texel_bytes(options) + colour_texel_bytes(emission_peak)) * 3 / 2;
}

uint64_t atlas_bytes(const ReliefModel& model, const ReliefTierOptions& options) {
  const AtlasPlan plan = plan_atlas(model);
  return static_cast<uint64_t>(plan.width) * static_cast<uint64_t>(plan.height) *
             (depth_texel_bytes(options) + colour_texel_bytes(model.emission_peak)) +
         (model.cube ? 0 : static_cast<uint64_t>(plan.width / 2) * static_cast<uint64_t>(plan.height / 2) * 2);
}

// The steps of a bake: the pose to capture in, the nearest tier's cells and maps, its cones; then of each farther tier
// cells and maps.
constexpr size_t kCaptureStep = 0;
constexpr size_t kCellStep = 1;
constexpr size_t kMapStep = 2;
constexpr size_t kTierSteps = 3;
constexpr size_t kConeStep = kTierSteps + 2 * kTiers.size();

// About what they take, measured with the built-in character; only their ratios count.
std::vector<double> step_weights(const ReliefTierOptions& options) {
  const bool bends = options.bend > 0;
  const double texels = options.maps.map_size / 128.0;
  std::vector<double> weights{options.capture == "best" ? 2.0 : 0.0, bends ? 16.0 : 0.0, 8.0 + 5.0 * texels * texels};
  for (size_t tier = 0; tier < kTiers.size(); ++tier) {
    weights.push_back(options.merge > 0 && bends ? 1.5 : 0.0);
    weights.push_back(options.merge > 0 ? 1.0 : 0.0);
  }
  weights.push_back(options.cones ? 3.0 * texels * texels : 0.0);
  return weights;
}

// Models of fewer boxes for smaller pictures. `nearest`: how the nearest tier was baked.
void add_tiers(const scene::Character& character, const scene::PoseBank& bank, const ReliefTierOptions& options,
               const ReliefBakeOptions& nearest, ReliefTiers& bake, BakeSteps& steps) {
  ReliefBakeOptions what = nearest;
  what.pieces.clear();
  what.longest = 0;
  // Skin that hardly leaves rigid boxes has these, which take fewer steps of the search, where it is small.
  const bool bends = options.bend > 0 && (options.capture != "best" || bake.capture.silhouette_error > kStiff);
  JointMerger merger(character, bank, what.capture);
  what.by_area = true;
  for (size_t tier = 0; tier < kTiers.size(); ++tier) {
    const double pixel = relief_height(character) / kTiers[tier].pixels;  // metres
    what.carriers = merger.merged(options.merge * pixel);
    what.texel = std::max(nearest.texel, kTiers[tier].texel * pixel);
    if (bends) {
      const CellOptions cells{.tolerance = kFarBend * pixel,
                              .skirt = kSkirt * what.texel,
                              .texel = kCutTexel * what.texel,
                              .most = static_cast<size_t>(options.cells)};
      what.pieces =
          skin_cells(character, bank, what.capture, what.carriers, cells, steps.of(kTierSteps + 2 * tier)).pieces;
      const bool cut = std::any_of(what.pieces.begin(), what.pieces.end(), [](const Piece& p) { return p.texel > 0; });
      // Fewer cells are off by too much of a figure of this size.
      if (cut && kTiers[tier].pixels > kWholePixels) continue;
      // What stands beside cut skin is searched as that is, and needs its texels.
      if (cut) what.texel = cells.texel;
    }
    // Joints that were given texels have half of them, 64 at least.
    for (size_t joint = 0; joint < what.texels_of_joint.size(); ++joint) {
      const int given = nearest.texels_of_joint[joint];
      what.texels_of_joint[joint] = std::min(given, std::max(64, given >> (tier + 1)));
    }
    ReliefModel model = bake_relief(character, what, steps.of(kTierSteps + 2 * tier + 1));
    const auto boxes = static_cast<double>(bake.models.back().boxes.size());
    if (static_cast<double>(model.boxes.size()) < (bends ? kFewer : 1.0) * boxes) {
      bake.tier_pixels.push_back(kTiers[tier].pixels);
      bake.models.push_back(std::move(model));
    }
  }
}

void add_cones(ReliefTiers& bake, BakeSteps& steps) {
  for (const ReliefModel& model : bake.models) {
    const AtlasPlan plan = plan_atlas(model);
    bake.cones.push_back(derive_cones(model, plan, fill_atlas(model, plan), steps.of(kConeStep)));
  }
}

// Makes do with texels so many times as coarse for cut skin; false where there is none.
bool coarsen(std::vector<Piece>& pieces, double times) {
  bool any = false;
  for (Piece& piece : pieces) {
    piece.texel *= times;
    any = any || (piece.texel > 0 && piece.texel < 1e3);
  }
  return any;
}

// smallest: the model of the coarsest texels that there are.
[[noreturn]] void refuse_budget(const scene::Character& character, const ReliefTierOptions& options,
                                const ReliefModel& smallest) {
  constexpr double kMiB = 1 << 20;
  throw Error("relief: budget",
              fmt::format("{} does not fit in {:.3g} MiB", character.name, static_cast<double>(options.budget) / kMiB),
              fmt::format("budget={:.2f} would fit",
                          std::ceil(100 * static_cast<double>(atlas_bytes(smallest, options)) / kMiB) / 100));
}

}  // namespace

void check_capture(const std::string& value, const std::string& where) { (void)split_capture(value, where); }

void check_resolution(const std::string& value, const std::string& where) {
  if (value != "none") (void)split_resolution(value, where);
}

double number_of(const char* begin, const char* end, const std::string& where, const std::string& text, double low,
                 double high, const char* advice) {
  double value = 0;
  const auto [last, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || last != end || !(value >= low && value < high))
    throw Error(where, fmt::format("\"{}\" is not understood", printable(text)), advice);
  return value;
}

double relief_height(const scene::Character& character) {
  return character.placement.height > 0 ? character.placement.height : 1.75;
}

void require_room(const scene::Character& character, size_t texels, const ReliefTierOptions& options,
                  const ReliefAllowance& allowance) {
  const uint64_t bytes = maps_bytes(texels, emission_peak(character), options);
  if (options.budget > 0 || bytes <= allowance.left) return;
  constexpr int kLeastMap = 32;     // that the option takes
  constexpr double kShrinks = 0.3;  // by half the texels a side: gutters do not
  int map = options.maps.map_size;
  auto smaller = static_cast<double>(bytes);
  for (; smaller > static_cast<double>(allowance.left) && map > kLeastMap; map /= 2) smaller *= kShrinks;
  const bool fits = smaller <= static_cast<double>(allowance.left);
  const uint64_t whole = allowance.left >> 20;  // MiB, as the option takes them
  throw Error("relief",
              fmt::format("the maps of {} need {} MiB, more than the {} MiB left of the bake budget", character.name,
                          bytes >> 20, allowance.left >> 20),
              budget_advice(fits ? fmt::format("map={}", map) : "",
                            fits ? fmt::format("lower map or its other sizes{}",
                                               whole > 0 ? fmt::format(", give it budget={}", whole) : "")
                                 : fmt::format("map={} would need about {} MiB still: use fewer characters", kLeastMap,
                                               static_cast<uint64_t>(std::ceil(smaller / (1 << 20)))),
                            bytes, allowance.left));
}

uint64_t depth_texel_bytes(const ReliefTierOptions& options) {
  return static_cast<uint64_t>(options.depth_bits) / 4 * (options.maps.cube ? 2 : 1) + (options.cones ? 4 : 0);
}

uint64_t colour_texel_bytes(float emission_peak) { return 2 * 4 * (emission_peak > 0 ? 3 : 2); }

std::string relief_key(const scene::Character& character, const scene::PoseBank& bank, const ReliefTierOptions& options,
                       const ReliefAllowance& allowance) {
  Sha256 hash;
  hash.text("relief").value(kBakeVersion).text(character.content_hash).text(options.capture);
  hash.value(options.maps.map_size).value(options.maps.rule).value(options.maps.threshold).value(options.maps.by_area);
  hash.value(options.merge).value(options.budget).value(options.cones).value(options.maps.cube);
  hash.text(options.resolution)
      .value(options.bend)
      .value(options.cells)
      .value(options.part)
      .value(options.part_auto ? allowance.share : uint64_t{0});
  // Which poses were measured.
  if (options.capture == "best" || options.merge > 0 || options.bend > 0)
    for (const scene::Mat3x4& m : bank.matrices()) hash.bytes(&m, sizeof m);
  return hash.hex();
}

std::vector<uint8_t> serialise(const ReliefTiers& bake) {
  ByteWriter out;
  const CaptureScore& c = bake.capture;
  out.value(c.pose.clip);
  for (const double v : {c.pose.phase, c.silhouette_error, c.box_volume, bake.deviation, bake.loose}) out.value(v);
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
    out.value(m.patches);
    out.value(m.cube);
    if (m.emission_peak > 0) out.values(m.emission);
  }
  for (const std::vector<uint8_t>& cones : bake.cones) out.values(cones);
  return out.bytes();
}

std::optional<ReliefTiers> deserialise_tiers(const std::vector<uint8_t>& bytes, size_t joints, bool cones) {
  ByteReader in(bytes);
  ReliefTiers bake;
  CaptureScore& c = bake.capture;
  c.pose.clip = in.value<int>();
  for (double* v : {&c.pose.phase, &c.silhouette_error, &c.box_volume, &bake.deviation, &bake.loose})
    *v = in.value<double>();
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
    m.patches = in.value<bool>();
    m.cube = in.value<bool>();
    if (m.emission_peak > 0) m.emission = in.values<uint8_t>();
    size_t texels = 0;
    for (const ReliefBox& box : m.boxes) {
      if (box.texels < 16 || box.texels > 256 || box.first != texels) return std::nullopt;
      for (const ReliefBox::Mover& mover : box.movers)
        if (mover.joint < 0 || static_cast<size_t>(mover.joint) >= joints) return std::nullopt;
      texels += ReliefModel::box_texels(box);
    }
    if (m.boxes.empty() || m.triangles_of_box.size() != m.boxes.size() ||
        m.depth.size() != texels * 2 * m.depth_maps() || m.extent.size() != (m.cube ? 0 : texels * 6) ||
        m.colour.size() != (texels + m.coarse_texels()) * 24 || m.normal.size() != texels * 24 ||
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

ReliefTiers bake_tiers(const scene::Character& character, const scene::PoseBank& bank, const ReliefTierOptions& options,
                       const ReliefAllowance& allowance, const BakeProgress& progress) {
  BakeSteps steps(progress, step_weights(options));
  ReliefTiers bake;
  ReliefBakeOptions what = options.maps;
  if (options.capture == "best")
    bake.capture = choose_capture(score_captures(character, bank, what.rule, what.threshold, steps.of(kCaptureStep)));
  else
    bake.capture.pose = parse_capture(options.capture, character);
  what.capture = bake.capture.pose;
  what.texels_of_joint = parse_resolution(options.resolution, character);
  const double height = relief_height(character);
  // Boxes in fewer parts, where the maps would take more than a character's share of the bake budget.
  what.longest = options.part * height;
  if (options.bend > 0) {
    // Texels of the longest box that there is.
    const double texel = kCutTexel * (options.part > 0 ? options.part : 1.0) * height / what.map_size;
    Cells cells = skin_cells(character, bank, what.capture, own_carriers(character),
                             {.tolerance = options.bend * height / kBendPixels,
                              .skirt = kSkirt / kCutTexel * texel,
                              .texel = texel,
                              .most = static_cast<size_t>(options.cells)},
                             steps.of(kCellStep));
    bake.deviation = cells.deviation;
    bake.loose = cells.loose;
    const double most = kMore * static_cast<double>(relief_texels(character, what));
    what.pieces = std::move(cells.pieces);
    while (static_cast<double>(relief_texels(character, what)) > most && coarsen(what.pieces, 1.1)) continue;
  }
  size_t texels = relief_texels(character, what);
  while (options.part_auto && what.longest > 0 &&
         maps_bytes(texels, emission_peak(character), options) > allowance.share) {
    what.longest = what.longest < height ? 1.25 * what.longest : 0;
    texels = relief_texels(character, what);
  }
  require_room(character, texels, options, allowance);
  bake.models.push_back(bake_relief(character, what, steps.of(kMapStep)));
  // Under a budget the texels grow until the maps fit.
  while (options.budget > 0 && atlas_bytes(bake.models[0], options) > options.budget) {
    if (what.by_area && what.texels_of_joint.empty()) {
      double texel = 0;
      for (const ReliefBox& box : bake.models[0].boxes)
        texel = std::max(texel, std::max({box.size.x, box.size.y, box.size.z}) / box.texels);
      what.texel = std::max(what.texel, texel) * 1.25;
    } else {
      what.map_size /= 2;
      coarsen(what.pieces, 2);
      for (int& side : what.texels_of_joint)
        if (side > 0) side = std::max(16, side / 2);
    }
    if (what.map_size < 16 || what.texel > 1e3) refuse_budget(character, options, bake.models[0]);
    bake.models[0] = bake_relief(character, what, steps.of(kMapStep));
  }
  if (options.merge > 0) add_tiers(character, bank, options, what, bake, steps);
  if (options.cones) add_cones(bake, steps);
  steps.end();
  return bake;
}

}  // namespace crowdbench::renderers
