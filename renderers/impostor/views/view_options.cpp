#include "renderers/impostor/views/view_options.h"

#include <numbers>

namespace crowdbench::renderers {

namespace {
constexpr const char* kViews = "views";
}

OptionDoc views_option() {
  return {kViews, "sphere-AxE[-mirrored]|cube-N|hemi-N", "sphere-17x8",
          "the view grid: azimuths x elevations, or N a side",
          [](const std::string& value, const std::string& where) { (void)parse_view_grid(value, 0, where); }};
}

OptionDoc el_min_option() {
  return {"el_min", "-89..89", "0", "degrees: the lowest elevation of the grid; lower views use its lowest row"};
}

ViewGrid read_view_grid(const OptionReader& reader) {
  return parse_view_grid(reader.text(kViews), reader.number("el_min", -89, 89) * std::numbers::pi / 180,
                         reader.where(kViews));
}

Spec with_view_grid(Spec spec, const ViewGrid& grid) {
  std::erase_if(spec.options, [](const auto& option) { return option.first == kViews; });
  spec.options.emplace_back(kViews, grid.text());
  return spec;
}

std::vector<std::pair<std::string, double>> view_error_facts(const ViewGrid& grid) {
  const ViewErrors errors = compute_view_errors(grid);
  return {{"view_error_deg_mean", errors.mean * 180 / std::numbers::pi},
          {"view_error_deg_max", errors.largest * 180 / std::numbers::pi}};
}

}  // namespace crowdbench::renderers
