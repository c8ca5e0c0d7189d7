#include "reports/page/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.h"
#include "reports/charts/charts.h"
#include "reports/model/summary.h"
#include "reports/page/page_frame.h"

namespace crowdbench::reports {
namespace {

constexpr const char* kNone = "<td>–</td>";

class Page {
 public:
  Page(const StoreContents& contents, const PageOptions& options) : contents_(contents), options_(options) {
    scenes_ = scenes_of(contents);
    if (scenes_.empty())
      throw Error(options.source, "holds no measurement", "run `crowdbench bench --out " + options.source + "` first");
  }

  std::string make() {
    head();
    const bool several = scenes_.size() > 1;
    for (const Scene& scene : scenes_) {
      colours_ = representation_colours(scene.representations.size());
      if (several)
        add("<h2>{}, {} × {} pixels, scenario “{}”</h2>\n", html_escape(scene.character), scene.width, scene.height,
            html_escape(scene.run->scenario_name));
      if (several) answer_of(scene);
      pictures(scene);
      cost(scene);
      quality(scene);
      memory(scene);
      floors(scene);
      work(scene);
      holes(scene);
    }
    method();
    provenance();
    html_ += page_foot(options_.source);
    return std::move(html_);
  }

 private:
  template <typename... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(html_), format, std::forward<Args>(args)...);
  }

  void head() {
    const Scene& first = scenes_.front();
    std::string names;
    for (const Scene& scene : scenes_) {
      const std::string name = html_escape(scene.character);
      if (names.find(name) == std::string::npos) names += (names.empty() ? "" : ", ") + name;
    }
    std::string against;
    for (const std::string& name : first.representations)
      if (name != first.reference) against += (against.empty() ? "" : ", ") + name;
    const std::string title =
        against.empty() ? "What a crowd costs to draw as " + first.reference
                        : fmt::format("A crowd drawn as {} and as {}: cost and difference", first.reference, against);
    html_ += page_head(title);
    const RunRow& run = *first.run;
    add("<p class=\"under\">Characters: {}. Measured {} on {}, {}, by crowdbench {} ({}).</p>\n", names,
        html_escape(run.started), html_escape(run.cpu_model.value_or("an unnamed processor")),
        html_escape(run.gl_renderer), html_escape(run.version), html_escape(run.revision));
    if (scenes_.size() == 1) answer_of(first);
    const bool software =
        std::any_of(scenes_.begin(), scenes_.end(), [](const Scene& scene) { return scene.run->software; });
    if (software)
      html_ +=
          "<div class=\"banner\">Drawn by a software rasteriser: a CPU stood in for the graphics card. <span>Times "
          "here "
          "compare representations with each other on this machine and say nothing about a GPU; no frame rate is "
          "given. The pictures and the differences between them are not affected.</span></div>\n";
  }

  void answer_of(const Scene& scene) {
    const std::vector<std::string> sentences = answer(scene);
    if (sentences.empty()) return;
    html_ += "<div class=\"tiles\">\n";
    for (const Tile& tile : tiles(scene))
      add("<div><b>{}</b><span>{}</span></div>\n", html_escape(tile.figure), html_escape(tile.meaning));
    html_ += "</div>\n";
    if (const auto notice = void_notice(scene))
      add("<div class=\"banner\">{} <span>The pictures and the differences stand.</span></div>\n",
          html_escape(*notice));
    html_ += "<div class=\"answer\">\n";
    for (const std::string& sentence : sentences) add("<p>{}</p>\n", html_escape(sentence));
    html_ += "</div>\n";
  }

  std::string dot(const Scene& scene, const std::string& representation) const {
    const auto& names = scene.representations;
    const auto place = std::find(names.begin(), names.end(), representation);
    const std::string colour = place == names.end() ? "#9aa5b1" : colours_[static_cast<size_t>(place - names.begin())];
    return fmt::format("<span class=\"dot\" style=\"background:{}\"></span>{}", colour, html_escape(representation));
  }

