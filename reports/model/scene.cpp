#include "reports/model/scene.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

namespace crowdbench::reports {
namespace {

template <typename T>
void insert_sorted(std::vector<T>& values, const T& value) {
  const auto place = std::lower_bound(values.begin(), values.end(), value);
  if (place == values.end() || *place != value) values.insert(place, value);
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

namespace {

// Descriptions of the names that the comparisons have: the described ones in their order, then the others by name.
std::vector<ScoreDoc> docs_of(const Scene& scene, const std::vector<ScoreDoc>& described) {
  const auto place = [&](const std::string& name) {
    const auto found = std::find_if(described.begin(), described.end(), [&](const ScoreDoc& doc) {
      return name == doc.name || name.starts_with(doc.name + ".");
    });
    return found - described.begin();
  };
  std::set<std::pair<std::ptrdiff_t, std::string>> names;
  for (const auto* rows : {&scene.agent_comparisons, &scene.crowd_comparisons})
    for (const ComparisonRow* row : *rows)
      for (const ScoreRow& score : row->scores) names.emplace(place(score.name), score.name);
  std::vector<ScoreDoc> docs;
  for (const auto& [order, name] : names) docs.push_back(doc_of(described, name));
  return docs;
}

}  // namespace

std::vector<Scene> scenes_of(const StoreContents& contents, const std::vector<ScoreDoc>& scores) {
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
        if (row.kind == "crowd") scenes[index].crowd_comparisons.push_back(&row);
        if (row.kind == "agent") scenes[index].agent_comparisons.push_back(&row);
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
  for (Scene& scene : scenes) scene.scores = docs_of(scene, scores);
  return scenes;
}

std::vector<Scene> scenes_of_agents(const StoreContents& contents, const std::vector<Scene>& timed,
                                    const std::vector<ScoreDoc>& scores) {
  std::set<int64_t> told;  // comparisons that a timed scene has
  for (const Scene& scene : timed)
    for (const ComparisonRow* row : scene.agent_comparisons) told.insert(row->id);
  std::map<int64_t, const RunRow*> runs;
  for (const RunRow& run : contents.runs) runs[run.id] = &run;
  std::vector<Scene> scenes;
  std::map<std::pair<int64_t, std::string>, size_t> places;
  std::map<int64_t, size_t> scene_of_comparison;
  for (const ComparisonRow& row : contents.comparisons) {
    const auto run = runs.find(row.run);
    if (row.kind != "agent" || told.contains(row.id) || run == runs.end()) continue;
    const auto [place, added] = places.try_emplace({row.run, row.character}, scenes.size());
    if (added) {
      Scene& scene = scenes.emplace_back();
      scene.run = run->second;
      scene.character = row.character;
      scene.reference = row.reference;
      scene.representations = {row.reference};
    }
    Scene& scene = scenes[place->second];
    scene.agent_comparisons.push_back(&row);
    scene_of_comparison[row.id] = place->second;
    auto& names = scene.representations;
    if (std::find(names.begin(), names.end(), row.representation) == names.end()) names.push_back(row.representation);
  }
  for (const PictureRow& row : contents.pictures) {
    if (!row.comparison) {
      for (Scene& scene : scenes)
        if (scene.run->id == row.run) scene.pictures.push_back(&row);
    } else if (const auto place = scene_of_comparison.find(*row.comparison); place != scene_of_comparison.end()) {
      scenes[place->second].pictures.push_back(&row);
    }
  }
  for (Scene& scene : scenes) scene.scores = docs_of(scene, scores);
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

}  // namespace crowdbench::reports
