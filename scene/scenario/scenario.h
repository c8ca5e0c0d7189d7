// Scenario: one TOML file that says what is shown; every key has a default, a unit and a range.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene/character/character.h"
#include "scene/frame/camera.h"
#include "scene/frame/frame.h"
#include "scene/frame/light.h"

namespace crowdbench::scene {

enum class PlacementKind : uint8_t { grid, jittered, poisson, lanes };
enum class MotionKind : uint8_t { treadmill, lanes, free };
// plaza: a square around the centre. view: the ground that the view sees between the stage's depths, at the spacing.
// frustum: the same ground, evenly over depth and width, whatever the spacing; agents may interpenetrate.
enum class Stage : uint8_t { plaza, view, frustum };

struct CharacterEntry {
  std::string source = "mannequin";     // as open_character takes it; relative to the scenario's folder
  std::optional<double> height = 1.75;  // metres; nullopt = "as_is"
  std::optional<double> turn_deg;       // about +Y, so that it faces +Z; nullopt: guessed (NormaliseOptions::turn_deg)
  UpAxis up = UpAxis::y;                // of the file
  std::vector<std::string> animations;  // files whose clips it plays too, named as `source` is (scene/pose/retarget.h)
  std::vector<std::string> bones;       // RetargetOptions::bones
  std::vector<std::string> clips;       // names or indices in use; empty: the default clip
  std::vector<std::string> hide;
  bool rigid_meshes = true;
  double share = 1.0;  // relative share of the agents, > 0
  bool operator==(const CharacterEntry&) const = default;
};

struct CrowdSettings {
  uint32_t agents = 100;  // 0..1,000,000
  PlacementKind placement = PlacementKind::jittered;
  MotionKind motion = MotionKind::treadmill;
  Stage stage = Stage::plaza;
  double spacing = 1.2;               // metres between neighbours, 0.7..100
  std::optional<double> heading_deg;  // one heading for all; nullopt: random
  double scale_variation = 0.05;      // agents scale 1 +- this, 0..0.5
  double speed_variation = 0.1;       // playback speed 1 +- this, 0..0.5
  uint32_t outfits = 8;               // number of outfits, 1..4096; 1 = all alike (white)
  glm::dvec3 centre{0.0};             // metres: where the stage lies in the world; y is the ground's height
  double stage_near = 4;              // metres: `view` and `frustum` place agents between these eye-space depths
  double stage_far = 60;
  bool operator==(const CrowdSettings&) const = default;
};

// Where the pictures are looked at: a model by name, or a display by ColorVideoVDP's keys, whose meaning, defaults and
// dependence on each other are those of metrics/display.h. Nothing given: nobody chose one.
struct DisplaySettings {
  std::optional<std::string> model;                  // a model's name, or FILE.json[:NAME]
  std::optional<std::array<int64_t, 2>> resolution;  // width and height in pixels
  std::optional<double> viewing_distance_meters, viewing_distance_inches;
  std::optional<double> diagonal_size_meters, diagonal_size_inches;
  std::optional<double> fov_diagonal;  // degrees
  std::optional<double> pixels_per_degree;
  std::optional<double> max_luminance, min_luminance;  // cd/m2
  std::optional<double> contrast;
  std::optional<double> e_ambient;  // lux
  std::optional<double> k_refl, exposure;
  std::optional<std::string> colorspace;
  bool operator==(const DisplaySettings&) const = default;
};

struct Scenario {
  std::string name = "default";
  uint64_t seed = 1;
  int width = 640;  // 1..16384
  int height = 480;
  Antialiasing antialiasing;
  double tick_rate = 30;                     // Hz
  double pose_rate = 30;                     // Hz, of the pose bank
  std::string representation = "reference";  // a spec as renderers/representation.h has it
  std::optional<double> occupancy;  // requested fraction of covered pixels, (0, 1]; solved for camera and placement
  std::vector<CharacterEntry> characters{CharacterEntry{}};
  CrowdSettings crowd;
  CameraPath camera{{CameraKey{0.0, Camera{{0.0, 3.0, 9.0}, {0.0, 0.9, 0.0}, {0.0, 1.0, 0.0}, 0.6108652381980153}}}};
  Light light;
  bool ground = false;
  glm::vec3 background{0.2158605F, 0.2158605F, 0.2158605F};  // linear; in TOML '#rrggbb' sRGB
  DisplaySettings display;
  bool operator==(const Scenario&) const = default;
};

}  // namespace crowdbench::scene
