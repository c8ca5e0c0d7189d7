#include "renderers/mesh/mesh_level.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"

namespace crowdbench::renderers {
namespace {

size_t triangles_of(const scene::Mesh& mesh) { return mesh.indices.size() / 3; }

}  // namespace

MeshLevel make_mesh_level(const std::shared_ptr<const scene::Character>& character,
                          const std::shared_ptr<const scene::PoseBank>& bank, const MeshLevelOptions& options) {
  if (options.lod == 0) {
    scene::LodMesh made = scene::make_lod_mesh(*character, *bank, options.request);
    std::string note;
    if (!made.why_more.empty())
      note = fmt::format("{}: {} triangles and no fewer: {}", character->name, triangles_of(made.mesh), made.why_more);
    return {character, bank, std::move(made.mesh), true, std::move(note)};
  }
  const size_t levels = character->levels.size();
  if (options.lod > levels)
    throw Error("representation 'mesh'",
                fmt::format("option lod={}, but {} has {}", options.lod, printable(character->name),
                            levels == 0 ? "no levels of its own" : fmt::format("levels 0 to {}", levels)),
                "triangles=N simplifies its mesh");
  return {character, bank, character->levels[options.lod - 1], false, {}};
}

BakeInfo bake_info_of(const std::vector<MeshLevel>& levels) {
  constexpr double kMillimetres = 1000;
  constexpr double kFigure = 100;  // pixels
  BakeInfo info;
  double triangles = 0;
  double whole = 0;
  double tries = 0;  // meshoptimizer's triangles
  double stated = 0;
  double pixels = 0;
  bool simplified = false;
  scene::SurfaceDistance worst;
  scene::SurfaceDistance other;
  const auto raise = [](scene::SurfaceDistance& most, const scene::SurfaceDistance& one) {
    most = {std::max(most.max, one.max), std::max(most.rms, one.rms)};
  };
  for (const MeshLevel& level : levels) {
    const scene::LodError error = scene::lod_error(*level.character, level.mesh, *level.bank);
    raise(worst, error.distance);
    triangles += static_cast<double>(triangles_of(level.mesh));
    whole += static_cast<double>(level.character->triangles());
    if (const double height = level.character->placement.height; height > 0)
      pixels = std::max(pixels, error.distance.max / height * kFigure);
    if (!level.note.empty()) info.notes.push_back(level.note);
    if (!level.simplified) continue;
    simplified = true;
    const auto alone = scene::meshoptimizer_mesh(*level.character, *level.bank, triangles_of(level.mesh));
    raise(other, scene::lod_error(*level.character, alone.mesh, *level.bank).distance);
    tries += static_cast<double>(triangles_of(alone.mesh));
    stated = std::max(stated, alone.stated_error);
  }
  info.facts = {{"triangles", triangles},
                {"of_triangles", whole},
                {"error_max_mm", worst.max * kMillimetres},
                {"error_rms_mm", worst.rms * kMillimetres},
                {"error_max_px_at_100_px", pixels}};
  if (simplified)
    info.facts.insert(info.facts.end(), {{"meshoptimizer_triangles", tries},
                                         {"meshoptimizer_stated_mm", stated * kMillimetres},
                                         {"meshoptimizer_max_mm", other.max * kMillimetres},
                                         {"meshoptimizer_rms_mm", other.rms * kMillimetres}});
  return info;
}

}  // namespace crowdbench::renderers
