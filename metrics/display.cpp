// Based on: R. K. Mantiuk, P. Hanji, M. Ashraf, Y. Asano, A. Chapiro, "ColorVideoVDP: A visual difference predictor for
// image, video and display distortions", ACM TOG 43(4), 2024, and its display models (github.com/gfxdisp/ColorVideoVDP,
// pycvvdp/vvdp_data/display_models.json and color_spaces.json, commit 7ca201a; the numbers are under the MIT licence in
// metrics/cvvdp/LICENSE). PQ: SMPTE ST 2084. HLG: ITU-R BT.2100 and BT.2390 for its system gamma.
#include "metrics/display.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "metrics/flip.h"

namespace crowdbench::metrics {
namespace {

constexpr double kInch = 0.0254;
constexpr double kLeastSignal = 0.005;  // cd/m2 that linear and PQ values are raised to

constexpr Matrix3 kBt709 = {
    {{0.4124564, 0.3575761, 0.1804375}, {0.2126729, 0.7151522, 0.072175}, {0.0193339, 0.119192, 0.9503041}}};
constexpr Matrix3 kBt2020 = {{{0.637, 0.1446, 0.1689}, {0.2627, 0.678, 0.0593}, {0.0, 0.0281, 1.061}}};
constexpr Matrix3 kDisplayP3 = {{{0.4866, 0.2657, 0.1982}, {0.229, 0.6917, 0.0793}, {0, 0.0451, 1.0437}}};
constexpr Matrix3 kAdobeRgb = {
    {{0.5767309, 0.185554, 0.1881852}, {0.2973769, 0.6273491, 0.0752741}, {0.0270343, 0.0706872, 0.9911085}}};

constexpr ColourSpace kSpaces[] = {
    {"sRGB", Eotf::srgb, 0, kBt709},
    {"BT.709", Eotf::srgb, 0, kBt709},
    {"BT.709-linear", Eotf::linear, 0, kBt709},
    {"BT.2020-PQ", Eotf::pq, 0, kBt2020},
    {"BT.2020-HLG", Eotf::hlg, 0, kBt2020},
    {"BT.2020-linear", Eotf::linear, 0, kBt2020},
    {"Display P3 Apple", Eotf::srgb, 0, kDisplayP3},
    {"Adobe RGB (1998)", Eotf::gamma, 2.2, kAdobeRgb},
};

struct Model {
  const char* name;
  const char* description;
  int width, height;
  double distance;         // metres
  double diagonal_inches;  // or
  double fov_diagonal;     // degrees
  double peak, black, ambient;
  const char* space;
};

constexpr Model kModels[] = {
    {"standard_4k", "30-inch 4K monitor, office light", 3840, 2160, 0.7472, 30, 0, 200, 200.0 / 1000, 250, "sRGB"},
    {"standard_hdr_pq", "30-inch 4K HDR monitor, dim room, PQ", 3840, 2160, 0.7472, 30, 0, 1500, 1500 / 1e6, 10,
     "BT.2020-PQ"},
    {"standard_hdr_hlg", "30-inch 4K HDR monitor, dim room, HLG", 3840, 2160, 0.7472, 30, 0, 1500, 1500 / 1e6, 10,
     "BT.2020-HLG"},
    {"standard_hdr_linear", "30-inch 4K HDR monitor, dim room, values in cd/m2", 3840, 2160, 0.7472, 30, 0, 1500,
     1500 / 1e6, 10, "BT.709-linear"},
    {"standard_hdr_linear_dark", "30-inch 4K HDR monitor, dark room, values in cd/m2", 3840, 2160, 0.7472, 30, 0, 1500,
     1500 / 1e6, 0, "BT.709-linear"},
    {"standard_hdr_linear_zoom", "30-inch 4K HDR monitor from very near, values in cd/m2", 3840, 2160, 0.25, 30, 0,
     10000, 10000 / 1e6, 10, "BT.709-linear"},
    {"standard_fhd", "24-inch full HD monitor, office light", 1920, 1080, 0.6, 24, 0, 200, 200.0 / 1000, 250, "sRGB"},
    {"standard_hmd", "headset, 110 degrees", 1440, 1600, 3, 0, 110, 100, 0.1, 0, "sRGB"},
    {"standard_phone", "6-inch phone, office light", 2400, 1080, 0.4, 6, 0, 500, 0.05, 250, "sRGB"},
    {"sdr_4k_30", "30-inch 4K monitor, office light, from nearer", 3840, 2160, 0.6, 30, 0, 100, 100.0 / 1000, 250,
     "sRGB"},
    {"sdr_fhd_24", "24-inch full HD monitor of 100 cd/m2, office light", 1920, 1080, 0.6, 24, 0, 100, 100.0 / 1000, 250,
     "sRGB"},
    {"htc_vive_pro", "HTC Vive Pro", 1440, 1600, 3, 0, 110, 133.3, 0.1, 0, "sRGB"},
    {"iphone_12_pro", "iPhone 12 Pro", 2532, 1170, 20 * kInch, 6.1, 0, 825, 0.0004, 250, "sRGB"},
    {"iphone_14_pro", "iPhone 14 Pro, lying", 2532, 1170, 20 * kInch, 6.1, 0, 1025, 0.0004, 250, "sRGB"},
    {"iphone_14_pro_vert", "iPhone 14 Pro, upright", 1170, 2532, 20 * kInch, 6.1, 0, 1025, 0.0004, 250, "sRGB"},
    {"iphone_14_pro_hdr", "iPhone 14 Pro, lying, HLG", 2532, 1170, 20 * kInch, 6.1, 0, 1590, 0.0004, 10, "BT.2020-HLG"},
    {"iphone_14_pro_hdr_vert", "iPhone 14 Pro, upright, HLG", 1170, 2532, 20 * kInch, 6.1, 0, 1590, 0.0004, 10,
     "BT.2020-HLG"},
    {"ipad_pro_12_9", "iPad Pro 12.9", 2732, 2048, 20 * kInch, 12.9, 0, 600, 0.37, 250, "sRGB"},
    {"macbook_pro_16", "MacBook Pro 16", 3072, 1920, 25 * kInch, 16, 0, 500, 0.37, 250, "sRGB"},
    {"lg_oled_2017_sdr", "LG OLED of 2017", 3840, 2160, 101 * kInch, 64.5, 0, 272, 0.014, 100, "sRGB"},
    {"lg_oled_2017_hdr", "LG OLED of 2017, its HDR peak", 3840, 2160, 101 * kInch, 64.5, 0, 754, 0.038, 100, "sRGB"},
    {"eizo_CG3146", "EIZO Prominence CG3146", 4096, 2160, 0.73406, 31.063, 0, 300, 300.0 / 3000, 0, "sRGB"},
};

Display display_of_model(const Model& m) {
  Display d;
  d.name = m.name;
  d.description = m.description;
  d.width = m.width;
  d.height = m.height;
  d.distance = m.distance;
  d.diagonal = m.diagonal_inches * kInch;
  d.fov_diagonal = m.fov_diagonal;
  d.pixels_per_degree = m.fov_diagonal > 0 ? pixels_per_degree_by_fov(m.width, m.height, m.fov_diagonal)
                                           : pixels_per_degree_by_size(m.width, m.height, d.diagonal, m.distance);
  d.peak = m.peak;
  d.black = m.black;
  d.ambient = m.ambient;
  d.colour_space =
      *std::find_if(std::begin(kSpaces), std::end(kSpaces), [&](const ColourSpace& s) { return s.name == m.space; });
  return d;
}

double srgb_decoded(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }

double pq_nits(double v) {
  constexpr double kM1 = 2610.0 / 16384;
  constexpr double kM2 = 2523.0 / 4096 * 128;
  constexpr double kC1 = 3424.0 / 4096;
  constexpr double kC2 = 2413.0 / 4096 * 32;
  constexpr double kC3 = 2392.0 / 4096 * 32;
  const double e = std::pow(v, 1 / kM2);
  return 10000 * std::pow(std::max(e - kC1, 0.0) / (kC2 - kC3 * e), 1 / kM1);
}

double hlg_scene(double v) {
  constexpr double kA = 0.17883277;
  constexpr double kB = 0.28466892;
  constexpr double kC = 0.55991073;
  return v <= 0.5 ? v * v / 3 : (std::exp((v - kC) / kA) + kB) / 12;
}

double hlg_gamma(const Display& d) {
  if (d.peak <= 1000) return 1.2;
  return 1.2 + 0.42 * std::log10(d.peak / 1000) - 0.07623 * std::log10(d.ambient / 5);
}

// What the system gamma multiplies the scene's light by.
double hlg_gain(const Display& d, const std::array<double, 3>& scene) {
  const auto& y = d.colour_space.rgb_to_xyz[1];
  const double luminance = y[0] * scene[0] + y[1] * scene[1] + y[2] * scene[2];
  return luminance > 0 ? std::pow(luminance, hlg_gamma(d) - 1) : 0;
}

double scaled(const Display& d, double linear) {
  return (d.peak - d.black) * std::clamp(d.exposure * linear, 0.0, 1.0) + d.black;
}

double component(const Display& d, double v) {
  if (d.colour_space.eotf == Eotf::linear) return std::clamp(d.exposure * v, std::max(kLeastSignal, d.black), d.peak);
  v = std::clamp(v, 0.0, 1.0);
  switch (d.colour_space.eotf) {
    case Eotf::srgb: return scaled(d, srgb_decoded(v));
    case Eotf::gamma: return scaled(d, std::pow(v, d.colour_space.gamma));
    case Eotf::pq: return std::clamp(d.exposure * pq_nits(v), kLeastSignal, d.peak) + d.black;
    default: return hlg_scene(v);
  }
}

}  // namespace

std::span<const ColourSpace> colour_spaces() { return kSpaces; }

double reflected(const Display& display) { return display.ambient / std::numbers::pi * display.reflectivity; }

std::array<double, 3> light_of(const Display& display, const std::array<double, 3>& values) {
  std::array<double, 3> out{};
  std::transform(values.begin(), values.end(), out.begin(), [&](double v) { return component(display, v); });
  if (display.colour_space.eotf == Eotf::hlg) {
    const double gain = hlg_gain(display, out);
    for (double& l : out) l = scaled(display, gain * l);
  }
  for (double& l : out) l += reflected(display);
  return out;
}

double pixels_per_degree_by_size(int width, int height, double diagonal, double distance) {
  const double pixel = diagonal / std::hypot(width, height);  // metres
  return 1 / (2 * std::atan(pixel / (2 * distance)) * 180 / std::numbers::pi);
}

double pixels_per_degree_by_fov(int width, int height, double fov_diagonal_degrees) {
  return pixels_per_degree_by_size(width, height, 2 * std::tan(fov_diagonal_degrees / 2 * std::numbers::pi / 180), 1);
}

std::vector<std::string> display_names() {
  std::vector<std::string> names;
  for (const Model& model : kModels) names.emplace_back(model.name);
  return names;
}

Display find_display(std::string_view name, const std::string& where) {
  for (const Model& model : kModels)
    if (model.name == name) return display_of_model(model);
  const std::string near = nearest_name(name, display_names());
  throw Error(where, fmt::format("'{}' is not a display", printable(name, 60)),
              fmt::format("{}use one of {}, or a file NAME.json with ColorVideoVDP's keys",
                          near.empty() ? "" : fmt::format("did you mean {}? Else ", near),
                          nearest_first(name, display_names(), 6)));
}

const Display& default_display() {
  static const Display display = display_of_model(kModels[0]);
  return display;
}

std::string display_text(const Display& d) {
  return fmt::format("{}: {:.2f} pixels/degree, peak {:g}, black {:g}, reflected {:.4g} cd/m2, {}", d.name,
                     d.pixels_per_degree, d.peak, d.black, reflected(d), d.colour_space.name);
}

std::string display_text(const ChosenDisplay& chosen) {
  if (chosen.given) return display_text(chosen.display);
  return fmt::format("{} (by default; FLIP at its own {:.2f})", display_text(chosen.display), kFlipPixelsPerDegree);
}

}  // namespace crowdbench::metrics
