#include "scene/scenario/scenario_keys.h"

#include <fmt/format.h>

#include <cmath>

#include "core/colour.h"

namespace crowdbench::scene {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

// Degrees that read back as exactly these radians where there are such degrees (a product by pi / 180 skips some).
double degrees_of(double radians) {
  const double nearest = radians / kDegree;
  double below = nearest;
  double above = nearest;
  for (int step = 0; step < 4; ++step) {
    if (below * kDegree == radians) return below;
    if (above * kDegree == radians) return above;
    below = std::nextafter(below, -1e300);
    above = std::nextafter(above, 1e300);
  }
  return nearest;
}

std::string hex_of(const glm::vec3& linear) {
  return fmt::format("#{:02x}{:02x}{:02x}", linear_to_srgb8(linear.r), linear_to_srgb8(linear.g),
                     linear_to_srgb8(linear.b));
}

glm::vec3 linear_of(const std::string& hex) {
  const auto channel = [&hex](size_t at) {
    return static_cast<float>(srgb_to_linear(std::stoi(hex.substr(at, 2), nullptr, 16) / 255.0));
  };
  return {channel(1), channel(3), channel(5)};
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      out += {'\\', c};
    else if (byte < 0x20 || byte == 0x7f)
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(byte));
    else
      out += c;
  }
  return out + '"';
}

