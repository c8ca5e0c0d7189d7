// The scores: one table of what can be said about two pictures, figures or clips. Every command, page and export walks
// it, so that none of them spells a score's name.
//
// A score is one file of this folder, which defines `extern const Score score_NAME`, and one line of the table in
// registry.cpp. Walkers take the table as a parameter; scores() is the whole one.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <typeindex>
#include <utility>
#include <vector>

#include "metrics/cvvdp/temporal_filter.h"
#include "metrics/difference.h"
#include "metrics/display.h"
#include "metrics/pseudocolour.h"

namespace crowdbench::metrics {

// What a score must be given, as bits of an OR.
using Needs = uint32_t;
constexpr Needs kNeedsCodes = 1U << 0U;    // both pictures as sRGB code values of 8 or 16 bits
constexpr Needs kNeedsLinear = 1U << 1U;   // both pictures as floats
constexpr Needs kNeedsIds = 1U << 2U;      // both id buffers
constexpr Needs kNeedsDepth = 1U << 3U;    // both depth buffers
constexpr Needs kNeedsRegion = 1U << 4U;   // the pixels that count
constexpr Needs kNeedsFrames = 1U << 5U;   // successive frames (Score::over_time)
constexpr Needs kNeedsDisplay = 1U << 6U;  // where the pictures are looked at (metrics/display.h)
// "code values, ids": for people.
std::string needs_text(Needs needs);

// What was drawn for one side of a comparison: buffers of one size, borrowed, each absent where there is none.
struct Buffers {
  const Image8* codes = nullptr;     // sRGB-encoded; alpha is ignored
  const Image16* codes16 = nullptr;  // in place of `codes`
  const ImageF* linear = nullptr;    // linear light, or whatever unit the file is in
  const ImageU32* ids = nullptr;     // one channel: agent index + 1, 0 = nothing
  const ImageF* depth = nullptr;     // one channel: eye-space metres, +infinity where empty
};

// Two pictures. Everything that is given has one size, or scores throw Error.
struct ScoreInput {
  Buffers reference;
  Buffers test;
  const Mask* region = nullptr;      // the pixels that scores of Scope::region count; none: every pixel
  const Display* display = nullptr;  //
  // `display` was chosen by nobody: it is there for scores that cannot do without one, and a score with a default of
  // its own keeps to that.
  bool display_is_default = false;
  double fps = 0;                        // of successive frames; 0: not known
  Padding padding = Padding::replicate;  // what stands for the frames before the first
  bool maps = false;                     // fill ScoreResult::map where the score has one
};
// The input's pictures are looked at there; borrows.
void look_at(const ChosenDisplay& chosen, ScoreInput& input);
// The needs that the input meets; both sides must have a buffer for it to count. Never kNeedsFrames.
Needs given(const ScoreInput& input);

// Intermediate results that several scores use (luma, the SSIM map, silhouettes): each is made at its first use and
// kept. One for each ScoreInput.
class Shared {
 public:
  // The T of this input, by make() at the first call; T names what it is, so each use has a type of its own.
  template <typename T, typename Make>
  const T& get(const Make& make) {
    std::shared_ptr<void>& place = kept_[std::type_index(typeid(T))];
    if (!place) place = std::make_shared<T>(make());
    return *static_cast<const T*>(place.get());
  }

 private:
  std::map<std::type_index, std::shared_ptr<void>> kept_;
};

// A value a pixel, and the range that its picture is coloured over.
struct ScoreMap {
  Plane values;           // NaN where there is none, drawn as `equal`
  int left = 0, top = 0;  // the pixel of `values`' first element: a map may be smaller than its pictures
  double equal = 0;       // drawn dark blue: no difference
  double worst = 1;       // drawn red; values beyond are drawn as the nearer end
  std::string unit;       // "code values"; empty for a pure number
  bool open = false;      // values may lie beyond `worst`: the bar's end says so, and the caption where some do
};

// A picture beside a score's map that the score's source draws.
struct ScoreDrawing {
  std::string file;   // without ending
  std::string title;  // for people: what its values are
  ScoreMap map;
  const ColourTable* colours = nullptr;  // the source's
};

// How a figure of every frame becomes one of the whole sequence.
enum class OverFrames : uint8_t { mean, least, greatest };
struct ScoreFigure {
  std::string name;  // "weighted_median"; [a-z0-9_]
  double value = 0;
  OverFrames over_frames = OverFrames::mean;
};

struct ScoreResult {
  std::optional<double> value;  // never NaN; infinite where the score's range says so
  std::string reason;           // why there is no value; empty where there is one
  // There is none because pixels are not numbers or infinite: what is pooled over such a picture is no score either.
  bool not_finite = false;
  std::string conditions;  // what it was computed under, where that is a choice: "67.02 pixels/degree"
  // Where the score's source pools one map by several rules: each by its name ("mean", "weighted_median"), that of
  // `value` among them. Else empty.
  std::vector<ScoreFigure> pooled;
  // Further figures that explain `value` and are not other poolings of it: parts by channel, what was chosen.
  std::vector<ScoreFigure> details;
  std::optional<ScoreMap> map;
  // Over time: what each frame adds, as the value of a clip whose frames all add as much; nothing for a frame that adds
  // none (a second difference has none in the first two). Empty where the score has no such figures. `map` is then that
  // of the first frame of the worst value.
  std::vector<std::optional<double>> by_frame;
  std::vector<ScoreDrawing> drawings;  // with ScoreInput::maps
};
// Not available, because ...
ScoreResult absent(std::string reason);
// The same, because pixels are not finite.
ScoreResult absent_not_finite(std::string reason);

// The pixels that carry one agent's id in the reference or in the test, in reading order.
struct AgentPixels {
  uint32_t id = 0;
  std::vector<std::pair<int, int>> pixels;  // x, y; at least one
};

// A score while successive frames are shown to it, in order and one at a time: a clip need not fit in memory.
struct FrameScore {
  std::function<void(const ScoreInput&, Shared&)> take;  // borrows the frame for the call; all frames of one size
  std::function<ScoreResult()> finish;
};

enum class Direction : uint8_t { higher_is_better, lower_is_better };
enum class Scope : uint8_t {
  picture,  // the whole of the pictures that it is given
  region    // ScoreInput::region, where there is one
};

// What a score is used for besides being listed, as bits of an OR.
using Uses = uint32_t;
constexpr Uses kInTables = 1U << 0U;  // a column of the tables in a terminal, which have no room for all
constexpr Uses kHeadline = 1U << 1U;  // said in the report's answer and under its pictures; the first is its tile
constexpr Uses kCharted = 1U << 2U;   // the report draws it against the height of the figure
constexpr Uses kRanking = 1U << 3U;   // the one by which the worst of many is found (one score of the table)
constexpr Uses kByCause = 1U << 4U;   // `quality --causes` says in it what each kind of wrong pixel costs (one score)

struct Score {
  std::string_view name;    // for ever: key in JSON, CSV and the result store; [a-z0-9_]
  std::string_view title;   // for people, in the middle of a sentence: "SSIM in the figure"
  std::string_view column;  // head of a column in a terminal, at most 9 characters
  std::string_view unit;    // "dB"; empty for a pure number
  Direction direction = Direction::higher_is_better;
  int digits = 3;                  // after the point, for people
  double least = 0, greatest = 0;  // range; the better end of it is what two equal pictures score
  // Taken to pass unseen where nobody says how good a picture must be (one score of the table).
  std::optional<double> threshold = std::nullopt;
  Needs needs = 0;
  Scope scope = Scope::picture;
  Uses uses = 0;
  std::string_view computes;  // the formula in a line
  std::string_view source;    // publication
  std::string_view absence;   // when the score does not exist though its needs are met; empty: never
  std::string_view map_file;  // of a picture of its map, without ending; empty: no map

