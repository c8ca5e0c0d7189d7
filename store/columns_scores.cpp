// What pictures, their scores and what is made of these are stored as.
#include "store/column_fields.h"

namespace crowdbench {

using namespace column_fields;

// clang-format off
template <>
const Table<ComparisonRow>& table<ComparisonRow>() {
  using R = ComparisonRow;
  static const Table<R> made = make_table<R>(
      {.name = "comparison",
       .rows = "comparisons",
       .meaning = "Two pictures of the same view; what they differ by is in `score`."},
      &StoreContents::comparisons,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::kind>({.name = "kind",
                       .meaning = "crowd: a whole frame; agent: one agent, as `quality` defines it; agent_in_crowd: one "
                                  "agent of a whole frame, as `distance` defines it",
                       .values = {"crowd", "agent", "agent_in_crowd"}}),
      field<&R::representation>({.name = "representation", .meaning = "canonical text of what is compared"}),
      field<&R::reference>({.name = "reference", .meaning = "canonical text of what it is compared with"}),
      field<&R::character>({.name = "character", .meaning = "sources of the characters, joined by \" + \""}),
      field<&R::agents>({.name = "agents", .unit = "agents", .meaning = "size of the crowd; agent: 0"}),
      field<&R::requested_occupancy>({.name = "requested_occupancy",
                                      .unit = "fraction",
                                      .meaning = "of the picture, as in `measurement`; agent: 0"}),
      field<&R::tick>({.name = "tick", .unit = "ticks", .meaning = "moment of the animation; agent: 0"}),
      field<&R::height_px>({.name = "height_px", .unit = "px", .meaning = "height of the agent in the picture"}),
      field<&R::azimuth_deg>({.name = "azimuth_deg", .unit = "degrees", .meaning = "of the camera about the agent"}),
      field<&R::elevation_deg>({.name = "elevation_deg", .unit = "degrees", .meaning = "of the camera"}),
      field<&R::clip>({.name = "clip", .meaning = "the agent's motion; crowd: empty"}),
      field<&R::time>({.name = "time_s", .unit = "s", .meaning = "moment within that clip"}),
      field<&R::agent>({.name = "agent", .meaning = "agent_in_crowd: its place in the crowd, from 0", .since = 3}),
      field<&R::distance>({.name = "distance_m",
                           .unit = "m",
                           .meaning = "agent_in_crowd: from the eye to the agent",
                           .since = 3}),
      field<&R::pixels_per_texel>({.name = "pixels_per_texel",
                                   .meaning = "agent_in_crowd: pixels that a texel of its map spans; absent where it "
                                              "has none",
                                   .since = 3}),
      field<&R::alone_px>({.name = "alone_px",
                           .unit = "px",
                           .meaning = "agent_in_crowd: pixels that the reference covers where it stands alone",
                           .since = 3}),
      field<&R::visible_px>({.name = "visible_px",
                             .unit = "px",
                             .meaning = "agent_in_crowd: of these, those that others leave visible",
                             .since = 3}),
      field<&R::state>({.name = "state",
                        .meaning = "agent_in_crowd: whether it counts in curves (counted), else why not: occluded, "
                                   "cut_off, no_pixel",
                        .since = 3}),
      field<&R::display>({.name = "display",
                          .meaning = "where the pictures are looked at, for scores that depend on it",
                          .since = 3}),
      field<&R::display_given>({.name = "display_given",
                                .meaning = "somebody chose that display; else scores with a default of their own kept "
                                           "to it (FLIP: 67.02 pixels/degree)",
                                .since = 3}));
  return made;
}

template <>
const Table<ScoreRow>& table<ScoreRow>() {
  using R = ScoreRow;
  static const Table<R> made = make_table<R>(
      {.name = "score",
       .rows = "scores",
       .meaning = "One score of a comparison: a new score is a new name, never a new column.",
       .owner = "comparison",
       .within = "name"},
      nullptr,
      field<&R::name>({.name = "name", .meaning = "\"ssim\", \"psnr\", ...; unit and direction are the score's"}),
      field<&R::value>({.name = "value", .meaning = "infinity where the score is infinite"}),
      field<&R::reason>({.name = "reason",
                         .meaning = "why there is no value; else empty",
                         .check = "value IS NOT NULL OR reason <> ''"}));
  return made;
}

template <>
const Table<PictureRow>& table<PictureRow>() {
  using R = PictureRow;
  static const Table<R> made = make_table<R>(
      {.name = "picture", .rows = "pictures", .meaning = "A picture for the report."},
      &StoreContents::pictures,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::comparison>({.name = "comparison",
                             .meaning = "the comparison that it belongs to",
                             .references = "comparison"}),
      field<&R::role>({.name = "role", .meaning = "\"reference\", \"test\", \"difference\", \"hero\"; \"legend\": the colour bar of a "
                                      "run's differences"}),
      field<&R::caption>({.name = "caption", .meaning = "for people"}),
      field<&R::width>({.name = "width_px", .unit = "px", .meaning = "width"}),
      field<&R::height>({.name = "height_px", .unit = "px", .meaning = "height"}),
      field<&R::png>({.name = "png", .meaning = "the PNG file"}));
  return made;
}

template <>
const Table<CurveRow>& table<CurveRow>() {
  using R = CurveRow;
  static const Table<R> made = make_table<R>(
      {.name = "curve",
       .rows = "curves",
       .meaning = "A score of the agents of a crowd against how far away they are (`distance`): medians of bins of "
                  "equally many, in `curve_bin`.",
       .since = 3},
      &StoreContents::curves,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::representation>({.name = "representation", .meaning = "canonical text of what is compared"}),
      field<&R::reference>({.name = "reference", .meaning = "canonical text of what it is compared with"}),
      field<&R::character>({.name = "character", .meaning = "sources of the characters, joined by \" + \""}),
      field<&R::score>({.name = "score", .meaning = "name of the score"}),
      field<&R::against>({.name = "against",
                          .meaning = "what is x: distance in metres, height in pixels, or pixels that a texel spans",
                          .values = {"distance_m", "height_px", "pixels_per_texel"}}),
      field<&R::points>({.name = "points", .meaning = "agents in frames that count and have the score"}),
      field<&R::agents>({.name = "agents", .unit = "agents", .meaning = "different ones among them"}),
      field<&R::rank_correlation>({.name = "rank_correlation",
                                   .meaning = "Spearman's, of the value with how far away; absent where either never "
                                              "changes"}),
      field<&R::display>({.name = "display", .meaning = "where the pictures are looked at, as in `comparison`"}),
      field<&R::display_given>({.name = "display_given", .meaning = "somebody chose that display"}));
  return made;
}

template <>
const Table<CurveBinRow>& table<CurveBinRow>() {
  using R = CurveBinRow;
  static const Table<R> made = make_table<R>(
      {.name = "curve_bin",
       .rows = "bins",
       .meaning = "One bin of a curve.",
       .owner = "curve",
       .within = "bin",
       .since = 3},
      nullptr,
      field<&R::bin>({.name = "bin", .meaning = "its number from near to far, from 0"}),
      field<&R::from>({.name = "x_from", .meaning = "x of its nearest point"}),
      field<&R::to>({.name = "x_to", .meaning = "x of its farthest point"}),
      field<&R::x>({.name = "x", .meaning = "median of x"}),
      field<&R::median>({.name = "median", .meaning = "median of the score"}),
      field<&R::low>({.name = "median_low", .meaning = "lower end of its 95 % interval, whole agents drawn anew"}),
      field<&R::high>({.name = "median_high", .meaning = "upper end of that interval"}),
      field<&R::points>({.name = "points", .meaning = "agents in frames"}),
      field<&R::agents>({.name = "agents", .unit = "agents", .meaning = "different ones among them"}));
  return made;
}

template <>
const Table<ThresholdRow>& table<ThresholdRow>() {
  using R = ThresholdRow;
  static const Table<R> made = make_table<R>(
      {.name = "threshold",
       .rows = "thresholds",
       .meaning = "From where on, going away, the median of a curve is as good as a value or better.",
       .since = 3},
      &StoreContents::thresholds,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::curve>({.name = "curve", .meaning = "the curve that it is of", .references = "curve"}),
      field<&R::value>({.name = "value", .meaning = "of the score"}),
      field<&R::status>({.name = "status",
                         .meaning = "whether the curve comes to it",
                         .values = {"reached", "everywhere", "not_reached", "not_distinguishable"}}),
      field<&R::at>({.name = "x", .meaning = "from where on; absent: everywhere or nowhere"}),
      field<&R::low>({.name = "x_low", .meaning = "nearer end of its 95 % interval; absent: open at that end"}),
      field<&R::high>({.name = "x_high", .meaning = "farther end of it"}));
  return made;
}

template <>
const Table<CauseRangeRow>& table<CauseRangeRow>() {
  using R = CauseRangeRow;
  static const Table<R> made = make_table<R>(
      {.name = "cause_range",
       .rows = "cause_ranges",
       .meaning = "What the squared error of figures of one range of heights comes from (`quality --causes`, `distance "
                  "--causes`); the shares of the causes in `cause_share`.",
       .since = 4},
      &StoreContents::cause_ranges,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::representation>({.name = "representation", .meaning = "canonical text of what is compared"}),
      field<&R::reference>({.name = "reference", .meaning = "canonical text of what it is compared with"}),
      field<&R::character>({.name = "character", .meaning = "sources of the characters, joined by \" + \""}),
      field<&R::unit>({.name = "unit", .meaning = "what is drawn anew for the interval", .values = {"view", "agent"}}),
      field<&R::from>({.name = "from_px", .unit = "px", .meaning = "least height of the figures"}),
      field<&R::below>({.name = "below_px", .unit = "px", .meaning = "their heights are below this; absent: no end"}),
      field<&R::units>({.name = "units", .meaning = "views or agents of such a height"}),
      field<&R::total>({.name = "total", .meaning = "squared error, code values squared, summed over R, G and B"}),
      field<&R::residue>({.name = "residue", .unit = "fraction", .meaning = "share of it that no cause explains"}),
      field<&R::dominant>({.name = "dominant",
                           .meaning = "the cause that has most of it; absent: not distinguishable"}),
      field<&R::share_low>({.name = "share_low",
                            .unit = "fraction",
                            .meaning = "lower end of the 95 % interval of its share"}),
      field<&R::share_high>({.name = "share_high", .unit = "fraction", .meaning = "upper end of that interval"}),
      field<&R::words>({.name = "words", .meaning = "the same for people"}));
  return made;
}

template <>
const Table<CauseShareRow>& table<CauseShareRow>() {
  using R = CauseShareRow;
  static const Table<R> made = make_table<R>(
      {.name = "cause_share",
       .rows = "shares",
       .meaning = "The share that one cause has of the squared error of a range of heights.",
       .owner = "cause_range",
       .within = "cause",
       .since = 4},
      nullptr,
      field<&R::cause>({.name = "cause", .meaning = "its name: \"view\", \"silhouette\", ..."}),
      field<&R::title>({.name = "title", .meaning = "the same for people"}),
      field<&R::share>({.name = "share",
                        .unit = "fraction",
                        .meaning = "below 0: it undoes error of a cause before it"}));
  return made;
}

template <>
const Table<PopRow>& table<PopRow>() {
  using R = PopRow;
  static const Table<R> made = make_table<R>(
      {.name = "pop",
       .rows = "pops",
       .meaning = "A switch of an agent in a sequence of frames (`popping`), by how visible it is: its scores are in "
                  "`pop_score`.",
       .since = 4},
      &StoreContents::pops,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::representation>({.name = "representation", .meaning = "canonical text of what is drawn"}),
      field<&R::character>({.name = "character", .meaning = "sources of the characters, joined by \" + \""}),
      field<&R::from>({.name = "from", .meaning = "what drew the agent before"}),
      field<&R::to>({.name = "to", .meaning = "what draws it after"}),
      field<&R::agent>({.name = "agent", .meaning = "its place in the crowd, from 0"}),
      field<&R::tick>({.name = "tick", .meaning = "the first frame that shows the switch"}),
      field<&R::frames>({.name = "frames", .meaning = "over which it goes"}),
      field<&R::complete>({.name = "complete", .meaning = "it ended within the sequence"}),
      field<&R::distance>({.name = "distance_m", .unit = "m", .meaning = "from the eye to the agent"}),
      field<&R::pixels>({.name = "pixels_px",
                         .unit = "px",
                         .meaning = "of the most visible step; 0: nothing of the agent is seen"}),
      field<&R::worst_tick>({.name = "worst_tick", .meaning = "frame of the most visible step"}),
      field<&R::display>({.name = "display", .meaning = "where the pictures are looked at, as in `comparison`"}));
  return made;
}

template <>
const Table<PopScoreRow>& table<PopScoreRow>() {
  using R = PopScoreRow;
  static const Table<R> made = make_table<R>(
      {.name = "pop_score",
       .rows = "pop_scores",
       .meaning = "One score of a switch: the worst of its steps.",
       .owner = "pop",
       .within = "name",
       .since = 4},
      nullptr,
      field<&R::name>({.name = "name", .meaning = "as `schema --scores` lists those of switches"}),
      field<&R::value>({.name = "value", .meaning = "absent: nothing of the agent is seen, or it does not exist"}));
  return made;
}
// clang-format on

}  // namespace crowdbench
