#include "reports/model/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "core/statistics.h"

namespace crowdbench::reports {
namespace {

template <typename T>
void insert_sorted(std::vector<T>& values, const T& value) {
  const auto place = std::lower_bound(values.begin(), values.end(), value);
  if (place == values.end() || *place != value) values.insert(place, value);
}

// "mannequin" in the plural where that is a word, else "agents".
std::string agents_text(uint64_t count) {
  return fmt::format("{} {}", count_text(count), count == 1 ? "agent" : "agents");
}

std::string view_text(const Scene& scene, double occupancy) {
  return occupancy > 0
             ? fmt::format("covering {} of a {} \u00d7 {} picture", percent_text(occupancy), scene.width, scene.height)
             : fmt::format("in a {} \u00d7 {} picture", scene.width, scene.height);
}

// The speed of the largest crowd that both were timed with.
const RatioRow* largest_ratio(const Scene& scene, const std::string& name, double occupancy) {
  for (auto agents = scene.agents.rbegin(); agents != scene.agents.rend(); ++agents) {
    const MeasurementRow* row = scene.find(name, *agents, occupancy);
    if (row == nullptr || !is_timed(*row)) continue;
    const RatioRow* ratio = scene.ratio("speed", name, *agents, occupancy, scene.run->headline);
    if (ratio != nullptr) return ratio;
  }
  return nullptr;
}

// One size says enough in a summary: the one nearest 64 pixels.
const ScoreByHeight* nearest_height(const std::vector<ScoreByHeight>& scores, const std::string& name) {
  const ScoreByHeight* nearest = nullptr;
  const auto distance = [](const ScoreByHeight& score) { return std::abs(std::log(score.height_px / 64)); };
  for (const ScoreByHeight& score : scores)
    if (score.representation == name && (nearest == nullptr || distance(score) < distance(*nearest))) nearest = &score;
  return nearest;
}

}  // namespace

const MeasurementRow* Scene::find(const std::string& representation, uint32_t agent_count, double occupancy) const {
  for (const MeasurementRow* row : rows)
    if (row->key.representation == representation && row->key.agents == agent_count &&
        row->key.requested_occupancy == occupancy)
      return row;
  return nullptr;
}

const RatioRow* Scene::ratio(const std::string& kind, const std::string& representation, uint32_t agent_count,
                             double occupancy, const std::string& metric) const {
  // The latest, should a point have been measured again.
  for (auto row = ratios.rbegin(); row != ratios.rend(); ++row)
    if ((*row)->kind == kind && (*row)->of.representation == representation && (*row)->of.agents == agent_count &&
        (*row)->of.requested_occupancy == occupancy && (*row)->metric == metric)
      return *row;
  return nullptr;
}

const PictureRow* Scene::picture(const ComparisonRow& comparison, const std::string& role) const {
  for (const PictureRow* row : pictures)
    if (row->comparison == comparison.id && row->role == role) return row;
  return nullptr;
}

std::vector<Scene> scenes_of(const StoreContents& contents) {
  using SceneKey = std::tuple<std::string, std::string, std::string, std::string>;
  std::map<int64_t, const RunRow*> runs;
  for (const RunRow& run : contents.runs) runs[run.id] = &run;
  const auto key_of_run = [&](int64_t id, const std::string& character) -> std::optional<SceneKey> {
    const auto found = runs.find(id);
    if (found == runs.end()) return std::nullopt;
    const RunRow& run = *found->second;
    return SceneKey{run.scenario_hash, run.revision, run.gl_renderer + run.gl_version, character};
  };

  std::vector<Scene> scenes;
  std::map<std::tuple<SceneKey, int, int>, size_t> places;
  std::map<std::pair<size_t, PointKey>, size_t> latest;  // scene and key -> place in its rows
  for (const MeasurementRow& row : contents.measurements) {
    const auto key = key_of_run(row.run, row.key.character);
    if (!key) continue;
    const auto [place, added] = places.try_emplace({*key, row.key.width, row.key.height}, scenes.size());
    if (added) {
      Scene& scene = scenes.emplace_back();
      scene.character = row.key.character;
      scene.width = row.key.width;
      scene.height = row.key.height;
    }
    Scene& scene = scenes[place->second];
    scene.run = runs[row.run];
    if (scene.reference.empty()) scene.reference = row.reference;
    const auto [at, fresh] = latest.try_emplace({place->second, row.key}, scene.rows.size());
    if (fresh)
      scene.rows.push_back(&row);
    else
      scene.rows[at->second] = &row;
    insert_sorted(scene.occupancies, row.key.requested_occupancy);
    insert_sorted(scene.agents, row.key.agents);
    auto& names = scene.representations;
    if (std::find(names.begin(), names.end(), row.key.representation) == names.end())
      names.push_back(row.key.representation);
  }
  for (Scene& scene : scenes) {
    auto& names = scene.representations;
    std::stable_partition(names.begin(), names.end(), [&](const std::string& name) { return name == scene.reference; });
  }
  for (const RatioRow& row : contents.ratios) {
    const auto key = key_of_run(row.run, row.of.character);
    if (!key) continue;
    const auto place = places.find({*key, row.of.width, row.of.height});
    if (place != places.end()) scenes[place->second].ratios.push_back(&row);
  }
  // Comparisons and pictures know their run and character, not the size of the timed picture.
  std::map<int64_t, size_t> scene_of_comparison;
  for (const ComparisonRow& row : contents.comparisons) {
    const auto key = key_of_run(row.run, row.character);
    for (const auto& [place, index] : places)
      if (key && std::get<0>(place) == *key) {
        (row.kind == "crowd" ? scenes[index].crowd_comparisons : scenes[index].agent_comparisons).push_back(&row);
        scene_of_comparison[row.id] = index;
        break;
      }
  }
  for (const PictureRow& row : contents.pictures) {
    if (row.comparison) {
      const auto place = scene_of_comparison.find(*row.comparison);
      if (place != scene_of_comparison.end()) scenes[place->second].pictures.push_back(&row);
      continue;
    }
    for (Scene& scene : scenes)
      if (scene.run->id == row.run) {
        scene.pictures.push_back(&row);
        break;
      }
  }
  return scenes;
}

const std::optional<TimeSummary>& time_of(const MeasurementRow& row, const std::string& metric) {
  if (metric == "gpu") return row.gpu_ns;
  if (metric == "wall") return row.frame_ns;
  return row.cpu_ns;
}

std::string metric_title(const std::string& metric) {
  if (metric == "gpu") return "GPU time";
  if (metric == "wall") return "wall-clock time";
  return "process CPU time";
}

bool is_timed(const MeasurementRow& row) { return row.status == Status::valid && row.frame_ns.has_value(); }

std::vector<CrossoverLine> crossovers_of(const Scene& scene, const std::string& metric) {
  std::vector<CrossoverLine> lines;
  for (const double occupancy : scene.occupancies) {
    for (size_t i = 0; i < scene.representations.size(); ++i) {
      for (size_t j = i + 1; j < scene.representations.size(); ++j) {
        Curve first;
        Curve second;
        for (const uint32_t agents : scene.agents) {
          const MeasurementRow* a = scene.find(scene.representations[i], agents, occupancy);
          const MeasurementRow* b = scene.find(scene.representations[j], agents, occupancy);
          if (a == nullptr || b == nullptr || !is_timed(*a) || !is_timed(*b)) continue;
          const auto& time_a = time_of(*a, metric);
          const auto& time_b = time_of(*b, metric);
          if (!time_a || !time_b || time_a->median <= 0 || time_b->median <= 0 || agents == 0) continue;
          first.x.push_back(agents);
          first.y.push_back(time_a->median);
          second.x.push_back(agents);
          second.y.push_back(time_b->median);
        }
        if (first.x.size() < 2) continue;
        CrossoverLine line;
        line.occupancy = occupancy;
        line.first = scene.representations[i];
        line.second = scene.representations[j];
        line.from = static_cast<uint32_t>(first.x.front());
        line.to = static_cast<uint32_t>(first.x.back());
        const std::vector<Crossover> found = crossovers(first, second);
        for (const Crossover& crossing : found) {
          line.agents = crossing.x;
          line.time_ns = crossing.y;
          line.cheaper_beyond = crossing.first_is_below_after ? line.first : line.second;
          line.cheaper_below = crossing.first_is_below_after ? line.second : line.first;
          lines.push_back(line);
        }
        if (found.empty()) {
          size_t first_wins = 0;
          for (size_t k = 0; k < first.y.size(); ++k) first_wins += first.y[k] < second.y[k] ? 1 : 0;
          line.cheaper_beyond = first_wins * 2 > first.y.size() ? line.first : line.second;
          lines.push_back(line);
        }
      }
    }
  }
  return lines;
}

std::optional<double> score_of(const ComparisonRow& comparison, const std::string& name) {
  for (const ScoreRow& score : comparison.scores)
    if (score.name == name) return score.value;
  return std::nullopt;
}

std::vector<ScoreByHeight> scores_by_height(const Scene& scene, const std::string& score) {
  std::vector<ScoreByHeight> all;
  for (const std::string& representation : scene.representations) {
    std::map<double, std::vector<double>> values;
    for (const ComparisonRow* row : scene.agent_comparisons) {
      if (row->representation != representation || !row->height_px) continue;
      const std::optional<double> value = score_of(*row, score);
      if (value && std::isfinite(*value)) values[*row->height_px].push_back(*value);
    }
    for (const auto& [height, list] : values) {
      double sum = 0;
      for (const double value : list) sum += value;
      const auto [least, greatest] = std::minmax_element(list.begin(), list.end());
      all.push_back({representation, height, sum / static_cast<double>(list.size()), *least, *greatest, list.size()});
    }
  }
  return all;
}

std::vector<std::string> answer(const Scene& scene) {
  std::vector<std::string> paragraphs;
  const std::string& metric = scene.run->headline;
  const auto lines = crossovers_of(scene, metric);
  for (const std::string& name : scene.representations) {
    if (name == scene.reference) continue;
    for (const double occupancy : scene.occupancies) {
      const RatioRow* best = largest_ratio(scene, name, occupancy);
      if (best == nullptr) continue;
      const bool faster = best->ratio >= 1;
      std::string text =
          fmt::format("With {} {}, {} is {} times as {} as {} (95 % interval {} to {}, {} interleaved pairs).",
                      agents_text(best->of.agents), view_text(scene, occupancy), name,
                      factor_text(faster ? best->ratio : 1 / best->ratio), faster ? "fast" : "slow", scene.reference,
                      factor_text(faster ? best->low : 1 / best->high),
                      factor_text(faster ? best->high : 1 / best->low), best->pairs);
      for (const CrossoverLine& line : lines) {
        if (line.occupancy != occupancy || line.first != scene.reference || line.second != name) continue;
        if (line.agents)
          text += fmt::format(" From about {} on, {} is the cheaper one.",
                              agents_text(static_cast<uint64_t>(std::llround(*line.agents))), line.cheaper_beyond);
        else
          text += fmt::format(" Of the two, {} is the cheaper one over the whole range, {} to {}.", line.cheaper_beyond,
                              count_text(line.from), agents_text(line.to));
      }
      paragraphs.push_back(text);
    }
    const auto overlap = scores_by_height(scene, "silhouette_iou");
    const ScoreByHeight* shown = nearest_height(overlap, name);
    if (shown == nullptr) continue;
    std::string text = fmt::format(
        "Seen {:.0f} pixels tall, the silhouette of {} overlaps that of {} by {} on average over {} views "
        "(intersection "
        "over union; {} in the worst view)",
        shown->height_px, name, scene.reference, percent_text(shown->mean), shown->views, percent_text(shown->least));
    for (const ScoreByHeight& s : scores_by_height(scene, "ssim"))
      if (s.representation == name && s.height_px == shown->height_px) text += fmt::format("; SSIM is {:.3f}", s.mean);
    paragraphs.push_back(text + ".");
  }
  return paragraphs;
}

std::optional<std::string> void_notice(const Scene& scene) {
  const RatioRow* worst = nullptr;
  for (const RatioRow* row : scene.ratios)
    if (row->kind == "floor" && row->of.representation == scene.reference && row->metric == scene.run->headline &&
        (worst == nullptr || row->ratio > worst->ratio))
      worst = row;
  if (worst == nullptr || worst->ratio <= kReferenceFloorBound) return std::nullopt;
  return fmt::format(
      "Figures of speed are void: {} took up to {} times its own floor (the same draw with a static pose), more than "
      "{}.",
      scene.reference, factor_text(worst->ratio), kReferenceFloorBound);
}

std::vector<Tile> tiles(const Scene& scene) {
  std::vector<Tile> all;
  if (scene.representations.size() < 2 || scene.occupancies.empty()) return all;
  const std::string& name = scene.representations[1];
  const std::string& metric = scene.run->headline;
  const double occupancy = scene.occupancies.front();
  const std::string at = occupancy > 0 ? " at " + percent_text(occupancy) + " occupancy" : std::string();
  if (const RatioRow* ratio = largest_ratio(scene, name, occupancy); ratio != nullptr)
    all.push_back({factor_text(ratio->ratio) + "×",
                   fmt::format("the speed of {} with {}{}{}", scene.reference, agents_text(ratio->of.agents), at,
                               void_notice(scene) ? " (void, see below)" : "")});
  for (const CrossoverLine& line : crossovers_of(scene, metric))
    if (line.occupancy == occupancy && line.first == scene.reference && line.second == name && line.agents) {
      all.push_back({fmt::format("{:.0f} agents", *line.agents),
                     fmt::format("from there on {} is the cheaper one{}", line.cheaper_beyond, at)});
      break;
    }
  const auto overlap = scores_by_height(scene, "silhouette_iou");
  const ScoreByHeight* nearest = nearest_height(overlap, name);
  if (nearest != nullptr)
    all.push_back(
        {percent_text(nearest->mean), fmt::format("of the silhouette right, {:.0f} pixels tall (intersection over "
                                                  "union, mean of {} views)",
                                                  nearest->height_px, nearest->views)});
  for (const MeasurementRow* row : scene.rows)
    if (row->key.representation == name && row->texture_bytes && row->buffer_bytes) {
      all.push_back({bytes_text(*row->texture_bytes + *row->buffer_bytes), "of textures and buffers on the GPU"});
      break;
    }
  return all;
}

std::string count_text(uint64_t count) {
  std::string digits = std::to_string(count);
  for (int place = static_cast<int>(digits.size()) - 3; place > 0; place -= 3)
    digits.insert(static_cast<size_t>(place), 1, ',');
  return digits;
}

std::string time_text(double nanoseconds) {
  const double ms = nanoseconds / 1e6;
  if (ms < 0.1) return fmt::format("{:.1f} \u00b5s", nanoseconds / 1e3);
  if (ms < 10) return fmt::format("{:.2f} ms", ms);
  if (ms < 100) return fmt::format("{:.1f} ms", ms);
  if (ms < 10000) return fmt::format("{:.0f} ms", ms);
  return fmt::format("{:.1f} s", ms / 1e3);
}

std::string bytes_text(uint64_t bytes) {
  const auto value = static_cast<double>(bytes);
  if (bytes < 1024) return fmt::format("{} B", bytes);
  if (bytes < (uint64_t{1} << 20)) return fmt::format("{:.1f} KiB", value / 1024);
  if (bytes < (uint64_t{1} << 30)) return fmt::format("{:.1f} MiB", value / (1 << 20));
  return fmt::format("{:.2f} GiB", value / (1 << 30));
}

std::string percent_text(double fraction) {
  const double percent = fraction * 100;
  return std::abs(percent - std::round(percent)) < 0.05 ? fmt::format("{:.0f} %", percent)
                                                        : fmt::format("{:.1f} %", percent);
}

std::string factor_text(double factor) {
  if (factor < 10) return fmt::format("{:.2f}", factor);
  return factor < 100 ? fmt::format("{:.1f}", factor) : fmt::format("{:.0f}", factor);
}

}  // namespace crowdbench::reports