  void image(const PictureRow& picture, const std::string& caption) {
    add("<figure><img width=\"{}\" height=\"{}\" alt=\"{}\" src=\"data:image/png;base64,{}\"><figcaption>{}"
        "</figcaption></figure>\n",
        picture.width, picture.height, html_escape(picture.caption), base64(picture.png), caption);
  }

  void chart(const std::string& spec, const std::string& title) {
    if (spec.empty()) return;
    html_ += chart_block(spec, title, ++charts_);
  }

  static std::string occupancy_title(double occupancy) {
    return occupancy > 0 ? percent_text(occupancy) + " of the picture covered" : "the scenario's own camera";
  }

  // ---- sections

  void pictures(const Scene& scene) {
    std::vector<const PictureRow*> heroes;
    for (const PictureRow* picture : scene.pictures)
      if (picture->role == "hero") heroes.push_back(picture);
    if (heroes.empty() && scene.crowd_comparisons.empty()) return;
    html_ += "<h2>The same crowd, the same view</h2>\n";
    if (!heroes.empty()) {
      html_ += "<div class=\"pictures\">\n";
      for (const PictureRow* picture : heroes) image(*picture, html_escape(picture->caption));
      html_ += "</div>\n";
    }
    for (const ComparisonRow* comparison : scene.crowd_comparisons) {
      const PictureRow* reference = scene.picture(*comparison, "reference");
      const PictureRow* test = scene.picture(*comparison, "test");
      const PictureRow* difference = scene.picture(*comparison, "difference");
      if (reference == nullptr || test == nullptr) continue;
      add("<h3>{} agents, {}</h3>\n<div class=\"pictures\">\n", count_text(comparison->agents),
          occupancy_title(comparison->requested_occupancy));
      image(*reference, fmt::format("<b>{}</b>, the reference", dot(scene, comparison->reference)));
      image(*test, fmt::format("<b>{}</b>{}", dot(scene, comparison->representation), scores_caption(*comparison)));
      if (difference != nullptr)
        image(*difference, "absolute difference: dark blue = equal, red = the largest possible error");
      html_ += "</div>\n";
    }
    html_ += "<p class=\"note\">Click a picture to enlarge it.</p>\n";
  }

  static std::string scores_caption(const ComparisonRow& comparison) {
    std::string text;
    if (const auto ssim = score_of(comparison, "ssim")) text += fmt::format(", SSIM {:.3f}", *ssim);
    if (const auto psnr = score_of(comparison, "psnr"))
      text += std::isinf(*psnr) ? ", identical" : fmt::format(", PSNR {:.1f} dB", *psnr);
    if (const auto iou = score_of(comparison, "silhouette_iou"))
      text += fmt::format(", crowd silhouette overlap {}", percent_text(*iou));
    return text;
  }

  void cost(const Scene& scene) {
    const std::string& metric = scene.run->headline;
    add("<h2>Cost</h2>\n<p>Median {} of a finished frame, from a posed crowd in hand to colour and depth. Bars are 95 "
        "% "
        "bootstrap intervals of the median; dashed lines mark where two curves cross. Both axes are logarithmic.</p>\n",
        metric_title(metric));
    html_ += "<div class=\"charts\">\n";
    for (const double occupancy : scene.occupancies) chart(time_chart(scene, occupancy), occupancy_title(occupancy));
    html_ += "</div>\n";
    const std::string speed = speed_chart(scene);
    if (!speed.empty()) {
      html_ += "<div class=\"charts\">\n";
      chart(speed, "Speed against " + scene.reference);
      html_ += "</div>\n";
    }
    crossover_table(scene, metric);
    for (const double occupancy : scene.occupancies) cost_table(scene, occupancy, metric);
  }

