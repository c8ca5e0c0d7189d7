// What flat's C++ and GLSL share.
#ifndef CROWDBENCH_FLAT_SHARED_H
#define CROWDBENCH_FLAT_SHARED_H

#define CB_FLAT_CLIPS 256  // of one character's bank, at most

#define CB_FLAT_TEXTURE_ALBEDO 0
#define CB_FLAT_TEXTURE_SURFACE 1

#endif
