#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "bench/commands/score_bounds.h"
#include "bench/commands/score_commands.h"
#include "bench/commands/score_json.h"
#include "bench/experiments/pop_map.h"
#include "bench/experiments/score_rows.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "core/json.h"
#include "core/progress.h"
#include "core/version.h"
#include "metrics/heat_map.h"
#include "metrics/pseudocolour.h"
#include "renderers/gl/context.h"
#include "reports/page/pop_page.h"
#include "scene/gltf/gltf.h"
#include "scene/pose/normalise.h"

namespace crowdbench::bench {
namespace {

struct PopmapOptions {
  std::string representation = renderers::default_impostor().text();
  CharacterOptions character;
  std::string clip;
  std::string azimuths = "0:337.5:22.5";
  std::string elevations = "0:30:10";
  std::string phases = "0.025:0.975:0.25";
  std::string ratios = "0.5,1,2";
  std::string heights;
  std::string scores;
  std::string display;
  std::string out;
  std::string device;
  int fade = 4;
  AntialiasingOptions antialiasing;
  uint64_t bake_budget_mib = kDefaultBakeBudgetMiB;
  bool no_cache = false;
  bool json = false;
};

using Scores = std::vector<const metrics::Score*>;

Json to_json(const PopCell& cell, const Scores& scores) {
  const auto values = [&](const PopScores& s) {
    Json out = Json::object();
    for (const auto& [prefix, of_kind] : {std::pair("", &s.cut), std::pair("fade_step_", &s.fade_step)})
      for (size_t i = 0; i < scores.size(); ++i)
        out[prefix + std::string(scores[i]->name)] = json_number((*of_kind)[i]);
    return out;
  };
  return {{"ratio", cell.ratio > 0 ? Json(cell.ratio) : Json(nullptr)},
          {"height_px", cell.height_px},
          {"azimuth_deg", cell.azimuth_deg},
          {"elevation_deg", cell.elevation_deg},
          {"phase", cell.phase},
          {"shown_phase", cell.shown_phase},
          {"own_pose", values(cell.own)},
          {"matched_pose", values(cell.matched)}};
}

struct SwitchKind {
  bool matched, fade;
  const char* key;
  const char* text;
};
constexpr SwitchKind kSwitchKinds[] = {{false, false, "own_cut", "own pose, cut"},
                                       {false, true, "own_fade", "own pose, fade step"},
                                       {true, false, "matched_cut", "matched pose, cut"},
                                       {true, true, "matched_fade", "matched pose, fade step"}};

// Cells of one size.
std::vector<std::vector<PopCell>> by_size(const std::vector<PopCell>& cells) {
  std::vector<std::vector<PopCell>> out;
  for (const PopCell& cell : cells) {
    if (out.empty() || out.back().back().height_px != cell.height_px) out.emplace_back();
    out.back().push_back(cell);
  }
  return out;
}

std::string size_text(const PopCell& cell) {
  return cell.ratio > 0 ? fmt::format("{:.3g} px/texel, {:.0f} px tall", cell.ratio, cell.height_px)
                        : fmt::format("{:.0f} px tall", cell.height_px);
}

Json statistics_json(const std::vector<PopCell>& cells, const Scores& scores) {
  Json out = Json::object();
  for (const SwitchKind& kind : kSwitchKinds)
    for (size_t i = 0; i < scores.size(); ++i) {
      Json& place = out[kind.key][std::string(scores[i]->name)];
      const auto s = summarise_pops(cells, *scores[i], i, kind.matched, kind.fade);
      if (!s) {
        place = nullptr;
        continue;
      }
      const PopCell& worst = cells[s->worst_cell];
      place = {{"mean", json_number(s->mean)},
               {tail_name(*scores[i]), json_number(s->tail)},
               {"worst", json_number(s->worst)},
               {"worst_at",
                {{"azimuth_deg", worst.azimuth_deg},
                 {"elevation_deg", worst.elevation_deg},
                 {"phase", worst.phase},
                 {"height_px", worst.height_px}}}};
    }
  return out;
}

std::string csv(const std::vector<PopCell>& cells, const Scores& scores) {
  std::string out = "ratio,height_px,azimuth_deg,elevation_deg,phase,shown_phase";
  for (const char* pose : {"own_", "matched_"})
    for (const char* kind : {"", "fade_step_"})
      for (const metrics::Score* score : scores) out += fmt::format(",{}{}{}", pose, kind, score->name);
  out += "\n";
  for (const PopCell& c : cells) {
    out += fmt::format("{},{},{},{},{},{}", c.ratio > 0 ? fmt::format("{}", c.ratio) : "", c.height_px, c.azimuth_deg,
                       c.elevation_deg, c.phase, c.shown_phase);
    for (const PopScores* s : {&c.own, &c.matched})
      for (const auto* of_kind : {&s->cut, &s->fade_step})
        for (const std::optional<double>& v : *of_kind) out += v ? fmt::format(",{}", *v) : ",";
    out += "\n";
  }
  return out;
}

// Means of a score over the phases, elevation upwards, azimuth to the right: a panel a size and kind of switch.
Image8 draw_heat_map(const std::vector<PopCell>& cells, const PopRequest& request, const metrics::Score& score,
                     size_t place) {
  std::vector<std::vector<metrics::HeatPanel>> panels;
  double high = 0;
  std::vector<double> elevations = request.elevations_deg;
  std::sort(elevations.rbegin(), elevations.rend());
  for (const std::vector<PopCell>& size : by_size(cells)) {
    std::vector<metrics::HeatPanel> row;
    for (const SwitchKind& kind : kSwitchKinds) {
      if (kind.fade) continue;
      metrics::HeatPanel panel;
      panel.title = fmt::format("{}: {}", size_text(size.front()), kind.text);
      for (const double a : request.azimuths_deg) panel.columns.push_back(fmt::format("{:g}", a));
      for (const double e : elevations) {
        panel.rows.push_back(fmt::format("{:g}", e));
        for (const double a : request.azimuths_deg) {
          double sum = 0;
          int count = 0;
          for (const PopCell& cell : size)
            if (cell.azimuth_deg == a && cell.elevation_deg == e) {
              const std::optional<double>& value = (kind.matched ? cell.matched : cell.own).cut[place];
              sum += value.value_or(0);
              count += value ? 1 : 0;
            }
          panel.values.push_back(count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN());
          if (count > 0) high = std::max(high, panel.values.back());
        }
      }
      row.push_back(std::move(panel));
    }
    panels.push_back(std::move(row));
  }
  return metrics::heat_map(
      panels, high > 0 ? high : 1.0,
      fmt::format("{} over the silhouettes, {}{}mean of the phases; azimuth across, elevation up, degrees",
                  score.column, score.unit, score.unit.empty() ? "" : ", "));
}

// Mesh, impostor and their difference next to each other, cut to the figures.
Image8 draw_worst(const PopPictures& pictures) {
  const auto box = metrics::crop_box(metrics::mask_of(pictures.mesh.ids), metrics::mask_of(pictures.impostor.ids));
  if (!box) return Image8(1, 1, 3);
  const Image8 mesh = metrics::crop(pictures.mesh.colour, *box);
  const Image8 impostor = metrics::crop(pictures.impostor.colour, *box);
  const Image8 difference = metrics::pseudocolour(metrics::error_levels(mesh, impostor));
  // Shown large enough to be seen: whole multiples of a pixel.
  const int zoom = std::max(1, 360 / std::max(box->height, 1));
  Image8 out(3 * box->width * zoom + 8, box->height * zoom, 3);
  std::fill(out.data.begin(), out.data.end(), uint8_t{64});
  int left = 0;
  for (const Image8* picture : {&mesh, &impostor, &difference}) {
    for (int y = 0; y < box->height * zoom; ++y)
      for (int x = 0; x < box->width * zoom; ++x) std::copy_n(picture->at(x / zoom, y / zoom), 3, out.at(left + x, y));
    left += box->width * zoom + 4;
  }
  return metrics::with_colour_bar(out, "mesh, impostor, absolute difference (code values)");
}

// Pictures of a cell, cut to the figures.
struct Worst {
  std::optional<double> value;
  PopPictures pictures;
};

reports::PopPicture picture_of(const Image8& image, const metrics::Box& box, const std::string& caption) {
  const Image8 cut = metrics::crop(image, box);
  // Small figures are shown enlarged, by whole multiples so that their pixels stay what they are.
  const int zoom = std::max(1, 240 / std::max(box.height, 1));
  Image8 rgb(cut.width, cut.height, 3);
  for (int y = 0; y < cut.height; ++y)
    for (int x = 0; x < cut.width; ++x) std::copy_n(cut.at(x, y), 3, rgb.at(x, y));
  return {caption, rgb.width * zoom, rgb.height * zoom, encode_png(rgb)};
}

reports::PopPoint point_of(const PopCell& cell, const Scores& scores) {
  reports::PopPoint point{cell.ratio, cell.height_px, cell.azimuth_deg, cell.elevation_deg, cell.phase, {}};
  point.scores.resize(scores.size());
  for (size_t w = 0; w < std::size(kSwitchKinds); ++w) {
    const PopScores& of_pose = kSwitchKinds[w].matched ? cell.matched : cell.own;
    for (size_t i = 0; i < scores.size(); ++i)
      point.scores[i][w] = (kSwitchKinds[w].fade ? of_pose.fade_step : of_pose.cut)[i];
  }
  return point;
}

reports::PopSize page_size(const std::vector<PopCell>& cells, const Scores& scores, const PopPictures* pictures,
                           int fade) {
  static_assert(std::size(kSwitchKinds) == reports::kPopSwitchKinds);
  reports::PopSize size;
  for (const PopCell& cell : cells) size.points.push_back(point_of(cell, scores));
  size.summaries.resize(scores.size());
  for (size_t i = 0; i < scores.size(); ++i)
    for (size_t w = 0; w < std::size(kSwitchKinds); ++w)
      if (const auto s = summarise_pops(cells, *scores[i], i, kSwitchKinds[w].matched, kSwitchKinds[w].fade))
        size.summaries[i][w] = reports::PopSummary{s->mean, s->tail, s->worst, size.points[s->worst_cell]};
  if (pictures == nullptr) return size;
  const auto box = metrics::crop_box(metrics::mask_of(pictures->mesh.ids), metrics::mask_of(pictures->impostor.ids));
  if (!box) return size;
  size.worst = {
      picture_of(pictures->mesh.colour, *box, "mesh, own pose"),
      picture_of(pictures->matched.colour, *box, "mesh in the stored frame's pose"),
      picture_of(pictures->impostor.colour, *box, "impostor"),
      picture_of(metrics::pseudocolour(metrics::error_levels(pictures->mesh.colour, pictures->impostor.colour)), *box,
                 "own pose against impostor: dark blue equal, red the largest possible error")};
  const std::string bar_caption = "mean absolute difference, code values";
  const Image8 bar = metrics::colour_bar(220, bar_caption);
  size.worst.push_back({bar_caption, bar.width, bar.height, encode_png(bar)});
  const std::vector<Image8> steps = fade_pictures(pictures->mesh.colour, pictures->impostor.colour, fade);
  for (size_t i = 0; i < steps.size(); ++i) size.fade.push_back(picture_of(steps[i], *box, fmt::format("tick {}", i)));
  return size;
}

// Of --scores; what the user names must exist for a switch.
Scores scores_for(const PopmapOptions& options, metrics::ScoreTable table) {
  if (options.scores.empty()) return usual_pop_scores(table);
  const Scores possible = pop_scores(table);
  if (options.scores == "all") return possible;
  const Scores chosen = chosen_scores(options.scores, "--scores", table);
  for (const metrics::Score* score : chosen)
    if (std::find(possible.begin(), possible.end(), score) == possible.end())
      throw Error("--scores", fmt::format("{} does not exist for a switch", score->name),
                  "it needs more than two pictures of code values");
  return chosen;
}

// table: the scores that are computed; they must outlive what is returned.
PopRequest read_options(const PopmapOptions& options, metrics::ScoreTable table) {
  PopRequest request;
  request.table = table;
  request.display = display_of_option(options.display);
  request.representation = parse_representation(options.representation);
  request.azimuths_deg = parse_numbers(options.azimuths, "--azimuth-deg", -360, 360);
  request.elevations_deg = parse_numbers(options.elevations, "--elevation-deg", -90, 90);
  request.phases = parse_numbers(options.phases, "--phase", 0, 0.999999);
  request.ratios = parse_numbers(options.ratios, "--ratio", 0.01, 100);
  if (!options.heights.empty()) request.heights_px = parse_numbers(options.heights, "--height-px", 4, 4096);
  request.fade = options.fade;
  request.character = open_subject(options.character, options.clip);
  request.clip = request.character->placement.default_clip;
  if (!options.clip.empty()) request.clip = scene::require_clip_or_none(*request.character, options.clip);
  options.antialiasing.change(request.antialiasing);
  request.bake_budget = options.bake_budget_mib << 20;
  request.use_cache = !options.no_cache;
  return request;
}

size_t sizes_of(const PopRequest& request) {
  return request.heights_px.empty() ? request.ratios.size() : request.heights_px.size();
}
size_t cells_of(const PopRequest& request) {
  return sizes_of(request) * request.azimuths_deg.size() * request.elevations_deg.size() * request.phases.size();
}

// What was found, and the worst cell of each size by the ranking score.
struct PopMap {
  std::vector<PopCell> cells;
  Scores scores;
  size_t ranking = 0;  // into scores
  std::vector<Worst> worst;
};

PopMap measure(gl::Context& context, const PopRequest& request) {
  PopMap map;
  map.scores = pop_scores(request.table);
  if (map.scores.empty()) throw Error("popmap", "there is no score of a figure to draw a map of");
  const metrics::Score& ranking = metrics::ranking_score(map.scores);
  map.ranking = static_cast<size_t>(std::find(map.scores.begin(), map.scores.end(), &ranking) - map.scores.begin());
  map.worst.resize(sizes_of(request));
  const size_t total = cells_of(request);
  Progress progress("pop map", total);
  size_t done = 0;
  map.cells = compute_pop_map(context, request, [&](const PopCell& cell, const PopPictures& pictures) {
    Worst& here = map.worst[done++ / (total / map.worst.size())];
    progress.advance(1);
    const std::optional<double>& value = cell.own.cut[map.ranking];
    if (value && (!here.value || metrics::is_worse(ranking, *value, *here.value))) here = {*value, pictures};
  });
  return map;
}

Json report_of(const PopMap& map, const PopRequest& request, const std::string& renderer) {
  Json report = {{"character", request.character->name},
                 {"representation", request.representation.text()},
                 {"fade", request.fade},
                 {"display", display_json(request.display)},
                 {"renderer", renderer},
                 {"sizes", Json::array()}};
  for (const auto& size : by_size(map.cells))
    report["sizes"].push_back({{"ratio", size.front().ratio > 0 ? Json(size.front().ratio) : Json(nullptr)},
                               {"height_px", size.front().height_px},
                               {"cells", size.size()},
                               {"switch", statistics_json(size, map.scores)}});
  return report;
}

void write_page(const std::filesystem::path& path, const PopMap& map, const PopRequest& request,
                const gl::Context& context) {
  reports::PopPage page;
  page.representation = request.representation.text();
  page.character = request.character->name;
  page.clip = request.clip < 0 ? "none" : request.character->clips[static_cast<size_t>(request.clip)].name;
  page.renderer = context.renderer();
  page.program = fmt::format("crowdbench {} ({})", version(), git_revision());
  page.software = context.is_software();
  page.display = display_line(request.display);
  page.fade = request.fade;
  page.scores = score_docs(map.scores);
  page.ranking = map.ranking;
  const auto groups = by_size(map.cells);
  for (size_t i = 0; i < groups.size(); ++i)
    page.sizes.push_back(
        page_size(groups[i], map.scores, map.worst[i].value ? &map.worst[i].pictures : nullptr, request.fade));
  write_file(path, std::string_view(reports::pop_page(page)));
}

void write_folder(const std::filesystem::path& folder, const PopMap& map, const PopRequest& request, Json report,
                  const gl::Context& context) {
  make_folder(folder);
  const metrics::Score& ranking = *map.scores[map.ranking];
  report["cells"] = Json::array();
  for (const PopCell& cell : map.cells) report["cells"].push_back(to_json(cell, map.scores));
  write_file(folder / "popmap.json", report.dump(1) + "\n");
  write_file(folder / "popmap.csv", csv(map.cells, map.scores));
  write_png(folder / "heat_map.png", draw_heat_map(map.cells, request, ranking, map.ranking));
  const auto worst = std::max_element(map.worst.begin(), map.worst.end(), [&](const Worst& a, const Worst& b) {
    return b.value && (!a.value || metrics::is_worse(ranking, *b.value, *a.value));
  });
  if (worst->value) write_png(folder / "worst.png", draw_worst(worst->pictures));
  write_page(folder / "popmap.html", map, request, context);
}

// all: every score, not only those of tables.
void print_text(const PopMap& map, const PopRequest& request, bool all) {
  fmt::print("{} against the mesh of {}: {} azimuths x {} elevations x {} phases, cross-fade of {} ticks\n",
             request.representation.text(), printable(request.character->name), request.azimuths_deg.size(),
             request.elevations_deg.size(), request.phases.size(), request.fade);
  for (const auto& size : by_size(map.cells)) {
    fmt::print("{}\n  {:<26} {:<10}{:>8}{:>13}{:>9}   worst at\n", size_text(size.front()), "", "", "mean",
               "95 % within", "worst");
    for (const SwitchKind& kind : kSwitchKinds)
      for (size_t i = 0; i < map.scores.size(); ++i) {
        const metrics::Score& score = *map.scores[i];
        if (!all && (score.uses & metrics::kInTables) == 0) continue;
        const auto s = summarise_pops(size, score, i, kind.matched, kind.fade);
        if (!s) {
          fmt::print("  {:<26} {:<10} not available: {}\n", kind.text, score.column, score.absence);
          continue;
        }
        const PopCell& at = size[s->worst_cell];
        fmt::print("  {:<26} {:<10}{:>8}{:>13}{:>9}   azimuth {:g}, elevation {:g}, phase {:g}\n", kind.text,
                   score.column, metrics::value_text(score, s->mean), metrics::value_text(score, s->tail),
                   metrics::value_text(score, s->worst), at.azimuth_deg, at.elevation_deg, at.phase);
      }
  }
}

int run_popmap(const PopmapOptions& options, metrics::ScoreTable table) {
  const Scores scores = scores_for(options, table);
  const PopRequest request = read_options(options, scores);
  constexpr size_t kMost = 200'000;
  if (const size_t total = cells_of(request); total > kMost)
    throw Error("popmap", fmt::format("{} cells are more than {}", total, kMost), "ask for fewer views");
  const auto context = open_context(options.device);
  const PopMap map = measure(*context, request);
  const Json report = report_of(map, request, context->renderer());
  if (!options.out.empty()) write_folder(options.out, map, request, report, *context);
  if (options.json) {
    fmt::print("{}\n", report.dump(2));
    return 0;
  }
  print_text(map, request, !options.scores.empty());
  if (!options.out.empty())
    fmt::print("popmap.html, popmap.json, popmap.csv, heat_map.png, worst.png in {}\n", printable(options.out));
  return 0;
}

}  // namespace

void add_popmap(Command& app, Run& run) { add_popmap(app, run, metrics::scores()); }

void add_popmap(Command& app, Run& run, metrics::ScoreTable table) {
  Command* command =
      app.add_subcommand("popmap", "What a switch from the mesh would show, over views, phases and sizes");
  command->footer(
      "Mesh and impostor at the identical camera and frame: scores over their silhouettes, or the crop around them. "
      "`own pose`: the mesh\n"
      "shows the exact phase, the impostor its stored frame; `matched pose`: the mesh shows the stored frame too.\n"
      "`fade step`: the largest step of a cross-fade.\n\n"
      "Examples:\n"
      "  crowdbench popmap --representation flat --out pops\n"
      "  crowdbench popmap --representation relief --height-px 40,80 --azimuth-deg 0:330:30 --fade 8 --json");
  auto options = std::make_shared<PopmapOptions>();
  add_representation_option(*command, options->representation, "what is switched to");
  add_character_options(*command, options->character);
  add_clip_option(*command, options->clip);
  const auto add_list = [&](const char* name, std::string& list, const char* text) {
    command->add_option(name, list, text)->type_name("LIST")->capture_default_str();
  };
  add_list("--azimuth-deg", options->azimuths, "0 = from the front, 90 = from its left");
  add_list("--elevation-deg", options->elevations, "0 = level, 90 = from straight above");
  add_list("--phase", options->phases, "of the clip, 0 to 1");
  add_list("--ratio", options->ratios, "pixels that a texel spans");
  add_list("--height-px", options->heights, "instead of --ratio: the character's height in pixels, at its depth");
  command->add_option("--fade", options->fade, "ticks of the cross-fade")
      ->type_name("N")
      ->capture_default_str()
      ->whole_number(1, 60);
  command
      ->add_option(
          "--scores", options->scores,
          "only these, name,name,...; all: every one that two pictures have (those of the silhouettes and of tables)")
      ->type_name("LIST");
  add_display_option(*command, options->display);
  command->add_option("--out", options->out, "a folder for the page, the table, the heat map and the worst case")
      ->type_name("DIR")
      ->output_folder();
  add_antialiasing_options(*command, options->antialiasing);
  add_bake_options(*command, options->bake_budget_mib, &options->no_cache);
  add_device_option(*command, options->device);
  add_json_option(*command, options->json);
  command->callback([options, table, &run] { run = [options, table] { return run_popmap(*options, table); }; });
}

}  // namespace crowdbench::bench
