#include "bench/stage/cast_name.h"

namespace crowdbench::bench {

std::string cast_name(const scene::Cast& cast) {
  std::string name;
  for (const auto& character : cast.characters) name += (name.empty() ? "" : " + ") + character->name;
  return name;
}

}  // namespace crowdbench::bench