  void crossover_table(const Scene& scene, const std::string& metric) {
    const auto lines = crossovers_of(scene, metric);
    if (lines.empty()) return;
    html_ +=
        "<h3>Where the curves cross</h3>\n<div class=\"scroll\"><table>\n<tr><th "
        "class=\"l\">Pair</th><th>Occupancy</th>"
        "<th>Crossing at</th><th class=\"l\">Cheaper</th></tr>\n";
    for (const CrossoverLine& line : lines) {
      add("<tr><td class=\"l\">{} and {}</td><td>{}</td>", dot(scene, line.first), dot(scene, line.second),
          line.occupancy > 0 ? percent_text(line.occupancy) : "–");
      if (line.agents)
        add("<td>{:.0f} agents, {}</td><td class=\"l\">{} below, {} beyond</td></tr>\n", *line.agents,
            time_text(line.time_ns), html_escape(line.cheaper_below), html_escape(line.cheaper_beyond));
      else
        add("<td>none</td><td class=\"l\">{} from {} to {} agents</td></tr>\n", html_escape(line.cheaper_beyond),
            count_text(line.from), count_text(line.to));
    }
    html_ +=
        "</table></div>\n<p class=\"note\">By straight lines in log time against log agents between measured points. "
        "Crossings move with resolution, processor and driver.</p>\n";
  }

  void cost_table(const Scene& scene, double occupancy, const std::string& metric) {
    const bool fps = !scene.run->software;
    add("<h3>{}</h3>\n<div class=\"scroll\"><table>\n<tr><th class=\"l\">Representation</th><th>Agents</th><th>{}</th>"
        "<th>95 % interval</th><th>5th to 95th percentile</th><th>Wall clock</th><th>99th percentile</th>{}<th>Speed, "
        "{} = 1</th><th>Interval</th><th>Covered</th><th>Frames</th></tr>\n",
        occupancy_title(occupancy),
        metric == "gpu"    ? "GPU time"
        : metric == "wall" ? "Wall clock"
                           : "CPU time",
        fps ? "<th>1 % low, fps</th>" : "", html_escape(scene.reference));
    for (const uint32_t agents : scene.agents) {
      for (const std::string& name : scene.representations) {
        const MeasurementRow* row = scene.find(name, agents, occupancy);
        if (row == nullptr) continue;
        add("<tr><td class=\"l\">{}</td><td>{}</td>", dot(scene, name), count_text(agents));
        if (!row->frame_ns || !time_of(*row, metric)) {
          add("<td class=\"l i\" colspan=\"{}\">{}: {}</td></tr>\n", fps ? 10 : 9, status_name(row->status),
              html_escape(row->reason));
          continue;
        }
        const TimeSummary& time = *time_of(*row, metric);
        add("<td>{}</td><td class=\"i\">{} to {}</td><td class=\"i\">{} to {}</td><td>{}</td><td class=\"i\">{}</td>",
            time_text(time.median), time_text(time.low), time_text(time.high), time_text(time.p05), time_text(time.p95),
            time_text(row->frame_ns->median), time_text(row->frame_ns->p99));
        if (fps) add("<td>{}</td>", row->low_1_percent_fps ? fmt::format("{:.1f}", *row->low_1_percent_fps) : "–");
        if (const RatioRow* ratio = scene.ratio("speed", name, agents, occupancy, metric); ratio != nullptr)
          add("<td>{}×</td><td class=\"i\">{} to {}</td>", factor_text(ratio->ratio), factor_text(ratio->low),
              factor_text(ratio->high));
        else
          add("{}{}", kNone, kNone);
        add("<td>{}{}</td><td>{}</td></tr>\n", covered_text(scene, *row),
            row->status == Status::valid ? "" : fmt::format(" <span class=\"bad\">{}</span>", status_name(row->status)),
            row->rounds);
      }
    }
    html_ += "</table></div>\n";
  }

  static std::string covered_text(const Scene& scene, const MeasurementRow& row) {
    if (!row.covered_px) return "–";
    return percent_text(static_cast<double>(*row.covered_px) / (static_cast<double>(scene.width) * scene.height));
  }

