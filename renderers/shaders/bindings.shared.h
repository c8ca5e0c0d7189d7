// Names of every binding, attribute and uniform that C++ and GLSL share; both include this file.
#ifndef CROWDBENCH_BINDINGS_SHARED_H
#define CROWDBENCH_BINDINGS_SHARED_H

// Uniform blocks.
#define CB_UNIFORM_FRAME 0   // FrameUniforms (frame.glsl, frame_resources.h)
#define CB_UNIFORM_DITHER 1  // vec4: least and first excluded threshold of a dithered pass (output.glsl)
#define CB_UNIFORM_TABLE 2   // of what is being drawn, a representation's own (flat)

// Shader storage blocks 0 to 7 are common, 8 and above belong to a representation.
#define CB_STORAGE_AGENTS 0     // AgentRecord[]: all agents of the frame, character after character
#define CB_STORAGE_LIST 2       // uint[]: positions in AGENTS of the agents to draw
#define CB_STORAGE_PALETTE 3    // vec4[]: posed joints of the listed agents, three rows a joint, list-major
#define CB_STORAGE_POSE_BANK 4  // vec4[]: one character's bank, three rows a joint, sample-major
#define CB_STORAGE_SKINNED 5    // uvec4[]: skinned vertices, slot-major (renderers/mesh/skinned_buffer.h)
#define CB_STORAGE_CAPTURE 9    // CaptureView[]: one orthographic view an agent, for bakes

// Texture units.
#define CB_TEXTURE_BASE_COLOUR 0
#define CB_TEXTURE_EMISSIVE 1
#define CB_TEXTURE_MATERIALS 2  // texels of the character being drawn (mesh)
#define CB_TEXTURE_REST 3       // vertices of the character being skinned into a buffer (skin.comp)
#define CB_TEXTURE_SKINNED 4    // what that wrote
#define CB_TEXTURE_BLENDS 5     // of each instance: two slots of that, 16 bits each, and the blend (mesh.vert)
#define CB_TEXTURE_TILE_ROWS 6  // of each instance: the rows of the matrix to its tile (mesh.vert)
#define CB_TEXTURE_TILES 9      // tiles of the character being drawn: where they lie (flat)
#define CB_TEXTURE_OUTLINES 10  // corners of the tiles' outlines (flat)
#define CB_TEXTURE_VIEWS 11     // the planes of a view grid (flat)
// Buffers as texels: where many lanes read different places, llvmpipe fetches a texel several times faster than a
// storage block's element, and GPUs do not mind.
#define CB_TEXTURE_AGENTS 13   // AGENTS, four RGBA32F texels an agent
#define CB_TEXTURE_OUTFITS 14  // kOutfitSlots RGBA32F texels an outfit
#define CB_TEXTURE_PALETTE 15  // PALETTE, three RGBA32F texels a joint

// Uniform locations.
#define CB_LOCATION_FIRST 0     // uint: position in LIST (and in PALETTE) of the first instance
#define CB_LOCATION_JOINTS 1    // uint: joints of the character
#define CB_LOCATION_COUNT 2     // uint: agents to pose
#define CB_LOCATION_VERTICES 3  // uint: vertices of the character's mesh
#define CB_LOCATION_SLOT 4      // uint: slot of skinned vertices that the first instance reads
#define CB_LOCATION_RADIUS 5    // float: metres that a surfel's disc reaches
#define CB_LOCATION_SAMPLES 6   // float: samples of the target along a pixel of the picture
#define CB_LOCATION_OVERLAP 7   // float: share of a slice's depth that it shows of each neighbour's
#define CB_LOCATION_REACH 8     // float: factor of how far a surfel's surface goes on
#define CB_LOCATION_THIN 9      // float: factor of discs in figures of few pixels
#define CB_LOCATION_TALL 10     // float: metres, a character's longest side

// Vertex attributes of the mesh.
#define CB_ATTRIBUTE_POSITION 0  // vec3 position, w = the material's index
#define CB_ATTRIBUTE_NORMAL 1
#define CB_ATTRIBUTE_UV 2
#define CB_ATTRIBUTE_JOINTS 3
#define CB_ATTRIBUTE_WEIGHTS 4
#define CB_ATTRIBUTE_COLOUR 5
#define CB_ATTRIBUTE_EMISSIVE_UV 6
#define CB_ATTRIBUTE_AGENT 7  // uint, one an instance: the agent's position in AGENTS, from LIST

// Body parts that an outfit colours (scene::kOutfitSlots).
#define CB_OUTFIT_SLOTS 16

// Flags of a material (mesh.frag).
#define CB_MATERIAL_UNLIT 1u
#define CB_MATERIAL_TEXTURE 2u
#define CB_MATERIAL_EMISSIVE_TEXTURE 4u

#define CB_MATERIAL_TEXELS 3  // of a material in CB_TEXTURE_MATERIALS

#endif
