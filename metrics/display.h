// Display: where pictures are looked at. How many pixels a degree of visual angle holds, and the light that a pixel
// value becomes. One description for every score that depends on it.
//
// Models by name, keys of a file and the rule from value to light are those of ColorVideoVDP (Mantiuk et al. 2024,
// doi 10.1145/3658144; github.com/gfxdisp/ColorVideoVDP, commit 7ca201a, MIT licence: metrics/cvvdp/LICENSE).
//
// A display has no default of its own: a score that needs one is not computed where none is given, because its value
// means nothing without. Whoever asks for such a score gives default_display() where the user said nothing, and prints
// display_text() beside the score.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace crowdbench::metrics {

// From an encoded value to light.
enum class Eotf : uint8_t {
  srgb,    // IEC 61966-2-1
  gamma,   // value^ColourSpace::gamma
  linear,  // values are cd/m2, after exposure
  pq,      // SMPTE ST 2084
  hlg      // ITU-R BT.2100, with its system gamma by peak and surround
};

using Matrix3 = std::array<std::array<double, 3>, 3>;

struct ColourSpace {
  std::string_view name;  // "sRGB", "BT.2020-PQ": as ColorVideoVDP has it
  Eotf eotf = Eotf::srgb;
  double gamma = 0;  // of Eotf::gamma
  Matrix3 rgb_to_xyz{};
};
// Every one that a display may have. ColorVideoVDP's "luminance", which has one channel, is not among them.
std::span<const ColourSpace> colour_spaces();

// The members' own values are those of standard_4k, so that Display{60} is that display seen from where it has 60
// pixels a degree.
struct Display {
  double pixels_per_degree = 75.40244934516303;  // of visual angle at the middle of the display, above 0
  std::string name = "standard_4k";              // of the table or the file
  std::string description;                       // a sentence; may be empty
  int width = 3840, height = 2160;               // its pixels; 0 where only pixels_per_degree is given
  double distance = 0.7472;                      // metres from the eye; 0 where not given
  double diagonal = 0.762;                       // metres; 0 where not given
  double fov_diagonal = 0;                       // degrees, in place of the diagonal (headsets); 0 where not given
  double peak = 200;                             // cd/m2 of the largest value
  double black = 0.2;                            // cd/m2 of the smallest, without reflections
  double ambient = 250;                          // lux on the screen
  double reflectivity = 0.005;                   // share of the ambient light that the screen sends back
  double exposure = 1;                           // multiplies linear values before they are shown
  ColourSpace colour_space = colour_spaces()[0];
};

// The ambient light that the screen sends back: cd/m2.
double reflected(const Display& display);

// The light of one pixel in cd/m2 for R, G and B, as the eye gets it. values: 0..1, outside held within; with
// Eotf::linear any finite number, cd/m2 after exposure.
std::array<double, 3> light_of(const Display& display, const std::array<double, 3>& values);

// Pixels a degree of a display of that many pixels and metres; of that field of view between opposite corners.
double pixels_per_degree_by_size(int width, int height, double diagonal, double distance);
double pixels_per_degree_by_fov(int width, int height, double fov_diagonal_degrees);

// ColorVideoVDP's models, in its order.
std::vector<std::string> display_names();
// By name. where: the option or key that gave it. Throws Error with the near names.
Display find_display(std::string_view name, const std::string& where);
// standard_4k.
const Display& default_display();

// A file with ColorVideoVDP's keys. Either one model, an object of:
//   name, source, __comment            text, not needed
//   colorspace                         of colour_spaces(); "sRGB"
//   resolution                         [width, height] in pixels
//   viewing_distance_meters or viewing_distance_inches
//   diagonal_size_meters or diagonal_size_inches, or fov_diagonal (degrees)
//   pixels_per_degree                  in place of the three above
//   max_luminance                      cd/m2, needed
//   min_luminance (cd/m2) or contrast  max_luminance / contrast is the black; min_luminance goes first; contrast 500
//   E_ambient (lux; 0), k_refl (0.005), exposure (1)
// or an object of such models by name, as ColorVideoVDP's own display_models.json. Other keys are refused. Throws Error
// naming file, key and what is right; safe on hostile text.
std::vector<Display> read_displays(const std::filesystem::path& file);
// The same from memory. where: the source, for errors; places: where a key of a single model was given, in place of
// "where: key". name: of a single model, in place of its place in an object.
std::vector<Display> parse_displays(std::string_view text, const std::string& where, const std::string& name,
                                    const std::map<std::string, std::string>& places = {});

// What a user writes: a model's name, FILE.json, or FILE.json:NAME where the file holds several. where: the option or
// key, for errors. Throws Error.
Display display_of(const std::string& text, const std::string& where);

// The display that a command's pictures are looked at on.
struct ChosenDisplay {
  Display display = default_display();
  bool given = false;  // somebody chose it: ScoreInput::display_is_default
};

// For people: "standard_4k: 75.40 pixels/degree, peak 200, black 0.2, reflected 0.3979 cd/m2, sRGB".
std::string display_text(const Display& display);
// The same; where nobody chose it, with what scores do then that have a default of their own.
std::string display_text(const ChosenDisplay& chosen);

}  // namespace crowdbench::metrics
