// How rows and tables call a cast.
#pragma once
#include <string>

#include "scene/cast/cast.h"

namespace crowdbench::bench {

// "mannequin", or "a.glb + b.glb".
std::string cast_name(const scene::Cast& cast);

}  // namespace crowdbench::bench
