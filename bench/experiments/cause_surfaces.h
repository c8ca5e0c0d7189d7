// What error by cause asks to be drawn: surfaces pixel by pixel, and a figure as a stored view has it.
#pragma once
#include <functional>
#include <vector>

#include "metrics/surface_causes.h"
#include "renderers/frame/capture.h"
#include "renderers/gl/context.h"
#include "renderers/impostor/views/view_sampling.h"
#include "renderers/representation.h"

namespace crowdbench::bench {

// Who draws.
struct Drawer {
  gl::Context& context;
  const scene::Cast& cast;
  renderers::Renderer& renderer;
  renderers::Representation& representation;
};

// The frame, and what its surfaces are made of: every representation is lit by one formula
// (renderers/shaders/shading.glsl), so that pictures under no light, ambient light alone and directed light alone say
// base colour, light given off and the cosine. samples: odd k; drawn as the frame of a picture k times as wide and
// high, of which every pixel shows the middle one of k x k: what is chosen by size is chosen for that size.
metrics::Surfaces draw_surfaces(const Drawer& drawer, const scene::Frame& frame, int samples = 1);

// The figures of a frame as stored views have them.
struct StoredViews {
  metrics::Surfaces surfaces;
  // By agent that a stored view shows, in the order of the frame: the pixels that it covers, ascending, hidden ones
  // too.
  std::vector<std::pair<uint32_t, std::vector<size_t>>> covered;
};
// How the views of who draws an agent are sampled; nullptr: who draws it stores none. index: in
// frame.agents[character].
using ViewsOfAgent = std::function<const renderers::ViewSampling*(size_t character, size_t index)>;
// Each figure is drawn by `drawer` from the direction of the view that stands for how the frame's eye sees it, by
// parallel rays (a lens of a long focal length), finer than the frame, and laid on the plane that the view's picture
// would lie on; who is in front is decided by the surfaces that it shows. A mirrored view is drawn from the mirrored
// direction. An agent without views is drawn as the mesh is.
StoredViews draw_stored_views(const Drawer& drawer, const scene::Frame& frame, const ViewsOfAgent& views);

}  // namespace crowdbench::bench
