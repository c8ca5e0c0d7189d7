// The reference representation: the skinned mesh itself. See README.md in this folder.
#pragma once
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType mesh_type;

// The same mesh, the same culling and materials, drawn for bakes: agent i of the frame goes through orthographic view i
// of CB_STORAGE_CAPTURE, and the colour targets receive what renderers/impostor/tiles/capture.glsl says instead of a
// picture. peak: of the light given off (renderers/bake/emission.h); above 0 there is a third target.
std::unique_ptr<Representation> make_mesh_capture(const MakeContext& make, float peak);

}  // namespace crowdbench::renderers
