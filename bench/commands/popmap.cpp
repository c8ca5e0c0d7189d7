#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "bench/experiments/pop_map.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "core/progress.h"
#include "core/version.h"
#include "metrics/heat_map.h"
#include "metrics/pseudocolour.h"
#include "renderers/gl/context.h"
#include "reports/page/pop_page.h"
#include "scene/cast/open_character.h"
#include "scene/gltf/gltf.h"

namespace crowdbench::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string representation = "flat";
  std::string character = "mannequin";
  std::string clip;
  std::string azimuths = "0:337.5:22.5";
  std::string elevations = "0:30:10";
  std::string phases = "0.025:0.975:0.25";
  std::string ratios = "0.5,1,2";
  std::string heights;
  std::string out;
  std::string device;
  int fade = 4;
  uint64_t bake_budget_mib = kDefaultBakeBudgetMiB;
  bool no_cache = false;
  bool json = false;
};

Json number(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json to_json(const PopCell& cell) {
  const auto scores = [](const PopScores& s) {
    return Json{{"mae", number(s.cut.mae)},
                {"ssim_union", number(s.cut.ssim_union)},
                {"fade_step_mae", number(s.fade_step.mae)},
                {"fade_step_ssim_union", number(s.fade_step.ssim_union)}};
  };
  return {{"ratio", cell.ratio > 0 ? Json(cell.ratio) : Json(nullptr)},
          {"height_px", cell.height_px},
          {"azimuth_deg", cell.azimuth_deg},
          {"elevation_deg", cell.elevation_deg},
          {"phase", cell.phase},
          {"shown_phase", cell.shown_phase},
          {"own_pose", scores(cell.own)},
          {"matched_pose", scores(cell.matched)}};
}

struct Way {
  bool matched, fade;
  const char* key;
  const char* text;
};
constexpr Way kSwitchKinds[] = {{false, false, "own_cut", "own pose, cut"},
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

Json statistics_json(const std::vector<PopCell>& cells) {
  Json out = Json::object();
  for (const Way& way : kSwitchKinds)
    for (const auto& [measure, name] :
         {std::pair(PopMeasure::mae, "mae"), std::pair(PopMeasure::ssim_union, "ssim_union")}) {
      const auto s = summarise_pops(cells, measure, way.matched, way.fade);
      if (!s) {
        out[way.key][name] = nullptr;
        continue;
      }
      const PopCell& worst = cells[s->worst_cell];
      out[way.key][name] = {{"mean", s->mean},
                            {measure == PopMeasure::mae ? "p95" : "p05", s->tail},
                            {"worst", s->worst},
                            {"worst_at",
                             {{"azimuth_deg", worst.azimuth_deg},
                              {"elevation_deg", worst.elevation_deg},
                              {"phase", worst.phase},
                              {"height_px", worst.height_px}}}};
    }
  return out;
}

std::string csv(const std::vector<PopCell>& cells) {
  std::string out =
      "ratio,height_px,azimuth_deg,elevation_deg,phase,shown_phase,own_mae,own_ssim_union,own_fade_step_mae,"
      "own_fade_step_ssim_union,matched_mae,matched_ssim_union,matched_fade_step_mae,matched_fade_step_ssim_union\n";
  const auto text = [](const std::optional<double>& v) { return v ? fmt::format("{}", *v) : std::string(); };
  for (const PopCell& c : cells) {
    out += fmt::format("{},{},{},{},{},{}", c.ratio > 0 ? fmt::format("{}", c.ratio) : "", c.height_px, c.azimuth_deg,
                       c.elevation_deg, c.phase, c.shown_phase);
    for (const PopScores* s : {&c.own, &c.matched})
      for (const std::optional<double>* v :
           {&s->cut.mae, &s->cut.ssim_union, &s->fade_step.mae, &s->fade_step.ssim_union})
        out += "," + text(*v);
    out += "\n";
  }
  return out;
}

// Means over the phases, elevation upwards, azimuth to the right: a panel a size and a way of switching.
Image8 draw_heat_map(const std::vector<PopCell>& cells, const PopRequest& request) {
  std::vector<std::vector<metrics::HeatPanel>> panels;
  double high = 0;
  std::vector<double> elevations = request.elevations_deg;
  std::sort(elevations.rbegin(), elevations.rend());
  for (const std::vector<PopCell>& size : by_size(cells)) {
    std::vector<metrics::HeatPanel> row;
    for (const Way& way : kSwitchKinds) {
      if (way.fade) continue;
      metrics::HeatPanel panel;
      panel.title = fmt::format("{}: {}", size_text(size.front()), way.text);
      for (const double a : request.azimuths_deg) panel.columns.push_back(fmt::format("{:g}", a));
      for (const double e : elevations) {
        panel.rows.push_back(fmt::format("{:g}", e));
        for (const double a : request.azimuths_deg) {
          double sum = 0;
          int count = 0;
          for (const PopCell& cell : size)
            if (cell.azimuth_deg == a && cell.elevation_deg == e) {
              const std::optional<double>& mae = (way.matched ? cell.matched : cell.own).cut.mae;
              sum += mae.value_or(0);
              count += mae ? 1 : 0;
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
      "MAE over the silhouettes, code values, mean of the phases; azimuth across, elevation up, degrees");
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
  double mae = -1;
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

reports::PopPoint point_of(const PopCell& cell) {
  reports::PopPoint point{cell.ratio, cell.height_px, cell.azimuth_deg, cell.elevation_deg, cell.phase, {}, {}};
  for (size_t w = 0; w < std::size(kSwitchKinds); ++w) {
    const PopScores& scores = kSwitchKinds[w].matched ? cell.matched : cell.own;
    const PopScore& score = kSwitchKinds[w].fade ? scores.fade_step : scores.cut;
    point.mae[w] = score.mae;
    point.ssim_union[w] = score.ssim_union;
  }
  return point;
}

reports::PopSize page_size(const std::vector<PopCell>& cells, const PopPictures* pictures, int fade) {
  static_assert(std::size(kSwitchKinds) == reports::kPopSwitchKinds);
  reports::PopSize size;
  for (const PopCell& cell : cells) size.points.push_back(point_of(cell));
  for (size_t w = 0; w < std::size(kSwitchKinds); ++w)
    for (const auto& [measure, to] :
         {std::pair(PopMeasure::mae, &size.mae), std::pair(PopMeasure::ssim_union, &size.ssim_union)})
      if (const auto s = summarise_pops(cells, measure, kSwitchKinds[w].matched, kSwitchKinds[w].fade))
        (*to)[w] = reports::PopSummary{s->mean, s->tail, s->worst, size.points[s->worst_cell]};
  if (pictures == nullptr) return size;
  const auto box = metrics::crop_box(metrics::mask_of(pictures->mesh.ids), metrics::mask_of(pictures->impostor.ids));
  if (!box) return size;
  size.worst = {
      picture_of(pictures->mesh.colour, *box, "mesh, own pose"),
      picture_of(pictures->matched.colour, *box, "mesh in the stored frame's pose"),
      picture_of(pictures->impostor.colour, *box, "impostor"),
      picture_of(metrics::pseudocolour(metrics::error_levels(pictures->mesh.colour, pictures->impostor.colour)), *box,
                 "own pose against impostor: dark blue equal, red the largest possible error")};
  const std::vector<Image8> steps = fade_pictures(pictures->mesh.colour, pictures->impostor.colour, fade);
  for (size_t i = 0; i < steps.size(); ++i) size.fade.push_back(picture_of(steps[i], *box, fmt::format("tick {}", i)));
  return size;
}

int run_popmap(const Options& options) {
  PopRequest request;
  request.representation = parse_representation(options.representation);
  request.azimuths_deg = parse_numbers(options.azimuths, "--azimuth-deg", -360, 360);
  request.elevations_deg = parse_numbers(options.elevations, "--elevation-deg", -90, 90);
  request.phases = parse_numbers(options.phases, "--phase", 0, 0.999999);
  request.ratios = parse_numbers(options.ratios, "--ratio", 0.01, 100);
  if (!options.heights.empty()) request.heights_px = parse_numbers(options.heights, "--height-px", 4, 4096);
  request.fade = options.fade;
  request.character = std::make_shared<const scene::Character>(scene::open_character(options.character, {}));
  request.clip = request.character->placement.default_clip;
  if (!options.clip.empty())
    request.clip = options.clip == "none" && !scene::find_clip(*request.character, "none")
                       ? -1
                       : scene::require_clip(*request.character, options.clip);
  request.bake_budget = options.bake_budget_mib << 20;
  request.use_cache = !options.no_cache;
  const size_t sizes = request.heights_px.empty() ? request.ratios.size() : request.heights_px.size();
  const size_t total = sizes * request.azimuths_deg.size() * request.elevations_deg.size() * request.phases.size();
  constexpr size_t kMost = 200'000;
  if (total > kMost)
    throw Error("popmap", fmt::format("{} cells are more than {}", total, kMost), "ask for fewer views");

  const auto context = open_context(options.device);
  std::vector<Worst> worst(sizes);  // by size
  std::vector<PopCell> cells;
  {
    Progress progress("pop map", total);
    size_t done = 0;
    cells = compute_pop_map(*context, request, [&](const PopCell& cell, const PopPictures& pictures) {
      Worst& here = worst[done++ / (total / sizes)];
      progress.advance(1);
      if (cell.own.cut.mae && *cell.own.cut.mae > here.mae) here = {*cell.own.cut.mae, pictures};
    });
  }
  Json report = {{"character", request.character->name},
                 {"representation", request.representation.text()},
                 {"fade", request.fade},
                 {"renderer", context->renderer()},
                 {"sizes", Json::array()}};
  for (const auto& size : by_size(cells))
    report["sizes"].push_back({{"ratio", size.front().ratio > 0 ? Json(size.front().ratio) : Json(nullptr)},
                               {"height_px", size.front().height_px},
                               {"cells", size.size()},
                               {"switch", statistics_json(size)}});
  if (!options.out.empty()) {
    const std::filesystem::path folder = options.out;
    make_folder(folder);
    Json whole = report;
    whole["cells"] = Json::array();
    for (const PopCell& cell : cells) whole["cells"].push_back(to_json(cell));
    write_file(folder / "popmap.json", whole.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
    write_file(folder / "popmap.csv", csv(cells));
    write_png(folder / "heat_map.png", draw_heat_map(cells, request));
    const auto worst_of_all =
        std::max_element(worst.begin(), worst.end(), [](const Worst& a, const Worst& b) { return a.mae < b.mae; });
    if (worst_of_all->mae >= 0) write_png(folder / "worst.png", draw_worst(worst_of_all->pictures));
    reports::PopPage page{request.representation.text(),
                          request.character->name,
                          request.clip < 0 ? "none" : request.character->clips[static_cast<size_t>(request.clip)].name,
                          context->renderer(),
                          fmt::format("crowdbench {} ({})", version(), git_revision()),
                          context->is_software(),
                          request.fade,
                          {}};
    const auto groups = by_size(cells);
    for (size_t i = 0; i < groups.size(); ++i)
      page.sizes.push_back(page_size(groups[i], worst[i].mae >= 0 ? &worst[i].pictures : nullptr, request.fade));
    write_file(folder / "popmap.html", std::string_view(reports::pop_page(page)));
  }
  if (options.json) {
    fmt::print("{}\n", report.dump(2, ' ', false, Json::error_handler_t::replace));
    return 0;
  }
  fmt::print("{} against the mesh of {}: {} azimuths x {} elevations x {} phases, cross-fade of {} ticks\n",
             request.representation.text(), printable(request.character->name), request.azimuths_deg.size(),
             request.elevations_deg.size(), request.phases.size(), request.fade);
  for (const auto& size : by_size(cells)) {
    fmt::print("{}\n  {:<26}{:>8}{:>8}{:>8}   {:>8}{:>8}{:>8}   worst at (MAE)\n", size_text(size.front()), "", "MAE",
               "p95", "worst", "SSIM", "p05", "worst");
    for (const Way& way : kSwitchKinds) {
      const auto mae = summarise_pops(size, PopMeasure::mae, way.matched, way.fade);
      const auto ssim = summarise_pops(size, PopMeasure::ssim_union, way.matched, way.fade);
      if (!mae) {
        fmt::print("  {:<26} nothing is drawn\n", way.text);
        continue;
      }
      const PopCell& at = size[mae->worst_cell];
      const std::string similarity = ssim ? fmt::format("{:>8.3f}{:>8.3f}{:>8.3f}", ssim->mean, ssim->tail, ssim->worst)
                                          : fmt::format("{:>24}", "too small");
      fmt::print("  {:<26}{:>8.2f}{:>8.2f}{:>8.2f}   {}   azimuth {:g}, elevation {:g}, phase {:g}\n", way.text,
                 mae->mean, mae->tail, mae->worst, similarity, at.azimuth_deg, at.elevation_deg, at.phase);
    }
  }
  if (!options.out.empty())
    fmt::print("popmap.html, popmap.json, popmap.csv, heat_map.png, worst.png in {}\n", printable(options.out));
  return 0;
}

}  // namespace

void add_popmap(Command& app, Run& run) {
  Command* command =
      app.add_subcommand("popmap", "What a switch from the mesh would show, over views, phases and sizes");
  command->footer(
      "Mesh and impostor at the identical camera and frame: MAE and SSIM over their silhouettes. `own pose`: the mesh\n"
      "shows the exact phase, the impostor its stored frame; `matched pose`: the mesh shows the stored frame too.\n"
      "`fade step`: the largest step of a cross-fade.\n\n"
      "Examples:\n"
      "  crowdbench popmap --representation flat --out pops\n"
      "  crowdbench popmap --representation relief --height-px 40,80 --azimuth-deg 0:330:30 --fade 8 --json");
  auto options = std::make_shared<Options>();
  add_representation_option(*command, options->representation, "what is switched to");
  add_character_option(*command, options->character);
  add_clip_option(*command, options->clip);
  const auto add_list = [&](const char* name, std::string& list, const char* text) {
    command->add_option(name, list, text)->type_name("LIST")->capture_default_str();
  };
  add_list("--azimuth-deg", options->azimuths, "0 = from the front, 90 = from its left");
  add_list("--elevation-deg", options->elevations, "0 = level, 90 = from straight above");
  add_list("--phase", options->phases, "of the clip, 0 to 1");
  add_list("--ratio", options->ratios, "pixels that a texel spans");
  add_list("--height-px", options->heights, "instead of --ratio: the character's height in pixels");
  command->add_option("--fade", options->fade, "ticks of the cross-fade")
      ->type_name("N")
      ->capture_default_str()
      ->whole_number(1, 60);
  command->add_option("--out", options->out, "a folder for the page, the table, the heat map and the worst case")
      ->type_name("DIR")
      ->output_folder();
  add_bake_options(*command, options->bake_budget_mib, &options->no_cache);
  add_device_option(*command, options->device);
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return run_popmap(*options); }; });
}

}  // namespace crowdbench::bench
