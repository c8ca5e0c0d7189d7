// What polypostor's C++ and GLSL share.
#ifndef CROWDBENCH_POLYPOSTOR_SHARED_H
#define CROWDBENCH_POLYPOSTOR_SHARED_H

#define CB_POLYPOSTOR_CLIPS 256  // of one character's bank, at most
#define CB_POLYPOSTOR_LEVELS 12
#define CB_POLYPOSTOR_GROUP 64

// From one step between poses to the next some parts may show another image. Over this share of each step, before its
// end and after its beginning, the images of both share the pixels by ordered dither, half each at the pose between.
#define CB_POLYPOSTOR_FADE 0.25

#define CB_POLYPOSTOR_STORAGE_TABLE 10
#define CB_POLYPOSTOR_STORAGE_SETS 11      // PolypostorSet[]
#define CB_POLYPOSTOR_STORAGE_RANGES 12    // PolypostorRange[]
#define CB_POLYPOSTOR_STORAGE_FIGURES 13   // Figure[], one an agent drawn
#define CB_POLYPOSTOR_STORAGE_COMMANDS 14  // uint[5], one an agent drawn

#define CB_POLYPOSTOR_TEXTURE_ALBEDO 0
#define CB_POLYPOSTOR_TEXTURE_NORMALS 1
#define CB_POLYPOSTOR_TEXTURE_MATERIALS 2
#define CB_POLYPOSTOR_TEXTURE_WORDS 3     // the frames' blocks, R32UI
#define CB_POLYPOSTOR_TEXTURE_EMISSION 4  // of characters that glow

#define CB_POLYPOSTOR_LOCATION_LEVELS 3  // uint[CB_POLYPOSTOR_LEVELS]: position in the list of the level's first agent

#define CB_POLYPOSTOR_LOCATION_TEXELS 20  // float: texels of level 0 a unit of x and y (debug=stretch)
#define CB_POLYPOSTOR_LOCATION_PEAK 21    // float: of the light given off

#define CB_POLYPOSTOR_ATTRIBUTE_VERTEX 0  // PolypostorVertex
#define CB_POLYPOSTOR_ATTRIBUTE_CLIP 1    // Figure, one an instance: four columns
#define CB_POLYPOSTOR_ATTRIBUTE_LIGHT 5
#define CB_POLYPOSTOR_ATTRIBUTE_POSE 6

#endif
