// What per-joint impostors' C++ and GLSL share.
#ifndef CROWDBENCH_PERJOINT_SHARED_H
#define CROWDBENCH_PERJOINT_SHARED_H

#define CB_PERJOINT_CORNERS 6  // of a tile's outline
#define CB_PERJOINT_FEW 4      // of those of levels from CB_PERJOINT_FEW_FROM on; the rest repeat the last
#define CB_PERJOINT_FEW_FROM 2

#define CB_PERJOINT_TEXTURE_ALBEDO 0
#define CB_PERJOINT_TEXTURE_SURFACE 1
#define CB_PERJOINT_TEXTURE_EMISSION 2
#define CB_PERJOINT_TEXTURE_PIECES \
  7  // CB_PERJOINT_PIECE_TEXELS a piece: rest pose to joint (three rows), centre and
     // depth range, joint
#define CB_PERJOINT_PIECE_TEXELS 5

#endif