  void quality(const Scene& scene) {
    if (scene.crowd_comparisons.empty() && scene.agent_comparisons.empty()) return;
    add("<h2>Difference from {}</h2>\n", html_escape(scene.reference));
    if (!scene.agent_comparisons.empty()) {
      html_ +=
          "<p>One agent at the identical view, over several directions, heights and moments. Bands run from the worst "
          "to "
          "the best view.</p>\n<div class=\"charts\">\n";
      chart(score_chart(scene, "silhouette_iou", "silhouette overlap (IoU)"), "Silhouette");
      chart(score_chart(scene, "ssim_union", "SSIM over the figure"), "Structure within the figure");
      html_ += "</div>\n";
      agent_table(scene);
      agent_pictures(scene);
    }
    crowd_table(scene);
  }

  void agent_table(const Scene& scene) {
    static const std::vector<std::pair<const char*, const char*>> kScores = {
        {"silhouette_iou", "Silhouette IoU"},       {"boundary_px_mean", "Boundary off by, px"},
        {"boundary_px_p95", "95th percentile, px"}, {"ssim", "SSIM"},
        {"ssim_union", "SSIM in the figure"},       {"psnr", "PSNR, dB"}};
    html_ +=
        "<div class=\"scroll\"><table>\n<caption>Mean over the views, with the worst view in "
        "brackets.</caption><tr><th "
        "class=\"l\">Representation</th><th>Height, px</th><th>Views</th>";
    std::vector<std::vector<ScoreByHeight>> columns;
    for (const auto& [name, title] : kScores) {
      add("<th>{}</th>", title);
      columns.push_back(scores_by_height(scene, name));
    }
    html_ += "</tr>\n";
    for (const ScoreByHeight& row : columns.front()) {
      add("<tr><td class=\"l\">{}</td><td>{:.0f}</td><td>{}</td>", dot(scene, row.representation), row.height_px,
          row.views);
      for (size_t c = 0; c < columns.size(); ++c) {
        const auto cell = std::find_if(columns[c].begin(), columns[c].end(), [&](const ScoreByHeight& s) {
          return s.representation == row.representation && s.height_px == row.height_px;
        });
        if (cell == columns[c].end()) {
          html_ += kNone;
          continue;
        }
        const bool pixels = std::string_view(kScores[c].first).starts_with("boundary");
        const double worst = pixels ? cell->greatest : cell->least;
        const int digits = c >= 3 && c != 5 ? 3 : c == 5 ? 1 : pixels ? 2 : 3;
        add("<td>{:.{}f} <span class=\"i\">({:.{}f})</span></td>", cell->mean, digits, worst, digits);
      }
      html_ += "</tr>\n";
    }
    html_ += "</table></div>\n";
  }

  // One group a height: reference, test, difference. Small figures are enlarged so that their pixels can be seen.
  void agent_pictures(const Scene& scene) {
    std::string body;
    for (const ComparisonRow* comparison : scene.agent_comparisons) {
      const PictureRow* reference = scene.picture(*comparison, "reference");
      const PictureRow* test = scene.picture(*comparison, "test");
      const PictureRow* difference = scene.picture(*comparison, "difference");
      if (reference == nullptr || test == nullptr) continue;
      body += "<figure class=\"group\"><div>";
      const int scale = std::clamp(180 / std::max(1, reference->height), 1, 4);
      for (const PictureRow* picture : {reference, test, difference})
        if (picture != nullptr)
          body += fmt::format("<img width=\"{}\" height=\"{}\" alt=\"{}\" src=\"data:image/png;base64,{}\">",
                              picture->width * scale, picture->height * scale, html_escape(picture->caption),
                              base64(picture->png));
      body += fmt::format("</div><figcaption><b>{:.0f} pixels tall</b>{}: {}, {}, difference",
                          comparison->height_px.value_or(0), scale > 1 ? fmt::format(" (shown {}×)", scale) : "",
                          html_escape(comparison->reference), html_escape(comparison->representation));
      if (const auto iou = score_of(*comparison, "silhouette_iou"))
        body += fmt::format("<br>silhouette IoU {:.3f}", *iou);
      if (const auto ssim = score_of(*comparison, "ssim")) body += fmt::format(", SSIM {:.3f}", *ssim);
      body += "</figcaption></figure>\n";
      if (caption_.empty())
        caption_ = fmt::format("Seen from {:.0f}° beside the front and {:.0f}° above.",
                               comparison->azimuth_deg.value_or(0), comparison->elevation_deg.value_or(0));
    }
    if (!body.empty())
      add("<h3>One agent by height</h3>\n<p class=\"note\">{}</p>\n<div class=\"groups\">\n{}</div>\n", caption_, body);
    caption_.clear();
  }

