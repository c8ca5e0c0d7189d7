// Every impostor beside levels of detail of the reference: the one that is as wrong, and the one that costs as much.
// Pure functions.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "reports/model/scene.h"

namespace crowdbench::reports {

// A level of detail of the reference: the reference with options, but not one that changes between levels by itself.
bool is_level(const Scene& scene, const std::string& name);
// A level that nobody asked for: `bench` and `demo` add some to set the others against. One that the run's command line
// does not name, beside others that are no levels; what a sweep's plan lists is asked for.
bool is_ruler(const Scene& scene, const std::string& name);
// What title and answer are of: all but the reference and the rulers, in the order of the scene.
std::vector<std::string> subjects_of(const Scene& scene);

// A place among the levels, as triangles an agent.
struct LevelPlace {
  enum class Where : uint8_t { between, beyond_finest, beyond_coarsest };
  Where where = Where::between;
  double triangles = 0;  // of the finest or coarsest where it is beyond
};

// One that is no level, at one point.
struct EqualLevels {
  std::string representation;
  std::optional<double> error;  // the score's value
  // The level as wrong, and its time over the representation's, from the ends of the intervals of both.
  std::optional<LevelPlace> equal_error;
  double factor = 1, low = 1, high = 1;
  // The level that takes as long, and its score's value; beyond an end, that of the end.
  LevelPlace equal_time;
  std::optional<double> error_of_equal_time;
};
struct LevelTable {
  uint32_t agents = 0;
  double occupancy = 0;
  ScoreDoc score;     // without a name where the crowd's pictures were not scored
  size_t levels = 0;  // that were timed, beside the whole reference
  std::vector<EqualLevels> rows;
};
// Of each occupancy: the largest crowd at which levels and others were timed and scored; else the largest at which they
// were timed. None where no level was. Between levels errors are taken to run straight against the logarithm of the
// triangles, and times against the triangles.
std::vector<LevelTable> level_tables(const Scene& scene);

// "about 290 triangles", "fewer than 125 triangles", "5,190 triangles and more".
std::string place_text(const LevelPlace& place);
// What the table says of one, to follow a sentence about its speed: " With 250 agents, a level of about 290 triangles
// of mesh is as wrong (FLIP 0.0620) and takes 2.89 times its time (2.72 to 3.09). As dear is a level of about ...".
std::string equal_levels_text(const LevelTable& table, const EqualLevels& row, const std::string& reference);
// The same as a clause, for a cell or a tile: "a level of about 290 triangles is as wrong, at 2.89 times its time";
// with no score "a level of about 420 triangles is as dear".
std::string equal_levels_clause(const EqualLevels& row);
// The row of one in the tables of a scene; nothing where there is none.
struct LevelsBeside {
  LevelTable table;
  EqualLevels row;
};
std::optional<LevelsBeside> levels_beside(const Scene& scene, const std::string& representation, double occupancy);

}  // namespace crowdbench::reports
