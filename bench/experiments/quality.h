// Quality: one agent drawn by a representation against the mesh at the identical view, scored.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "metrics/causes.h"
#include "metrics/figure.h"
#include "renderers/frame/capture.h"
#include "scene/character/character.h"

namespace crowdbench::bench {

// Where the camera stands. The agent's capture centre (the middle of the clip's posed bounds) is in the middle of the
// picture. Light and background are the frame's defaults (background sRGB 128).
struct QualityView {
  double height_px = 120;    // rows that the clip's first pose covers, seen level from that azimuth
  double azimuth_deg = 0;    // 0 = from the front, positive turns the camera towards the character's left
  double elevation_deg = 0;  // positive = from above, -90..90
  int clip = -1;             // into Character::clips; -1: the bind pose
  double time = 0;           // the file's own seconds
  double fov_y_deg = 30;     // vertical field of view; the same height is seen from another distance
};

// What each kind of wrong pixel costs: metrics::score_by_cause() had the pixels of that kind been the mesh's own.
struct QualityCauses {
  std::optional<double> silhouette;  // covered by one of the two only
  std::optional<double> surface;  // covered by both, at depths that differ by more than 1 % of the character's height
  std::optional<double> shading;  // covered by both, at the same depth
};

struct QualityRow {
  size_t index = 0;            // into QualitySetup::representations
  std::string representation;  // canonical text; as it was asked for where that cannot be read
  QualityView view;
  double phase = 0;     // of the clip at that time, as the agent carries it
  double distance = 0;  // metres, eye to capture centre
  metrics::FigureScores scores;
  std::string reference = renderers::reference_spec().text();  // what it is held against; kTruthName: the truth
  std::string refused;   // why the representation could not be drawn: nothing is scored; empty where it was
  QualityCauses causes;  // only when asked for
  std::optional<metrics::CauseErrors> errors;  // by cause, only when asked for; nothing where it was refused
};

struct QualityPictures {
  renderers::Capture reference, test;
  std::vector<metrics::CauseStep> steps;  // of the error by cause, when asked for
};

struct QualitySetup {
  std::shared_ptr<const scene::Character> character;
  std::vector<std::string> representations;
  std::vector<QualityView> views;
  int rows = 480;         // of the picture, 4:3; taller figures get a picture of 1.5 times their height
  double pose_rate = 30;  // Hz, of the bank that the representation draws from; the mesh has the exact time
  scene::Antialiasing antialiasing;
  bool truth = false;       // held against rays (truth/truth.h) instead of the drawn mesh; not with `causes`
  bool exact_pose = false;  // give the representation the exact time too, so that only its drawing is judged
  uint64_t bake_budget = uint64_t{512} << 20;
  bool use_cache = true;
  bool causes = false;       // fill QualityRow::causes and errors
  bool read_causes = false;  // without `causes`: fill QualityRow::errors with what the two pictures alone tell
  bool maps = false;         // fill the scores' maps, over FigureScores::box
  metrics::ChosenDisplay display;
  std::string debug;  // a debug view of the representations instead of their pictures
  metrics::ScoreTable table = metrics::scores();
};

// The picture's size for a figure of that height.
struct QualitySize {
  int width = 640;
  int height = 480;
};
QualitySize quality_size(const QualitySetup& setup, double height_px);
// distance: metres, eye to centre. centre: metres, world.
scene::Camera quality_camera(const QualityView& view, const glm::dvec3& centre, double distance);
// The distance at which `height` metres at the centre's depth are view.height_px of so many rows.
double distance_of_height(const QualityView& view, double height, int rows);
// The distance at which a figure of these positions (metres, world) covers view.height_px of so many rows, seen level:
// what is nearer than the centre is shown larger. Positions without height: distance_of_height of a metre.
double distance_of_figure(const QualityView& view, const glm::dvec3& centre, std::span<const glm::dvec3> positions,
                          int rows);

// One row a representation and view, in that order; `seen` is shown every pair of pictures as it is made. A
// representation that is refused (a text that cannot be read, a bake over its budget) has rows that say why. Throws
// Error: where all are refused, that of the first.
std::vector<QualityRow> compute_quality(
    gl::Context& context, const QualitySetup& setup,
    const std::function<void(const QualityRow&, const QualityPictures&)>& seen = {});

// "30,60,120" and "first:last:step" (last included where a step meets it), several joined by commas; at most 10,000
// values. Throws Error naming `option`.
std::vector<double> parse_numbers(const std::string& text, const std::string& option, double low, double high);

}  // namespace crowdbench::bench