  void crowd_table(const Scene& scene) {
    if (scene.crowd_comparisons.empty()) return;
    html_ +=
        "<h3>Whole frames</h3>\n<div class=\"scroll\"><table>\n<tr><th "
        "class=\"l\">Representation</th><th>Agents</th><th>Occupancy"
        "</th><th>SSIM</th><th>PSNR, dB</th><th>Mean absolute error, code values</th><th>Crowd silhouette "
        "IoU</th></tr>\n";
    const auto cell = [&](const ComparisonRow& row, const char* name, int digits) {
      const auto value = score_of(row, name);
      if (!value)
        html_ += kNone;
      else if (std::isinf(*value))
        html_ += "<td>∞</td>";
      else
        add("<td>{:.{}f}</td>", *value, digits);
    };
    for (const ComparisonRow* row : scene.crowd_comparisons) {
      add("<tr><td class=\"l\">{}</td><td>{}</td><td>{}</td>", dot(scene, row->representation), count_text(row->agents),
          row->requested_occupancy > 0 ? percent_text(row->requested_occupancy) : "–");
      cell(*row, "ssim", 3);
      cell(*row, "psnr", 1);
      cell(*row, "mae", 2);
      cell(*row, "silhouette_iou", 3);
      html_ += "</tr>\n";
    }
    html_ +=
        "</table></div>\n<p class=\"note\">Whole frames hold much background, which is always equal: small crowds "
        "score well "
        "for that alone. The figures by height above are the stricter ones.</p>\n";
  }

  // The row of each representation with the most agents, which is where bytes that grow with the crowd are largest.
  static std::vector<const MeasurementRow*> largest_rows(const Scene& scene) {
    std::vector<const MeasurementRow*> rows;
    for (const std::string& name : scene.representations) {
      const MeasurementRow* largest = nullptr;
      for (const MeasurementRow* row : scene.rows)
        if (row->key.representation == name && is_timed(*row) &&
            (largest == nullptr || row->key.agents > largest->key.agents))
          largest = row;
      if (largest != nullptr) rows.push_back(largest);
    }
    return rows;
  }

  void memory(const Scene& scene) {
    const auto rows = largest_rows(scene);
    if (std::none_of(rows.begin(), rows.end(),
                     [](const MeasurementRow* row) { return row->texture_bytes.has_value(); }))
      return;
    html_ +=
        "<h2>Memory</h2>\n<div class=\"scroll\"><table>\n<tr><th "
        "class=\"l\">Representation</th><th>Textures</th><th>Buffers</th>"
        "<th>On the GPU</th><th>Uploaded a frame</th><th>On disk</th><th>Shared by all</th><th>Bake</th></tr>\n";
    for (const MeasurementRow* row : rows) {
      const auto bytes = [&](const std::optional<uint64_t>& value) {
        html_ += value ? fmt::format("<td>{}</td>", bytes_text(*value)) : kNone;
      };
      add("<tr><td class=\"l\">{}</td>", dot(scene, row->key.representation));
      bytes(row->texture_bytes);
      bytes(row->buffer_bytes);
      if (row->texture_bytes && row->buffer_bytes)
        bytes(*row->texture_bytes + *row->buffer_bytes);
      else
        html_ += kNone;
      bytes(row->upload_bytes_per_frame);
      bytes(row->disk_bytes);
      bytes(row->shared_bytes);
      if (row->bake_seconds)
        add("<td>{:.2f} s{}</td>", *row->bake_seconds, row->bake_cached.value_or(false) ? ", from the cache" : "");
      else
        html_ += kNone;
      html_ += "</tr>\n";
    }
    html_ +=
        "</table></div>\n<p class=\"note\">Exact bytes as allocated, every mip level counted. Shared by all: pose "
        "banks and "
        "per-frame buffers that every representation reads.</p>\n";
  }

