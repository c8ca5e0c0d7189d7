// What the relief's C++ and GLSL agree on.
#ifndef CROWDBENCH_RELIEF_SHARED_H
#define CROWDBENCH_RELIEF_SHARED_H

#define RELIEF_STORAGE_BOXES 9    // BoxRecord[]: one a box of the character
#define RELIEF_STORAGE_POSED 10   // PosedBox[]: list position x box
#define RELIEF_STORAGE_POINTS 11  // vec4[]: RELIEF_HULL_POINTS corners of each box's hull, unit coordinates

#define RELIEF_HULL_POINTS 16  // an eight-sided prism along the box's longest edge

#define RELIEF_SHARES 8  // joints that move a box, at most

#define RELIEF_TEXTURE_DEPTH 0
#define RELIEF_TEXTURE_COLOUR 1
#define RELIEF_TEXTURE_NORMAL 2
#define RELIEF_TEXTURE_BOUNDS 3
#define RELIEF_TEXTURE_CONES 4
#define RELIEF_TEXTURE_EMISSION 5  // of characters that glow

#define RELIEF_LOCATION_COUNT 1   // uint: agents to pose
#define RELIEF_LOCATION_OFFSET 2  // uint: position in PALETTE of the first agent to pose
#define RELIEF_LOCATION_FIRST 0   // uint: position in LIST of the first instance
#define RELIEF_LOCATION_PEAK 3    // float: of the light given off

// How many levels finer than one texel a pixel colours are read: as the levels' textures are filtered for; and nearby,
// of a character without textures, which has nothing to filter.
#define RELIEF_FINER 1
#define RELIEF_FINER_PLAIN 3

// Search methods.
#define RELIEF_SEARCH_ADAPTIVE 0  // one step a texel crossed, each tested as an interval
#define RELIEF_SEARCH_LINEAR 1    // fixed steps, then binary refinement: the source's
#define RELIEF_SEARCH_CONE 2      // adaptive, passing over steps that the texel's cones show to be air

// Debug views.
#define RELIEF_DEBUG_BOXES 1
#define RELIEF_DEBUG_STEPS 2
#define RELIEF_DEBUG_HIT_FACE 3
#define RELIEF_DEBUG_MISSES 4

#endif