std::string decimal(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

// Getter and setter of one member, reached by a function from (scenario, index).
template <typename T>
using Member = std::function<T&(Scenario&, size_t)>;

// int64_t stands for every other integer and for enumerations, double for float, dvec3 for vec3.
template <typename T>
inline constexpr bool kAsInteger = std::is_enum_v<T> ||
                                   (std::is_integral_v<T> && !std::is_same_v<T, bool> && !std::is_same_v<T, uint64_t>);

template <typename T>
T value_as(const KeyValue& value) {
  if constexpr (kAsInteger<T>)
    return static_cast<T>(std::get<int64_t>(value));
  else if constexpr (std::is_same_v<T, float>)
    return static_cast<float>(std::get<double>(value));
  else if constexpr (std::is_same_v<T, glm::vec3>)
    return glm::vec3(std::get<glm::dvec3>(value));
  else
    return std::get<T>(value);
}

// The shortest decimal of the float, not its 17 digits.
double widened(float value) { return std::stod(fmt::format("{}", value)); }

template <typename T>
KeyValue value_from(const T& member) {
  if constexpr (kAsInteger<T>)
    return static_cast<int64_t>(member);
  else if constexpr (std::is_same_v<T, float>)
    return widened(member);
  else if constexpr (std::is_same_v<T, glm::vec3>)
    return glm::dvec3{widened(member.x), widened(member.y), widened(member.z)};
  else
    return member;
}

template <typename T>
void bind(Key& key, Member<T> member) {
  key.get = [member](const Scenario& s, size_t i) { return value_from<T>(member(const_cast<Scenario&>(s), i)); };
  key.set = [member](Scenario& s, size_t i, const KeyValue& v) { member(s, i) = value_as<T>(v); };
}

template <typename T>
void bind(Key& key, Member<std::optional<T>> member) {
  key.get = [member](const Scenario& s, size_t i) -> KeyValue {
    const std::optional<T>& value = member(const_cast<Scenario&>(s), i);
    return value ? value_from<T>(*value) : KeyValue{};
  };
  key.set = [member](Scenario& s, size_t i, const KeyValue& v) {
    if (std::holds_alternative<std::monostate>(v))
      member(s, i).reset();
    else
      member(s, i) = value_as<T>(v);
  };
}

struct Range {
  double low = 0;
  double high = 0;
};

template <typename T>
Key key(const char* table, const char* name, KeyType type, const char* unit, Range range, const char* meaning,
        Member<T> member) {
  Key k;
  k.table = table;
  k.name = name;
  k.type = type;
  k.unit = unit;
  k.low = range.low;
  k.high = range.high;
  k.meaning = meaning;
  bind(k, std::move(member));
  return k;
}

Key with_words(Key k, std::vector<std::string> words) {
  k.words = std::move(words);
  return k;
}

Key or_else(Key k, const char* absent) {
  k.absent = absent;
  return k;
}

constexpr double kWorld = 1e9;  // metres: the largest coordinate

void add_camera_keys(std::vector<Key>& keys, const char* table) {
  const auto camera = [](Scenario& s, size_t i) -> Camera& { return s.camera.keys[i].camera; };
  keys.push_back(key<glm::dvec3>(
      table, "eye", KeyType::vector, "m", {-kWorld, kWorld},
      "where the camera is", [=](Scenario & s, size_t i) -> auto& { return camera(s, i).eye; }));
  keys.push_back(key<glm::dvec3>(
      table, "target", KeyType::vector, "m", {-kWorld, kWorld},
      "what it looks at", [=](Scenario & s, size_t i) -> auto& { return camera(s, i).target; }));
  keys.push_back(key<glm::dvec3>(
      table, "up", KeyType::vector, "", {-1, 1},
      "what is up in the picture; any length above 0", [=](Scenario & s, size_t i) -> auto& {
        return camera(s, i).up;
      }));
  Key fov = key<double>(
      table, "fov_y_deg", KeyType::number, "degrees", {0.1, 179},
      "vertical field of view", [=](Scenario & s, size_t i) -> auto& { return camera(s, i).fov_y; });
  fov.get = [=](const Scenario& s, size_t i) -> KeyValue { return degrees_of(s.camera.keys[i].camera.fov_y); };
  fov.set = [=](Scenario& s, size_t i, const KeyValue& v) { camera(s, i).fov_y = std::get<double>(v) * kDegree; };
  keys.push_back(fov);
  keys.push_back(key<double>(
      table, "near", KeyType::number, "m", {1e-6, 1e6},
      "distance of the near plane", [=](Scenario & s, size_t i) -> auto& { return camera(s, i).near; }));
  keys.push_back(key<double>(
      table, "far", KeyType::number, "m", {0, 1e12},
      "distance of the far plane, beyond `near`; 0 = infinite", [=](Scenario & s, size_t i) -> auto& {
        return camera(s, i).far;
      }));
}

void add_top_keys(std::vector<Key>& keys) {
  keys.push_back(key<std::string>(
      "", "name", KeyType::text, "", {}, "the scenario's name, as reports show it",
      [](Scenario & s, size_t) -> auto& { return s.name; }));
  keys.push_back(key<uint64_t>(
      "", "seed", KeyType::seed, "", {0, 18446744073709551615.0},
      "everything random follows from it; in quotes above 9223372036854775807",
      [](Scenario & s, size_t) -> auto& { return s.seed; }));
  keys.push_back(key<int>(
      "", "width", KeyType::integer, "pixels", {1, 16384}, "width of the picture",
      [](Scenario & s, size_t) -> auto& { return s.width; }));
  keys.push_back(key<int>(
      "", "height", KeyType::integer, "pixels", {1, 16384}, "height of the picture",
      [](Scenario & s, size_t) -> auto& { return s.height; }));
  keys.push_back(key<int>(
      "", "samples", KeyType::integer, "", {1, 8},
      "samples a pixel of multisampling: 1, 2, 4 or 8, as the driver has them",
      [](Scenario & s, size_t) -> auto& { return s.antialiasing.samples; }));
  keys.push_back(key<int>(
      "", "supersample", KeyType::integer, "", {1, 9}, "odd K: K x K samples a pixel, averaged in linear light",
      [](Scenario & s, size_t) -> auto& { return s.antialiasing.supersample; }));
  keys.push_back(key<double>(
      "", "tick_rate", KeyType::number, "Hz", {0.001, 1e6}, "ticks a second",
      [](Scenario & s, size_t) -> auto& { return s.tick_rate; }));
  keys.push_back(key<double>(
      "", "pose_rate", KeyType::number, "Hz", {1, 1000}, "samples a second in the pose bank",
      [](Scenario & s, size_t) -> auto& { return s.pose_rate; }));
  keys.push_back(key<std::string>(
      "", "representation", KeyType::text, "", {},
      "what draws the crowd, as `crowdbench info --representations` lists it; reference: what all are held against",
      [](Scenario & s, size_t) -> auto& { return s.representation; }));
  keys.push_back(
      or_else(key<std::optional<double>>(
                  "", "occupancy", KeyType::number, "fraction of the picture", {0.0001, 1},
                  "how much of the picture the crowd covers, solved by moving camera and agents; \"none\": as they are",
                  [](Scenario & s, size_t) -> auto& { return s.occupancy; }),
              "none"));
  keys.push_back(key<bool>(
      "", "ground", KeyType::flag, "", {}, "draw a grey grid at the ground's height",
      [](Scenario & s, size_t) -> auto& { return s.ground; }));
  Key background = key<glm::vec3>(
      "", "background", KeyType::colour, "sRGB", {}, "colour where nothing is drawn",
      [](Scenario & s, size_t) -> auto& { return s.background; });
  background.get = [](const Scenario& s, size_t) -> KeyValue { return hex_of(s.background); };
  background.set = [](Scenario& s, size_t, const KeyValue& v) { s.background = linear_of(std::get<std::string>(v)); };
  keys.push_back(background);
}

void add_crowd_keys(std::vector<Key>& keys) {
  keys.push_back(key<uint32_t>(
      "crowd", "agents", KeyType::integer, "", {0, 1'000'000}, "number of agents",
      [](Scenario & s, size_t) -> auto& { return s.crowd.agents; }));
  keys.push_back(with_words(
      key<PlacementKind>(
          "crowd", "placement", KeyType::choice, "", {},
          "where agents stand: on a grid; on a grid with random offsets, at least 0.49 m apart; as a Poisson disk "
          "sample, at least 0.75 spacings apart; in street lanes",
          [](Scenario & s, size_t) -> auto& { return s.crowd.placement; }),
      {"grid", "jittered", "poisson", "lanes"}));
  keys.push_back(
      with_words(key<MotionKind>(
                     "crowd", "motion", KeyType::choice, "", {},
                     "how they move: clips play and places stay; every street lane at one speed, never overlapping "
                     "(implies `placement = \"lanes\"`); each its own way, which may overlap",
                     [](Scenario & s, size_t) -> auto& { return s.crowd.motion; }),
                 {"treadmill", "lanes", "free"}));
  keys.push_back(with_words(
      key<Stage>(
          "crowd", "stage", KeyType::choice, "", {},
          "a square around `centre`; the ground that the first view sees between `stage_near` and `stage_far`, filled "
          "from its middle at `spacing`; or all of that ground, evenly over depth and width, where agents may "
          "interpenetrate",
          [](Scenario & s, size_t) -> auto& { return s.crowd.stage; }),
      {"plaza", "view", "frustum"}));
  keys.push_back(key<double>(
      "crowd", "spacing", KeyType::number, "m", {0.7, 100}, "between neighbours; one agent a square of this side",
      [](Scenario & s, size_t) -> auto& { return s.crowd.spacing; }));
  keys.push_back(or_else(key<std::optional<double>>(
                             "crowd", "heading_deg", KeyType::number, "degrees", {-360, 360},
                             "one heading for all, 0 = +Z, 90 = +X; \"random\": each its own (in lanes: along X)",
                             [](Scenario & s, size_t) -> auto& { return s.crowd.heading_deg; }),
                         "random"));
  keys.push_back(key<double>(
      "crowd", "scale_variation", KeyType::number, "", {0, 0.5},
      "agents are 1 +- this times as tall as their character",
      [](Scenario & s, size_t) -> auto& { return s.crowd.scale_variation; }));
  keys.push_back(key<double>(
      "crowd", "speed_variation", KeyType::number, "", {0, 0.5}, "clips play 1 +- this times as fast",
      [](Scenario & s, size_t) -> auto& { return s.crowd.speed_variation; }));
  keys.push_back(key<uint32_t>(
      "crowd", "outfits", KeyType::integer, "", {1, 4096},
      "number of outfits (colours by body part); 1 = the textures as they are",
      [](Scenario & s, size_t) -> auto& { return s.crowd.outfits; }));
  keys.push_back(key<glm::dvec3>(
      "crowd", "centre", KeyType::vector, "m", {-kWorld, kWorld},
      "middle of the stage; its second number is the ground's height",
      [](Scenario & s, size_t) -> auto& { return s.crowd.centre; }));
  keys.push_back(key<double>(
      "crowd", "stage_near", KeyType::number, "m", {0.01, 1e6},
      "stages `view` and `frustum`: depth of the nearest agents",
      [](Scenario & s, size_t) -> auto& { return s.crowd.stage_near; }));
  keys.push_back(key<double>(
      "crowd", "stage_far", KeyType::number, "m", {0.01, 1e6},
      "stages `view` and `frustum`: depth of the farthest agents, at least `stage_near`",
      [](Scenario & s, size_t) -> auto& { return s.crowd.stage_far; }));
}

void add_light_keys(std::vector<Key>& keys) {
  keys.push_back(key<glm::vec3>(
      "light", "direction", KeyType::vector, "", {-1, 1}, "towards the light; any length above 0",
      [](Scenario & s, size_t) -> auto& { return s.light.direction; }));
  keys.push_back(key<float>(
      "light", "ambient", KeyType::number, "", {0, 16}, "light from everywhere, linear",
      [](Scenario & s, size_t) -> auto& { return s.light.ambient; }));
  keys.push_back(key<float>(
      "light", "diffuse", KeyType::number, "", {0, 16}, "light from the direction, linear, times the cosine",
      [](Scenario & s, size_t) -> auto& { return s.light.diffuse; }));
}

void add_character_keys(std::vector<Key>& keys) {
  keys.push_back(key<std::string>(
      "character", "source", KeyType::text, "", {},
      "`mannequin[:triangles=N,joints=N]`, or a glTF, FBX or COLLADA file seen from the scenario's folder",
      [](Scenario & s, size_t i) -> auto& { return s.characters[i].source; }));
  keys.push_back(or_else(
      key<std::optional<double>>(
          "character", "height", KeyType::number, "m", {0.001, 1e4},
          "scaled so that it stands so tall in its clips in use (the tallest first pose of them); \"as_is\": as in "
          "the file",
          [](Scenario & s, size_t i) -> auto& { return s.characters[i].height; }),
      "as_is"));
  keys.push_back(
      or_else(key<std::optional<double>>(
                  "character", "turn_deg", KeyType::number, "degrees", {-360, 360},
                  "turned about the vertical so that it faces +Z, from +Z towards +X; \"guess\": by 180 where "
                  "walk, feet and face point to -Z, with a warning",
                  [](Scenario & s, size_t i) -> auto& { return s.characters[i].turn_deg; }),
              "guess"));
  keys.push_back(with_words(key<UpAxis>(
                                "character", "up", KeyType::choice, "", {}, "which axis of the file points up",
                                [](Scenario & s, size_t i) -> auto& { return s.characters[i].up; }),
                            {"y", "z"}));
  keys.push_back(key<std::vector<std::string>>(
      "character", "animations", KeyType::texts, "", {},
      "files whose clips it plays beside its own, named as `source` is; bones are matched by node name, by `bones`, "
      "and "
      "by the names that common programs give human bones",
      [](Scenario & s, size_t i) -> auto& { return s.characters[i].animations; }));
  keys.push_back(key<std::vector<std::string>>(
      "character", "bones", KeyType::texts, "", {},
      "\"mine=theirs\": which of its nodes play which nodes of `animations`",
      [](Scenario & s, size_t i) -> auto& { return s.characters[i].bones; }));
  keys.push_back(key<std::vector<std::string>>(
      "character", "clips", KeyType::texts, "", {}, "clips in use, by name or index; empty: the default clip",
      [](Scenario & s, size_t i) -> auto& { return s.characters[i].clips; }));
  keys.push_back(key<std::vector<std::string>>(
      "character", "hide", KeyType::texts, "", {}, "nodes whose meshes are left out, with all below them",
      [](Scenario & s, size_t i) -> auto& { return s.characters[i].hide; }));
  keys.push_back(key<bool>(
      "character", "rigid_meshes", KeyType::flag, "", {}, "keep meshes that hang on joints without a skin (a sword)",
      [](Scenario & s, size_t i) -> auto& { return s.characters[i].rigid_meshes; }));
  keys.push_back(key<double>(
      "character", "share", KeyType::number, "", {1e-6, 1e6},
      "part of the agents, relative to the other characters' shares",
      [](Scenario & s, size_t i) -> auto& { return s.characters[i].share; }));
}

// A key of [display]: not given where it is "none".
template <typename T>
void add_display_key(std::vector<Key>& keys, const char* name, KeyType type, const char* unit, Range range,
                     const char* meaning, std::optional<T> DisplaySettings::*member) {
  keys.push_back(or_else(key<std::optional<T>>(
                             "display", name, type, unit, range,
                             meaning, [member](Scenario & s, size_t) -> auto& { return s.display.*member; }),
                         "none"));
}

// The ranges are those of metrics/display_file.cpp.
void add_display_keys(std::vector<Key>& keys) {
  using D = DisplaySettings;
  constexpr double kInch = 0.0254;
  const auto number = [&](const char* name, const char* unit, Range range, const char* meaning,
                          std::optional<double> D::*member) {
    add_display_key(keys, name, KeyType::number, unit, range, meaning, member);
  };
  add_display_key(keys, "model", KeyType::text, "", {},
                  "a model of ColorVideoVDP by its name, or FILE.json, or FILE.json:NAME, seen from the scenario's "
                  "folder; instead of all other keys",
                  &D::model);
  add_display_key(keys, "resolution", KeyType::size, "pixels", {1, 65536}, "width and height", &D::resolution);
  number("viewing_distance_meters", "m", {1e-3, 1e4}, "from the eye", &D::viewing_distance_meters);
  number("viewing_distance_inches", "inches", {1e-3 / kInch, 1e4 / kInch}, "the same", &D::viewing_distance_inches);
  number("diagonal_size_meters", "m", {1e-3, 1e4}, "between opposite corners", &D::diagonal_size_meters);
  number("diagonal_size_inches", "inches", {1e-3 / kInch, 1e4 / kInch}, "the same", &D::diagonal_size_inches);
  number("fov_diagonal", "", {0.1, 179}, "degrees between opposite corners, in place of distance and diagonal",
         &D::fov_diagonal);
  number("pixels_per_degree", "pixels/degree", {1, 1e4}, "in place of resolution, distance and diagonal",
         &D::pixels_per_degree);
  number("max_luminance", "cd/m2", {1e-2, 1e6}, "of the largest value; needed without `model`", &D::max_luminance);
  number("min_luminance", "cd/m2", {0, 1e6}, "of the smallest value, without reflections", &D::min_luminance);
  number("contrast", "", {1.01, 1e12}, "max_luminance / contrast is min_luminance; 500 where neither is given",
         &D::contrast);
  number("E_ambient", "lux", {0, 1e6}, "light of the room on the screen; 0 where not given", &D::e_ambient);
  number("k_refl", "", {0, 1}, "share of that light that the screen sends back; 0.005 where not given", &D::k_refl);
  number("exposure", "", {1e-6, 1e6}, "multiplies linear values before they are shown; 1 where not given",
         &D::exposure);
  add_display_key(keys, "colorspace", KeyType::text, "", {},
                  "from value to light, as ColorVideoVDP names it: sRGB (where not given), BT.2020-PQ, ...",
                  &D::colorspace);
}

std::vector<Key> make_keys() {
  std::vector<Key> keys;
  add_top_keys(keys);
  add_crowd_keys(keys);
  add_camera_keys(keys, "camera");
  keys.push_back(key<double>(
      "camera.key", "time", KeyType::number, "s", {0, 1e9}, "when the path passes this view",
      [](Scenario & s, size_t i) -> auto& { return s.camera.keys[i].time; }));
  add_camera_keys(keys, "camera.key");
  add_light_keys(keys);
  add_display_keys(keys);
  add_character_keys(keys);
  return keys;
}

}  // namespace