  void floors(const Scene& scene) {
    const std::string& metric = scene.run->headline;
    std::string body;
    for (const std::string& name : scene.representations)
      for (const double occupancy : scene.occupancies)
        for (const uint32_t agents : scene.agents)
          if (const RatioRow* ratio = scene.ratio("floor", name, agents, occupancy, metric); ratio != nullptr) {
            const bool poor = name == scene.reference && ratio->ratio > kReferenceFloorBound;
            fmt::format_to(
                std::back_inserter(body),
                "<tr><td class=\"l\">{}</td><td>{}</td><td>{}</td><td{}>{}</td><td class=\"i\">{} to {}</td></tr>\n",
                dot(scene, name), count_text(agents), occupancy > 0 ? percent_text(occupancy) : "–",
                poor ? " class=\"bad\"" : "", factor_text(ratio->ratio), factor_text(ratio->low),
                factor_text(ratio->high));
          }
    if (body.empty()) return;
    add("<h2>Time over its floor</h2>\n<p>The floor of a representation is the same draw with the work removed (a "
        "static pose for a "
        "mesh; the same quads and fetches without lighting for impostors). Near 1, little is left to gain. Where {} is "
        "above 1.4 "
        "times its floor, it is not a fair yardstick.</p>\n<div class=\"scroll\"><table>\n<tr><th "
        "class=\"l\">Representation</th>"
        "<th>Agents</th><th>Occupancy</th><th>Time / floor</th><th>95 % interval</th></tr>\n{}</table></div>\n",
        html_escape(scene.reference), body);
  }

  void work(const Scene& scene) {
    std::string body;
    const auto count = [](const std::optional<uint64_t>& value) {
      return value ? fmt::format("<td>{}</td>", count_text(*value)) : std::string(kNone);
    };
    for (const double occupancy : scene.occupancies)
      for (const uint32_t agents : scene.agents)
        for (const std::string& name : scene.representations) {
          const MeasurementRow* row = scene.find(name, agents, occupancy);
          if (row == nullptr || !is_timed(*row)) continue;
          body += fmt::format("<tr><td class=\"l\">{}</td><td>{}</td><td>{}</td>{}{}{}{}{}{}</tr>\n", dot(scene, name),
                              count_text(agents), occupancy > 0 ? percent_text(occupancy) : "–",
                              count(row->triangles_per_agent), count(row->vertices_shaded), count(row->primitives),
                              count(row->fragments), count(row->samples_passed), count(row->covered_px));
        }
    if (body.empty()) return;
    html_ +=
        "<h2>Work counted</h2>\n<p>Counts of one frame; unlike times they do not depend on the machine's "
        "mood.</p>\n<details><summary>"
        "Show the counters</summary><div class=\"scroll\"><table>\n<tr><th "
        "class=\"l\">Representation</th><th>Agents</th><th>Occupancy</th>"
        "<th>Triangles an agent</th><th>Vertices shaded</th><th>Primitives</th><th>Fragments</th><th>Samples "
        "passed</th><th>Pixels with an "
        "agent</th></tr>\n" +
        body + "</table></div></details>\n";
  }