  // Two pictures. Called with its needs met. nullptr: only over time.
  ScoreResult (*compute)(const ScoreInput& input, Shared& shared) = nullptr;
  // Successive frames. nullptr: each frame by itself.
  FrameScore (*over_time)() = nullptr;
  // The same over one agent's pixels of the whole pictures; nothing where it does not exist. Called with ids, and its
  // needs but kNeedsRegion met. nullptr: not defined for an agent.
  std::optional<double> (*by_agent)(const ScoreInput& input, Shared& shared, const AgentPixels& agent) = nullptr;
  // In which the score's source paints its map; nullptr: error_colours().
  const ColourTable& (*colours)() = nullptr;
};

using ScoreTable = std::span<const Score* const>;
// Every score, in the order in which people read them.
ScoreTable scores();
// By kRanking; the first score of a table that has none. A table without scores is a bug and asserts.
const Score& ranking_score(ScoreTable table);
// By kByCause; nullptr where the table has none.
const Score* score_by_cause(ScoreTable table);
// By `threshold`; nullptr where the table has none.
const Score* score_of_threshold(ScoreTable table);
// What two equal pictures score: the better end of the range.
double best_value(const Score& score);
// Whether value `a` is worse than `b`.
bool is_worse(const Score& score, double a, double b);
// A score of the silhouettes alone, or of one agent, stands among its like: its name without "silhouette_".
std::string_view name_among_silhouettes(const Score& score);

struct Scored {
  const Score* score = nullptr;
  ScoreResult result;
};
// The scores of the table, in its order, whose needs the input meets together with `also`; where one of `also` is not
// there, its scores are absent and say so. A value that is not a number becomes absent too. Throws Error on sizes that
// differ.
std::vector<Scored> score_pictures(ScoreTable table, const ScoreInput& input, Shared& shared, Needs also = 0);
// The scores that such an input has, all absent for one reason.
std::vector<Scored> absent_scores(ScoreTable table, Needs needs, const std::string& reason);

// The scores of a table that are over time, while frames are shown to them.
class ClipScores {
 public:
  explicit ClipScores(ScoreTable table);
  // As score_pictures; scores whose needs the first frame does not meet are left out.
  void take(const ScoreInput& frame);
  std::vector<Scored> finish() const;
  size_t frames() const { return frames_; }

 private:
  ScoreTable table_;
  std::vector<std::pair<const Score*, FrameScore>> running_;
  size_t frames_ = 0;
};

// For people: the value at the score's digits, "inf", or "-" where there is none.
std::string value_text(const Score& score, const std::optional<double>& value);

// How a map is painted, with a colour bar below that names score, unit, range and value, and the pixels that the map
// has where these are not all of the picture's: as the score's source does (Score::colours), in dark blue to red
// (error_colours()), or in a perceptually uniform table. `plain`: as the source does, without a bar, a pixel a value.
enum class MapColours : uint8_t { own, plain, error, magma, viridis };
// The map of a result that has one, as a picture. RGB.
Image8 map_picture(const Score& score, const ScoreResult& result, MapColours colours = MapColours::own);
Image8 drawing_picture(const ScoreDrawing& drawing, MapColours colours = MapColours::own);
// The mean of a map over the pixels of an agent that it covers, NaN left out; nothing where there is none. left, top:
// the pixel of the map's first element.
std::optional<double> mean_over(const Plane& map, int left, int top, const AgentPixels& agent);

// Every score of the table with what is said of it above, as Markdown.
std::string scores_markdown(ScoreTable table);

}  // namespace crowdbench::metrics
