// The page of `tune`: which representation from which distance on, how sure, what it shows and costs.
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "reports/model/tune_model.h"

namespace crowdbench::reports {

// All plain text, numbers as people read them; "–" where there is none.
struct TunePageSwitch {
  std::string from, to;
  std::string height, height_interval;  // pixels
  std::string next;                     // the next taller height that was measured, pixels
  std::string depth, depth_interval;    // metres
  std::string ratio;                    // pixels that a texel spans
  std::string hysteresis;
  std::string pop;
  std::string sure;  // the share of the resamples that make this change
};
// A rule of thumb beside a measured switch.
struct TunePageRule {
  std::string to, rule;
  std::string measured_height, measured_depth;
  std::string height, depth;  // of the rule
  std::string shown, verdict, cost;
};
struct TunePageEngines {
  std::string to, metres, unity, unreal, godot, godot_pixels;
};
struct TunePagePicture {
  std::string caption;
  int width = 0, height = 0;  // as they are shown, pixels
  std::vector<uint8_t> png;
};
// A switch: before, after, what differs.
struct TunePagePictures {
  std::string title;
  std::vector<TunePagePicture> pictures;
};
struct TunePageCharacter {
  std::string name;
  std::string measured;            // what its figures are from
  std::vector<std::string> alone;  // its own rule, where there are several characters
  TuneGraph graph;
  std::vector<std::vector<std::string>> rows;  // height, depth, agents, then score and time of each curve
  std::vector<size_t> chosen;                  // by row: the curve that the rule draws
  std::vector<std::string> notes;
};

struct TunePage {
  std::string title;
  std::string under;                // what was tuned, on what
  std::vector<std::string> broken;  // what was promised and does not hold; said first
  std::vector<std::string> answer;  // sentences
  bool software = false;            // drawn by a software rasteriser
  std::vector<TunePageSwitch> switches;
  std::string draws_as;  // the hybrid; empty where there is none
  std::vector<TunePagePictures> pictures;
  std::string picture_scale;  // what the colours of differences are
  TunePagePicture picture_bar;
  std::vector<TunePageCharacter> characters;
  std::vector<TunePageRule> rules;
  std::vector<TunePageEngines> engines;
  std::vector<std::string> engine_notes;
  std::string lens_verdict;             // empty: not checked
  std::vector<std::string> lens_lines;  // by character and bin
  std::vector<std::vector<std::string>>
      lenses;                            // rows, degrees, representation, height, score, as tuned, worse, verdict
  std::vector<std::string> proof_lines;  // of promise and proof; empty: none
  std::vector<std::vector<std::string>> seeds;  // seed, what for, times fast, interval, reference ms, plan ms
  std::vector<std::pair<std::string, std::string>> facts;  // provenance
};

// One self-contained HTML page that opens without a network. Throws Error when the program was built without the chart
// library.
std::string tune_page(const TunePage& page);

}  // namespace crowdbench::reports