const std::vector<KeyTable>& scenario_tables() {
  static const std::vector<KeyTable> all = {
      {"", false, "the picture, the ticks and what is solved for", ""},
      {"crowd", false, "who stands where and how they move", ""},
      {"camera", false, "one view; a scenario has this or a path of [[camera.key]]", ""},
      {"camera.key", true, "a view of a path, passed at its time; keys by ascending time", ""},
      {"light", false, "albedo * (ambient + diffuse * max(0, N.L)) in linear light", ""},
      {"display", false,
       "where the pictures are looked at, for scores that depend on it: `display = \"standard_fhd\"`, or "
       "ColorVideoVDP's keys; --display goes first",
       "model"},
      {"character", true, "a type of character; one mannequin when there is none", ""},
  };
  return all;
}

const std::vector<Key>& scenario_keys() {
  static const std::vector<Key> all = make_keys();
  return all;
}

std::string toml_value(const Key& key, const KeyValue& value) {
  struct Writer {
    const Key& key;
    std::string operator()(std::monostate) const { return quoted(key.absent); }
    std::string operator()(bool v) const { return v ? "true" : "false"; }
    std::string operator()(int64_t v) const {
      return key.type == KeyType::choice ? quoted(key.words[static_cast<size_t>(v)]) : fmt::format("{}", v);
    }
    std::string operator()(uint64_t v) const {
      return v > uint64_t{INT64_MAX} ? fmt::format("\"{}\"", v) : fmt::format("{}", v);
    }
    std::string operator()(double v) const { return decimal(v); }
    std::string operator()(const std::string& v) const { return quoted(v); }
    std::string operator()(const glm::dvec3& v) const {
      return fmt::format("[{}, {}, {}]", decimal(v.x), decimal(v.y), decimal(v.z));
    }
    std::string operator()(const std::array<int64_t, 2>& v) const { return fmt::format("[{}, {}]", v[0], v[1]); }
    std::string operator()(const std::vector<std::string>& v) const {
      std::string line;
      std::string lines;
      for (const std::string& text : v) {
        line += (line.empty() ? "" : ", ") + quoted(text);
        lines += fmt::format("  {},\n", quoted(text));
      }
      return line.size() < 100 ? fmt::format("[{}]", line) : fmt::format("[\n{}]", lines);
    }
  };
  return std::visit(Writer{key}, value);
}

}  // namespace crowdbench::scene
