// Displays from files: ColorVideoVDP's keys.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "core/error.h"
#include "core/files.h"
#include "metrics/display.h"

namespace crowdbench::metrics {
namespace {

using nlohmann::json;

constexpr size_t kMostBytes = size_t{64} << 10U;
constexpr int kMostDepth = 3;  // an object of models with a resolution each
constexpr double kInch = 0.0254;

constexpr const char* kKeys[] = {"name",
                                 "source",
                                 "__comment",
                                 "colorspace",
                                 "resolution",
                                 "k_refl",
                                 "exposure",
                                 "fov_diagonal",
                                 "max_luminance",
                                 "min_luminance",
                                 "contrast",
                                 "E_ambient",
                                 "pixels_per_degree",
                                 "viewing_distance_meters",
                                 "viewing_distance_inches",
                                 "diagonal_size_meters",
                                 "diagonal_size_inches"};

// Parses; refuses what is too deep and members of one name, which would mean different things to different parsers.
json parsed(std::string_view text, const std::string& where) {
  std::vector<std::set<std::string>> keys;
  const auto watch = [&](int depth, json::parse_event_t event, json& value) {
    if (event == json::parse_event_t::object_start || event == json::parse_event_t::array_start) {
      if (depth >= kMostDepth)
        throw Error(where, fmt::format("JSON is nested deeper than {} levels", kMostDepth), "use ColorVideoVDP's keys");
      keys.emplace_back();
    } else if (event == json::parse_event_t::object_end || event == json::parse_event_t::array_end) {
      keys.pop_back();
    } else if (event == json::parse_event_t::key && !keys.back().insert(value.get<std::string>()).second) {
      throw Error(where, fmt::format("the key '{}' is there twice", printable(value.get<std::string>(), 60)),
                  "keep one of them");
    }
    return true;
  };
  try {
    return json::parse(text.begin(), text.end(), watch);
  } catch (const json::exception& e) {
    std::string reason = e.what();
    const size_t bracket = reason.find("] ");
    if (bracket != std::string::npos) reason.erase(0, bracket + 2);
    throw Error(where, "JSON does not parse: " + printable(reason, 160));
  }
}

// One model's members, each with its range.
class Reader {
 public:
  using Places = std::map<std::string, std::string>;
  Reader(const json& object, std::string where, const Places& places = {})
      : object_(object), where_(std::move(where)), places_(places) {}

  void require_known_keys() const {
    const std::vector<std::string> known(std::begin(kKeys), std::end(kKeys));
    for (const auto& [key, value] : object_.items())
      if (std::find(known.begin(), known.end(), key) == known.end())
        throw Error(where_, fmt::format("'{}' is not a key of a display", printable(key, 60)),
                    "use one of " + nearest_first(key, known, 4));
  }

  std::optional<double> number(const char* key, double least, double most) const {
    const auto found = object_.find(key);
    if (found == object_.end()) return std::nullopt;
    const double value = found->is_number() ? found->get<double>() : NAN;
    if (!(value >= least && value <= most))
      throw Error(at(key), fmt::format("{} is not right", printable(shown(*found), 40)),
                  fmt::format("use a number from {:g} to {:g}", least, most));
    return value;
  }

  // In metres, of which the file may say inches.
  std::optional<double> length(const std::string& key, double least, double most) const {
    const auto metres = number((key + "_meters").c_str(), least, most);
    const auto inches = number((key + "_inches").c_str(), least / kInch, most / kInch);
    if (metres && inches)
      throw Error(where_, fmt::format("{0}_meters and {0}_inches are both given", key), "keep one of them");
    if (inches) return *inches * kInch;
    return metres;
  }

  std::optional<std::string> text(const char* key) const {
    const auto found = object_.find(key);
    if (found == object_.end()) return std::nullopt;
    if (!found->is_string()) throw Error(at(key), fmt::format("{} is not text", printable(shown(*found), 40)));
    return found->get<std::string>();
  }

  std::optional<std::array<int, 2>> resolution() const {
    const auto found = object_.find("resolution");
    if (found == object_.end()) return std::nullopt;
    constexpr int kMost = 65536;
    const auto is_side = [](const json& v) { return v.is_number_integer() && v >= 1 && v <= kMost; };
    if (!found->is_array() || found->size() != 2 || !is_side((*found)[0]) || !is_side((*found)[1]))
      throw Error(at("resolution"), fmt::format("{} is not a resolution", printable(shown(*found), 40)),
                  fmt::format("use [width, height] in pixels, 1 to {} each", kMost));
    return std::array{(*found)[0].get<int>(), (*found)[1].get<int>()};
  }

  std::string at(const std::string& key) const {
    const auto place = places_.find(key);
    return place == places_.end() ? where_ + ": " + key : place->second;
  }
  const std::string& where() const { return where_; }

