#include "renderers/mesh/mesh_level.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "core/error.h"
#include "core/hash.h"

namespace crowdbench::renderers {
namespace {

// Raised whenever a level comes out otherwise than before, or is stored otherwise.
constexpr int kLevelVersion = 2;

size_t triangles_of(const scene::Mesh& mesh) { return mesh.indices.size() / 3; }

// What is stored of a level: of a simplified mesh its triangles, as its vertices are the character's own.
struct LevelBake {
  uint64_t vertices = 0;               // of the mesh that the indices are of
  std::vector<uint32_t> indices;       // none of a level that the file holds
  std::vector<uint32_t> index_counts;  // by primitive
  LevelInfo info;                      // all but what the character says itself
  static uint64_t texture_bytes() { return 0; }
};

void write_error(ByteWriter& out, const scene::LodError& error) {
  for (const double v : {error.max, error.rms, error.phase}) out.value(v);
  for (const uint64_t v : {uint64_t(error.bank_clip), uint64_t{error.poses}, uint64_t{error.places}}) out.value(v);
}

scene::LodError read_error(ByteReader& in) {
  scene::LodError error;
  for (double* v : {&error.max, &error.rms, &error.phase}) *v = in.value<double>();
  error.bank_clip = static_cast<int>(in.value<uint64_t>());
  for (size_t* v : {&error.poses, &error.places}) *v = in.value<uint64_t>();
  return error;
}

std::vector<uint8_t> serialise(const LevelBake& bake) {
  ByteWriter out;
  out.value(bake.vertices);
  out.values(bake.indices);
  out.values(bake.index_counts);
  out.values(std::vector<char>(bake.info.note.begin(), bake.info.note.end()));
  write_error(out, bake.info.error);
  out.value(static_cast<uint8_t>(bake.info.meshoptimizer ? 1 : 0));
  if (bake.info.meshoptimizer) {
    out.value(bake.info.meshoptimizer->triangles);
    out.value(bake.info.meshoptimizer->stated);
    write_error(out, bake.info.meshoptimizer->error);
  }
  return out.bytes();
}

// std::nullopt also where it is of another mesh than this one.
std::optional<LevelBake> deserialise_level(std::span<const uint8_t> bytes, const scene::Mesh& mesh,
                                           const scene::PoseBank& bank) {
  ByteReader in(bytes);
  LevelBake bake;
  bake.vertices = in.value<uint64_t>();
  bake.indices = in.values<uint32_t>();
  bake.index_counts = in.values<uint32_t>();
  const auto note = in.values<char>();
  bake.info.note.assign(note.begin(), note.end());
  bake.info.error = read_error(in);
  if (in.value<uint8_t>() != 0) {
    LevelInfo::Other other;
    other.triangles = in.value<uint64_t>();
    other.stated = in.value<double>();
    other.error = read_error(in);
    bake.info.meshoptimizer = other;
  }
  if (!in.ok() || !in.at_end() || bake.vertices != mesh.positions.size()) return std::nullopt;
  const auto clip = static_cast<size_t>(bake.info.error.bank_clip);
  if (clip >= bank.clips().size()) return std::nullopt;
  if (bake.indices.empty() && bake.index_counts.empty()) return bake;
  // What the GPU will follow must lead nowhere else.
  const auto sum = std::accumulate(bake.index_counts.begin(), bake.index_counts.end(), uint64_t{0});
  const bool sound = bake.index_counts.size() == mesh.primitives.size() && sum == bake.indices.size() &&
                     std::ranges::all_of(bake.index_counts, [](uint32_t count) { return count % 3 == 0; }) &&
                     std::ranges::all_of(bake.indices, [&](uint32_t i) { return i < mesh.positions.size(); });
  return sound ? std::optional(std::move(bake)) : std::nullopt;
}

void require_level(const scene::Character& character, size_t lod) {
  const size_t levels = character.levels.size();
  if (lod > levels)
    throw Error("representation 'mesh'",
                fmt::format("option lod={}, but {} has {}", lod, printable(character.name),
                            levels == 0 ? "no levels of its own" : fmt::format("levels 0 to {}", levels)),
                "triangles=N simplifies its mesh");
}

LevelBake bake_level(const scene::Character& character, const scene::PoseBank& bank, const MeshLevelOptions& options,
                     const BakeProgress& progress) {
  LevelBake bake;
  if (options.lod > 0) {
    const scene::Mesh& own = character.levels[options.lod - 1];
    bake.vertices = own.positions.size();
    bake.info.error = scene::lod_error(character, own, bank);
    return bake;
  }
  scene::LodMesh made = scene::make_lod_mesh(character, bank, options.request, progress);
  bake.vertices = made.mesh.positions.size();
  bake.info.error = scene::lod_error(character, made.mesh, bank);
  if (!made.why_more.empty())
    bake.info.note =
        fmt::format("{}: {} triangles and no fewer: {}", character.name, triangles_of(made.mesh), made.why_more);
  const auto alone = scene::meshoptimizer_mesh(character, bank, triangles_of(made.mesh));
  bake.info.meshoptimizer =
      LevelInfo::Other{triangles_of(alone.mesh), alone.stated_error, scene::lod_error(character, alone.mesh, bank)};
  for (const scene::Primitive& p : made.mesh.primitives) bake.index_counts.push_back(p.index_count);
  bake.indices = std::move(made.mesh.indices);
  return bake;
}

// The stored triangles, of the character's vertices.
scene::Mesh mesh_of(const scene::Character& character, LevelBake& bake, const MeshLevelOptions& options) {
  if (options.lod > 0) return character.levels[options.lod - 1];
  scene::Mesh mesh = character.mesh;
  mesh.indices = std::move(bake.indices);
  uint32_t first = 0;
  for (size_t p = 0; p < mesh.primitives.size(); ++p) {
    mesh.primitives[p].first_index = first;
    first += mesh.primitives[p].index_count = bake.index_counts[p];
  }
  return mesh;
}

LevelMesh level_of(const scene::Character& character, const scene::PoseBank& bank, LevelBake bake,
                   const MeshLevelOptions& options) {
  LevelMesh level;
  level.mesh = mesh_of(character, bake, options);
  level.info = std::move(bake.info);
  level.info.character = character.name;
  level.info.triangles = triangles_of(level.mesh);
  level.info.of_triangles = character.triangles();
  level.info.height = character.placement.height;
  const int clip = bank.clips()[static_cast<size_t>(level.info.error.bank_clip)].clip;
  level.info.worst_clip = clip < 0 ? "the bind pose" : character.clips[static_cast<size_t>(clip)].name;
  return level;
}

void hash_places(Sha256& hash, const scene::Mesh& mesh) {
  const auto vectors = [&](const auto& v) { hash.value(v.size()).bytes(v.data(), v.size() * sizeof(v[0])); };
  vectors(mesh.positions);
  vectors(mesh.joints);
  vectors(mesh.weights);
  hash.values(mesh.indices);
}

}  // namespace

MeshLevels load_mesh_levels(const std::vector<std::shared_ptr<const scene::Character>>& characters,
                            const std::vector<std::shared_ptr<const scene::PoseBank>>& banks,
                            const MeshLevelOptions& options, const BakePolicy& policy) {
  BakeLoader loader(policy, {"mesh-level", "a level of detail", "textures", "use fewer characters"});
  MeshLevels out;
  for (size_t c = 0; c < characters.size(); ++c) {
    const scene::Character& character = *characters[c];
    const scene::PoseBank& bank = *banks[c];
    require_level(character, options.lod);
    const scene::Mesh& mesh = options.lod > 0 ? character.levels[options.lod - 1] : character.mesh;
    auto bake = loader.load<LevelBake>(
        character.name, mesh_level_key(character, bank, options),
        [&](std::span<const uint8_t> bytes) { return deserialise_level(bytes, mesh, bank); },
        [&](uint64_t, const BakeProgress& progress) { return bake_level(character, bank, options, progress); });
    out.levels.push_back(level_of(character, bank, std::move(bake), options));
  }
  out.records = loader.records();
  return out;
}

std::string mesh_level_key(const scene::Character& character, const scene::PoseBank& bank,
                           const MeshLevelOptions& options) {
  Sha256 hash;
  hash.text("mesh level").value(kLevelVersion).text(character.content_hash);
  hash.value(uint64_t{options.request.triangles}).value(options.request.ratio).value(options.request.error);
  hash.value(uint64_t{options.lod});
  // A character's hash is of its mesh alone.
  if (options.lod > 0) hash_places(hash, character.levels[options.lod - 1]);
  hash.value(bank.clips().size());
  for (const scene::BankClip& clip : bank.clips()) hash.value(clip.samples);
  hash.value(bank.matrices().size()).bytes(bank.matrices().data(), bank.matrices().size() * sizeof(scene::Mat3x4));
  return hash.hex();
}

BakeInfo bake_info_of(const MeshLevels& levels) {
  constexpr double kMillimetres = 1000;
  constexpr double kFigure = 100;  // pixels
  BakeInfo info = bake_info_of(std::span<const BakeRecord>(levels.records));
  LevelInfo sum;  // of triangles; of errors the largest
  LevelInfo::Other other;
  double pixels = 0;
  bool simplified = false;
  const auto raise = [](scene::LodError& most, const scene::LodError& one) {
    most.max = std::max(most.max, one.max);
    most.rms = std::max(most.rms, one.rms);
  };
  for (const LevelMesh& level : levels.levels) {
    const LevelInfo& one = level.info;
    sum.triangles += one.triangles;
    sum.of_triangles += one.of_triangles;
    raise(sum.error, one.error);
    pixels = std::max(pixels, one.pixels(kFigure));
    if (!one.note.empty()) info.notes.push_back(one.note);
    info.levels.push_back(one);
    if (!one.meshoptimizer) continue;
    simplified = true;
    other.triangles += one.meshoptimizer->triangles;
    other.stated = std::max(other.stated, one.meshoptimizer->stated);
    raise(other.error, one.meshoptimizer->error);
  }
  info.facts = {{"triangles", static_cast<double>(sum.triangles)},
                {"of_triangles", static_cast<double>(sum.of_triangles)},
                {"error_max_mm", sum.error.max * kMillimetres},
                {"error_rms_mm", sum.error.rms * kMillimetres},
                {"error_max_px_at_100_px", pixels}};
  if (simplified)
    info.facts.insert(info.facts.end(), {{"meshoptimizer_triangles", static_cast<double>(other.triangles)},
                                         {"meshoptimizer_stated_mm", other.stated * kMillimetres},
                                         {"meshoptimizer_max_mm", other.error.max * kMillimetres},
                                         {"meshoptimizer_rms_mm", other.error.rms * kMillimetres}});
  return info;
}

}  // namespace crowdbench::renderers
