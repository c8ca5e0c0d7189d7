// What C++ and GLSL of dynamic impostors share.
#ifndef CROWDBENCH_DYNAMIC_SHARED_H
#define CROWDBENCH_DYNAMIC_SHARED_H

#define CB_DYNAMIC_TEXTURE_PAGE 0
#define CB_DYNAMIC_TEXTURE_RECORDS 7

// Texels of a record: the plane's centre relative to the eye, and the id; its two axes, by the agent's scale; the
// rectangle's low and high corner on it, metres at scale 1; the same on the page.
#define CB_DYNAMIC_TEXELS 5

#endif
