// What flat's C++ and GLSL share.
#ifndef CROWDBENCH_FLAT_SHARED_H
#define CROWDBENCH_FLAT_SHARED_H

#define CB_FLAT_CLIPS 256      // of one character's bank, at most
#define CB_FLAT_LAYER_BITS 12  // of a level's textures, at most

#define CB_FLAT_TEXTURE_ALBEDO 0
#define CB_FLAT_TEXTURE_SURFACE 1   // of compressed tiles: the normals
#define CB_FLAT_TEXTURE_SLOTS 2     // of compressed tiles
#define CB_FLAT_TEXTURE_DEPTH 3     // of compressed tiles drawn with depth=nailboard or parallax
#define CB_FLAT_TEXTURE_EMISSION 4  // of characters that glow
#define CB_FLAT_TEXTURE_MOTION 5    // of bakes with motion

#endif
