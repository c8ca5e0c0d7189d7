// The scores of a scene as Markdown tables.
#pragma once
#include <string>

#include "reports/model/scene.h"

namespace crowdbench::reports {

// Single agents by height, then whole frames, each under its heading and left out where nothing was compared.
std::string scores_markdown(const Scene& scene);

}  // namespace crowdbench::reports
