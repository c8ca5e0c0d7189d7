// Based on: N. Coic, C. Loscos and A. Meyer, "Three LOD for the realistic and real-time rendering of crowds with
// dynamic lighting" (2007), whose middle level are layered impostors. Differs from the source: README.md.
#include "renderers/layered/layered.h"

#include "renderers/flat/flat.h"
#include "renderers/impostor/views/view_options.h"

namespace crowdbench::renderers {
namespace {

FlatBakeOptions bake_options(const Spec& spec) {
  const OptionReader reader(layered_type, spec);
  FlatBakeOptions options;
  options.drawn_by = layered_type.name;
  options.grid = read_view_grid(reader);
  options.frames = read_frame_count(reader);
  options.texels = static_cast<int>(reader.integer("texels", 16, 1024));
  return options;
}

}  // namespace

const RepresentationType layered_type = {
    .name = "layered",
    .summary = "layered impostors: each tile as parallel layers, one for each interval of its stored depths",
    .options = {views_option(),
                el_min_option(),
                frames_option("stored frames a clip"),
                fps_option(),
                {"texels", "16..1024", "128", "texels across the captured width"},
                {"slices", "1..32", "8", "layers of figures of the finest level; half as many of each coarser one"},
                {"overlap", "0..4", "0.5", "share of an interval that a layer shows of each neighbour's"}},
    .make = [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      const OptionReader reader(layered_type, spec);
      FlatSlices slices;
      slices.most = static_cast<int>(reader.integer("slices", 1, 32));
      slices.overlap = reader.number("overlap", 0, 4);
      slices.floor = reader.flag("floor");
      MakeContext whole = context;
      whole.required_by = {};
      return make_flat_slices(whole, bake_options(spec), slices);
    },
    .view_sampling = [](const Spec& spec, const scene::Character& character,
                        const std::shared_ptr<const scene::PoseBank>& bank) -> ViewSampling {
      return forecast_flat(character, bank, bake_options(spec)).sampling;
    },
    .floor = "the same layers and fetches without lighting",
    .suits = {.new_clips = "no: every clip is baked",
              .close_by = "layers part, and what lies between them is missing",
              .from_above = "the nearest of the stored views",
              .shadows = "at the depth of its layers; light is that of stored normals"},
};

}  // namespace crowdbench::renderers
