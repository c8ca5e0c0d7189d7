#include "reports/model/scene.h"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
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

void Scene::take(const MeasurementRow& row) {
  const PointKey& key = row.key;
  const auto [at, fresh] =
      row_places_.try_emplace({key.representation, key.agents, key.requested_occupancy}, rows.size());
  if (fresh)
    rows.push_back(&row);
  else
    rows[at->second] = &row;
  insert_sorted(occupancies, key.requested_occupancy);
  insert_sorted(agents, key.agents);
  if (std::find(representations.begin(), representations.end(), key.representation) == representations.end())
    representations.push_back(key.representation);
}

void Scene::take(const RatioRow& row) {
  ratios.push_back(&row);
  const PointKey& of = row.of;
  latest_ratios_[{{of.representation, of.agents, of.requested_occupancy}, row.kind, row.metric}] = &row;
}

const MeasurementRow* Scene::find(const std::string& representation, uint32_t agent_count, double occupancy) const {
  const auto at = row_places_.find({representation, agent_count, occupancy});
  return at == row_places_.end() ? nullptr : rows[at->second];
}

const RatioRow* Scene::ratio(const std::string& kind, const std::string& representation, uint32_t agent_count,
                             double occupancy, const std::string& metric) const {
  const auto at = latest_ratios_.find({{representation, agent_count, occupancy}, kind, metric});
  return at == latest_ratios_.end() ? nullptr : at->second;
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

// Which rows are one scene.
class SceneKeys {
 public:
  // File, scenario, revision, renderer and processor, character.
  using Key = std::tuple<std::string, std::string, std::string, std::string, std::string>;

  explicit SceneKeys(const StoreContents& contents) {
    for (const RunRow& run : contents.runs) {
      const auto source = contents.sources.find(run.id);
      runs_[run.id] = {&run, source == contents.sources.end() ? "" : source->second, likeness_of(run)};
    }
    struct Sizes {
      std::set<uint32_t> agents;
      std::set<double> occupancies;
    };
    std::map<Key, Sizes> sizes;
    for (const MeasurementRow& row : contents.measurements)
      if (const auto key = of(row.run, row.key.character)) {
        sizes[*key].agents.insert(row.key.agents);
        sizes[*key].occupancies.insert(row.key.requested_occupancy);
      }
    for (const auto& [key, size] : sizes)
      if (size.agents.size() * size.occupancies.size() > kPairsInAScene) scattered_.insert(std::get<1>(key));
    for (auto& [id, run] : runs_)
      if (scattered_.contains(run.likeness)) run.likeness = run.row->scenario_hash;
  }

  std::optional<Key> of(int64_t id, const std::string& character) const {
    const auto found = runs_.find(id);
    if (found == runs_.end()) return std::nullopt;
    const RunRow& run = *found->second.row;
    const std::string machine =
        run.gl_renderer + run.gl_version + run.cpu_model.value_or("") + std::to_string(run.cpu_threads);
    return Key{found->second.source, found->second.likeness, run.revision, machine, character};
  }
  const RunRow* run(int64_t id) const { return runs_.at(id).row; }

 private:
  struct Run {
    const RunRow* row = nullptr;
    std::string source, likeness;
  };
  // Texts that say neither are told apart by their hash alone.
  static std::string likeness_of(const RunRow& run) {
    std::string text = without_crowd_size(run.scenario);
    return text == run.scenario ? run.scenario_hash : text;
  }
  std::map<int64_t, Run> runs_;
  std::set<std::string> scattered_;
};

using ScenePlaces = std::map<std::tuple<SceneKeys::Key, int, int>, size_t>;  // and width, height

// Comparisons and pictures know their run and character, not the size of the timed picture.
void add_comparisons(const StoreContents& contents, const SceneKeys& keys, const ScenePlaces& places,
                     std::vector<Scene>& scenes) {
  std::map<SceneKeys::Key, size_t> first;
  for (const auto& [place, index] : places) first.try_emplace(std::get<0>(place), index);
  std::map<int64_t, size_t> scene_of_comparison;
  for (const ComparisonRow& row : contents.comparisons) {
    const auto key = keys.of(row.run, row.character);
    const auto place = key ? first.find(*key) : first.end();
    if (place == first.end()) continue;
    Scene& scene = scenes[place->second];
    if (row.kind == "crowd") scene.crowd_comparisons.push_back(&row);
    if (row.kind == "agent") scene.agent_comparisons.push_back(&row);
    scene_of_comparison[row.id] = place->second;
  }
  for (const PictureRow& row : contents.pictures) {
    if (row.comparison) {
      const auto place = scene_of_comparison.find(*row.comparison);
      if (place != scene_of_comparison.end()) scenes[place->second].pictures.push_back(&row);
      continue;
    }
    const auto scene =
        std::find_if(scenes.begin(), scenes.end(), [&](const Scene& one) { return one.run->id == row.run; });
    if (scene != scenes.end()) scene->pictures.push_back(&row);
  }
}

}  // namespace

std::vector<double> shown_occupancies(const Scene& scene) {
  if (scene.occupancies.size() <= kMostCurves) return scene.occupancies;
  std::map<double, std::set<uint32_t>> crowds;
  for (const MeasurementRow* row : scene.rows)
    if (is_timed(*row)) crowds[row->key.requested_occupancy].insert(row->key.agents);
  std::vector<double> with_curves;
  for (const auto& [occupancy, agents] : crowds)
    if (agents.size() > 1) with_curves.push_back(occupancy);
  if (with_curves.size() <= kMostCurves) return with_curves;
  std::vector<double> out;
  for (size_t i = 0; i < kMostCurves; ++i) out.push_back(with_curves[i * (with_curves.size() - 1) / (kMostCurves - 1)]);
  return out;
}

std::string without_crowd_size(const std::string& scenario) {
  std::string out;
  std::istringstream lines(scenario);
  std::string table;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('[')) table = line;
    if (table.empty() && line.starts_with("occupancy = ")) continue;
    if (table == "[crowd]" && line.starts_with("agents = ")) continue;
    out += line + "\n";
  }
  return out;
}

std::vector<Scene> scenes_of(const StoreContents& contents, const std::vector<ScoreDoc>& scores) {
  const SceneKeys keys(contents);
  std::vector<Scene> scenes;
  ScenePlaces places;
  for (const MeasurementRow& row : contents.measurements) {
    const auto key = keys.of(row.run, row.key.character);
    if (!key) continue;
    const auto [place, added] = places.try_emplace({*key, row.key.width, row.key.height}, scenes.size());
    if (added) {
      Scene& scene = scenes.emplace_back();
      scene.source = std::get<0>(*key);
      scene.likeness = std::get<1>(*key);
      scene.character = row.key.character;
      scene.width = row.key.width;
      scene.height = row.key.height;
    }
    Scene& scene = scenes[place->second];
    scene.run = keys.run(row.run);
    if (scene.reference.empty()) scene.reference = row.reference;
    scene.take(row);
  }
  for (Scene& scene : scenes) {
    auto& names = scene.representations;
    std::stable_partition(names.begin(), names.end(), [&](const std::string& name) { return name == scene.reference; });
  }
  for (const RatioRow& row : contents.ratios) {
    const auto key = keys.of(row.run, row.of.character);
    if (!key) continue;
    const auto place = places.find({*key, row.of.width, row.of.height});
    if (place != places.end()) scenes[place->second].take(row);
  }
  add_comparisons(contents, keys, places, scenes);
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
