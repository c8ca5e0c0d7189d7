#include "bench/experiments/quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <tuple>

#include "bench/commands/cause_output.h"
#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "bench/commands/score_commands.h"
#include "bench/commands/score_json.h"
#include "bench/experiments/bench_run.h"
#include "bench/experiments/cause_rows.h"
#include "bench/experiments/quality_rows.h"
#include "bench/experiments/score_rows.h"
#include "bench/stage/truth_capture.h"
#include "bench/timing/run_facts.h"
#include "core/command_line.h"
#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "core/image_io.h"
#include "core/json.h"
#include "core/progress.h"
#include "renderers/gl/context.h"
#include "scene/cast/open_character.h"
#include "scene/gltf/gltf.h"

namespace crowdbench::bench {
namespace {

struct QualityOptions {
  std::vector<std::string> representations;
  std::string reference;
  std::string debug;
  CharacterOptions character;
  std::string heights = "120";
  std::string azimuths = "0";
  std::string elevations = "0";
  std::string clip;
  std::string times;
  std::string maps;
  std::string display;
  std::string results;
  std::string device;
  AntialiasingOptions antialiasing;
  uint64_t bake_budget_mib = kDefaultBakeBudgetMiB;
  int rows = 480;
  bool exact_pose = false;
  bool flicker = false;
  bool orbit = false;
  bool no_cache = false;
  bool causes = false;
  bool json = false;
};

// Representations as parts of file names: letters, digits and . = - stay, the rest becomes _. Long texts are cut, and
// those that then look alike get some digits of the text's hash.
std::vector<std::string> file_names(const std::vector<std::string>& representations) {
  constexpr size_t kLongest = 80;
  std::vector<std::string> names;
  for (const std::string& text : representations) {
    std::string name;
    for (const char c : text.substr(0, kLongest))
      name +=
          (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '=' || c == '-'
              ? c
              : '_';
    names.push_back(std::move(name));
  }
  std::vector<std::string> out = names;
  for (size_t i = 0; i < names.size(); ++i)
    if (representations[i].size() > kLongest || std::count(names.begin(), names.end(), names[i]) > 1)
      out[i] += "-" + sha256_hex(representations[i]).substr(0, 8);
  return out;
}

// Two pictures of one height next to each other, four grey pixels between them.
Image8 side_by_side(const Image8& a, const Image8& b) {
  constexpr int kGap = 4;
  Image8 out(a.width + kGap + b.width, a.height, 3);
  std::fill(out.data.begin(), out.data.end(), uint8_t{64});
  for (int y = 0; y < a.height; ++y)
    for (const auto& [picture, left] : {std::pair{&a, 0}, std::pair{&b, a.width + kGap}})
      for (int x = 0; x < picture->width; ++x) std::copy_n(picture->at(x, y), 3, out.at(left + x, y));
  return out;
}

// "relief_map=64_h120_a45_e0_t0.25": which representation, height, azimuth, elevation and time.
std::string stem(const std::string& representation, const QualityView& view) {
  return fmt::format("{}_h{}_a{}_e{}_t{}", representation, view.height_px, view.azimuth_deg, view.elevation_deg,
                     view.time);
}

void write_maps(const std::filesystem::path& folder, const std::string& name, const QualityRow& row,
                const QualityPictures& pictures) {
  if (!row.scores.box) return;
  const Image8 reference = metrics::crop(pictures.reference.colour, *row.scores.box);
  const Image8 test = metrics::crop(pictures.test.colour, *row.scores.box);
  write_png(folder / (name + "_reference.png"), reference);
  write_png(folder / (name + "_test.png"), test);
  write_png(folder / (name + "_side_by_side.png"), side_by_side(reference, test));
  for (const auto& [score, result] : row.scores.scores)
    if (result.map)
      write_png(folder / fmt::format("{}_{}.png", name, score->map_file), metrics::map_picture(*score, result));
  for (size_t i = 0; i < pictures.steps.size(); ++i) {
    const metrics::CauseStep& step = pictures.steps[i];
    write_png(folder / fmt::format("{}_cause{}_{}.png", name, i + 1,
                                   step.cause ? metrics::doc_of(*step.cause).name : "residue"),
              metrics::crop(step.codes, *row.scores.box));
  }
}

// One view through the times, in their order: representation, height, elevation, azimuth. Of an orbit one time through
// the azimuths: the time in place of the azimuth.
using FilmKey = std::tuple<size_t, double, double, double>;
using Films = std::map<FilmKey, metrics::ClipScores>;

void add_to_films(Films& films, const QualityRow& row, const QualityPictures& pictures, metrics::ScoreTable table,
                  bool orbit, const metrics::ChosenDisplay& display) {
  const FilmKey key(row.index, row.view.height_px, row.view.elevation_deg,
                    orbit ? row.view.time : row.view.azimuth_deg);
  const metrics::Mask either =
      metrics::union_of(metrics::mask_of(pictures.reference.ids), metrics::mask_of(pictures.test.ids));
  metrics::ScoreInput frame{buffers_of(pictures.reference), buffers_of(pictures.test)};
  frame.region = &either;
  metrics::look_at(display, frame);
  films.try_emplace(key, table).first->second.take(frame);
}

// What is asked of compute_quality, and what the times and the clip of its views are called.
struct Asked {
  QualitySetup setup;
  scene::CharacterEntry entry;
  std::string clip;
  size_t times = 0;
  size_t azimuths = 0;
  bool orbit = false;  // azimuths as successive frames, not times
};

// What dominates a representation's error, over its views.
std::vector<CauseRange> ranges_of(const std::vector<QualityRow>& rows, size_t index) {
  std::vector<CauseUnit> units;
  for (size_t i = 0; i < rows.size(); ++i)
    if (rows[i].index == index && rows[i].errors) units.push_back({rows[i].view.height_px, i, rows[i].errors->whole});
  constexpr uint64_t kSeed = 1;
  return causes_by_height(units, kSeed);
}

// The result file of --db, and the run in it.
class Results {
 public:
  Results(const std::string& file, gl::Context& context, const Asked& asked)
      : store_(file), subject_{asked.setup.character->name, asked.clip}, display_(asked.setup.display) {
    scene::Scenario scenario;
    scenario.name = "quality";
    scenario.characters = {asked.entry};
    run_ = store_.write(describe_run(context, choose_timing_method(context), scenario, "quality", command_line()));
    store_.begin();
    write_legend(store_, run_);
  }
  void add(const QualityRow& row, const QualityPictures& pictures) {
    write_quality_pictures(store_, run_, store_.write(quality_row(run_, subject_, row, display_)), row, pictures);
  }
  // Those that were refused are kept too, with the reason. All are kept, or none.
  void finish(const std::vector<QualityRow>& rows, const Asked& asked) {
    for (const QualityRow& row : rows)
      if (!row.refused.empty()) store_.write(quality_row(run_, subject_, row, display_));
    if (asked.setup.causes)
      for (size_t index = 0; index < asked.setup.representations.size(); ++index)
        for (const CauseRangeRow& row : cause_rows(
                 run_, {asked.setup.representations[index], renderers::reference_spec().text(), subject_.character},
                 ranges_of(rows, index), "view"))
          store_.write(row);
    store_.commit();
  }

 private:
  StoreWriter store_;
  QualitySubject subject_;
  metrics::ChosenDisplay display_;
  int64_t run_ = 0;
};

// With an exact pose every view has a bake of its own moment, which is its only stored frame.
void say_what_exact_poses_hide(const std::vector<renderers::Spec>& specs) {
  for (const renderers::Spec& spec : specs) {
    for (const auto& [key, value] : spec.options)
      if (key.starts_with("frames"))
        fmt::print(
            stderr,
            "crowdbench: note: {}: {}={} shows nothing with --exact-pose, where the exact time is the one stored "
            "frame; leave --exact-pose out\n",
            printable(spec.name), key, printable(value));
    say_what_exact_poses_hide(spec.components);
  }
}

Asked read_options(const QualityOptions& options, metrics::ScoreTable table) {
  if (options.flicker && options.exact_pose)
    throw Error("--flicker", "an exact pose has no frames between which it could jump", "leave --exact-pose out");
  const std::string drawn = renderers::reference_spec().text();
  if (!options.reference.empty() && options.reference != kTruthName && options.reference != drawn)
    throw Error("--reference", fmt::format("'{}' is not a reference", printable(options.reference)),
                fmt::format("use {} or {}", drawn, kTruthName));
  if (options.reference == kTruthName && options.causes)
    throw Error("--causes", "causes are told apart by what is drawn, and the truth is not", "leave --reference out");
  Asked asked;
  QualitySetup& setup = asked.setup;
  setup.truth = options.reference == kTruthName;
  // A text that cannot be read is refused before anything is drawn.
  const std::vector<renderers::Spec> specs = parse_representations(options.representations);
  if (options.exact_pose) say_what_exact_poses_hide(specs);
  for (const renderers::Spec& spec : specs) setup.representations.push_back(spec.text());
  setup.debug = options.debug;
  setup.display = display_of_option(options.display);
  scene::CharacterEntry entry = options.character.entry();
  if (!options.clip.empty()) entry.clips = {options.clip};
  setup.character = std::make_shared<const scene::Character>(scene::open_character(entry));
  print_warnings(*setup.character);
  asked.entry = entry;
  const scene::Character& character = *setup.character;
  setup.rows = options.rows;
  setup.exact_pose = options.exact_pose;
  setup.use_cache = !options.no_cache;
  setup.causes = options.causes;
  setup.read_causes = options.json;
  setup.maps = !options.maps.empty();
  setup.table = table;
  options.antialiasing.change(setup.antialiasing);
  setup.bake_budget = options.bake_budget_mib << 20;

  QualityView view;
  view.clip =
      options.clip.empty() ? character.placement.default_clip : scene::require_clip_or_none(character, options.clip);
  asked.clip = view.clip < 0 ? "none" : character.clips[static_cast<size_t>(view.clip)].name;
  const double start = view.clip < 0 ? 0.0 : character.clips[static_cast<size_t>(view.clip)].start;
  const std::vector<double> times =
      options.times.empty() ? std::vector<double>{start} : parse_numbers(options.times, "--time", -1e6, 1e6);
  asked.times = times.size();
  asked.orbit = options.orbit;
  std::vector<double> azimuths;
  for (const double a : parse_numbers(options.azimuths, "--azimuth-deg", -3600, 3600))
    if (std::none_of(azimuths.begin(), azimuths.end(),
                     [&](double b) { return std::abs(std::remainder(a - b, 360.0)) < 1e-9; }))
      azimuths.push_back(a);
  asked.azimuths = azimuths.size();
  for (const double time : times)
    for (const double height : parse_numbers(options.heights, "--height-px", 4, 4096))
      for (const double elevation : parse_numbers(options.elevations, "--elevation-deg", -90, 90))
        for (const double azimuth : azimuths) {
          view.time = time;
          view.height_px = height;
          view.elevation_deg = elevation;
          view.azimuth_deg = azimuth;
          setup.views.push_back(view);
        }
  return asked;
}

Json row_json(const QualityRow& row, const Asked& asked) {
  Json out = {{"representation", row.representation},
              {"height_px", row.view.height_px},
              {"azimuth_deg", row.view.azimuth_deg},
              {"elevation_deg", row.view.elevation_deg},
              {"clip", asked.clip},
              {"time", row.view.time},
              {"phase", row.phase},
              {"distance_m", row.distance}};
  Json reasons = Json::object();
  put_scores(out, reasons, row.scores.scores);
  if (!reasons.empty()) out["reasons"] = reasons;
  if (!row.refused.empty()) out["refused"] = row.refused;
  if (row.errors) {
    out["causes"] = causes_json(*row.errors, {}, false);
    out["causes"]["told_by"] = asked.setup.causes ? "drawing" : "comparing";
  }
  if (const metrics::Score* score = metrics::score_by_cause(asked.setup.table); score && asked.setup.causes)
    out[std::string(score->name) + "_if_right"] = {{"silhouette", json_number(row.causes.silhouette)},
                                                   {"surface", json_number(row.causes.surface)},
                                                   {"shading", json_number(row.causes.shading)}};
  return out;
}

Json all_causes_json(const std::vector<QualityRow>& rows, const Asked& asked) {
  Json out = Json::array();
  for (size_t index = 0; index < asked.setup.representations.size(); ++index) {
    const std::vector<CauseRange> ranges = ranges_of(rows, index);
    if (ranges.empty()) continue;
    out.push_back({{"representation", asked.setup.representations[index]},
                   {"by_height", cause_ranges_json(ranges)},
                   {"words", cause_words(ranges, "view")}});
  }
  return out;
}

// A list for each score over time, under its name.
void put_films(Json& out, const Films& films, const Asked& asked) {
  for (const auto& [key, film] : films) {
    const auto& [index, height, elevation, held] = key;
    for (const auto& [score, result] : film.finish()) {
      const std::string name(score->name);
      out[name].push_back({{"representation", asked.setup.representations[index]},
                           {"height_px", height},
                           {"elevation_deg", elevation},
                           {asked.orbit ? "time" : "azimuth_deg", held},
                           {"frames", film.frames()},
                           {name, score_json(result)}});
      if (!result.value) out[name].back()["reason"] = result.reason;
    }
  }
}

std::string reference_name(const Asked& asked) {
  return asked.setup.truth ? kTruthName : renderers::reference_spec().text();
}

void print_json(const std::vector<QualityRow>& rows, const Films& films, const Asked& asked,
                const std::string& renderer) {
  Json out = {{"representations", asked.setup.representations},
              {"character", asked.setup.character->name},
              {"renderer", renderer},
              {"reference", reference_name(asked)},
              {"exact_pose", asked.setup.exact_pose},
              {"display", display_json(asked.setup.display)}};
  out["rows"] = Json::array();
  for (const QualityRow& row : rows) out["rows"].push_back(row_json(row, asked));
  if (asked.setup.causes) out["causes"] = all_causes_json(rows, asked);
  put_films(out, films, asked);
  fmt::print("{}\n", out.dump(2));
}

void print_scores(const QualityRow& row, const Asked& asked) {
  fmt::print("{:>7g} {:>7g} {:>7g} {:>7.3f} |", row.view.height_px, row.view.azimuth_deg, row.view.elevation_deg,
             row.view.time);
  if (!row.refused.empty()) {
    fmt::print(" refused: {}\n", row.refused);
    return;
  }
  for (const auto& [score, result] : row.scores.scores)
    if ((score->uses & metrics::kInTables) != 0) fmt::print(" {:>9}", metrics::value_text(*score, result.value));
  if (const metrics::Score* score = metrics::score_by_cause(asked.setup.table); score && asked.setup.causes)
    fmt::print(" | {} with the mesh's silhouette {}, surface {}, shading {}", score->title,
               metrics::value_text(*score, row.causes.silhouette), metrics::value_text(*score, row.causes.surface),
               metrics::value_text(*score, row.causes.shading));
  fmt::print("\n");
  if (row.errors)
    fmt::print("{:>32}| squared error {}: {}\n", "", row.errors->whole.total, cause_shares_text(row.errors->whole));
}

// What dominates each representation's error, and what could not be told.
void print_cause_words(const std::vector<QualityRow>& rows, const Asked& asked) {
  for (size_t index = 0; index < asked.setup.representations.size(); ++index) {
    const std::vector<CauseRange> ranges = ranges_of(rows, index);
    if (ranges.empty()) continue;
    fmt::print("\n{}: the error is dominated by: {}\n", asked.setup.representations[index],
               cause_words(ranges, "view"));
    const auto told =
        std::find_if(rows.begin(), rows.end(), [&](const QualityRow& row) { return row.index == index && row.errors; });
    print_untold(*told->errors);
  }
}

void print_films(const Films& films, const Asked& asked) {
  for (const auto& [key, film] : films) {
    const auto& [index, height, elevation, held] = key;
    for (const auto& [score, result] : film.finish())
      fmt::print("{:>7g} {:>7} {:>7g} | {} {}{}{}, {}\n", height,
                 asked.orbit ? std::string("all") : fmt::format("{:g}", held), elevation, score->title,
                 metrics::value_text(*score, result.value), score->unit.empty() ? "" : " ", score->unit,
                 asked.setup.representations[index]);
  }
}

void print_text(const std::vector<QualityRow>& rows, const Films& films, const Asked& asked,
                const std::string& renderer) {
  fmt::print("{}, clip {}, against the {} at the same view; {}\n", asked.setup.character->name, printable(asked.clip),
             reference_name(asked), renderer);
  std::optional<size_t> shown;
  for (const QualityRow& row : rows) {
    if (row.index != shown) {
      shown = row.index;
      fmt::print("{}\n{:>7} {:>7} {:>7} {:>7} |", row.representation, "height", "azimuth", "elev", "time");
      for (const auto& [score, result] : row.scores.scores)
        if ((score->uses & metrics::kInTables) != 0) fmt::print(" {:>9}", score->column);
      fmt::print("\n");
    }
    print_scores(row, asked);
  }
  print_cause_words(rows, asked);
  fmt::print("display {}\n", display_line(asked.setup.display));
  if (films.empty()) return;
  fmt::print("\nover {} {} as successive frames, over the silhouettes\n", asked.orbit ? asked.azimuths : asked.times,
             asked.orbit ? "azimuths" : "times");
  print_films(films, asked);
}

int run_quality(const QualityOptions& options, metrics::ScoreTable table) {
  const Asked asked = read_options(options, table);
  const std::vector<std::string> names = file_names(asked.setup.representations);
  if (!options.maps.empty()) make_folder(options.maps);
  gl::Context context({.device = options.device});
  std::optional<Results> results;
  if (!options.results.empty()) results.emplace(options.results, context, asked);
  Films films;
  std::vector<QualityRow> rows;
  {
    Progress progress("quality", asked.setup.views.size() * asked.setup.representations.size());
    rows = compute_quality(context, asked.setup, [&](const QualityRow& row, const QualityPictures& pictures) {
      if (options.flicker || options.orbit)
        add_to_films(films, row, pictures, table, options.orbit, asked.setup.display);
      if (!options.maps.empty()) write_maps(options.maps, stem(names[row.index], row.view), row, pictures);
      if (results) results->add(row, pictures);
      progress.advance();
    });
  }
  if (results) results->finish(rows, asked);
  if (options.json)
    print_json(rows, films, asked, context.renderer());
  else
    print_text(rows, films, asked, context.renderer());
  return std::all_of(rows.begin(), rows.end(), [](const QualityRow& row) { return row.refused.empty(); }) ? 0 : 1;
}

void add_reference_option(Command& command, std::string& reference) {
  command
      .add_option("--reference", reference,
                  fmt::format("what it is held against: {} (the default), or {}: rays cast in double precision at the\n"
                              "exact pose, on the CPU, by which the mesh itself can be judged",
                              renderers::reference_spec().text(), kTruthName))
      ->type_name("NAME");
}

}  // namespace

void add_quality(Command& app, Run& run) { add_quality(app, run, metrics::scores()); }

void add_quality(Command& app, Run& run, metrics::ScoreTable table) {
  Command* command =
      app.add_subcommand("quality", "Score one agent, drawn by a representation, against the mesh at the same view");
  command->footer(
      "Vertical field of view 30 degrees, background sRGB 128, light fixed to the scene. Lists (30,60,120) and ranges\n"
      "(0:315:45) give a row each. Scores are over the crop around both silhouettes, or the pixels of either;\n"
      "`crowdbench schema --scores` says what each is.\n"
      "The mesh shows the exact time; the representation shows the frame that it stored for it, unless "
      "--exact-pose.\n"
      "A representation that cannot be baked or drawn has rows that say why, and the status is 1; 2 where all are "
      "refused.\n\n"
      "Examples:\n"
      "  crowdbench quality --representation flat\n"
      "  crowdbench quality --representation flat --height-px 30,60,120 --azimuth-deg 0:315:45 --elevation-deg 0,30\n"
      "  crowdbench quality --representation flat --azimuth-deg 0:60:1 --elevation-deg 12 --time 0.2 --orbit\n"
      "  crowdbench quality --representation flat:views=hemi-12 --clip walk --time 0.25 --maps maps --json\n"
      "  crowdbench quality --representation mesh --reference truth --supersample 3");
  auto options = std::make_shared<QualityOptions>();
  add_representation_option(*command, options->representations, "what is judged")->required();
  add_reference_option(*command, options->reference);
  add_character_options(*command, options->character);
  const auto add_list = [&](const char* name, std::string& list, const char* text) {
    command->add_option(name, list, text)->type_name("LIST")->capture_default_str();
  };
  add_list("--height-px", options->heights,
           "rows that the figure spans in its clip's first pose, seen level, 4 to 4096; of tips thinner than\n"
           "a pixel the samples of a picture may miss some");
  add_list("--azimuth-deg", options->azimuths, "0 = from the front, 90 = from the character's left");
  add_list("--elevation-deg", options->elevations, "0 = level, 90 = from straight above");
  add_clip_option(*command, options->clip);
  add_list("--time", options->times, "seconds on the file's own axis (the clip's start)");
  command
      ->add_option("--maps", options->maps,
                   "a folder for the pictures and the scores' maps, named by representation, height and view; made "
                   "where missing")
      ->type_name("DIR")
      ->output_folder();
  command->add_option(
      "--debug", options->debug,
      "a debug view of the representation instead of its picture, for --maps:\n" + renderers::debug_views_of_all());
  command->add_option("--rows", options->rows, "rows of the picture, 4:3; taller figures get a larger one")
      ->type_name("N")
      ->capture_default_str()
      ->whole_number(16, 8192);
  auto* flicker =
      command->add_flag("--flicker", options->flicker,
                        "also the scores over time of each view, with the times as successive frames (three at least)");
  command
      ->add_flag(
          "--orbit", options->orbit,
          "also the scores over time of each time, with the azimuths as successive frames: what a change of the\n"
          "stored view shows to an eye that goes round the figure")
      ->excludes(flicker);
  command->add_flag("--exact-pose", options->exact_pose,
                    "the representation too is given the exact time, as its only stored frame");
  command->add_flag(
      "--causes", options->causes,
      "the squared error by cause (`schema --results` says how: stored frame, stored view, order, silhouette,\n"
      "surface, shading, texture, size class; with --maps its pictures), and ssim had the pixels of one\n"
      "kind been the mesh's own: outside one silhouette, on another surface, otherwise shaded");
  add_display_option(*command, options->display);
  add_results_option(*command, options->results);
  add_antialiasing_options(*command, options->antialiasing);
  add_bake_options(*command, options->bake_budget_mib, &options->no_cache);
  add_device_option(*command, options->device);
  add_json_option(*command, options->json);
  command->callback([options, table, &run] { run = [options, table] { return run_quality(*options, table); }; });
}

}  // namespace crowdbench::bench
