// The sections of the report that tell of one scene, each in a file of its own with a template of the same name. Empty
// where the scene's rows have nothing to tell.
#pragma once
#include <string>
#include <vector>

#include "reports/model/answer.h"
#include "reports/model/scene.h"
#include "reports/page/html_template.h"

namespace crowdbench::reports {

// A scene while its sections are made.
class SceneOnPage {
 public:
  // scene must outlive this. last_chart: the number of the page's last chart, counted up by each new one.
  SceneOnPage(const Scene& scene, int& last_chart);

  const Scene& scene;

  // The representation's name behind a dot of its colour.
  Html mark(const std::string& representation) const;
  Html chart(const std::string& specification, const std::string& title);

 private:
  std::vector<std::string> colours_;
  int& last_chart_;
};

// "15 % of the picture covered"
std::string occupancy_title(double occupancy);

Html answer_section(const Scene& scene);
Html pictures_section(const SceneOnPage& page);
Html cost_section(SceneOnPage& page);
Html difference_section(SceneOnPage& page);
// The cost model, where representations break even, and the front over time, bytes and error.
Html model_section(SceneOnPage& page);
// Every impostor beside the level of detail as wrong and the one as dear.
Html equal_levels_section(const SceneOnPage& page);
// The raw frame times, where the rows were read with them.
Html samples_section(SceneOnPage& page);
Html memory_section(const SceneOnPage& page);
Html floors_section(const SceneOnPage& page, const FloorTexts& floors);
Html work_section(const SceneOnPage& page);
Html untimed_section(const SceneOnPage& page);

}  // namespace crowdbench::reports