 private:
  static std::string shown(const json& value) { return value.dump(-1, ' ', true, json::error_handler_t::replace); }
  const json& object_;
  std::string where_;
  Places places_;
};

void read_geometry(const Reader& in, Display& d) {
  const auto resolution = in.resolution();
  const auto distance = in.length("viewing_distance", 1e-3, 1e4);
  const auto diagonal = in.length("diagonal_size", 1e-3, 1e4);
  const auto fov = in.number("fov_diagonal", 0.1, 179);
  const auto given = in.number("pixels_per_degree", 1, 1e4);
  d.width = resolution ? (*resolution)[0] : 0;
  d.height = resolution ? (*resolution)[1] : 0;
  d.distance = distance.value_or(0);
  d.diagonal = diagonal.value_or(0);
  d.fov_diagonal = fov.value_or(0);
  if (given)
    d.pixels_per_degree = *given;
  else if (resolution && fov)
    d.pixels_per_degree = pixels_per_degree_by_fov(d.width, d.height, *fov);
  else if (resolution && diagonal && distance)
    d.pixels_per_degree = pixels_per_degree_by_size(d.width, d.height, *diagonal, *distance);
  else
    throw Error(in.where(), "nothing says how many pixels a degree holds",
                "give pixels_per_degree, or resolution with viewing_distance_meters and diagonal_size_inches, or "
                "resolution with fov_diagonal");
  if (!(d.pixels_per_degree >= 1 && d.pixels_per_degree <= 1e4))
    throw Error(in.where(), fmt::format("the display has {:.3g} pixels a degree", d.pixels_per_degree),
                "give a size and a distance that make 1 to 10000");
}

void read_photometry(const Reader& in, Display& d) {
  const auto peak = in.number("max_luminance", 1e-2, 1e6);
  if (!peak) throw Error(in.where(), "max_luminance is missing", "give the peak in cd/m2");
  d.peak = *peak;
  const double contrast = in.number("contrast", 1.01, 1e12).value_or(500);
  d.black = in.number("min_luminance", 0, 1e6).value_or(d.peak / contrast);
  if (d.black >= d.peak)
    throw Error(in.at("min_luminance"), fmt::format("{:g} is not below max_luminance {:g}", d.black, d.peak));
  d.ambient = in.number("E_ambient", 0, 1e6).value_or(0);
  d.reflectivity = in.number("k_refl", 0, 1).value_or(0.005);
  d.exposure = in.number("exposure", 1e-6, 1e6).value_or(1);
  const std::string space = in.text("colorspace").value_or("sRGB");
  const auto spaces = colour_spaces();
  const auto found = std::find_if(spaces.begin(), spaces.end(), [&](const ColourSpace& s) { return s.name == space; });
  if (found == spaces.end()) {
    std::vector<std::string> names;
    for (const ColourSpace& s : spaces) names.emplace_back(s.name);
    throw Error(in.at("colorspace"), fmt::format("'{}' is not a colour space", printable(space, 60)),
                "use one of " + nearest_first(space, names));
  }
  d.colour_space = *found;
  if (d.colour_space.eotf == Eotf::hlg && d.peak > 1000 && d.ambient <= 0)
    throw Error(in.at("E_ambient"), "HLG above 1000 cd/m2 depends on the room's light", "give it in lux, above 0");
}

Display read_model(const json& object, const std::string& where, const std::string& name,
                   const Reader::Places& places = {}) {
  const Reader in(object, where, places);
  in.require_known_keys();
  for (const char* text : {"source", "__comment"}) in.text(text);
  Display d;
  d.name = printable(name, 60);
  d.description = printable(in.text("name").value_or(""));
  read_geometry(in, d);
  read_photometry(in, d);
  return d;
}

}  // namespace

std::vector<Display> parse_displays(std::string_view text, const std::string& where, const std::string& name,
                                    const std::map<std::string, std::string>& places) {
  const json all = parsed(text, where);
  if (!all.is_object()) throw Error(where, "JSON is not an object", "use ColorVideoVDP's keys");
  const bool several =
      !all.empty() && std::all_of(all.begin(), all.end(), [](const json& member) { return member.is_object(); });
  if (!several) return {read_model(all, where, name, places)};
  std::vector<Display> out;
  for (const auto& [key, model] : all.items())
    out.push_back(read_model(model, fmt::format("{}: {}", where, printable(key, 60)), key));
  return out;
}

std::vector<Display> read_displays(const std::filesystem::path& file) {
  return parse_displays(read_text(file, kMostBytes), file.string(), file.stem().string());
}

Display display_of(const std::string& text, const std::string& where) {
  constexpr std::string_view kEnding = ".json";
  const size_t ending = text.rfind(kEnding);
  const size_t after = ending == std::string::npos ? 0 : ending + kEnding.size();
  if (after == 0 || (after < text.size() && text[after] != ':')) return find_display(text, where);
  const std::string file = text.substr(0, after);
  const std::vector<Display> displays = read_displays(file);
  const std::string name = after < text.size() ? text.substr(after + 1) : "";
  if (name.empty() && displays.size() == 1) return displays[0];
  std::vector<std::string> names;
  for (const Display& d : displays) {
    if (d.name == name) return d;
    names.push_back(d.name);
  }
  if (name.empty())
    throw Error(where, fmt::format("{} holds {} displays", printable(file), displays.size()),
                fmt::format("say which: {}:NAME with one of {}", printable(file), nearest_first(name, names, 6)));
  throw Error(where, fmt::format("{} holds no display '{}'", printable(file), printable(name, 60)),
              "use one of " + nearest_first(name, names, 6));
}

}  // namespace crowdbench::metrics