  void holes(const Scene& scene) {
    std::string body;
    for (const MeasurementRow* row : scene.rows)
      if (row->status != Status::valid)
        fmt::format_to(
            std::back_inserter(body),
            "<tr><td class=\"l\">{}</td><td>{}</td><td>{}</td><td class=\"l\">{}</td><td class=\"wrap\">{}</td></tr>\n",
            dot(scene, row->key.representation), count_text(row->key.agents),
            row->key.requested_occupancy > 0 ? percent_text(row->key.requested_occupancy) : "–",
            status_name(row->status), html_escape(row->reason));
    if (body.empty()) return;
    html_ +=
        "<h2>Points without a valid time</h2>\n<div class=\"scroll\"><table>\n<tr><th "
        "class=\"l\">Representation</th><th>Agents</th><th>Occupancy"
        "</th><th class=\"l\">Status</th><th class=\"l\">Reason</th></tr>\n" +
        body + "</table></div>\n";
  }

  void method() {
    html_ +=
        "<h2>How it was measured</h2>\n<p>All representations draw the same seeded crowd from the same camera at the "
        "same moment and take "
        "turns within one process (A B C A B C …), one tick of animation a turn, so that drift of the machine hits all "
        "alike. Before the "
        "timed turns each draws the exact state until its running median has settled. A speed is the median of the "
        "ratios of frames that "
        "were drawn in the same turn, with a bootstrap 95 % interval. The camera and the placement are solved so that "
        "the reference covers "
        "the stated share of the picture. A time counts as valid only when a frame of the same run was looked at: "
        "something was drawn, its "
        "coverage agrees with the reference’s, and two moments differ.</p>\n";
  }

  void provenance() {
    html_ += "<h2>Provenance</h2>\n";
    for (const RunRow& run : contents_.runs) {
      add("<h3>Run {}: {}</h3>\n<dl>", run.id, html_escape(run.started));
      const auto line = [&](const char* title, const std::string& value) {
        add("<dt>{}</dt><dd>{}</dd>", title, html_escape(value));
      };
      line("command", run.arguments.empty() ? run.command : run.arguments);
      line("crowdbench", fmt::format("{} ({})", run.version, run.revision));
      line("OpenGL renderer", run.gl_renderer + (run.software ? " (software)" : ""));
      line("OpenGL version", fmt::format("{}; {}", run.gl_version, run.gl_vendor));
      line("processor",
           fmt::format("{}, {} hardware threads", run.cpu_model.value_or("not named by the machine"), run.cpu_threads));
      line("system", run.os);
      line("cost of reading the clocks", fmt::format("{:.2f} µs", run.timer_cost_ns / 1e3));
      line("seed", std::to_string(run.seed));
      line("scenario", fmt::format("{}, SHA-256 {}", run.scenario_name, run.scenario_hash));
      add("</dl>\n<details><summary>Scenario text</summary><pre>{}</pre></details>\n", html_escape(run.scenario));
    }
  }

  const StoreContents& contents_;
  const PageOptions& options_;
  std::vector<Scene> scenes_;
  std::vector<std::string> colours_;
  std::string html_;
  std::string caption_;
  int charts_ = 0;
};

}  // namespace

std::string report_page(const StoreContents& contents, const PageOptions& options) {
  return Page(contents, options).make();
}

std::string html_escape(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      default: out += c;
    }
  }
  return out;
}

std::string script_json(std::string_view json) {
  std::string out;
  out.reserve(json.size());
  for (const char c : json) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

std::string base64(const std::vector<uint8_t>& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t left = bytes.size() - i;
    const unsigned group = static_cast<unsigned>(bytes[i]) << 16U |
                           (left > 1 ? static_cast<unsigned>(bytes[i + 1]) << 8U : 0U) |
                           (left > 2 ? static_cast<unsigned>(bytes[i + 2]) : 0U);
    out += kDigits[group >> 18U];
    out += kDigits[group >> 12U & 63U];
    out += left > 1 ? kDigits[group >> 6U & 63U] : '=';
    out += left > 2 ? kDigits[group & 63U] : '=';
  }
  return out;
}

}  // namespace crowdbench::reports
