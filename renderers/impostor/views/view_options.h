// The view grid as options and facts of the representations that store views.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "renderers/impostor/views/view_grid.h"
#include "renderers/representation.h"

namespace crowdbench::renderers {

// "views" and "el_min".
OptionDoc views_option();
OptionDoc el_min_option();
// Reads both. Throws Error naming the option.
ViewGrid read_view_grid(const OptionReader& reader);

// The spec with another grid, of the same lowest elevation.
Spec with_view_grid(Spec spec, const ViewGrid& grid);

// BakeInfo::facts of how far the picked view is from the direction to the eye, degrees.
std::vector<std::pair<std::string, double>> view_error_facts(const ViewGrid& grid);

}  // namespace crowdbench::renderers
